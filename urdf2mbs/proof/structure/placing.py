"""Place one robot in the ground of the other: the pose of its root, and the zeros of its joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

from urdf2mbs.proof.structure.cost import PHYSICAL, compute_costs
from urdf2mbs.proof.structure.tree import LEAVE_OUT, Floats, Tree

#: The pose of a robot in the same place as the other one, (3, 4).
SAME_PLACE = np.eye(3, 4)
#: The number of root poses that are tried beside it.
POSE_COUNT = 4
#: The rounds in which a pose is fitted to the half of the points that it fits best.
FIT_ROUNDS = 4
#: The cosine between the axes of joints that can be turned to each other.
PARALLEL = 0.95
#: A joint is turned if its subtree is off by more than this, relative to the robot's size, ...
OFF = 0.02
#: ... and less than this of it is left when it is turned.
REMAINDER = 0.6


class _Fit(NamedTuple):
    """How well a pose of the root fits."""

    cost: float
    """The mean cost of the cheapest pairs of joints, whatever their parents are."""
    pose: Floats
    a_numbers: list[int]
    b_numbers: list[int]


def find_root_poses(a: Tree, b: Tree) -> list[Floats]:
    """Find poses of a robot in the ground of the other one, the likeliest first.

    Each quarter turn about the coordinate axes is tried, as people choose axes differently, and
    fitted to the points that it brings near to each other.

    Returns:
        Up to ``POSE_COUNT`` poses (3, 4), each of another rotation.
    """
    best: dict[tuple[float, ...], _Fit] = {}
    for rotation in Rotation.create_group("O").as_matrix():
        origin = b.carried_centres[0] - rotation @ a.carried_centres[0]
        rough = _rate_pose(a, b, np.column_stack([rotation, origin]))
        fine = _rate_pose(a, b, _fit_pose(a, b, rough))
        for fit in (rough, fine):
            key = tuple(fit.pose[:, :3].round(1).flat)
            best[key] = min(best.get(key, fit), fit, key=lambda each: each.cost)
    return [fit.pose for fit in sorted(best.values(), key=lambda each: each.cost)[:POSE_COUNT]]


def _rate_pose(a: Tree, b: Tree, pose: Floats) -> _Fit:
    """Rate a pose by the joints that lie best on each other."""
    costs = compute_costs(a, b, np.repeat(pose[None], len(a), 0), PHYSICAL)[1:, 1:]
    costs = np.minimum(costs, 2 * LEAVE_OUT)
    rows, columns = linear_sum_assignment(costs)
    cost = float(costs[rows, columns].mean())
    return _Fit(cost, pose, (rows + 1).tolist(), (columns + 1).tolist())


def _fit_pose(a: Tree, b: Tree, fit: _Fit) -> Floats:
    """Fit a pose to the centres of mass of pairs of joints (trimmed Kabsch algorithm).

    In each round the half of the points that fits best decides, so that wrong pairs do not.
    """
    from_points = np.vstack([a.centres[fit.a_numbers], a.carried_centres[fit.a_numbers]])
    to_points = np.vstack([b.centres[fit.b_numbers], b.carried_centres[fit.b_numbers]])
    kept = np.ones(len(from_points), bool)
    rotation, origin = fit.pose[:, :3], fit.pose[:, 3]
    for _ in range(FIT_ROUNDS):
        from_centre, to_centre = from_points[kept].mean(axis=0), to_points[kept].mean(axis=0)
        covariance = (to_points[kept] - to_centre).T @ (from_points[kept] - from_centre)
        u, _, v = np.linalg.svd(covariance)
        rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v
        origin = to_centre - rotation @ from_centre
        distances = np.linalg.norm(from_points @ rotation.T + origin - to_points, axis=1)
        kept = distances <= np.median(distances) + 1e-12
    return np.column_stack([rotation, origin])


def turn_joints(a: Tree, b: Tree, pairs: Mapping[int, int], root_pose: Floats) -> Floats:
    """Move each joint to where its subtree lies on its counterpart, if it is far from it.

    So a joint with another zero does not hide the joints of its subtree.

    Args:
        a: The robot that is placed.
        b: The other one.
        pairs: The group of ``b`` for groups of ``a``.
        root_pose: The pose of ``a`` in the ground of ``b``, (3, 4).

    Returns:
        The pose of each group of ``a``, (n, 3, 4): from where it is by ``a``, to where it would be.
    """
    poses = np.repeat(root_pose[None], len(a), 0)
    for i in range(1, len(a)):
        poses[i] = poses[a.parents[i]]
        j = pairs.get(i)
        if j is not None and a.revolute[i] == b.revolute[j]:
            axis = poses[i, :, :3] @ a.axes[i]
            if abs(axis @ b.axes[j]) >= PARALLEL:
                poses[i] = _move_joint(a, b, pairs, (i, j), poses[i])
    return poses


def _move_joint(
    a: Tree, b: Tree, pairs: Mapping[int, int], pair: tuple[int, int], pose: Floats
) -> Floats:
    """Return the pose (3, 4) of what a joint carries, with the joint moved if that helps."""
    i, j = pair
    rotation, origin = pose[:, :3], pose[:, 3]
    axis, point = rotation @ a.axes[i], rotation @ a.points[i] + origin
    carried = [k for k in a.below[i] if k in pairs]
    counterparts = [pairs[k] for k in carried]
    own_points = np.vstack([a.centres[carried], a.points[carried]]) @ rotation.T + origin
    target = np.vstack([b.centres[counterparts], b.points[counterparts]])
    turn, shift = np.eye(3), np.zeros(3)
    if a.revolute[i]:
        angle = _fit_angle(own_points - point, target - b.points[j], axis)
        turn = Rotation.from_rotvec(angle * axis).as_matrix()
    else:
        shift = axis * np.median((target - own_points) @ axis)
    moved = (own_points - point) @ turn.T + point + shift
    before, after = (
        np.linalg.norm(points - target, axis=1).mean() for points in (own_points, moved)
    )
    if before <= OFF * b.size or after >= REMAINDER * before:
        return pose
    return np.column_stack([turn @ rotation, turn @ (origin - point) + point + shift])


def _fit_angle(own_points: Floats, target: Floats, axis: Floats) -> float:
    """Compute the angle (rad) about an axis that brings points nearest to others.

    With p and q their components normal to the axis e, the sum of ``|R p - q|^2`` is least at
    ``atan2(sum (p x q) . e, sum p . q)``.  As in a pose, the half that fits best decides.
    """
    p, q = (points - np.outer(points @ axis, axis) for points in (own_points, target))
    sines, cosines = np.cross(p, q) @ axis, (p * q).sum(axis=1)
    kept = np.ones(len(p), bool)
    angle = 0.0
    for _ in range(FIT_ROUNDS):
        angle = float(np.arctan2(sines[kept].sum(), cosines[kept].sum()))
        turned = p * np.cos(angle) + np.cross(axis, p) * np.sin(angle)
        distances = np.linalg.norm(turned - q, axis=1)
        kept = distances <= np.median(distances) + 1e-12
    return angle
