"""What a project has to say of a conversion: what its sensors and forces are for."""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Summary, Use
from urdf2mbs_project.simulation import Simulation


def summarise(conversion: Conversion) -> Summary:
    simulation = conversion.state(Simulation)
    known = [
        *(
            (one.point.sensor, Use(f"{one.kind} '{one.name}'", one.link, one.rotation))
            for one in simulation.sensors
        ),
        *(
            (
                one.point.extforce,
                Use("contact", ", ".join(one.links), spots=tuple(spot.at for spot in one.spots)),
            )
            for one in simulation.contacts
        ),
        *(
            (one.point.extforce, Use(f"wrench, user model '{one.model.name}'"))
            for one in simulation.wrenches
        ),
    ]
    rows: list[tuple[str, ...]] = [
        (one.name, one.link, ", ".join(joint.name for joint in one.joints))
        for one in simulation.force_torques
    ]
    head = ("sensor", "URDF link", "driven joints whose Qc it reads")
    return Summary(
        uses={named.name: use for named, use in known if named is not None},
        tables=[("Force-torque sensors", head, rows)] if rows else [],
    )
