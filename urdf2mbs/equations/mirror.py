"""Which joints are mirrored: the left arm's and the right arm's, two legs', two fingers'."""

from __future__ import annotations

from urdf2mbs.equations.tree import Tree, is_fixed


def mirrored(tree: Tree) -> dict[int, int]:
    """The number of the other joint, for each joint that has one.

    Two joints behind the same one, or behind two that are mirrored, are if they are of the same
    kind; if there is a choice, those with the same joints behind them.
    """
    frames = tree.frames
    names: dict[tuple[object, ...], int] = {}
    shape = [0] * len(frames)
    """Equal for joints that have the same behind them."""
    for frame in reversed(frames):
        kind = (frame.joint.type, is_fixed(frame.joint))
        behind = sorted(shape[child] for child in frame.children)
        shape[frame.number] = names.setdefault((kind, *behind), len(names))

    def partner(number: int, others: list[int]) -> int | None:
        kind = frames[number].joint.type, is_fixed(frames[number].joint)
        alike = [k for k in others if (frames[k].joint.type, is_fixed(frames[k].joint)) == kind]
        same = [k for k in alike if shape[k] == shape[number]]
        return next(iter(same or alike), None)

    out: dict[int, int] = {}
    stack = [(0, 0)]
    while stack:
        one, other = stack.pop()
        alone = list(frames[one].children)
        others = alone if one == other else list(frames[other].children)
        while alone:
            number = alone.pop(0)
            found = partner(number, others)
            if found is not None:
                others.remove(found)
                out[number], out[found] = found, number
                stack.append((number, found))
            elif one == other:
                stack.append((number, number))
    return out
