"""The summary of a project: the uses of its sensors and forces, and a table of sensors."""

from __future__ import annotations

from urdf2mbs.plugin import Conversion, Summary, Use
from urdf2mbs_project.simulation import Simulation


def summarise(conversion: Conversion) -> Summary:
    """Return what sensors and external forces of the .mbs are used for."""
    simulation = conversion.state(Simulation)
    uses: dict[str, Use] = {}
    for sensor in simulation.sensors:
        if sensor.point.sensor is not None:
            text = f"{sensor.kind} '{sensor.name}'"
            uses[sensor.point.sensor.name] = Use(text, sensor.link, sensor.rotation)
    for contact in simulation.contacts:
        if contact.point.extforce is not None:
            spots = tuple(spot.centre for spot in contact.spots)
            uses[contact.point.extforce.name] = Use(
                "contact", ", ".join(contact.links), spots=spots
            )
    for wrench in simulation.wrenches:
        if wrench.point.extforce is not None:
            text = f"wrench, user model '{wrench.model.name}'"
            uses[wrench.point.extforce.name] = Use(text)
    rows: list[tuple[str, ...]] = [
        (sensor.name, sensor.link, ", ".join(joint.name for joint in sensor.joints))
        for sensor in simulation.force_torques
    ]
    head = ("sensor", "URDF link", "driven joints whose Qc it reads")
    return Summary(uses=uses, tables=[("Force-torque sensors", head, rows)] if rows else [])
