"""Fit view: the 3D viewer opens on the whole robot, with symbols that suit the robot's size."""

from __future__ import annotations

from math import hypot

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Light, View, Viewpoint
from urdf2mbs.ranges import rounded
from urdf2mbs.spatial import add, rotate
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Mesh

#: The scale factors are those of robots as tall as a human (m).
HUMAN = 1.8


class FitView(Pass):
    reads = ("robot",)
    writes = ("view",)

    def run(self, conversion: Conversion) -> None:
        low, high = _extent(conversion)
        x, y, z = (rounded((a + b) / 2, 3) for a, b in zip(low, high, strict=True))
        size = max(hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]), 0.1)
        away = (rounded(x + 1.3 * size, 3), rounded(y + 0.6 * size, 3), rounded(z + 0.5 * size, 3))
        camera = Viewpoint(
            "Whole_robot", position=away, target=(x, y, z),
            front_clip=rounded(0.005 * size, 3), back_clip=rounded(30 * size, 3),
        )  # fmt: skip
        unit = size / HUMAN
        conversion.mbs.view = View(
            frame=rounded(0.1 * unit, 3), joint=rounded(0.2 * unit, 3), com=rounded(0.2 * unit, 3),
            point=rounded(0.3 * unit, 3), viewpoints=[camera],
            lights=[Light("Light_1", (2.0, 1.0, 1.0)), Light("Light_2", (-1.0, -2.0, -1.0))],
        )  # fmt: skip


def _extent(conversion: Conversion) -> tuple[list[float], list[float]]:
    """The box (m) round all link frames, centres of mass and primitive shapes, at zero."""
    robot = conversion.robot
    poses = robot.poses()
    points = [xyz for xyz, _ in poses.values()]
    for name, link in robot.links.items():
        xyz, rot = poses[name]
        if link.inertial is not None:
            points.append(add(xyz, rotate(rot, link.inertial.origin.xyz)))
        for visual in link.visuals:
            shape = visual.geometry
            if isinstance(shape, Mesh):
                continue
            if isinstance(shape, Box):
                radius = hypot(*shape.size) / 2
            elif isinstance(shape, Cylinder):
                radius = hypot(shape.radius, shape.length / 2)
            elif isinstance(shape, Capsule):
                radius = shape.radius + shape.length / 2
            else:
                radius = shape.radius
            x, y, z = add(xyz, rotate(rot, visual.origin.xyz))
            points.append((x - radius, y - radius, z - radius))
            points.append((x + radius, y + radius, z + radius))
    columns = list(zip(*points, strict=True))
    return [min(column) for column in columns], [max(column) for column in columns]
