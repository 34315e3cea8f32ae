"""``<joint>``: its links, axis and limits, and what it mimics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO
from urdf2mbs.urdf.model import (
    JOINT_TYPES,
    Calibration,
    Dynamics,
    Joint,
    Limit,
    Mimic,
    SafetyController,
)
from urdf2mbs.urdf.tree import loops
from urdf2mbs.urdf.values import quote

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading


#: Parts of a joint that can be left out, by the name that they have in URDF and in the model.
OPTIONAL: dict[str, Callable[..., Any]] = {
    "dynamics": Dynamics, "mimic": Mimic, "safety_controller": SafetyController,
    "calibration": Calibration,
}  # fmt: skip


def read_joint(reading: Reading, element: Any, joints: dict[str, Joint]) -> None:
    """Add a ``<joint>`` to ``joints``; its origin (m, rad) is in the parent link's frame."""
    name = reading.name(element, "joint", joints)
    if name is None:
        return
    kind = read_type(reading, element, name)
    parts = reading.parts(element)
    parent = read_end(reading, element, parts, "parent")
    child = read_end(reading, element, parts, "child")
    if parent == child:
        what = f"joint '{name}' has the link '{parent}' as its parent and as its child"
        reading.fail("joint-same-link", what, parts["child"])
    joint = joints[name] = Joint(
        name, kind, parent, child, reading.origin(parts.get("origin")), line=element.sourceline
    )
    axis = parts.get("axis")
    if axis is not None and kind not in ("fixed", "floating"):  # these have none
        joint.axis = reading.values(axis)["xyz"]
        if joint.axis == ZERO:
            what = f"joint '{name}' is {kind}, and its axis is zero"
            hint = 'give a direction, such as xyz="0 0 1", or make the joint fixed'
            reading.fail("axis-zero", what, axis, hint)
    if "limit" in parts:
        joint.limit = read_limit(reading, joint, parts["limit"])
    elif kind in ("revolute", "prismatic"):
        what = f"a {kind} joint wants a <limit>, and is read as one without limits"
        reading.warn("joint-limit-missing", what, element.sourceline)
    for tag, make in OPTIONAL.items():
        if tag in parts:
            try:
                setattr(joint, tag, make(**reading.values(parts[tag])))
            except ConversionError as error:
                reading.warn_of_left_out(parts[tag], f"<{tag}>", error)


def read_type(reading: Reading, element: Any, name: str) -> str:
    """The type of a joint."""
    kind: str | None = element.get("type")
    if len(element.attrib) != 2:
        reading.unknown_attributes(element)
    if kind in JOINT_TYPES:
        return kind
    types = f"the types are: {', '.join(JOINT_TYPES)}"
    if not kind:
        reading.fail("joint-type-missing", f"joint '{name}' has no type", element, types)
    reading.text(element, "type", kind)
    plain = kind.strip().lower()
    if plain not in JOINT_TYPES:
        what = f"joint '{name}' is of the type {quote(kind)}, which URDF does not know"
        reading.fail("joint-type-unknown", what, element, nearest(plain, JOINT_TYPES) or types)
    what = f"the type {quote(kind)} is read as '{plain}'"
    reading.warn("joint-type-spelling", what, element.sourceline)
    return plain


def read_end(reading: Reading, element: Any, parts: dict[str, Any], which: str) -> str:
    """The name of a joint's ``parent`` or ``child`` link."""
    part = parts.get(which)
    name: str | None = None if part is None else part.get("link")
    if part is not None and len(part.attrib) != 1:
        reading.unknown_attributes(part)
    if not name:
        what, at = f"{reading.where} has no {which} link", element if part is None else part
        reading.fail("joint-link-missing", what, at, f'give <{which} link="..."/>')
    return name


def read_limit(reading: Reading, joint: Joint, element: Any) -> Limit:
    """The limits of a joint; a number that cannot be read, or is infinite, is no limit."""
    limit = Limit(**reading.values(element, lenient="a limit"))
    lower, upper = limit.lower, limit.upper
    ranged = joint.type in ("revolute", "prismatic") and None not in (lower, upper)
    if ranged and lower > upper:  # type: ignore[operator]
        reading.warn(
            "limit-order", "lower limit above upper limit; neither counts", element.sourceline,
            detail=f"{lower!r} and {upper!r}",
        )  # fmt: skip
    return limit


def check_mimics(reading: Reading, robot: Robot) -> None:
    """Free a joint that mimics no joint, or in the end itself, with a warning."""
    joints = robot.joints
    leaders: dict[str, str] = {}
    for joint in joints.values():
        if joint.mimic is None:
            continue
        leader = joint.mimic.joint
        if leader not in joints:
            joint.mimic = None
            reading.warn(
                "mimic-left-out",
                f"'{leader}' is no joint, so its followers move freely"
                if leader
                else "<mimic> names no joint, so its joint moves freely",
                joint.line, owner=("joint", joint.name), like=(leader, joints),
            )  # fmt: skip
        else:
            leaders[joint.name] = leader
    for loop in loops(leaders):
        for name in loop:
            joints[name].mimic = None
            reading.warn(
                "mimic-left-out", "joints mimic one another, or themselves, so they move freely",
                joints[loop[0]].line, owner=("joint", name),
            )  # fmt: skip
