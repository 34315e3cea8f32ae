"""The columns of the mass matrix: what all joints feel of one that accelerates."""

from __future__ import annotations

from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import NONE, OWN, Spatial, Vector

#: From so many columns on, one turn by a sum of angles pays.
RUN = 2


class Columns:
    """Carries force and moment of one unit acceleration inwards, past all joints.

    From the frame behind a joint there are three ways: past this joint; past a run of joints
    that turn about the same axis, by one turn with the sum of their angles; or nowhere, if all
    joints further in are looked at from here, each by its axis and its lever.  The cheapest is
    chosen for each frame, by the number of columns that come by.
    """

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        frames = tree.frames
        self.columns = [0] * len(frames)
        """How many columns come to the frame behind each joint."""
        for frame in reversed(frames[1:]):
            self.columns[frame.parent] += self.columns[frame.number] + 1
        self.seen: list[list[tuple[Frame, Vector, Vector]]] = [[] for _ in frames]
        """The joints up to each frame's own, their axes and levers in its axes."""
        self.work = [0] * len(frames)
        """How many operations these take, at most."""
        self.price = [0.0] * len(frames)
        self.stops = [False] * len(frames)
        for frame in frames[1:]:
            self._look(frame)

    def _look(self, frame: Frame) -> None:
        k, parent, operations = frame.number, frame.parent, self.tree.graph.op
        size = len(operations)
        turned = bool(frame.sin)
        step = _weight(frame.offset) * 4 + self.price[parent] + (12 if turned else 0)
        self.price[k] = step if parent else 9.0 if turned else 0.0
        if not self.columns[k]:
            return
        axes = self.seen[k]
        for inner, axis, lever in self.seen[parent]:
            lever = frame.to_child(lever + frame.offset) if inner.turns else NONE
            axes.append((inner, frame.to_child(axis), lever))
        axes.append((frame, frame.unit, NONE))
        self.work[k] = self.work[parent] + len(operations) - size
        levers = {lever for inner, _, lever in axes if inner.turns}
        price = sum(4 * _weight(lever) for lever in levers)
        price += sum(2 * _weight(axis) - 1 for _, axis, _ in axes if _weight(axis) > 1)
        # the others' axes may come from here
        saved = (self.price[k] - price) * self.columns[k]
        if saved > self.work[k] * 0.75:
            self.stops[k] = True
            self.price[k] = price

    def carry(self, frame: Frame, force: Spatial, matrix: dict[tuple[int, int], Scalar]) -> None:
        """Fill the column of one joint from force and moment about the joint's origin, in the axes
        that its frame has where the joint is at zero."""
        column, offset = frame.number, frame.offset
        f, n = frame.to_parent_axes(force.linear), frame.to_parent_axes(force.angular)
        at = self.tree.frames[frame.parent]
        while at.number:
            n = n + offset.cross(f)
            if self.stops[at.number]:
                for inner, axis, lever in self.seen[at.number]:
                    felt = n + lever.cross(f) if inner.turns else f
                    matrix[inner.number, column] = axis @ felt
                return
            run = self._run(at)
            if len(run) > 1:
                f, n = self._past(run, f, n, column, matrix)
                at = run[-1]
            else:
                matrix[at.number, column] = at.along(Spatial((f, n)))
                f, n = at.to_parent(f), at.to_parent(n)
            offset, at = at.offset, self.tree.frames[at.parent]

    def _run(self, frame: Frame) -> list[Frame]:
        """The joints from this one inwards that turn about the same axis."""
        run = [frame]
        if not frame.turns or self.columns[frame.number] < RUN:
            return run
        while True:
            if frame.change is not OWN:
                return run
            frame = self.tree.frames[frame.parent]
            if not frame.turns or frame.axis != run[0].axis or self.stops[frame.number]:
                return run
            run.append(frame)

    def _past(
        self, run: list[Frame], f: Vector, n: Vector, column: int,
        matrix: dict[tuple[int, int], Scalar],
    ) -> tuple[Vector, Vector]:  # fmt: skip
        axis, turns = run[0].axis, _turns(run)
        f, n = f.turned(axis, *turns[0]), n.turned(axis, *turns[0])
        for frame, turn in zip(run[:-1], turns[1:], strict=True):
            matrix[frame.number, column] = n[axis]
            n = n + frame.offset.turned(axis, *turn).cross(f)
        matrix[run[-1].number, column] = n[axis]
        return run[-1].to_parent_axes(f), run[-1].to_parent_axes(n)


def _turns(run: list[Frame]) -> list[tuple[Scalar, Scalar]]:
    """Cosine and sine of the angle of each frame of a run to the frame before all."""
    c: Scalar = 1
    s: Scalar = 0
    out = []
    for frame in reversed(run):
        c, s = c * frame.cos - s * frame.sin, s * frame.cos + c * frame.sin
        out.append((c, s))
    return out[::-1]


def _weight(v: Vector) -> int:
    """How many elements are not zero."""
    return sum(1 for x in v if x)
