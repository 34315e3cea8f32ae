"""``<joint>``: its links, axis and limits, and what it mimics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO
from urdf2mbs.urdf.elements import quote, suggest_attributes
from urdf2mbs.urdf.model import (
    JOINT_TYPES,
    RATES,
    Calibration,
    Dynamics,
    Joint,
    Limit,
    Mimic,
    SafetyController,
)
from urdf2mbs.urdf.tree import loops

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading


#: Parts of a joint that can be left out, by the name that they have in URDF and in the model.
OPTIONAL: dict[str, Callable[..., Any]] = {
    "dynamics": Dynamics,
    "mimic": Mimic,
    "safety_controller": SafetyController,
    "calibration": Calibration,
}
#: Numbers that are zero or more, by element, and what they do below zero.
NOT_NEGATIVE = {
    "dynamics": (("damping", "friction"), "drives the joint"),
    "limit": (("effort", *RATES), "permits nothing"),
}


def read_joint(reading: Reading, element: Any, joints: dict[str, Joint]) -> None:
    """Add a ``<joint>`` to ``joints``; its origin (m, rad) is in the parent link's frame.

    Args:
        reading: The file being read.
        element: The element of lxml.
        joints: The joints that were read before, by name.

    Raises:
        ConversionError: The joint has no meaning: a name, a link or its type is missing, its axis
            is zero, or a number that the .mbs needs cannot be read.
    """
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
        message = f"a {kind} joint has no <limit>: it is treated as unlimited"
        reading.warn("joint-limit-missing", message, element.sourceline)
    for tag, make in OPTIONAL.items():
        if tag in parts:
            try:
                setattr(joint, tag, make(**reading.values(parts[tag])))
            except ConversionError as error:
                reading.warn_of_left_out(parts[tag], f"<{tag}>", error)
    if joint.dynamics is not None:
        warn_of_negative(reading, parts["dynamics"], joint.dynamics)


def warn_of_negative(reading: Reading, element: Any, numbers: Dynamics | Limit) -> None:
    """Warn of numbers below zero that no joint has."""
    names, effect = NOT_NEGATIVE[element.tag]
    for name in names:
        value = getattr(numbers, name)
        if value is not None and value < 0.0:
            message = f"{name} of <{element.tag}> is below zero, which {effect}; it is kept"
            detail, hint = f"{value!r}", "write a number of zero or more"
            line = element.sourceline
            reading.warn("number-negative", message, line, detail=detail, hint=hint)


def read_type(reading: Reading, element: Any, name: str) -> str:
    """Return the type of a joint, which may have capitals or blanks, with a warning."""
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
    """Return the name of a joint's ``parent`` or ``child`` link."""
    part = parts.get(which)
    name: str | None = None if part is None else part.get("link")
    if part is not None and len(part.attrib) != 1:
        reading.unknown_attributes(part)
    if not name:
        what, at = f"{reading.where} has no {which} link", element if part is None else part
        written = "" if part is None else (part.text or "").strip()  # as in SDF
        hint = suggest_attributes(which, {"link": written or "..."})
        reading.fail("joint-link-missing", what, at, hint)
    if part is not None and len(part):
        reading.unknown_children(which, part, ())
    return name


def read_limit(reading: Reading, joint: Joint, element: Any) -> Limit:
    """Return the limits of a joint; a number that cannot be read, or is infinite, is no limit."""
    values = reading.values(element, lenient="a limit")
    limit = Limit(**values)
    warn_of_negative(reading, element, limit)
    lower, upper = limit.lower, limit.upper
    if joint.type not in ("revolute", "prismatic") or lower is None or upper is None:
        return limit
    missing = [name for name in ("lower", "upper") if name not in values]
    line = element.sourceline
    if lower > upper:
        message = "the lower limit is above the upper limit: both are ignored"
        if missing:
            message = f"{missing[0]} of <limit> is missing and means 0, and so {message}"
        reading.warn("limit-order", message, line, detail=f"{lower!r} and {upper!r}")
    elif limit.is_single:
        message = (
            "lower and upper of <limit> are equal (a number that is missing is 0): by URDF, the "
            "joint is locked there; in many files, it has no limits"
        )
        hint = (
            "'joint-parameters: {zero_limits: locked}' keeps it there, '{zero_limits: free}' (the "
            "default) lets it move; or state lower and upper"
        )
        reading.warn("limit-zero", message, line, hint=hint, detail=f"at {lower!r}")
    elif missing:
        message = f"{missing[0]} of <limit> is missing, which means 0 in URDF"
        reading.warn("limit-zero", message, line, detail=f"{lower!r} to {upper!r}")
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
