"""Compare the closed loops of an .mbs with its dependent joints.

A cut joins two bodies of different branches, and so adds constraints h(q) = 0.  Each independent
constraint of a loop makes one of its joints *dependent*: the number of dependent joints must be the
rank of the constraint Jacobian dh/dq.  Its elements follow from the geometry.  For a joint k on the
chain from the ground to an end of the cut, with p the point of the end::

    revolute joint    dp/dq_k = e_k x (p - p_k)    with e_k its axis, and p_k a point of the axis
    prismatic joint   dp/dq_k = e_k

A ``ball`` constrains the three components of p_2 - p_1, a ``rod`` only that along the rod, and a
``solid`` the three rotations, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from urdf2mbs.mbs.model import Connection, Mbs, Point
from urdf2mbs.messages.diagnostics import some
from urdf2mbs.proof.groups import Side
from urdf2mbs.proof.mbs_side import build_mbs_side
from urdf2mbs.proof.rigid import Frame, compose, rotate, transform_point
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import Robot

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Singular values of a constraint Jacobian up to this, relative to its largest element, are zero.
SINGULAR = 1e-7

#: A row of a constraint Jacobian: the derivatives of one constraint by the joints of the loop.
JacobianRow = dict[str, float]
#: Points by body (None: the base) and name.
Points = Mapping[tuple[str | None, str | None], Point]


class Loop(msgspec.Struct):
    """Cuts and user constraints that share joints."""

    cuts: list[Connection]
    rows: list[JacobianRow]
    joints: set[str]
    """Their joints that are not driven."""


class CutComparison(msgspec.Struct):
    """The joints that constraints tie to each other, and the differences of the cuts."""

    constrained_joints: set[str] = set()
    differences: list[Difference] = []
    but_for: dict[str, str] = {}
    not_compared: dict[str, str] = {}


def compare_cuts(robot: Robot, mbs: Mbs) -> CutComparison:
    """Compare the number of dependent joints of each loop with that of its constraints."""
    comparison = CutComparison()
    if not mbs.cuts and not mbs.user_constraints:
        return comparison
    natures = {name: joint.nature for name, joint in mbs.joints().items()}
    urdf_cuts = {cut.name for cut in mbs.cuts if _is_in_urdf(cut, robot)}
    for loop in _find_loops(mbs, natures):
        comparison.constrained_joints |= loop.joints
        if loop.cuts:
            may_be_rigid = all(cut.name in urdf_cuts for cut in loop.cuts)
            difference = _compare_loop(loop, natures, may_be_rigid=may_be_rigid)
            comparison.differences += [difference] if difference is not None else []
    for cut in mbs.cuts:
        name = f"cut '{cut.name}' ({cut.kind})"
        if cut.name in urdf_cuts:
            reason = "in <gazebo> of the URDF, whose ends are not read here"
            comparison.not_compared[name] = reason
        else:
            comparison.but_for[name] = "not in the robot's file"
    return comparison


def _is_in_urdf(cut: Connection, robot: Robot) -> bool:
    """Return True if a joint in the URDF's ``<gazebo>`` has the name of a cut."""
    names = {cut.name, cut.name.removesuffix("_1").removesuffix("_2")}
    return any(joint.name in names for extension in robot.extensions for joint in extension.joints)


def _find_loops(mbs: Mbs, natures: Mapping[str, str]) -> list[Loop]:
    """Find the loops of an .mbs: constraints that share a joint are in one loop."""
    constraints = _linearize_cuts(mbs)
    for constraint in mbs.user_constraints:
        # The derivatives are in the user functions.  Any will do that no two rows share.
        row = {
            name: 1.0 + 0.37 * len(constraints) + index
            for index, name in enumerate(constraint.joints)
        }
        constraints.append(Loop([], [row], set()))
    loops: list[Loop] = []
    for loop in constraints:
        loop.joints = {name for row in loop.rows for name in row if natures[name] != "driven"}
        for connected in [each for each in loops if not loop.joints.isdisjoint(each.joints)]:
            loops.remove(connected)
            loop.cuts = connected.cuts + loop.cuts
            loop.rows = connected.rows + loop.rows
            loop.joints |= connected.joints
        loops.append(loop)
    return loops


def _compare_loop(
    loop: Loop, natures: Mapping[str, str], *, may_be_rigid: bool
) -> Difference | None:
    """Compare the dependent joints of a loop with the rank of its constraints.

    Args:
        loop: The loop; it has at least one cut.
        natures: The nature of each joint.
        may_be_rigid: True if the loop is the URDF's, and may leave nothing that moves.
    """
    import numpy as np

    joints = sorted(loop.joints)
    jacobian = np.array([[row.get(name, 0.0) for name in joints] for row in loop.rows])
    rank = 0
    if joints:
        threshold = SINGULAR * np.abs(jacobian).max()
        rank = int(np.linalg.matrix_rank(jacobian, tol=threshold))
    cuts = "cut " + some(f"'{cut.name}'" for cut in loop.cuts)
    dependent = sum(natures[name] == "dependent" for name in joints)
    if joints and rank >= len(joints):
        if may_be_rigid:
            return None
        message = f"{cuts}: {some(joints)} cannot move"
        return Difference("cut", message, joint=joints[0])
    if dependent != rank:
        message = f"{cuts}: {dependent} of {some(joints)} dependent; expected {rank}"
        return Difference("cut", message, joint=joints[0] if joints else None)
    return None


# --- the Jacobian of a cut ---


class CutEnd(NamedTuple):
    """An end of a cut, all joints at the start."""

    point: NDArray[np.float64]
    """Position (3,) in the ground (m)."""
    chain: set[int]
    """Numbers of the groups from the ground to the body of the end."""


def _linearize_cuts(mbs: Mbs) -> list[Loop]:
    """Compute the constraint Jacobian of each cut, all joints at the start."""
    if not mbs.cuts:
        return []
    joints, points = mbs.joints(), mbs.points()
    side = build_mbs_side(mbs, {name for name, j in joints.items() if j.nature != "driven"})
    poses = side.compute_poses({name: joint.q or 0.0 for name, joint in joints.items()})
    return [
        Loop([cut], _linearize_cut(points, cut, side, poses), set())
        for cut in mbs.cuts
        if not cut.is_draft
    ]


def _linearize_cut(
    points: Points, cut: Connection, side: Side, poses: list[Frame]
) -> list[JacobianRow]:
    """Compute the constraint Jacobian of a cut.

    Args:
        points: The points of the model, by body and name.
        cut: The cut.
        side: Its rigid groups.
        poses: Pose of each group in the ground.
    """
    import numpy as np

    endpoints = (cut.endpoint1, cut.endpoint2)
    first, second = (_find_cut_end(points, endpoint, side, poses) for endpoint in endpoints)
    rod = second.point - first.point
    rod /= np.linalg.norm(rod) or 1.0
    selections = {"ball": np.eye(3, 6), "rod": np.array([[*rod, 0.0, 0.0, 0.0]])}
    constrained = selections.get(cut.kind, np.eye(6))  # a solid constrains all six
    columns: dict[str, NDArray[np.float64]] = {}
    # A joint that moves both ends alike does not move the cut.
    for number in sorted(first.chain ^ second.chain):
        group, pose = side.groups[number], poses[number]
        end, sign = (second, 1.0) if number in second.chain else (first, -1.0)
        axis = np.array(rotate(pose, group.axis))
        velocity = np.cross(axis, end.point - pose[9:]) if group.revolute else axis
        angular_velocity = axis * group.revolute
        columns[group.coordinate] = constrained @ (
            sign * np.concatenate([velocity, angular_velocity])
        )
    rows = zip(*columns.values(), strict=True)
    return [dict(zip(columns, map(float, row), strict=True)) for row in rows]


def _find_cut_end(
    points: Points, endpoint: tuple[str | None, str | None], side: Side, poses: list[Frame]
) -> CutEnd:
    """Find where an end of a cut is, and which groups lead to it."""
    import numpy as np

    body, point = endpoint
    number, pose = side.frames[body or ""]
    frame = compose(poses[number], pose)
    position = frame[9:]
    if point:
        position = transform_point(frame, points[body, point].coordinates)
    return CutEnd(np.array(position), _find_chain(side, number))


def _find_chain(side: Side, number: int) -> set[int]:
    """Find the groups from the ground to a group; the ground is not one of them."""
    chain = set()
    while number:
        chain.add(number)
        number = side.groups[number].parent
    return chain
