"""Lay one tree of joints over the other, at the least cost.

This is the constrained edit distance of unordered trees (Zhang, Algorithmica 15, 1996): a branch is
laid over a branch, so that what one joint carries stays together.  At each level the branches are
assigned to each other by the Hungarian algorithm.  A joint that the other robot lacks is left out:

* with all that it carries, or
* alone, its children attached to its parent; then all branches of the other robot at this place are
  laid over these children.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from urdf2mbs.proof.structure.tree import Floats, Tree

#: The cost of a pair that is kept_pairs, and of all others with one of its joints.
KNOWN, EXCLUDED = -1e2, 1e3
#: A cost that no assignment takes.
IMPOSSIBLE = 1e6

#: The group of the second tree that lies under each group of the first.
Pairs = tuple[tuple[int, int], ...]


class Layout(NamedTuple):
    """A way to lay branches over branches."""

    cost: float
    pairs: Pairs


class EditDistance:
    """The cheapest layouts of all branches of a tree over all branches of another one."""

    def __init__(self, a: Tree, b: Tree, costs: Floats, kept_pairs: Mapping[int, int]) -> None:
        """Compute the layouts of all branches, those of children first.

        Args:
            a: A tree of n groups.
            b: A tree of m groups.
            costs: The cost of each pair, (n, m).
            kept_pairs: Pairs that must be kept.
        """
        self.a = a
        self.b = b
        costs = costs.copy()
        for i, j in kept_pairs.items():
            costs[i] = costs[:, j] = EXCLUDED
        for i, j in kept_pairs.items():
            costs[i, j] = KNOWN
        self._costs: list[list[float]] = costs.tolist()
        self._branches: dict[tuple[int, int], Layout] = {}
        self._carried: dict[tuple[int, int], Layout] = {}
        for i in reversed(range(len(a))):  # children come after their parents: no deep recursion
            for j in reversed(range(len(b))):
                self._carried[i, j] = self._find_carried_layout(i, j)
                self._branches[i, j] = self._find_branch_layout(i, j)

    def lay_all(self) -> dict[int, int]:
        """Return the pairs of the cheapest layout, without the ground."""
        return dict(self.lay_branch(0, 0).pairs[1:])

    def lay_branch(self, i: int, j: int) -> Layout:
        """Lay a joint, and all that it carries, over another one."""
        return self._branches[i, j]

    def _find_branch_layout(self, i: int, j: int) -> Layout:
        """Find the cheapest layout: joint over joint, or one of them left out."""
        a, b = self.a, self.b
        carried = self._carried[i, j]
        own_cost = self._costs[i][j] if i else 0.0
        best = Layout(carried.cost + own_cost, ((i, j), *carried.pairs))
        if i:
            for child in b.children[j]:
                layout = self.lay_branch(i, child)
                cost = b.branch_costs[j] - b.branch_costs[child] + layout.cost
                best = min(best, Layout(cost, layout.pairs), key=_get_cost)
        if j:
            for child in a.children[i]:
                layout = self.lay_branch(child, j)
                cost = a.branch_costs[i] - a.branch_costs[child] + layout.cost
                best = min(best, Layout(cost, layout.pairs), key=_get_cost)
        return best

    def _find_carried_layout(self, i: int, j: int) -> Layout:
        """Find how all that a joint carries lies over all that another one carries.

        Either branch over branch, or all over the branches of a single one, which is left out.
        """
        a, b = self.a, self.b
        a_children, b_children = a.children[i], b.children[j]
        a_cost = sum(a.branch_costs[child] for child in a_children)
        b_cost = sum(b.branch_costs[child] for child in b_children)
        if not a_children or not b_children:
            return Layout(a_cost + b_cost, ())
        best = self._assign(a_children, b_children)
        for child in filter(b.children.__getitem__, b_children):
            layout = self._carried[i, child]
            cost = b_cost - b.branch_costs[child] + float(b.costs[child]) + layout.cost
            best = min(best, Layout(cost, layout.pairs), key=_get_cost)
        for child in filter(a.children.__getitem__, a_children):
            layout = self._carried[child, j]
            cost = a_cost - a.branch_costs[child] + float(a.costs[child]) + layout.cost
            best = min(best, Layout(cost, layout.pairs), key=_get_cost)
        return best

    def _assign(self, a_children: list[int], b_children: list[int]) -> Layout:
        """Assign branches to branches, each to one, or to none.

        The table has a row for each branch of the first tree, and one for each of the second that
        is left out; columns likewise::

                          branches of b    left out of a
            branches of a   lay_branch       its cost on the diagonal
            left out of b   on the diagonal  0
        """
        layouts = [[self.lay_branch(i, j) for j in b_children] for i in a_children]
        a_costs = [self.a.branch_costs[i] for i in a_children]
        b_costs = [self.b.branch_costs[j] for j in b_children]
        n, m = len(a_children), len(b_children)
        if n == m == 1:  # most joints carry one
            left_out = Layout(a_costs[0] + b_costs[0], ())
            return min(layouts[0][0], left_out, key=_get_cost)
        table = np.full((n + m, n + m), IMPOSSIBLE)
        table[:n, :m] = [[layout.cost for layout in row] for row in layouts]
        table[range(n), range(m, m + n)] = a_costs
        table[range(n, n + m), range(m)] = b_costs
        table[n:, m:] = 0.0
        rows, columns = linear_sum_assignment(table)
        pairs: Pairs = ()
        for row, column in zip(rows, columns, strict=True):
            if row < n and column < m:
                pairs += layouts[row][column].pairs
        return Layout(float(table[rows, columns].sum()), pairs)


def _get_cost(layout: Layout) -> float:
    return layout.cost
