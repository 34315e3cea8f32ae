"""Reframe inertia: the method's step 1, "Retrieve the inertial properties of the URDF link".

"The URDF rotational inertia matrix is represented in the inertial frame while the MBS
rotational inertia matrix is represented in the body reference frame": ``T_B = R T_I R^T``,
about the centre of mass in both.

In the preset ``compact`` a component that is only rounding is 0.0: Robotran's generator would take
it for a parameter.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Segment
from urdf2mbs.hookspecs import Pass
from urdf2mbs.spatial import Sym, Vec, compose, drop_rounding, lump, rotate_inertia
from urdf2mbs.urdf.model import Robot


class ReframeInertia(Pass):
    reads = ("robot", "bodies")
    writes = ("inertias",)

    def run(self, conversion: Conversion) -> None:
        _note_ground_mass(conversion)
        for segment in conversion.segments.values():
            inertial = inertia_of(segment, conversion.robot)
            if inertial is not None and segment.parent is not None:
                body = segment.body
                body.mass, body.com, body.inertia = inertial
                if conversion.aligned:  # what is turned is computed
                    body.com = drop_rounding(body.com)
                    body.inertia = drop_rounding(body.inertia)


def _note_ground_mass(conversion: Conversion) -> None:
    links = conversion.robot.links
    heavy = [link for link in conversion.ground.parts if not links[link].massless]
    if heavy:
        mass = sum(inertial.mass for link in heavy if (inertial := links[link].inertial))
        conversion.note(
            "ground-mass",
            f"{mass:.6g} kg fixed to the ground have no body, as they never move: "
            f"{', '.join(heavy)}",
        )


def inertia_of(segment: Segment, robot: Robot) -> tuple[float, Vec, Sym] | None:
    """Mass (kg), centre of mass (m) and inertia about it (kg m^2), in body axes, of all that
    moves with the segment; None if nothing there has any.

    Several parts make one by the parallel-axis theorem.
    """
    inertias: list[tuple[float, Vec, Sym]] = []
    for link, pose in segment.parts.items():
        inertial = robot.links[link].inertial
        if inertial is not None and not robot.links[link].massless:
            at = compose(pose, inertial.origin.pose)
            inertias.append((inertial.mass, at.xyz, rotate_inertia(at.rot, inertial.inertia)))
    return lump(inertias) if inertias else None
