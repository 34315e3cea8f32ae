"""Decompose joints: the method's step 2, with its Tables A.1 and A.2.

"Retrieve information on the joint binding the URDF link to its parent".  Robotran's joints act
along or about the current coordinate axes.  So a URDF joint becomes

1. driven rotations R3(yaw) R2(pitch) R1(roll): the joint's origin, in the URDF's own angles;
2. driven rotations that bring a coordinate axis onto the joint's axis;
3. the real joint, which keeps the URDF joint's name (a planar joint is three, a floating six);
4. the rotations of 2. undone, so that the body frame is the URDF link frame.

For example, a revolute joint ``knee`` about the axis (0, 1, 1), whose origin has a yaw::

    knee_origin_R3   knee_axis_R1   knee   knee_back_R1
    R3(yaw)          R1(45 deg)     R2(q)  R1(-45 deg)
    driven           driven                driven

Angles that are zero leave no joint.  A fixed joint is a T3 driven at 0; one that is a force-torque
sensor is T1 T2 T3 R1 R2 R3, all driven at 0.  The last row of Table A.2 is corrected: the angle of
its R2 is ``-atan2(z, hypot(x, y))``.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Step
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Joint
from urdf2mbs.mbs.names import free_name
from urdf2mbs.spatial import ALIGNED, Turn, axis_turns, unit

#: A unit axis that is off a coordinate axis or plane by less than this, the rounding of a double,
#: gets no note.
AXIS_ROUNDING = 1e-15
#: The .mbs joints of a floating joint, in their order.
SIX_JOINT_TYPES: tuple[str, ...] = ("T1", "T2", "T3", "R1", "R2", "R3")


class DecomposeJoints(Pass):
    """Turn each URDF joint into joints of the .mbs."""

    reads = ("robot", "bodies")
    writes = ("joints", "posture")

    def run(self, conversion: Conversion) -> None:
        """Give each body the joints of the URDF joints that lead to it."""
        names = set(conversion.robot.joints)
        for segment in conversion.segments.values():
            joints: list[Joint] = []
            for step in segment.steps:
                decompose(step)
                for joint in step.joints:
                    if joint.name != step.joint.name:
                        # Another URDF joint may have the name that a driven joint gets here.
                        joint.name = free_name(joint.name, names)
                        names.add(joint.name)
                joints += step.joints
                _note_unaligned_axis(conversion, step)
            if segment.parent is not None:
                segment.body.joints = joints


def decompose(step: Step) -> None:
    """Give a URDF joint its joints of the .mbs, in the order in which they act."""
    name = step.joint.name
    origin = _drive_turns(f"{name}_origin", step.turns)
    if step.joint.type == "fixed":
        step.coordinates = []
        step.joints = [*origin, *_lock_fixed_joint(step)]
        return
    turns, types = _choose_joint_types(step)
    if len(types) == 1:
        step.coordinates = [Joint(name, types[0])]
    else:
        step.coordinates = [Joint(f"{name}_{joint_type}", joint_type) for joint_type in types]
    inverse_turns = tuple((axis, -angle) for axis, angle in reversed(turns))
    step.joints = [
        *origin,
        *_drive_turns(f"{name}_axis", turns),
        *step.coordinates,
        *_drive_turns(f"{name}_back", inverse_turns),
    ]


def _lock_fixed_joint(step: Step) -> list[Joint]:
    """Return a driven T3 for a fixed joint; six driven joints if it is a force-torque sensor."""
    name = step.joint.name
    if step.measured:
        return [_drive(f"{name}_{joint_type}", joint_type, 0.0) for joint_type in SIX_JOINT_TYPES]
    return [_drive(name, "T3", 0.0)]


def _choose_joint_types(step: Step) -> tuple[tuple[Turn, ...], tuple[str, ...]]:
    """Choose the types of the .mbs joints that have the coordinates of a moving URDF joint.

    Returns:
        The turns that bring a coordinate axis onto the joint's axis, and the types.
    """
    if step.joint.type == "floating":
        return (), SIX_JOINT_TYPES
    turns, axis = axis_turns(step.axis)
    if step.joint.type == "planar":
        return turns, (f"T{axis % 3 + 1}", f"T{(axis + 1) % 3 + 1}", f"R{axis}")
    return turns, (f"T{axis}" if step.joint.type == "prismatic" else f"R{axis}",)


def _drive_turns(prefix: str, turns: tuple[Turn, ...]) -> list[Joint]:
    """Return a driven joint for each turn, called such as ``knee_origin_R3``."""
    return [_drive(f"{prefix}_R{axis}", f"R{axis}", angle) for axis, angle in turns]


def _drive(name: str, joint_type: str, q: float) -> Joint:
    """Return a joint that is driven at a constant coordinate q (rad or m)."""
    return Joint(name, joint_type, "driven", q=q, symbols=("q",))


def _note_unaligned_axis(conversion: Conversion, step: Step) -> None:
    """Note an axis that is taken to lie on a coordinate axis or plane, though it is a bit off."""
    joint = step.joint
    if joint.type in ("fixed", "floating"):
        return  # the axis of such a joint has no meaning
    small = [abs(component) for component in unit(step.axis) if abs(component) <= ALIGNED]
    deviation = max(small, default=0.0)
    if deviation > AXIS_ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{joint.name}': its axis is {deviation:.1e} rad off a coordinate "
            "axis or plane, and is taken to lie on it",
            joint=joint.name,
        )
