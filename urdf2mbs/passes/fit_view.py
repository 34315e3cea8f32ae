"""Fit view: the 3D viewer opens with the whole robot in sight, its symbols of a size to match."""

from __future__ import annotations

from math import hypot

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Light, View, Viewpoint
from urdf2mbs.spatial import add, rotate
from urdf2mbs.urdf.model import Box, Cylinder, Mesh

#: The height (m) of the human-sized robots whose view the scale factors are taken from.
HUMAN = 1.8


class FitView(Pass):
    reads = ("robot", "bodies", "posture")
    writes = ("view",)

    def run(self, conversion: Conversion) -> None:
        low, high = _extent(conversion)
        x, y, z = (_short((a + b) / 2) for a, b in zip(low, high, strict=True))
        size = max(hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]), 0.1)
        away = (_short(x + 1.3 * size), _short(y + 0.6 * size), _short(z + 0.5 * size))
        camera = Viewpoint(
            "Whole_robot", position=away, target=(x, y, z),
            front_clip=_short(0.005 * size), back_clip=_short(30 * size),
        )  # fmt: skip
        unit = size / HUMAN
        conversion.mbs.view = View(
            frame=_short(0.1 * unit), joint=_short(0.2 * unit), com=_short(0.2 * unit),
            point=_short(0.3 * unit), viewpoints=[camera],
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
            radius = (
                hypot(*shape.size) / 2 if isinstance(shape, Box)
                else hypot(shape.radius, shape.length / 2) if isinstance(shape, Cylinder)
                else shape.radius
            )  # fmt: skip
            x, y, z = add(xyz, rotate(rot, visual.origin.xyz))
            points.append((x - radius, y - radius, z - radius))
            points.append((x + radius, y + radius, z + radius))
    columns = list(zip(*points, strict=True))
    return [min(column) for column in columns], [max(column) for column in columns]


def _short(value: float) -> float:
    """Three significant digits: the view is for the eye, the robot is not rounded."""
    return float(f"{value:.3g}")
