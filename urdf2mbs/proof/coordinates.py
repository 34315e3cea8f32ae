"""Match the coordinates of a URDF with the joints of an .mbs that move in the same way.

Compared are the types and natures of joints, their ``<symbols>``, and joints that follow others.
Robotran integrates an ``independent`` joint, solves a ``dependent`` one from a constraint, and
keeps a ``driven`` one at its start, unless user code moves it.  Its generated equations have zero
for a q, qd or qdd that ``<symbols>`` leaves out.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import msgspec

from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.proof.cuts import compare_cuts
from urdf2mbs.proof.match import Match
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.urdf_side import FLOATING_ORDER, Coordinate, list_coordinates
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Robot

SYMBOLS = ("q", "qd", "qdd")


class Coordinates(msgspec.Struct):
    """The coordinates of a URDF in an .mbs, and their differences."""

    names: dict[str, str] = {}
    """The URDF's coordinates that move in the .mbs, too, and their joints there."""
    locked: dict[str, float] = {}
    """The URDF's coordinates that are constant in the .mbs, and their positions (rad or m)."""
    differences: list[Difference] = []
    but_for: dict[str, str] = {}
    """Known deviations that are not differences, each with the reason."""
    not_compared: dict[str, str] = {}
    """Elements that are not compared, each with the reason."""

    def add_difference(self, kind: str, message: str, **fields: Any) -> None:
        """Add a difference; the fields are those of ``Difference``."""
        self.differences.append(Difference(kind, message, **fields))


def match_coordinates(robot: Robot, mbs: Mbs, match: Match, driven: Collection[str]) -> Coordinates:
    """Match the coordinates of a URDF with the joints of an .mbs, and find their differences.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        match: Which joints of the .mbs are those of the URDF.
        driven: The joints of the .mbs that user code moves on purpose, though they follow others
            in the URDF.
    """
    cuts = compare_cuts(robot, mbs)
    matcher = _Matcher(
        robot=robot,
        mbs_joints=mbs.joints(),
        match=match,
        driven=driven,
        constrained_joints=cuts.constrained_joints,
        result=Coordinates(
            differences=cuts.differences, but_for=cuts.but_for, not_compared=cuts.not_compared
        ),
    )
    for joint in robot.joints.values():
        if joint.moves and joint.name not in match.locked:
            matcher.match_joint(joint)
    moving_joints = set(matcher.result.names.values())
    for body in mbs.bodies:
        for mbs_joint in body.joints:
            matcher.check_mbs_joint(body, mbs_joint, is_matched=mbs_joint.name in moving_joints)
    return matcher.result


class _Matcher(msgspec.Struct):
    """Matches one joint after the other; see ``match_coordinates``."""

    robot: Robot
    mbs_joints: dict[str, Joint]
    match: Match
    driven: Collection[str]
    constrained_joints: Collection[str]
    """The joints of the .mbs that cuts and user constraints tie to each other."""
    result: Coordinates
    used_joints: set[str] = set()
    """The joints of the .mbs that are those of the URDF."""

    def match_joint(self, joint: UrdfJoint) -> None:
        """Match the coordinates of a URDF joint that moves with its joints in the .mbs."""
        order = self.match.floating_orders.get(joint.name, FLOATING_ORDER)
        coordinates = list_coordinates(joint, order)
        names = self.match.joints.get(joint.name, ())
        if len(names) != len(coordinates) or not self.mbs_joints.keys() >= set(names):
            message = f"joint '{joint.name}' ({joint.type}) is not in the .mbs"
            self._add_difference(joint, "joint-missing", message)
            return
        for coordinate, name in zip(coordinates, names, strict=True):
            self._match_coordinate(joint, coordinate, self.mbs_joints[name])

    def _match_coordinate(self, joint: UrdfJoint, coordinate: Coordinate, mbs_joint: Joint) -> None:
        """Match a coordinate of a URDF joint with a joint of the .mbs."""
        self._check_nature(joint, mbs_joint)
        name = mbs_joint.name
        if name in self.used_joints:
            message = f"joint '{name}' is matched with '{joint.name}' and with another joint"
            self._add_difference(joint, "joint-missing", message)
        elif not self._moves(joint, mbs_joint):
            self.result.locked[coordinate.name] = mbs_joint.q or 0.0
        elif mbs_joint.type[0] != coordinate.type[0]:
            expected = "R1, R2 or R3" if coordinate.type[0] == "R" else "T1, T2 or T3"
            message = f"joint '{name}' is a {mbs_joint.type}; expected {expected}"
            self._add_difference(joint, "type", message, urdf=joint.type, mbs=mbs_joint.type)
        else:
            self.result.names[coordinate.name] = name
        self.used_joints.add(name)

    def _moves(self, joint: UrdfJoint, mbs_joint: Joint) -> bool:
        """Return True if a joint of the .mbs moves as its URDF joint does."""
        if mbs_joint.nature != "driven":
            return True
        return joint.mimic is not None and _find_constant_position(self.robot, joint) is None

    def _check_nature(self, joint: UrdfJoint, mbs_joint: Joint) -> None:
        """Compare the nature of a joint with that of its URDF joint."""
        name, nature = mbs_joint.name, mbs_joint.nature
        if nature == "dependent" and name not in self.constrained_joints:
            message = f"joint '{name}' is dependent, but no cut or user constraint moves it"
            self._add_difference(joint, "nature", message, urdf="independent", mbs=nature)
        if joint.mimic is not None:
            self._check_follower(joint, mbs_joint)
        elif nature == "driven":
            message = f"joint '{name}' is driven; expected independent"
            self._add_difference(joint, "nature", message, urdf="independent", mbs=nature)

    def _check_follower(self, joint: UrdfJoint, mbs_joint: Joint) -> None:
        """Compare the nature of a joint that follows another one in the URDF (``<mimic>``)."""
        assert joint.mimic is not None
        name, nature, leader = mbs_joint.name, mbs_joint.nature, joint.mimic.joint
        position = _find_constant_position(self.robot, joint)
        if nature == "driven" and position is not None:
            mbs_position = mbs_joint.q or 0.0
            if not abs(mbs_position - position) <= TOLERANCE:
                message = f"joint '{name}' is locked at {mbs_position:.9g}; "
                message += f"expected {position:.9g}"
                self._add_difference(joint, "zero", message, urdf=position, mbs=mbs_position)
        elif nature == "independent":
            reason = "free here, coupled by <mimic> in the URDF"
            self.result.but_for[f"joint '{joint.name}'"] = reason
        elif nature == "dependent":
            reason = "held by the user functions (user_cons_hJ)"
            self.result.not_compared[f"<mimic> of joint '{joint.name}'"] = reason
        elif name in self.driven:
            reason = f"driven, so that '{leader}' does not feel it"
            self.result.but_for[f"joint '{joint.name}'"] = reason
        else:
            message = f"joint '{name}' is driven; expected dependent: it follows '{leader}', "
            message += "which then feels its inertia"
            self._add_difference(joint, "nature", message, urdf="dependent", mbs=nature)

    def check_mbs_joint(self, body: Body, joint: Joint, *, is_matched: bool) -> None:
        """Check that a joint of the .mbs has a counterpart, and symbols for its motion."""
        is_driven = joint.nature == "driven"
        if not is_driven and joint.name not in self.used_joints:
            message = f"joint '{joint.name}' of body '{body.name}' moves in the .mbs only"
            self.result.add_difference("joint-extra", message, link=body.name, joint=joint.name)
        if is_driven and not is_matched:
            messages = _check_symbols_of_constant(joint)
        else:
            messages = _check_symbols_of_moving(joint)
        for message in messages:
            self.result.add_difference("symbols", message, link=body.name, joint=joint.name)

    def _add_difference(self, joint: UrdfJoint, kind: str, message: str, **fields: Any) -> None:
        """Add a difference of a URDF joint."""
        self.result.add_difference(kind, message, link=joint.child, joint=joint.name, **fields)


def _find_constant_position(robot: Robot, joint: UrdfJoint) -> float | None:
    """Find the position (rad or m) of a follower whose multiplier is zero; else None.

    The rules of a chain of followers, ``q = m q_leader + c``, are composed.
    """
    multiplier, offset = 1.0, 0.0
    while joint.mimic is not None:
        offset += multiplier * joint.mimic.offset
        multiplier *= joint.mimic.multiplier
        joint = robot.joints[joint.mimic.joint]
    return None if multiplier else offset


def _check_symbols_of_moving(joint: Joint) -> list[str]:
    """Check the symbols of a joint that moves, which needs all three; return messages."""
    if joint.symbols is None:
        return []
    dropped = [symbol for symbol in SYMBOLS if symbol not in joint.symbols]
    if not dropped:
        return []
    message = f"joint '{joint.name}' moves, but its <symbols> omit {', '.join(dropped)}"
    return [f"{message}: Robotran's equations have zero there"]


def _check_symbols_of_constant(joint: Joint) -> list[str]:
    """Check that the numbers of a driven joint agree with its symbols; return messages."""
    symbols = SYMBOLS if joint.symbols is None else joint.symbols
    messages = []
    if joint.q and "q" not in symbols:
        message = f"joint '{joint.name}' is locked at {joint.q:.9g}, but its <symbols> omit q"
        messages.append(f"{message}: Robotran's equations have zero there")
    for symbol, value in (("qd", joint.qd), ("qdd", joint.qdd)):
        if value and symbol in symbols:
            message = f"joint '{joint.name}' is locked, but its {symbol} is {value:.9g}"
            messages.append(f"{message}: Robotran's equations move it")
    return messages
