"""``<joint>``: its links, axis and limits, and the joint that it mimics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO
from urdf2mbs.urdf.elements import ELEMENTS, quote, suggest_attributes
from urdf2mbs.urdf.model import JOINT_TYPES, RATES, Dynamics, Joint, Limit
from urdf2mbs.urdf.tree import find_loops

if TYPE_CHECKING:
    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading

#: Children that are left out, with a warning, if they cannot be read.
OPTIONAL = ("dynamics", "mimic", "safety_controller", "calibration")
#: Numbers that are zero or more, by element, and the effect of one below zero.
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
    joint_type = read_type(reading, element, name)
    parts = reading.parts(element)
    parent = read_end(reading, element, parts, "parent")
    child = read_end(reading, element, parts, "child")
    if parent == child:
        message = f"joint '{name}' has the link '{parent}' as its parent and as its child"
        reading.fail("joint-same-link", message, parts["child"])
    origin, line = reading.origin(parts.get("origin")), element.sourceline
    joint = joints[name] = Joint(name, joint_type, parent, child, origin, line=line)
    if "axis" in parts and joint_type not in ("fixed", "floating"):  # these have no axis
        read_axis(reading, joint, parts["axis"])
    if "limit" in parts:
        joint.limit = read_limit(reading, joint, parts["limit"])
    elif joint_type in ("revolute", "prismatic"):
        message = f"a {joint_type} joint has no <limit>: it is treated as unlimited"
        reading.warn("joint-limit-missing", message, line)
    for tag in OPTIONAL:
        if tag in parts:
            struct: Any = ELEMENTS[tag].struct
            try:
                setattr(joint, tag, struct(**reading.values(parts[tag])))
            except ConversionError as error:
                reading.warn_of_left_out(parts[tag], f"<{tag}>", error)
    if joint.dynamics is not None:
        warn_of_negative(reading, parts["dynamics"], joint.dynamics)


def read_axis(reading: Reading, joint: Joint, element: Any) -> None:
    """Set the axis of a joint, in the child link's frame; raise ConversionError for 0 0 0."""
    joint.axis = reading.values(element)["xyz"]
    if joint.axis == ZERO:
        message = f"joint '{joint.name}': axis is 0 0 0; expected a non-zero vector"
        hint = 'give a direction, such as xyz="0 0 1", or make the joint fixed'
        reading.fail("axis-zero", message, element, hint)


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
    written: str | None = element.get("type")
    if len(element.attrib) != 2:
        reading.unknown_attributes(element)
    if written in JOINT_TYPES:
        return written
    hint = f"the types are: {', '.join(JOINT_TYPES)}"
    if not written:
        reading.fail("joint-type-missing", f"joint '{name}' has no type", element, hint)
    reading.check_expanded(element, "type", written)
    joint_type = written.strip().lower()
    if joint_type not in JOINT_TYPES:
        message = f"joint '{name}' is of the type {quote(written)}, which URDF does not know"
        hint = nearest(joint_type, JOINT_TYPES) or hint
        reading.fail("joint-type-unknown", message, element, hint)
    message = f"the type {quote(written)} is read as '{joint_type}'"
    reading.warn("joint-type-spelling", message, element.sourceline)
    return joint_type


def read_end(reading: Reading, element: Any, parts: dict[str, Any], tag: str) -> str:
    """Return the name of a joint's ``parent`` or ``child`` link."""
    part = parts.get(tag)
    name: str | None = None if part is None else part.get("link")
    if part is not None and len(part.attrib) != 1:
        reading.unknown_attributes(part)
    if not name:
        text = "" if part is None else (part.text or "").strip()  # as in SDF
        hint = suggest_attributes(tag, {"link": text or "..."})
        message = f"{reading.where} has no {tag} link"
        reading.fail("joint-link-missing", message, element if part is None else part, hint)
    if part is not None and len(part):
        reading.unknown_children(tag, part, ())
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
        if leader in joints:
            leaders[joint.name] = leader
            continue
        joint.mimic = None
        message = "<mimic> names no joint, so its joint moves freely"
        if leader:
            message = f"'{leader}' is no joint, so its followers move freely"
        owner, like = ("joint", joint.name), (leader, joints)
        reading.warn("mimic-left-out", message, joint.line, owner=owner, like=like)
    for loop in find_loops(leaders):
        for name in loop:
            joints[name].mimic = None
            message = "joints mimic one another, or themselves, so they move freely"
            line = joints[loop[0]].line
            reading.warn("mimic-left-out", message, line, owner=("joint", name))
