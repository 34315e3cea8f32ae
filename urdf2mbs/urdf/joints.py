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
    joint_name = reading.name(element, "joint", joints)
    if joint_name is None:
        return
    joint_type = read_type(reading, element, joint_name)
    children = reading.parts(element)
    parent = read_end(reading, element, children, "parent")
    child = read_end(reading, element, children, "child")
    if parent == child:
        message = f"joint '{joint_name}' has the link '{parent}' as its parent and as its child"
        reading.fail("joint-same-link", message, children["child"])
    origin, line = reading.origin(children.get("origin")), element.sourceline
    joint = joints[joint_name] = Joint(joint_name, joint_type, parent, child, origin, line=line)
    if "axis" in children and joint_type not in ("fixed", "floating"):  # these have no axis
        read_axis(reading, joint, children["axis"])
    if "limit" in children:
        joint.limit = read_limit(reading, joint, children["limit"])
    elif joint_type in ("revolute", "prismatic"):
        message = f"a {joint_type} joint has no <limit>: it is treated as unlimited"
        reading.warn("joint-limit-missing", message, line)
    for child_tag in OPTIONAL:
        if child_tag in children:
            struct_class: Any = ELEMENTS[child_tag].struct
            try:
                setattr(joint, child_tag, struct_class(**reading.values(children[child_tag])))
            except ConversionError as error:
                reading.warn_of_left_out(children[child_tag], f"<{child_tag}>", error)
    if joint.dynamics is not None:
        warn_of_negative(reading, children["dynamics"], joint.dynamics)


def read_axis(reading: Reading, joint: Joint, element: Any) -> None:
    """Set the axis of a joint, in the child link's frame; raise ConversionError for 0 0 0."""
    joint.axis = reading.values(element)["xyz"]
    if joint.axis == ZERO:
        message = f"joint '{joint.name}': axis is 0 0 0; expected a non-zero vector"
        hint = 'give a direction, such as xyz="0 0 1", or make the joint fixed'
        reading.fail("axis-zero", message, element, hint)


def warn_of_negative(reading: Reading, element: Any, numbers: Dynamics | Limit) -> None:
    """Warn of numbers below zero that no joint has."""
    attribute_names, effect = NOT_NEGATIVE[element.tag]
    for attribute_name in attribute_names:
        value = getattr(numbers, attribute_name)
        if value is not None and value < 0.0:
            message = (
                f"{attribute_name} of <{element.tag}> is below zero, which {effect}; it is kept"
            )
            detail, hint = f"{value!r}", "write a number of zero or more"
            line = element.sourceline
            reading.warn("number-negative", message, line, detail=detail, hint=hint)


def read_type(reading: Reading, element: Any, joint_name: str) -> str:
    """Return the type of a joint, which may have capitals or blanks, with a warning."""
    stated_type: str | None = element.get("type")
    if len(element.attrib) != 2:
        reading.unknown_attributes(element)
    if stated_type in JOINT_TYPES:
        return stated_type
    hint = f"the types are: {', '.join(JOINT_TYPES)}"
    if not stated_type:
        reading.fail("joint-type-missing", f"joint '{joint_name}' has no type", element, hint)
    reading.check_expanded(element, "type", stated_type)
    joint_type = stated_type.strip().lower()
    if joint_type not in JOINT_TYPES:
        message = (
            f"joint '{joint_name}' is of the type {quote(stated_type)}, which URDF does not know"
        )
        hint = nearest(joint_type, JOINT_TYPES) or hint
        reading.fail("joint-type-unknown", message, element, hint)
    message = f"the type {quote(stated_type)} is read as '{joint_type}'"
    reading.warn("joint-type-spelling", message, element.sourceline)
    return joint_type


def read_end(reading: Reading, element: Any, children: dict[str, Any], end_tag: str) -> str:
    """Return the name of a joint's ``parent`` or ``child`` link."""
    end_element = children.get(end_tag)
    link_name: str | None = None if end_element is None else end_element.get("link")
    if end_element is not None and len(end_element.attrib) != 1:
        reading.unknown_attributes(end_element)
    if not link_name:
        stated_text = "" if end_element is None else (end_element.text or "").strip()  # as in SDF
        hint = suggest_attributes(end_tag, {"link": stated_text or "..."})
        message = f"{reading.where} has no {end_tag} link"
        reading.fail(
            "joint-link-missing", message, element if end_element is None else end_element, hint
        )
    if end_element is not None and len(end_element):
        reading.unknown_children(end_tag, end_element, ())
    return link_name


def read_limit(reading: Reading, joint: Joint, element: Any) -> Limit:
    """Return the limits of a joint; a number that cannot be read, or is infinite, is no limit."""
    values = reading.values(element, lenient="a limit")
    limit = Limit(**values)
    warn_of_negative(reading, element, limit)
    lower, upper = limit.lower, limit.upper
    if joint.type not in ("revolute", "prismatic") or lower is None or upper is None:
        return limit
    missing_attributes = [
        attribute_name for attribute_name in ("lower", "upper") if attribute_name not in values
    ]
    line = element.sourceline
    if lower > upper:
        message = "the lower limit is above the upper limit: both are ignored"
        if missing_attributes:
            message = f"{missing_attributes[0]} of <limit> is missing and means 0, and so {message}"
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
    elif missing_attributes:
        message = f"{missing_attributes[0]} of <limit> is missing, which means 0 in URDF"
        reading.warn("limit-zero", message, line, detail=f"{lower!r} to {upper!r}")
    return limit


def check_mimics(reading: Reading, robot: Robot) -> None:
    """Free a joint that mimics no joint, or in the end itself, with a warning."""
    joints = robot.joints
    leaders_by_joint: dict[str, str] = {}
    for joint in joints.values():
        if joint.mimic is None:
            continue
        leader_name = joint.mimic.joint
        if leader_name in joints:
            leaders_by_joint[joint.name] = leader_name
            continue
        joint.mimic = None
        message = "<mimic> names no joint, so its joint moves freely"
        if leader_name:
            message = f"'{leader_name}' is no joint, so its followers move freely"
        owner, like = ("joint", joint.name), (leader_name, joints)
        reading.warn("mimic-left-out", message, joint.line, owner=owner, like=like)
    for mimic_loop in find_loops(leaders_by_joint):
        for joint_name in mimic_loop:
            joints[joint_name].mimic = None
            message = "joints mimic one another, or themselves, so they move freely"
            line = joints[mimic_loop[0]].line
            reading.warn("mimic-left-out", message, line, owner=("joint", joint_name))
