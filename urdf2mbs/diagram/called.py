"""What the parts will be called in the file."""

from __future__ import annotations

from urdf2mbs.mbs.model import Base, Body, Joint, Mbs, Point, Sensor
from urdf2mbs.mbs.names import rename


def called(mbs: Mbs) -> Mbs:
    """The names alone: as the file will have them, the bodies depth first."""
    draft = Mbs(
        mbs.name,
        base=Base(mbs.base.name, points=_points(mbs.base.points)),
        bodies=[
            Body(
                body.name, body.parent, body.point,
                [Joint(joint.name, joint.type) for joint in body.joints],
                points=_points(body.points),
            )
            for body in mbs.depth_first()
        ],
    )  # fmt: skip
    rename(draft)
    return draft


def _points(points: list[Point]) -> list[Point]:
    return [
        Point(
            point.name,
            sensor=point.sensor and Sensor(point.sensor.name),
            extforce=point.extforce and Sensor(point.extforce.name),
        )
        for point in points
    ]
