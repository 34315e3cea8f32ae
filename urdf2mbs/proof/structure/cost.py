"""The cost of taking a joint of one robot for a joint of the other.

A cost is a weighted sum of terms between 0 (the same) and about 1 (nothing in common).  Terms of
the place depend on where the robots stand; the others are seen from the joint alone, and hold
however the robot is turned, and wherever its joints have their zero.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from urdf2mbs.proof.structure.tree import Floats, Tree

#: How much each term weighs.
WEIGHTS = {
    # of the place
    "axis": 1.0,
    "line": 0.8,
    "carried centre": 0.4,
    "own centre": 0.4,
    # of the joint alone
    "kind": 0.8,
    "carried mass": 0.3,
    "own mass": 0.4,
    "moments": 0.2,
    "spacing": 0.2,
    "twist": 0.2,
    "lever": 0.2,
    "count": 0.3,
    # of people
    "name": 0.05,
}
#: The terms that say how well a pose of the robot fits: all but the name.
PHYSICAL = tuple(term for term in WEIGHTS if term != "name")
#: The terms of a joint that the other robot holds: its links are in the parent group there.
OF_HELD = ("axis", "line", "kind", "carried centre", "carried mass")
#: The distance, relative to the robot's size, that costs half of the weight of a term.
NEAR = 0.1
#: The mass, relative to that of the robot, and the moment, relative to such a mass at the robot's
#: size, below which differences fade.
FAINT_MASS = 1e-3
FAINT_MOMENT = 1e-2


def compute_costs(a: Tree, b: Tree, poses: Floats, terms: Iterable[str] = tuple(WEIGHTS)) -> Floats:
    """Compute the cost of each pair of groups.

    Args:
        a: A robot.
        b: Another one.
        poses: The pose of each group of ``a`` in the ground of ``b``, (n, 3, 4): from where it is
            by ``a``, to where it would be.
        terms: The terms that are summed.

    Returns:
        Costs (n, m).
    """
    pairs = _Pairs(a, b, poses)
    costs = np.zeros((len(a), len(b)))
    for term in terms:
        compute = getattr(pairs, f"compute_{term.replace(' ', '_')}")
        costs += WEIGHTS[term] * compute()
    return costs


class _Pairs:
    """All pairs of the groups of two robots; each method computes a term, (n, m)."""

    def __init__(self, a: Tree, b: Tree, poses: Floats) -> None:
        self.a = a
        self.b = b
        self.rotations, self.origins = poses[:, :, :3], poses[:, :, 3]
        self.axes = self._rotate(a.axes)
        self.near = NEAR * max(a.size, b.size)
        self.faint_mass = FAINT_MASS * max(a.carried_masses[0], b.carried_masses[0], 1e-9)

    def _rotate(self, vectors: Floats) -> Floats:
        """Rotate a vector of each group of ``a``."""
        rotated: Floats = np.einsum("nij,nj->ni", self.rotations, vectors)
        return rotated

    def _place(self, points: Floats) -> Floats:
        """Return where a point of each group of ``a`` is in the ground of ``b`` (m)."""
        return self._rotate(points) + self.origins

    def _fade(self, distances: Floats) -> Floats:
        """Return 0 for no distance, 1/2 for one that is near, and 1 for a far one."""
        faded: Floats = distances / (distances + self.near)
        return faded

    def _compute_gaps(self, a: Floats, b: Floats) -> Floats:
        """Compute the distances between points of both robots, faded."""
        distances: Floats = np.linalg.norm(self._place(a)[:, None] - b, axis=2)
        return self._fade(distances)

    @staticmethod
    def _compute_ratios(a: Floats, b: Floats, faint: float) -> Floats:
        """Compute the differences of positive numbers, relative to the larger one."""
        a = a[:, None]
        ratios: Floats = np.abs(a - b) / (np.maximum(a, b) + faint)
        return ratios

    def compute_kind(self) -> Floats:
        """Compare whether joints turn or shift."""
        unlike: Floats = np.not_equal.outer(self.a.revolute, self.b.revolute).astype(float)
        return unlike

    def compute_axis(self) -> Floats:
        """Compare the directions of axes: the sine, and little for the opposite one."""
        cosines = self.axes @ self.b.axes.T
        angles: Floats = np.sqrt(np.clip(1 - cosines**2, 0, 1)) + 0.1 * (cosines < 0)
        return angles

    def compute_line(self) -> Floats:
        """Compare where the axes of rotations are; of a shift, where it is drawn, for less."""
        offsets = self._place(self.a.points)[:, None] - self.b.points
        across_a = np.linalg.norm(np.cross(offsets, self.axes[:, None]), axis=2)
        across_b = np.linalg.norm(np.cross(offsets, self.b.axes[None]), axis=2)
        of_lines = self._fade((across_a + across_b) / 2)
        of_points = 0.3 * self._fade(np.linalg.norm(offsets, axis=2))
        both_turn = np.logical_and.outer(self.a.revolute, self.b.revolute)
        return np.where(both_turn, of_lines, of_points)

    def compute_carried_centre(self) -> Floats:
        """Compare the centres of all that the joints carry."""
        return self._compute_gaps(self.a.carried_centres, self.b.carried_centres)

    def compute_own_centre(self) -> Floats:
        """Compare the centres of the groups."""
        return self._compute_gaps(self.a.centres, self.b.centres)

    def compute_carried_mass(self) -> Floats:
        """Compare the masses of all that the joints carry."""
        return self._compute_ratios(self.a.carried_masses, self.b.carried_masses, self.faint_mass)

    def compute_own_mass(self) -> Floats:
        """Compare the masses of the groups."""
        return self._compute_ratios(self.a.masses, self.b.masses, self.faint_mass)

    def compute_moments(self) -> Floats:
        """Compare the principal moments of inertia of the groups."""
        faint = FAINT_MOMENT * self.faint_mass * self.b.size**2
        moments = zip(self.a.moments.T, self.b.moments.T, strict=True)
        ratios: Floats = np.mean([self._compute_ratios(a, b, faint) for a, b in moments], axis=0)
        return ratios

    def compute_spacing(self) -> Floats:
        """Compare the distances of the axes from those of the joints before."""
        return self._fade(np.abs(np.subtract.outer(self.a.spacings, self.b.spacings)))

    def compute_twist(self) -> Floats:
        """Compare the angles of the axes to those of the joints before."""
        return np.abs(np.subtract.outer(self.a.twists, self.b.twists))

    def compute_lever(self) -> Floats:
        """Compare the distances of the centres of mass from the axes."""
        return self._fade(np.abs(np.subtract.outer(self.a.levers, self.b.levers)))

    def compute_count(self) -> Floats:
        """Compare how many joints each joint carries."""
        counts_a, counts_b = (
            np.array([float(len(below)) for below in tree.below]) for tree in (self.a, self.b)
        )
        return self._compute_ratios(counts_a, counts_b, 0.0)

    def compute_name(self) -> Floats:
        """Compare the words of the names."""
        return np.array(
            [[1.0 - len(a & b) / max(len(a | b), 1) for b in self.b.words] for a in self.a.words]
        )
