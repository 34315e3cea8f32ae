"""Positions that somebody has given by hand in MBSysPad stay."""

from __future__ import annotations

from urdf2mbs.mbs.model import XY, Body, Mbs, Point


def keep(mbs: Mbs, drawn: Mbs) -> int:
    """Give a model, already laid out, the places that its parts have in ``drawn``.

    Parts are found by their names.  A part that is new stands
    beside what carries it, as far as the new diagram puts it.  Returns how many bodies stay.
    """
    before = {body.name: body for body in drawn.bodies}
    moved: dict[str | None, XY] = {None: (0.0, 0.0)}

    if mbs.base.position and drawn.base.position and drawn.base.drawing:
        moved[None] = _between(mbs.base.position, drawn.base.position)
        mbs.base.position, mbs.base.drawing = drawn.base.position, drawn.base.drawing
    _move(mbs.base.points, drawn.base.points, moved[None])

    kept = 0
    for body in mbs.depth_first():
        old = before.get(body.name)
        if old is not None and _alike(body, old):
            assert body.joints[-1].position is not None
            assert old.joints[-1].position is not None
            moved[body.name] = _between(body.joints[-1].position, old.joints[-1].position)
            for joint, there in zip(body.joints, old.joints, strict=True):
                joint.position = there.position
            body.drawing = old.drawing
            _move(body.points, old.points, moved[body.name])
            kept += 1
        else:
            by = moved[body.name] = moved[body.parent]
            for joint in body.joints:
                joint.position = _shifted(joint.position, by)
            _move(body.points, [], by)
    return kept


def _alike(body: Body, old: Body) -> bool:
    """Whether a body has the same joints as before, all of them with a place."""
    names = [joint.name for joint in body.joints] == [joint.name for joint in old.joints]
    return names and old.drawing is not None and all(joint.position for joint in old.joints)


def _move(points: list[Point], drawn: list[Point], by: XY) -> None:
    before = {point.name: point.position for point in drawn}
    for point in points:
        point.position = before.get(point.name) or _shifted(point.position, by)


def _between(one: XY, other: XY) -> XY:
    return (other[0] - one[0], other[1] - one[1])


def _shifted(position: XY | None, by: XY) -> XY | None:
    """A place that MBSysPad can scroll to."""
    if position is None:
        return None
    return (max(position[0] + by[0], 0.0), max(position[1] + by[1], 0.0))
