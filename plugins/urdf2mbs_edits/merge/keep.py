"""Places that somebody has given by hand in MBSysPad stay."""

from __future__ import annotations

from typing import Any

from urdf2mbs.plugin import XY, Mbs


def keep(mbs: Mbs, drawn: dict[int, Any]) -> None:
    """Give a model, already laid out, the places of ``drawn``: the object that each of its objects
    is in another file, by ``id``.  What is new stands beside what carries it, as far from it as the
    new diagram puts it."""
    moved: dict[str | None, XY] = {None: (0.0, 0.0)}

    def place(parts: list[Any], by: XY) -> None:
        for part in parts:
            old = drawn.get(id(part))
            part.position = (old and old.position) or _shifted(part.position, by)

    owners: list[Any] = [mbs.base, *mbs.depth_first()]
    for owner in owners:
        name, on = (None, None) if owner is mbs.base else (owner.name, owner.parent)
        parts = [owner] if owner is mbs.base else owner.joints
        by, last, old = moved[on], parts[-1].position, drawn.get(id(parts[-1]))
        if last and old and old.position:
            by = (old.position[0] - last[0], old.position[1] - last[1])
        moved[name] = by
        place([*parts, *owner.points], by)
        before = drawn.get(id(owner))
        owner.drawing = (before and before.drawing) or owner.drawing


def _shifted(position: XY | None, by: XY) -> XY | None:
    """A place that MBSysPad can scroll to."""
    if position is None or by == (0.0, 0.0):
        return position
    return (max(position[0] + by[0], 0.0), max(position[1] + by[1], 0.0))
