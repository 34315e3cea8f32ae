"""Words beside URDF's own that say nothing of the mechanics of a robot.

A URDF file often has elements and attributes of other programs.  Each one that is not read is a
warning (``mechanics-unread``), unless this file lists it: then it is a note.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

#: Elements that describe appearance: nothing in them is mechanics.
APPEARANCE = frozenset(("material", "color", "texture", "ambient", "diffuse", "specular"))
#: Elements of a file's own bookkeeping, of controllers, planners and drawing programs, by parent.
CHILDREN: dict[str, frozenset[str]] = {
    parent: frozenset(names.split())
    for parent, names in {
        "robot": "frame collision_filter_group collision_filter disable_collisions group_state "
        "schedule_topic_creator_file author version license description name",
        "link": "self_collision_checking collision_checking self_filter selfCollide "
        "self_collide enable_wind must_be_base_link description",
        "joint": "controller_gains description",
        "visual": "meta cast_shadows transparency laser_retro lighting visible layer "
        "accepting_renderer perception_properties plugin verbose",
        "collision": "verbose laser_retro max_contacts self_collide meta",
        "mesh": "declare_convex",
        "transmission": "motorTorqueConstant robotNamespace",
    }.items()
}
#: Attributes of the same kinds, by element.
ATTRIBUTES: dict[str, frozenset[str]] = {
    element: frozenset(names.split())
    for element, names in {
        "robot": "author license description",
        "link": "type concave description",
        "joint": "dont_collapse description",
        "visual": "group mask visible alpha description",
        "collision": "group mask concave margin description",
        "geometry": "name",
        "mesh": "name convexdecomposition convex_decomposition",
        "calibration": "reference_position",
    }.items()
}
#: Attributes of these names identify an element.
IDENTIFIERS = frozenset(("id", "uid", "class", "label", "comment", "note", "name"))
#: Namespaces of XML itself, and of the sensors and controllers of old Gazebo files.
NAMESPACES = (
    "http://www.w3.org/XML/1998/namespace",
    "http://www.w3.org/2001/XMLSchema-instance",
    "http://playerstage.sourceforge.net/gazebo/xmlschema/#sensor",
    "http://playerstage.sourceforge.net/gazebo/xmlschema/#controller",
    "http://playerstage.sourceforge.net/gazebo/xmlschema/#interface",
    "http://playerstage.sourceforge.net/gazebo/xmlschema/#rendering",
    "http://playerstage.sourceforge.net/gazebo/xmlschema/#gui",
)
#: Prefixes of the same, where a file does not declare them.
PREFIXES = frozenset(("xml", "xsi", "xmlns", "sensor", "controller", "interface", "rendering"))
#: Elements of which zero says something: gravity that does not act on a link.
ZERO_MATTERS = frozenset(("gravity", "enable_gravity"))


def is_harmless_child(parent: str, name: str, namespace: str) -> bool:
    """Return True if an element within ``parent`` says nothing of the mechanics of a robot.

    Args:
        parent: The tag of the parent, without a prefix.
        name: The tag of the element, without a prefix.
        namespace: The namespace of the element, or its prefix if the file declares none; empty
            for an element without a prefix.
    """
    if parent in APPEARANCE or name in APPEARANCE or _is_harmless_namespace(namespace):
        return True
    return name in CHILDREN.get(parent, ())


def is_harmless_attribute(element: str, name: str, namespace: str) -> bool:
    """Return True if an attribute says nothing of the mechanics; see ``is_harmless_child``."""
    if element in APPEARANCE or name in IDENTIFIERS or _is_harmless_namespace(namespace):
        return True
    return name in ATTRIBUTES.get(element, ())


def _is_harmless_namespace(namespace: str) -> bool:
    return bool(namespace) and (namespace in PREFIXES or namespace.startswith(NAMESPACES))


def is_zero(name: str, texts: Iterable[str]) -> bool:
    """Return True if all texts are zeros or ``false``, as in ``damping="0.0"``: no statement.

    Gravity that acts on a link is no statement, either.

    Args:
        name: The name of the element or attribute that has the texts.
        texts: The values of an attribute, or of all attributes and the text of an element.
    """
    words = " ".join(texts).split()
    if name in ZERO_MATTERS:
        return bool(words) and {word.lower() for word in words} <= {"1", "true"}
    if not words:
        return False
    try:
        return not any(0.0 if word.lower() == "false" else float(word) for word in words)
    except ValueError:
        return False
