"""The rigid groups of a robot as arrays, for the comparison of every group with every other."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from urdf2mbs.proof.groups import Side
from urdf2mbs.proof.rigid import (
    Inertia,
    rotate,
    sum_inertias,
    transform_inertia,
)

Floats = NDArray[np.float64]

#: The cost of leaving out a joint: a pair of joints is worth it up to twice this.
LEAVE_OUT = 1.5
#: The part of it for a joint that carries no mass, and so may not be modelled at all.
MASSLESS_SHARE = 0.3
#: Numbers from here on are not compared: their squares may be too large for a float.
LARGEST = 1e100
#: The words by which people name the sides of a robot.
_SIDES = {"l": "left", "r": "right"}


class Tree:
    """The groups of a side, in the ground, each joint at zero or where it is held.

    Group 0 is the ground, or the body of a floating base.  All arrays have one row for each of the
    n groups.
    """

    def __init__(
        self, side: Side, *, carries_base: bool, held: Mapping[str, float] | None = None
    ) -> None:
        """Compute the arrays.

        Args:
            side: The rigid groups, without the coordinates of a floating base.
            carries_base: Whether group 0 has mass to compare; that of the ground has none.
            held: The positions (rad or m) of coordinates that are not at zero.
        """
        groups = side.groups
        world = side.compute_poses(held)
        self.parents = [group.parent for group in groups]
        self.children = [group.children for group in groups]
        self.names = [group.coordinate for group in groups]
        """The coordinate that moves each group."""
        self.words = [find_words(group.joint) | find_words(group.child) for group in groups]
        self.revolute = np.array([group.revolute for group in groups])
        self.points: Floats = np.array([pose[9:] for pose in world])
        """A point of each axis, (n, 3) in m."""
        self.axes: Floats = np.array(
            [rotate(pose, group.axis) for group, pose in zip(groups, world, strict=True)]
        )
        """The unit vectors of the axes, (n, 3)."""
        inertias_of_groups = [
            [transform_inertia(inertia, pose) for inertia in group.inertias.values()]
            for group, pose in zip(groups, world, strict=True)
        ]
        if not carries_base:
            inertias_of_groups[0] = []
        self.below = [{number} for number in range(len(groups))]
        """Each group, with all groups that it carries."""
        carried = [list(inertias) for inertias in inertias_of_groups]
        for number in range(len(groups) - 1, 0, -1):
            parent = self.parents[number]
            carried[parent] += carried[number]
            self.below[parent] |= self.below[number]
        self.masses, self.centres, self.moments = self._sum(inertias_of_groups)
        """Of each group: kg, (n, 3) in m, and the principal moments (n, 3) in kg m^2."""
        self.carried_masses, self.carried_centres, _ = self._sum(carried)
        corners = np.vstack([self.points[1:], self.carried_centres])
        self.size = max(float(np.ptp(corners, axis=0).max()) / 2, 1e-6)
        """Half the extent of the robot (m)."""
        self.costs: Floats = np.where(self.carried_masses > 0, 1.0, MASSLESS_SHARE) * LEAVE_OUT
        """The cost of leaving out each joint."""
        self.branch_costs = [float(self.costs[[*below]].sum()) for below in self.below]
        """The cost of leaving out each joint with all that it carries."""
        self.spacings, self.twists = self._measure_axes()
        """Of each joint: the distance (m) of its axis from that of the joint before, and the sine
        of their angle."""
        self.levers = self._measure_levers()
        """The distance (m) of the centre of mass of each group from its axis."""

    def __len__(self) -> int:
        """Return the number of groups, the ground among them."""
        return len(self.parents)

    @property
    def is_measurable(self) -> bool:
        """Whether all numbers are small enough to be squared, and are numbers."""
        arrays = (self.points, self.centres, self.carried_centres, self.carried_masses)
        return all(bool((np.abs(array) < LARGEST).all()) for array in (*arrays, self.moments))

    def list_joints(self, without: Collection[int] = ()) -> list[int]:
        """Return the numbers of the groups that joints move, but for some."""
        return [number for number in range(1, len(self)) if number not in without]

    def _sum(self, parts: Sequence[Sequence[Inertia]]) -> tuple[Floats, Floats, Floats]:
        """Sum inertias: masses, centres (the joint of a group without mass), principal moments."""
        sums = [sum_inertias(inertias) for inertias in parts]
        masses = np.array([inertia.mass for inertia in sums])
        centres = np.array([inertia.centre for inertia in sums])
        tensors = np.array([inertia.tensor for inertia in sums])
        tensors = np.where(np.isfinite(tensors), tensors, LARGEST)
        matrices = tensors[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
        return (
            masses,
            np.where(masses[:, None] > 0, centres, self.points),
            np.abs(np.linalg.eigvalsh(matrices)),
        )

    def _measure_axes(self) -> tuple[Floats, Floats]:
        """Measure each axis from that of the joint before; the axis of a shift has no place.

        With e the directions, and d the vector between two points of the lines, the distance of
        lines is ``|d . (e x e')| / |e x e'|``, of parallel ones ``|d x e|``.
        """
        parents = np.array(self.parents)
        before = self.axes[parents]
        offset = self.points - self.points[parents]
        normal = np.cross(before, self.axes)
        sine = np.linalg.norm(normal, axis=1)
        skew = np.abs((offset * normal).sum(axis=1)) / np.maximum(sine, 1e-12)
        parallel = np.linalg.norm(np.cross(offset, self.axes), axis=1)
        spacing = np.where(sine > 1e-6, skew, parallel)
        placed = self.revolute & self.revolute[parents] & (parents > 0)
        return np.where(placed, spacing, 0.0), np.where(parents > 0, sine, 0.0)

    def _measure_levers(self) -> Floats:
        """Measure the centre of mass of each group from its axis."""
        levers = np.linalg.norm(np.cross(self.centres - self.points, self.axes), axis=1)
        return np.where(self.revolute & (self.masses > 0), levers, 0.0)


def find_words(name: str) -> set[str]:
    """Return the words of a name, and all pairs of neighbouring letters.

    ``l_kneeJoint`` and ``left_knee`` share three words, and the pairs of ``knee``.
    """
    words = re.findall(r"[a-z]+|\d+", re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower())
    letters = "".join(words)
    pairs = {letters[k : k + 2] for k in range(len(letters) - 1)}
    return {_SIDES.get(word, word) for word in words} | pairs
