"""Find the joints of one robot that are those of another, without their names.

Two trees of rigid groups are laid over each other at the least cost: joints turn or shift about
lines that may coincide, and carry masses that may be equal (``cost``, ``edit_distance``).  The
robot may stand elsewhere, and its joints may have other zeros (``placing``).  Of layouts that cost
nearly the same, the *judge* decides, which is the comparison of the two robots itself: the one with
the fewest joints that differ.  Joints that it cannot tell apart are listed as equal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import NamedTuple

import msgspec
import numpy as np
from scipy.optimize import linear_sum_assignment

from urdf2mbs.proof.match import Exchange
from urdf2mbs.proof.structure.cost import OF_HELD, WEIGHTS, compute_costs
from urdf2mbs.proof.structure.edit_distance import EditDistance
from urdf2mbs.proof.structure.placing import SAME_PLACE, find_root_poses, turn_joints
from urdf2mbs.proof.structure.tree import LEAVE_OUT, Floats, Tree

#: The rounds in which joints are turned, and the trees laid again.
LAYING_ROUNDS = 4
#: The root is tried elsewhere if more joints differ than this.
GOOD_ENOUGH = 1
#: An exchange that costs less than this for each joint is left to the judge; of joints that do not
#: differ, only half of it.
CLOSE = 1.0
#: The most exchanges that the judge looks at: each is a comparison.
MOST_TRIALS = 100
#: Names that are more alike by this after an exchange say that it should be made.
ALIKE = 0.2
#: A joint that is held, and costs less, is the one that moves in the other robot.
HELD = 0.25
#: Differences that are larger by no more than this share are as large.
AS_LARGE = 1.0 + 1e-6


class Score(NamedTuple):
    """What the judge finds of a layout; the less, the better."""

    joints: int
    """How many joints, or links, have a difference."""
    total: float
    """The sum of all relative differences."""
    coordinates: frozenset[str] = frozenset()
    """The coordinates of the first robot that have a difference."""

    def is_better(self, score: Score) -> bool:
        """Return True if fewer joints differ, or by less."""
        return self[:2] < score[:2]

    def is_as_good(self, best: Score) -> bool:
        """Return True if nobody can tell this layout from a better one by its differences."""
        return self.joints <= best.joints and self.total < AS_LARGE * best.total + 1e-9


#: Compares two robots, whose coordinates are matched by name.
Judge = Callable[[dict[str, str]], Score]


class StructureMatch(msgspec.Struct):
    """The coordinates of two robots that are the same."""

    names: dict[str, str]
    """Coordinates of the first robot, and their names in the second."""
    score: Score
    held: dict[str, str] = {}
    """Coordinates that the second robot holds."""
    equal: list[tuple[str, str]] = []
    """Coordinates of the first robot that may be exchanged, with as few differences."""
    against: list[Exchange] = []
    turned: bool = False
    """Another pose of the whole robot leaves as few differences."""


class _Trial(NamedTuple):
    """An exchange of two joints that is not made."""

    joints: tuple[int, int]
    score: Score
    gain: float
    """How much more alike the names of the pairs would be."""


class _Layout(NamedTuple):
    """One way to lay the first robot over the second."""

    score: Score
    pairs: dict[int, int]
    distance: EditDistance
    costs: Floats
    """The cost of each pair, (n, m)."""
    poses: Floats
    """The pose of each group of the first robot, (n, 3, 4)."""
    name_cost: float
    """How unlike the names are, the mean of all pairs."""

    @property
    def cost(self) -> float:
        """The cost of the layout for each joint."""
        return self.distance.lay_branch(0, 0).cost / len(self.distance.a)


def match_by_structure(
    a: Tree, b: Tree, whole_b: Tree, judge: Judge, kept_pairs: Mapping[int, int]
) -> StructureMatch:
    """Match the coordinates of two robots.

    Args:
        a: The first robot.
        b: The second one.
        whole_b: The second one, with the coordinates that it holds.
        judge: Counts the joints that differ.
        kept_pairs: Pairs of groups that must be kept.
    """
    return _Matcher(a, b, judge, kept_pairs).match(whole_b)


class _Matcher:
    """Lays the first robot over the second; see ``match_by_structure``."""

    def __init__(self, a: Tree, b: Tree, judge: Judge, kept_pairs: Mapping[int, int]) -> None:
        self.a = a
        self.b = b
        self.kept_pairs = kept_pairs
        self._judge = judge
        self._scores: dict[frozenset[tuple[int, int]], Score] = {}
        poses = np.repeat(SAME_PLACE[None], len(a), 0)
        self._name_costs = compute_costs(a, b, poses, ["name"]) / WEIGHTS["name"]

    def match(self, whole_b: Tree) -> StructureMatch:
        """Find the best layout, and those that are as good."""
        layouts = self._find_layouts()
        layout = self._choose(layouts)
        turned = any(
            each.score.is_as_good(layout.score) and each.pairs != layout.pairs for each in layouts
        )
        pairs, trials = self._exchange(layout)
        if layout is not layouts[0]:  # the robot as it stands deserves exchanges, too
            straight_pairs, straight_trials = self._exchange(layouts[0])
            if self._ask(straight_pairs).is_better(self._ask(pairs)):
                layout, pairs, trials = layouts[0], straight_pairs, straight_trials
        score = self._ask(pairs)
        names = self.a.names
        return StructureMatch(
            names=self._name(pairs),
            score=score,
            held=self._find_held(whole_b, layout, pairs),
            equal=[(names[i], names[k]) for (i, k), trial, _ in trials if trial.is_as_good(score)],
            against=[
                Exchange((names[i], names[k]), trial.joints)
                for (i, k), trial, gain in trials
                if gain > ALIKE and not trial.is_as_good(score)
            ],
            turned=turned,
        )

    def _ask(self, pairs: Mapping[int, int]) -> Score:
        """Return what the judge finds of pairs; it is asked once."""
        key = frozenset(pairs.items())
        if key not in self._scores:
            self._scores[key] = self._judge(self._name(pairs))
        return self._scores[key]

    def _name(self, pairs: Mapping[int, int]) -> dict[str, str]:
        return {self.a.names[i]: self.b.names[j] for i, j in pairs.items()}

    def _sum_names(self, pairs: Mapping[int, int]) -> float:
        """Sum how unlike the names of pairs are."""
        return float(sum(self._name_costs[pair] for pair in pairs.items()))

    # --- layouts ---

    def _find_layouts(self) -> list[_Layout]:
        """Find the best layout for each pose of the root that may be right."""
        layouts = [self._lay(SAME_PLACE)]
        if layouts[0].score.joints > GOOD_ENOUGH and min(len(self.a), len(self.b)) > 1:
            layouts += [self._lay(pose) for pose in find_root_poses(self.a, self.b)]
        return layouts

    def _lay(self, root_pose: Floats) -> _Layout:
        """Lay the trees, turn the joints, and lay them again until nothing changes."""
        a, b = self.a, self.b
        pairs: dict[int, int] = {}
        for _ in range(LAYING_ROUNDS):
            poses = turn_joints(a, b, pairs, root_pose)
            costs = compute_costs(a, b, poses)
            distance = EditDistance(a, b, costs, self.kept_pairs)
            last_pairs, pairs = pairs, distance.lay_all()
            if pairs == last_pairs:
                break
        pairs |= self._pair_elsewhere(costs, pairs)
        name_cost = self._sum_names(pairs) / max(len(pairs), 1)
        return _Layout(self._ask(pairs), pairs, distance, costs, poses, name_cost)

    def _pair_elsewhere(self, costs: Floats, pairs: Mapping[int, int]) -> dict[int, int]:
        """Pair the remaining joints that are alike, though their parents are not paired."""
        a_joints = self.a.list_joints(without=pairs)
        b_joints = self.b.list_joints(without=[*pairs.values()])
        rows, columns = linear_sum_assignment(costs[np.ix_(a_joints, b_joints)])
        left_over = (
            (a_joints[row], b_joints[column]) for row, column in zip(rows, columns, strict=True)
        )
        return {i: j for i, j in left_over if costs[i, j] < LEAVE_OUT / 2}

    def _choose(self, layouts: list[_Layout]) -> _Layout:
        """Choose a layout by the joints that differ, and by its cost.

        If most joints differ in each of them, their number says nothing: then the cost and the
        names decide.
        """
        count = len(self.a)
        if all(layout.score.joints > count / 2 for layout in layouts):
            return min(layouts, key=lambda layout: layout.cost + layout.name_cost)
        return min(layouts, key=lambda layout: round(layout.score.joints / count + layout.cost, 1))

    # --- exchanges ---

    def _exchange(self, layout: _Layout) -> tuple[dict[int, int], list[_Trial]]:
        """Exchange joints of a layout as long as fewer differ.

        Returns:
            The pairs that the judge prefers, and the scores of the others.
        """
        pairs = dict(layout.pairs)
        trials: list[_Trial] = []
        for i, k in combinations(sorted(pairs), 2):  # parents first
            if len(trials) == MOST_TRIALS:
                break
            exchanged = self._make_exchange(layout, pairs, i, k)
            if not exchanged:
                continue
            old, new = self._ask(pairs), self._ask(exchanged)
            gain = self._sum_names(pairs) - self._sum_names(exchanged)
            if new.is_better(old):
                pairs, new, gain = exchanged, old, -gain
            trials.append(_Trial((i, k), new, gain))
        return pairs, trials

    def _make_exchange(
        self, layout: _Layout, pairs: Mapping[int, int], i: int, k: int
    ) -> dict[int, int]:
        """Exchange two joints, if that costs little or their names ask for it; else return none.

        Branches on one parent are exchanged whole, and laid anew; other joints alone.
        """
        a, b = self.a, self.b
        j, q = pairs.get(i), pairs.get(k)
        if j is None or q is None:
            return {}
        if a.parents[i] != a.parents[k] or b.parents[j] != b.parents[q]:
            costs = layout.costs
            more = costs[i, q] + costs[k, j] - costs[i, j] - costs[k, q]
            is_kept = not self.kept_pairs.keys().isdisjoint((i, k))
            differ = {a.names[i], a.names[k]} <= self._ask(pairs).coordinates
            close = 2 * CLOSE if differ else CLOSE / 2
            return {} if is_kept or more >= close else {**pairs, i: q, k: j}
        branches = a.below[i] | a.below[k]
        if not self.kept_pairs.keys().isdisjoint(branches):
            return {}
        lay = layout.distance.lay_branch
        crossed, straight = (lay(i, q), lay(k, j)), (lay(i, j), lay(k, q))
        exchanged = {x: y for x, y in pairs.items() if x not in branches}
        used = set(exchanged.values())
        exchanged |= {x: y for branch in crossed for x, y in branch.pairs if y not in used}
        more = sum(branch.cost for branch in crossed) - sum(branch.cost for branch in straight)
        is_asked_for = self._sum_names(pairs) - self._sum_names(exchanged) > ALIKE
        return exchanged if more < CLOSE * len(branches) or is_asked_for else {}

    # --- joints that are held ---

    def _find_held(
        self, whole_b: Tree, layout: _Layout, pairs: Mapping[int, int]
    ) -> dict[str, str]:
        """Find joints that the second robot holds where the first one moves."""
        held = [j for j in whole_b.list_joints() if whole_b.names[j] not in self.b.names]
        costs = compute_costs(self.a, whole_b, layout.poses, OF_HELD)
        likely = [
            (float(costs[i, j]), i, j)
            for i in self.a.list_joints(without=pairs)
            for j in held
            if costs[i, j] < HELD
        ]
        names, held_names = self._name(pairs), dict[str, str]()
        score = self._ask(pairs)
        for _, i, j in sorted(likely)[:MOST_TRIALS]:
            name, held_name = self.a.names[i], whole_b.names[j]
            if name in held_names or held_name in held_names.values():
                continue
            new = self._judge({**names, **held_names, name: held_name})
            if not score.is_better(new):
                score = new
                held_names[name] = held_name
        return held_names
