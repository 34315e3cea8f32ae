"""Fit view: the 3D viewer opens on the whole robot, with symbols that suit the robot's size."""

from __future__ import annotations

from math import hypot

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Light, View, Viewpoint
from urdf2mbs.ranges import rounded
from urdf2mbs.spatial import add, rotate
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Geometry, Mesh, Robot

#: Size (m) of the robots for which MBSysPad's default symbols are made: as tall as a human.
HUMAN_SIZE = 1.8
#: The view is at least as large as this (m).
MIN_SIZE = 0.1
#: Where the camera is, from the middle of the robot, relative to the robot's size.
CAMERA_OFFSET = (1.3, 0.6, 0.5)
#: Distances at which the view begins and ends, relative to the robot's size.
FRONT_CLIP, BACK_CLIP = 0.005, 30


class FitView(Pass):
    """Make the 3D viewer open on the whole robot."""

    reads = ("robot",)
    writes = ("view",)

    def run(self, conversion: Conversion) -> None:
        """Set the camera, the lights and the size of the symbols."""
        lower, upper = _compute_bounds(conversion.robot)
        x, y, z = (_round((a + b) / 2) for a, b in zip(lower, upper, strict=True))
        size = max(hypot(upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]), MIN_SIZE)
        dx, dy, dz = (offset * size for offset in CAMERA_OFFSET)
        camera = Viewpoint(
            "Whole_robot",
            position=(_round(x + dx), _round(y + dy), _round(z + dz)),
            target=(x, y, z),
            front_clip=_round(FRONT_CLIP * size),
            back_clip=_round(BACK_CLIP * size),
        )
        scale = size / HUMAN_SIZE
        conversion.mbs.view = View(
            frame=_round(0.1 * scale),
            joint=_round(0.2 * scale),
            com=_round(0.2 * scale),
            point=_round(0.3 * scale),
            viewpoints=[camera],
            lights=[Light("Light_1", (2.0, 1.0, 1.0)), Light("Light_2", (-1.0, -2.0, -1.0))],
        )


def _round(length: float) -> float:
    """Round a length (m) to three digits."""
    return rounded(length, 3)


def _compute_bounds(robot: Robot) -> tuple[list[float], list[float]]:
    """Compute the box around all link frames, centres of mass and primitive shapes.

    Returns:
        Its lowest and its highest corner (m), in the frame of the root, all joints at zero.
    """
    poses = robot.poses()
    points = [pose.xyz for pose in poses.values()]
    for name, link in robot.links.items():
        position, rotation = poses[name]
        if link.inertial is not None:
            points.append(add(position, rotate(rotation, link.inertial.origin.xyz)))
        for visual in link.visuals:
            radius = _compute_radius(visual.geometry)
            if radius is not None:
                x, y, z = add(position, rotate(rotation, visual.origin.xyz))
                points.append((x - radius, y - radius, z - radius))
                points.append((x + radius, y + radius, z + radius))
    coordinates = list(zip(*points, strict=True))
    return [min(values) for values in coordinates], [max(values) for values in coordinates]


def _compute_radius(geometry: Geometry) -> float | None:
    """Compute the radius (m) of a sphere around a shape; None for a mesh, which is not read."""
    if isinstance(geometry, Mesh):
        return None
    if isinstance(geometry, Box):
        return hypot(*geometry.size) / 2
    if isinstance(geometry, Cylinder):
        return hypot(geometry.radius, geometry.length / 2)
    if isinstance(geometry, Capsule):
        return geometry.radius + geometry.length / 2
    return geometry.radius
