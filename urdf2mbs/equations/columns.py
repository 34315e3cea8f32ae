"""The columns of the mass matrix: what all joints feel of one that accelerates."""

from __future__ import annotations

from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import NONE, OWN, Frame, Tree, Vector, along


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
        tree, k = self.tree, frame.number
        parent, size = frame.parent, len(tree.graph.op)
        turned = bool(frame.sin)
        step = _weight(frame.offset) * 4 + self.price[parent] + (12 if turned else 0)
        self.price[k] = step if parent else 9.0 if turned else 0.0
        if not self.columns[k]:
            return
        axes = self.seen[k]
        for inner, axis, lever in self.seen[parent]:
            lever = tree.outward(frame, tree.plus(lever, frame.offset)) if inner.turns else NONE
            axes.append((inner, tree.outward(frame, axis), lever))
        axes.append((frame, along(frame.axis, 1), NONE))
        self.work[k] = self.work[parent] + len(tree.graph.op) - size
        levers = {lever for inner, _, lever in axes if inner.turns}
        price = sum(4 * _weight(lever) for lever in levers)
        price += sum(2 * _weight(axis) - 1 for _, axis, _ in axes if _weight(axis) > 1)
        # the others' axes may come from here
        saved = (self.price[k] - price) * self.columns[k]
        if saved > self.work[k] * 0.75:
            self.stops[k] = True
            self.price[k] = price

    def carry(
        self, frame: Frame, f: Vector, n: Vector, matrix: dict[tuple[int, int], Expr]
    ) -> None:
        """Fill the column of one joint from force and moment about the joint's origin, in the axes
        of the frame before it; further in, both are in the axes of each frame passed."""
        tree, column, offset = self.tree, frame.number, frame.offset
        at = tree.frames[frame.parent]
        while at.number:
            n = tree.plus(n, tree.cross(offset, f))
            if self.stops[at.number]:
                for inner, axis, lever in self.seen[at.number]:
                    reach = tree.plus(n, tree.cross(lever, f)) if inner.turns else f
                    matrix[inner.number, column] = tree.dot(axis, reach)
                return
            run = self._run(at)
            if len(run) > 1:
                f, n = self._past(run, f, n, column, matrix)
                at = run[-1]
            else:
                matrix[at.number, column] = n[at.axis] if at.turns else f[at.axis]
                f, n = tree.inward(at, f), tree.inward(at, n)
            offset, at = at.offset, tree.frames[at.parent]

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
        matrix: dict[tuple[int, int], Expr],
    ) -> tuple[Vector, Vector]:  # fmt: skip
        tree, axis = self.tree, run[0].axis
        turns = self._turns(run)
        c, s = turns[0]
        f, n = tree.turn(axis, c, s, f), tree.turn(axis, c, s, n)
        for frame, (c, s) in zip(run[:-1], turns[1:], strict=True):
            matrix[frame.number, column] = n[axis]
            n = tree.plus(n, tree.cross(tree.turn(axis, c, s, frame.offset), f))
        matrix[run[-1].number, column] = n[axis]
        return tree.before(run[-1], f), tree.before(run[-1], n)

    def _turns(self, run: list[Frame]) -> list[tuple[Expr, Expr]]:
        """Cosine and sine of the angle of each frame of a run to the frame before all."""
        add, mul = self.tree.graph.add, self.tree.graph.mul
        c, s = 1, 0
        out = []
        for frame in reversed(run):
            c, s = (
                add(mul(c, frame.cos), -mul(s, frame.sin)),
                add(mul(s, frame.cos), mul(c, frame.sin)),
            )
            out.append((c, s))
        return out[::-1]


#: From so many columns on, one turn by a sum of angles pays.
RUN = 2


def _weight(v: Vector) -> int:
    """How many elements are not zero."""
    return sum(1 for x in v if x)
