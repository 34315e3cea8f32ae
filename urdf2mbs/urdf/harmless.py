"""Words beside URDF's own that say nothing of the mechanics of a robot.

A URDF file often has elements and attributes of other programs.  Each one that is not read is a
warning (``mechanics-unread``), unless this file lists it: then it is a note.
"""

from __future__ import annotations

#: Elements that describe appearance: nothing in them is mechanics.
APPEARANCE = frozenset(("material", "color", "texture", "ambient", "diffuse", "specular"))
#: Elements of a file's own bookkeeping, of controllers, planners and drawing programs, by parent.
CHILDREN: dict[str, frozenset[str]] = {
    parent: frozenset(names.split())
    for parent, names in {
        "robot": "frame collision_filter_group collision_filter disable_collisions group_state "
        "schedule_topic_creator_file end_effector passive_joint disabled_collisions "
        "collision_group collision_checking camera light lidar audio_source author version "
        "license description name copyright date url software created_by meta metadata info",
        "link": "self_collision_checking collision_checking self_filter selfCollide "
        "self_collide enable_wind must_be_base_link description verbose audio_source sensor",
        "joint": "controller_gains hardwareInterface interface description sensor",
        "visual": "meta cast_shadows transparency laser_retro lighting visible layer "
        "accepting_renderer perception_properties plugin verbose",
        "collision": "verbose laser_retro max_contacts self_collide meta sdf",
        "mesh": "declare_convex",
        "transmission": "motorTorqueConstant robotNamespace",
    }.items()
}
#: Attributes of the same kinds, by element.
ATTRIBUTES: dict[str, frozenset[str]] = {
    element: frozenset(names.split())
    for element, names in {
        "robot": "author license description",
        "link": "concave description",
        "joint": "dont_collapse description",
        "visual": "group mask visible alpha description",
        "collision": "group mask concave convex margin description",
        "geometry": "name",
        "mesh": "name convex convexdecomposition convex_decomposition",
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
#: Names of numbers that are zero where nothing states them, in small letters.
ZERO_BY_DEFAULT = frozenset(
    [
        "damping",
        "friction",
        "stiffness",
        "armature",
        "offset",
        "xyz",
        "rpy",
        "pos",
        "position",
        "orientation",
        "rotation",
        "translation",
        "pose",
        "origin",
        "anchor",
        "x",
        "y",
        "z",
        "roll",
        "pitch",
        "yaw",
        "k",
        "d",
        "kp",
        "kd",
        "ki",
        "k_velocity",
        "mu",
        "mu_coulomb",
        "mu_viscous",
        "mu_static",
        "spring_k",
        "spring_stiffness",
        "spring_reference",
        "springreference",
        "reference",
        "rest",
        "restitution",
        "rolling_friction",
        "spinning_friction",
        "backlash",
    ]
)
#: Names of switches that are off, and of others that are on, where nothing states them.
OFF_BY_DEFAULT = frozenset(
    ["kinematic", "static", "fixed", "locked", "self_collide", "selfcollide"]
)
ON_BY_DEFAULT = frozenset(["gravity", "enable_gravity", "use_gravity", "enablegravity", "enabled"])
#: Words for on and off, in small letters.
ON = frozenset(("1", "1.0", "true", "yes", "on"))
OFF = frozenset(("0", "0.0", "false", "no", "off"))
#: What a material, a ``type`` of a link or MuJoCo's ``<compiler>`` says of mechanics all the same.
OF_MATTER = frozenset(["density", "mass", "friction", "mu", "restitution", "stiffness", "damping"])
OF_MOTION = frozenset(["static", "kinematic", "fixed", "dynamic"])


def is_harmless_child(parent_tag: str, bare_tag: str, namespace: str) -> bool:
    """Return True if an element within ``parent_tag`` says nothing of the mechanics of a robot.

    Args:
        parent_tag: The tag of the parent, without a prefix.
        bare_tag: The tag of the element, without a prefix.
        namespace: The namespace of the element, or its prefix if the file declares none; empty
            for an element without a prefix.
    """
    if parent_tag in APPEARANCE:
        return bare_tag not in OF_MATTER
    if bare_tag in APPEARANCE or _is_harmless_namespace(namespace):
        return True
    return bare_tag in CHILDREN.get(parent_tag, ())


def is_harmless_attribute(
    element_tag: str, attribute_name: str, namespace: str, attribute_text: str
) -> bool:
    """Return True if an attribute says nothing of the mechanics.

    Args:
        element_tag: The tag of its element, without a prefix.
        attribute_name: The attribute, without a prefix.
        namespace: As of ``is_harmless_child``.
        attribute_text: The value of the attribute.
    """
    if element_tag in APPEARANCE:
        return attribute_name not in OF_MATTER
    if element_tag == "link" and attribute_name == "type":
        return attribute_text.lower() not in OF_MOTION
    if attribute_name in IDENTIFIERS or _is_harmless_namespace(namespace):
        return True
    return attribute_name in ATTRIBUTES.get(element_tag, ())


def _is_harmless_namespace(namespace: str) -> bool:
    return bool(namespace) and (namespace in PREFIXES or namespace.startswith(NAMESPACES))


def is_default(bare_name: str, value_text: str) -> bool:
    """Return True if a text says what holds without it, as ``damping="0.0"``.

    Args:
        bare_name: The name of the attribute, or of the element that has the text.
        value_text: Numbers, or a word for on or off.
    """
    bare_name, value_words = bare_name.lower(), value_text.lower().split()
    if bare_name in ON_BY_DEFAULT:
        return bool(value_words) and ON.issuperset(value_words)
    if bare_name in OFF_BY_DEFAULT:
        return bool(value_words) and OFF.issuperset(value_words)
    try:
        return (
            bare_name in ZERO_BY_DEFAULT and bool(value_words) and not any(map(float, value_words))
        )
    except ValueError:
        return False
