"""Reframe inertia: the method's step 1, "Retrieve the inertial properties of the URDF link".

"The URDF rotational inertia matrix is represented in the inertial frame while the MBS rotational
inertia matrix is represented in the body reference frame": with R the rotation of the inertial
frame I in the body frame B, ``T_B = R T_I R^T``, about the centre of mass in both.

In the preset ``compact`` a component that is only rounding becomes 0.0: Robotran's generator would
take it for a parameter.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Segment
from urdf2mbs.hookspecs import Pass
from urdf2mbs.spatial import MassProperties, compose, drop_rounding, lump, rotate_inertia
from urdf2mbs.urdf.model import Robot


class ReframeInertia(Pass):
    """Give each body its mass, centre of mass and inertia."""

    reads = ("robot", "bodies")
    writes = ("inertias",)

    def run(self, conversion: Conversion) -> None:
        """Compute the mass properties of each segment in the frame of its body."""
        _note_ground_mass(conversion)
        for segment in conversion.segments.values():
            if segment.parent is None:
                continue
            mass_properties = compute_mass_properties(segment, conversion.robot)
            if mass_properties is not None:
                body = segment.body
                body.mass, body.com, body.inertia = mass_properties
                if conversion.aligned:  # a rotated frame makes the numbers computed ones
                    body.com = drop_rounding(body.com)
                    body.inertia = drop_rounding(body.inertia)


def _note_ground_mass(conversion: Conversion) -> None:
    """Note the links with mass that are fixed to the ground."""
    links = conversion.robot.links
    heavy_links = [link for link in conversion.ground.parts if not links[link].massless]
    if heavy_links:
        mass = sum(inertial.mass for link in heavy_links if (inertial := links[link].inertial))
        conversion.note(
            "ground-mass",
            f"{mass:.6g} kg fixed to the ground have no body, as they never move: "
            f"{', '.join(heavy_links)}",
        )


def compute_mass_properties(segment: Segment, robot: Robot) -> MassProperties | None:
    """Compute the mass properties of all links of a segment together.

    Args:
        segment: The links that move as one body.
        robot: The robot, whose links have the inertias.

    Returns:
        Mass (kg), centre of mass (m) and inertia about it (kg m^2), in body axes; None if no link
        of the segment has any.
    """
    parts: list[MassProperties] = []
    for link, pose in segment.parts.items():
        inertial = robot.links[link].inertial
        if inertial is not None and not robot.links[link].massless:
            frame = compose(pose, inertial.origin.pose)
            tensor = rotate_inertia(frame.rot, inertial.inertia)
            parts.append((inertial.mass, frame.xyz, tensor))
    return lump(parts) if parts else None
