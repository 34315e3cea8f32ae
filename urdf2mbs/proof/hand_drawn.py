"""Find the relative pose of two groups in a model that was drawn or edited by hand.

The frames of a hand-drawn model may be anywhere: often they are rotated to make the axis of a joint
a coordinate axis.  Then the relative pose X of two groups (see ``pair``) follows neither from the
joints at zero nor from the names of links.  A model that urdf2mbs wrote never needs this file, but
to explain an error in it.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import atan2, hypot, log10
from typing import NamedTuple

from urdf2mbs.proof.pair import TOLERANCE, GroupPair
from urdf2mbs.proof.rigid import (
    Frame,
    compose,
    compute_rotation,
    cross,
    dot,
    reject_from_axis,
    rotate,
    transform_point,
)
from urdf2mbs.spatial import Vec

#: A point nearer to the axis than this, relative to the scale, does not define an angle about it.
MIN_LEVER = 1e-3


def find_best_pose(pair: GroupPair, expected_pose: Frame | None, tolerance: float) -> Frame:
    """Find the relative pose in which most features of two groups agree.

    Needed if the groups differ at the relative pose that is known for them.  Then either a feature
    is wrong, or only the pose.  The pose at which most features agree shows which, so that each
    error is reported once, for the joint or body that has it.  The candidates are:

    * zero pose: the frames of the joints at zero coincide;
    * expected pose: the frame of a link coincides with the .mbs frame of its name;
    * aligned pose: the expected pose, rotated until the axes of the joints are parallel;
    * fitted pose: the zero pose, rotated and shifted until axes and points coincide.

    The first three are stated by the model.  The fitted pose is made from the features that it is
    compared by, so it is chosen only if it explains at least two misfits.

    Args:
        pair: The two groups.
        expected_pose: Pose of the URDF's group in the .mbs's group, by the names of links; None if
            no link of the group has a known frame.
        tolerance: A larger deviation of a feature is a misfit.

    Returns:
        Pose X of the URDF's group in the .mbs's group.
    """
    zero_pose = pair.compute_zero_pose()
    stated_poses = [zero_pose]
    if expected_pose is not None:
        stated_poses += [expected_pose, _align_axes(pair, expected_pose)]
    stated_pose = min(
        stated_poses, key=lambda pose: _sum_decades(pair.compute_feature_deviations(pose))
    )
    fitted_pose = _fit_to_points(pair, _align_axes(pair, zero_pose))

    stated_deviations = pair.compute_feature_deviations(stated_pose)
    fitted_deviations = pair.compute_feature_deviations(fitted_pose)
    stated_misfits = _count_misfits(stated_deviations, tolerance)
    fitted_misfits = _count_misfits(fitted_deviations, tolerance)
    if stated_misfits == 0 and fitted_misfits == 0:
        # The closer pose is taken, because rounding errors add up along a chain of groups.
        return fitted_pose if sum(fitted_deviations) < sum(stated_deviations) else stated_pose
    # One misfit is a wrong feature: a fit to this feature would hide the error, and shift it to
    # the others.  Two misfits that vanish together have one cause, a wrong stated pose.
    return fitted_pose if stated_misfits - fitted_misfits >= 2 else stated_pose


def _sum_decades(deviations: Iterable[float]) -> float:
    """Return the sum of log10 of deviations; the smaller, the better is the pose.

    A feature that agrees adds -9, and one that is wrong adds 0, however wrong it is.  So one
    wrong feature does not outweigh several that agree, as it would in a sum of squares.
    """
    decades = sum(log10(min(max(deviation, TOLERANCE), 1.0)) for deviation in deviations)
    # Python 3.12 sums floats more exactly than 3.11; rounded, ties are ties in both.
    return round(decades, 6)


def _count_misfits(deviations: Iterable[float], tolerance: float) -> int:
    """Count the deviations beyond the tolerance; NaN is one of them."""
    return sum(not deviation <= tolerance for deviation in deviations)


def _align_axes(pair: GroupPair, pose: Frame) -> Frame:
    """Rotate a relative pose by the least angle that makes the joint axes parallel.

    With u the URDF's axis and e the .mbs's, both in .mbs axes, the rotation is by the angle
    ``atan2(|u x e|, u . e)`` about ``u x e``.  The axes of a revolute joint must also be one line,
    so the origin is projected on that of the .mbs, which passes through its origin.
    """
    urdf_axis, mbs_axis = rotate(pose, pair.urdf.axis), pair.mbs.axis
    normal = cross(urdf_axis, mbs_axis)
    sine = hypot(*normal)
    if sine > 0.0:
        unit_normal = (normal[0] / sine, normal[1] / sine, normal[2] / sine)
        rotation = compute_rotation(unit_normal, atan2(sine, dot(urdf_axis, mbs_axis)))
        pose = _with_origin(compose(rotation, pose), pose[9:])
    if pair.urdf.revolute:
        pose = _with_origin(pose, _project_on_axis(pose[9:], mbs_axis))
    return pose


class PointPair(NamedTuple):
    """A point of the URDF's group and its counterpart (m), each in the frame of its group."""

    urdf: Vec
    mbs: Vec


def _fit_to_points(pair: GroupPair, pose: Frame) -> Frame:
    """Move a relative pose, its joint axes aligned, until points of the groups coincide.

    Aligned axes leave a revolute joint an angle about its axis and a shift along it.  A prismatic
    joint keeps its rotation, and has any shift.
    """
    points = _list_points(pair)
    if pair.urdf.revolute:
        pose = _rotate_to_points(pair, pose, points)
    return _shift_to_point(pair, pose, points[0]) if points else pose


def _list_points(pair: GroupPair) -> list[PointPair]:
    """List points that both groups have: the centre of mass, then the joints of the children."""
    points: list[PointPair] = []
    if pair.urdf_inertia.mass:  # a group without mass has no centre
        points.append(PointPair(pair.urdf_inertia.centre, pair.mbs_inertia.centre))
    for urdf_child, mbs_child in pair.find_children():
        points.append(PointPair(urdf_child.joint_frame[9:], mbs_child.joint_frame[9:]))
    return points


def _rotate_to_points(pair: GroupPair, pose: Frame, points: list[PointPair]) -> Frame:
    """Rotate a relative pose about the joint axis by the first point that is off the axis.

    Seen with the axis e pointing at the viewer; p and q lead from the axis to the points of the
    URDF and of the .mbs::

              q
             /
            /  ) angle = atan2((p x q) . e, p . q)
           e--------p
    """
    axis = pair.mbs.axis
    for point in points:
        urdf_lever = reject_from_axis(transform_point(pose, point.urdf), axis)
        mbs_lever = reject_from_axis(point.mbs, axis)
        if min(hypot(*urdf_lever), hypot(*mbs_lever)) > MIN_LEVER * pair.scale:
            sine = dot(cross(urdf_lever, mbs_lever), axis)
            angle = atan2(sine, dot(urdf_lever, mbs_lever))
            return compose(compute_rotation(axis, angle), pose)
    return pose


def _shift_to_point(pair: GroupPair, pose: Frame, point: PointPair) -> Frame:
    """Shift a relative pose so that a point agrees; for a revolute joint, along its axis only."""
    urdf_point = transform_point(pose, point.urdf)
    shift = (
        point.mbs[0] - urdf_point[0],
        point.mbs[1] - urdf_point[1],
        point.mbs[2] - urdf_point[2],
    )
    if pair.urdf.revolute:
        shift = _project_on_axis(shift, pair.mbs.axis)
    return _with_origin(pose, (pose[9] + shift[0], pose[10] + shift[1], pose[11] + shift[2]))


def _project_on_axis(vector: Vec, axis: Vec) -> Vec:
    """Return the component of a vector along a unit axis."""
    length = dot(vector, axis)
    return (length * axis[0], length * axis[1], length * axis[2])


def _with_origin(frame: Frame, origin: Vec) -> Frame:
    """Return a frame with the same rotation, and another origin (m)."""
    return (*frame[:9], *origin)
