"""Where the origins of the frames are: along each joint's axis that is free.

A body's frame may stand anywhere on the axis of its own turn, and that of a shift
anywhere at all: positions, velocities and joint forces are the same.
Each coordinate that is zero in the offset of a joint or in a centre of mass saves products, so
the origins are chosen with the fewest of these, for the whole tree at once (dynamic
programming, from the leaves to the ground).
"""

from __future__ import annotations

from math import inf

from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import Frame, Tree, Vector, along, relabel
from urdf2mbs.spatial import Vec

#: So many places are considered for each frame.
MOST = 4
#: Operations for each coordinate of an offset: in the forces, and in the composite bodies.
OFFSET, COMPOSITE = 10, 12
#: The same for a coordinate of a centre of mass.
CENTRE, FIRST_MOMENT = 10, 7
#: For each column of the mass matrix that is carried past a coordinate of an offset.
COLUMN = 4


def slide(tree: Tree, *, columns: bool) -> None:
    """Put each frame where it costs least: in the forces, or in the columns of the matrix."""
    frames = tree.frames
    places = [_Places(frame) for frame in frames]
    behind = [1] * len(frames)
    for frame in reversed(frames[1:]):
        behind[frame.parent] += behind[frame.number]
    for frame in frames[1:]:
        places[frame.number].choose_from(frame, tree, places)
    for frame in reversed(frames[1:]):
        own, before = places[frame.number], places[frame.parent]
        per_offset = COMPOSITE + COLUMN * behind[frame.number] if columns else OFFSET
        own.add_centre(FIRST_MOMENT if columns else CENTRE)
        before.add_child(own, frame, per_offset, tree.fold)
    chosen = [0] * len(frames)
    for frame in frames[1:]:
        own = places[frame.number]
        at = chosen[frame.number] = own.best[chosen[frame.parent]]
        tree.put(frame, own.slides[at])


class _Places:
    """The places considered for one frame, as expressions and as numbers."""

    def __init__(self, frame: Frame) -> None:
        self.slides: list[Vector] = [(0, 0, 0)]
        self.values: list[Vec] = [(0.0, 0.0, 0.0)]
        self.start = frame.at
        self.centre: Vec | None = None
        if frame.body is not None and frame.body.mass:
            self.centre = frame.body.com or (0.0, 0.0, 0.0)
        self.price = [0.0]
        self.best: list[int] = []
        """The place to take, for each place of the frame before."""

    def choose_from(self, frame: Frame, tree: Tree, places: list[_Places]) -> None:
        axis, before = frame.axis, places[frame.parent]
        for vector, value in zip(before.slides, before.values, strict=True):
            place = tree.behind(frame, tree.minus(vector, frame.start))
            x, y, z = (a - b for a, b in zip(value, self.start, strict=True))
            free = relabel((x, y, z), frame.change)
            if frame.turns:
                self._offer_along(axis, place[axis], free[axis])
            else:
                self._offer(place, free)
        if frame.turns:
            for child in frame.children:
                start = tree.frames[child].start
                self._offer_along(axis, start[axis], places[child].start[axis])
            if self.centre is not None and self.centre[axis]:
                self._offer_along(axis, tree.centre(frame)[axis], self.centre[axis])
        self.price = [0.0] * len(self.slides)

    def _offer_along(self, axis: int, x: Expr, value: float) -> None:
        at = [0.0, 0.0, 0.0]
        at[axis] = value
        self._offer(along(axis, x), (at[0], at[1], at[2]))

    def _offer(self, vector: Vector, value: Vec) -> None:
        if vector not in self.slides and len(self.slides) < MOST:
            self.slides.append(vector)
            self.values.append(value)

    def add_centre(self, price: float) -> None:
        if self.centre is None:
            return
        a, b, c = self.centre
        for i, (x, y, z) in enumerate(self.values):
            self.price[i] += price * ((x != a) + (y != b) + (z != c))

    def add_child(self, child: _Places, frame: Frame, price: float, fold: bool) -> None:
        """The price of each place with the best place of one child."""
        a, b, c = child.start
        adding = 0 if fold else 1
        values = [relabel(value, frame.back) for value in child.values]
        for i, (x, y, z) in enumerate(self.values):
            lowest, best = inf, 0
            for j, (u, v, w) in enumerate(values):
                total = child.price[j]
                for part in (a - x + u, b - y + v, c - z + w):
                    if part:
                        total += price
                total += adding * ((x != 0) + (y != 0) + (z != 0) + (u != 0) + (v != 0) + (w != 0))
                if total < lowest:
                    lowest, best = total, j
            self.price[i] += lowest
            child.best.append(best)
