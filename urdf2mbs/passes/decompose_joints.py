"""Decompose joints: the method's step 2, "Retrieve information on the joint binding the
URDF link to its parent", with its Tables A.1 and A.2.

Robotran's joints act along or about the current coordinate axes.  So a URDF joint becomes

1. driven rotations R3(yaw) R2(pitch) R1(roll): the joint's origin, in the URDF's own angles;
2. driven rotations that bring a coordinate axis onto the joint's axis;
3. the real joint, which keeps the URDF joint's name (a planar joint is three, a floating six);
4. the rotations of 2. undone, so that the body frame is the URDF link frame.

Angles that are zero leave no joint.  A fixed joint is a T3 driven at 0; one that is a
force-torque sensor is T1 T2 T3 R1 R2 R3, all driven at 0.  The last row of
Table A.2 is corrected: the angle of its R2 is ``-atan2(z, hypot(x, y))``.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Step
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Joint
from urdf2mbs.mbs.names import free_name
from urdf2mbs.spatial import ALIGNED, Turn, axis_turns, unit

#: A unit axis so far off a coordinate axis or plane gets no note: the rounding of a double.
ROUNDING = 1e-15
SIX: tuple[str, ...] = ("T1", "T2", "T3", "R1", "R2", "R3")


class DecomposeJoints(Pass):
    reads = ("robot", "bodies")
    writes = ("joints", "posture")

    def run(self, conversion: Conversion) -> None:
        taken = set(conversion.robot.joints)
        for segment in conversion.segments.values():
            joints: list[Joint] = []
            for step in segment.steps:
                decompose(step)
                for joint in step.joints:
                    if joint.name != step.joint.name:
                        # a URDF joint may have the name of a driven joint of ours
                        joint.name = free_name(joint.name, taken)
                        taken.add(joint.name)
                joints += step.joints
                _note_axis_off(conversion, step)
            if segment.parent is not None:
                segment.body.joints = joints


def decompose(step: Step) -> None:
    """Give a step its .mbs joints, in the order in which they act."""
    name, kind = step.joint.name, step.joint.type
    origin = _turns(f"{name}_origin", step.turns)
    if kind == "fixed":
        held = {f"{name}_{type_}": type_ for type_ in SIX} if step.measured else {name: "T3"}
        step.coordinates = []
        step.joints = [*origin, *(_drive(name, type_, 0.0) for name, type_ in held.items())]
        return
    turns: tuple[Turn, ...] = ()
    types = SIX
    if kind != "floating":
        turns, k = axis_turns(step.axis)
        if kind == "planar":
            types = (f"T{k % 3 + 1}", f"T{(k + 1) % 3 + 1}", f"R{k}")
        else:
            types = (f"T{k}" if kind == "prismatic" else f"R{k}",)
    if len(types) == 1:
        step.coordinates = [Joint(name, types[0])]
    else:
        step.coordinates = [Joint(f"{name}_{type_}", type_) for type_ in types]
    undone = tuple((k, -angle) for k, angle in reversed(turns))
    there, back = _turns(f"{name}_axis", turns), _turns(f"{name}_back", undone)
    step.joints = [*origin, *there, *step.coordinates, *back]


def _turns(name: str, turns: tuple[Turn, ...]) -> list[Joint]:
    return [_drive(f"{name}_R{k}", f"R{k}", angle) for k, angle in turns]


def _drive(name: str, type_: str, q: float) -> Joint:
    return Joint(name, type_, "driven", q=q, symbols=("q",))


def _note_axis_off(conversion: Conversion, step: Step) -> None:
    joint = step.joint
    if joint.type in ("fixed", "floating"):
        return  # an axis that a pass has left there means nothing
    off = max((abs(c) for c in unit(step.axis) if abs(c) <= ALIGNED), default=0.0)
    if off > ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{joint.name}': its axis is {off:.1e} rad off a coordinate "
            "axis or plane, and is taken to lie on it",
            joint=joint.name,
        )
