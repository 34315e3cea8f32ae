"""Which joints are mirrored: those of the left arm and the right arm, of two legs, two fingers.

The axes of the second limb's frames are named anew, so that the same joints turn about axes of
the same name in both: a URDF often has them named otherwise, and then the same equations would
look different.  Naming them costs no operation.
"""

from __future__ import annotations

from itertools import permutations, product

from urdf2mbs_equations.tree import Frame, Tree, is_fixed
from urdf2mbs_equations.vectors import OWN, Axes

#: All ways to name the axes of a frame anew: those of a right-handed frame.
NAMES = [
    Axes(((i, a), (j, b), (k, c)))
    for i, j, k in permutations(range(3))
    for a, b, c in product((1, -1), repeat=3)
    if a * b * c == (1 if (j - i) % 3 == 1 else -1)
]


def find_mirrored(tree: Tree) -> tuple[dict[int, int], dict[int, Axes]]:
    """By number the twin of each joint that has one, and the axes of frames in second limbs.

    Joints that move alike, behind the same one or behind two twins, are twins: first those with as
    many behind them, in the same branches.
    """
    finder = _Finder(tree)
    finder.find()
    return finder.twin, finder.labels


class _Finder:
    def __init__(self, tree: Tree) -> None:
        self.tree, frames = tree, tree.frames
        self.behind: list[list[int]] = [[] for _ in frames]
        """The next joints that move."""
        self.between: list[list[Frame]] = [[] for _ in frames]
        """The joints that never move between each and the one before that does."""
        self.shape = [0] * len(frames)
        """Equal for joints that have the same behind them."""
        for frame in frames[1:]:
            before = frames[frame.parent]
            while before.number and is_fixed(before.joint):
                self.between[frame.number].insert(0, before)
                before = frames[before.parent]
            if not is_fixed(frame.joint):
                self.behind[before.number].append(frame.number)
        known: dict[tuple[object, ...], int] = {}
        for frame in reversed(frames):
            k = frame.number
            key = frame.turns, *sorted(self.shape[i] for i in self.behind[k])
            self.shape[k] = known.setdefault(key, len(known))
        self.twin: dict[int, int] = {}
        self.labels: dict[int, Axes] = {}

    def find(self) -> None:
        stack = [(0, 0)]
        while stack:
            left, right = stack.pop()
            pairs = self._pairs(self.behind[left], self.behind[right])
            if left == right:
                paired = {k for pair in pairs for k in pair}
                stack += [(k, k) for k in self.behind[left] if k not in paired]
            else:
                self._name(left, right, pairs)
            stack += pairs

    def _pairs(self, lefts: list[int], rights: list[int]) -> list[tuple[int, int]]:
        """Pairs of joints behind two twins, or behind one joint: then both lists are the same."""
        same = lefts is rights
        left = list(lefts)
        right = left if same else list(rights)
        out = []
        turns = [frame.turns for frame in self.tree.frames]
        for kind in (self.shape, turns):
            for k in lefts:
                candidates = (j for j in right if (j > k or not same) and kind[k] == kind[j])
                j = next(candidates, 0) if k in left else 0
                if j:
                    out.append((k, j))
                    left.remove(k)
                    right.remove(j)
        return out

    def _name(self, left: int, right: int, pairs: list[tuple[int, int]]) -> None:
        """Name the axes of the second of two twins, and of the fixed joints before it."""
        frames, lefts, rights = self.tree.frames, self.between[left], self.between[right]
        alike = len(lefts) == len(rights)
        for frame, twin in zip(rights, lefts if alike else [None] * len(rights), strict=True):
            self._choose(frame, twin, [(left, right)])
        self._choose(frames[right], frames[left], pairs)

    def _choose(self, frame: Frame, twin: Frame | None, pairs: list[tuple[int, int]]) -> None:
        """Own axis and next axes like the twin's, and else the names of the frame before."""
        before = self.labels.get(frame.parent, OWN)
        square = is_fixed(frame.joint) and frame.sin in (0, 1, -1)
        wanted = []
        if twin is not None:
            wanted = [(self._axis(j, frame), self._axis(k, twin)) for k, j in pairs]

        def price(names: Axes) -> tuple[bool, int, bool]:
            new = {index: i for i, (index, _) in enumerate(names)}
            own = twin is not None and not square and new[frame.axis] != twin.axis
            off = sum(1 for a, b in wanted if a is not None and new[a] != b)
            return own, off, names != before

        names = min((names for names in NAMES if (frame.axis, 1) in names), key=price)
        self.labels[frame.number] = names
        if twin is not None and names[twin.axis] == (frame.axis, 1):
            self.twin[frame.number], self.twin[twin.number] = twin.number, frame.number

    def _axis(self, number: int, frame: Frame) -> int | None:
        """The axis of a joint behind a frame, as one of the frame's if it is one."""
        v = self.tree.frames[number].unit
        for fixed in reversed(self.between[number]):
            if fixed is frame:
                break
            v = fixed.to_parent(v)
        axes = [i for i, x in enumerate(v) if x]
        return axes[0] if len(axes) == 1 else None
