"""Keep the layout of a diagram that people arranged in MBSysPad."""

from __future__ import annotations

from typing import Any

from urdf2mbs.plugin import XY, Mbs


def keep_layout(mbs: Mbs, arranged_parts: dict[int, Any]) -> None:
    """Give a model the positions that its objects have in another file.

    A new object is placed beside the body that carries it, at the distance that the new layout has
    between them.

    Args:
        mbs: The model, already with a layout.
        arranged_parts: The object of the other file for objects of ``mbs``, by their ``id``.
    """
    offsets: dict[str | None, XY] = {None: (0.0, 0.0)}  # from the new layout to the old, px
    owners: list[Any] = [mbs.base, *mbs.depth_first()]
    for owner in owners:
        is_base = owner is mbs.base
        name, parent = (None, None) if is_base else (owner.name, owner.parent)
        parts = [owner] if is_base else owner.joints
        last, last_arranged = parts[-1].position, arranged_parts.get(id(parts[-1]))
        offset = offsets[parent]
        if last and last_arranged and last_arranged.position:
            x, y = last_arranged.position
            offset = (x - last[0], y - last[1])
        offsets[name] = offset
        for part in [*parts, *owner.points]:
            arranged = arranged_parts.get(id(part))
            part.position = (arranged and arranged.position) or _shift(part.position, offset)
        arranged = arranged_parts.get(id(owner))
        owner.drawing = (arranged and arranged.drawing) or owner.drawing


def _shift(position: XY | None, offset: XY) -> XY | None:
    """Shift a position (px), but not to where MBSysPad cannot scroll."""
    if position is None or offset == (0.0, 0.0):
        return position
    return (max(position[0] + offset[0], 0.0), max(position[1] + offset[1], 0.0))
