"""Rename links and joints of a robot, with all that refers to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from lxml import etree

from urdf2mbs.disk.xml import safe_parser
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.urdf.model import Extension, Robot


def rename_elements(robot: Robot, links: Mapping[str, str], joints: Mapping[str, str]) -> None:
    """Rename links and joints, also where joints, mimics and extensions refer to them.

    Args:
        robot: The robot, which is changed.
        links: The new name of each link that gets one.
        joints: The new name of each joint that gets one.

    Raises:
        ConfigError: A name is not that of a link or joint, or two would be called the same.
    """
    new_links = _complete_table("link", robot.links, links)
    new_joints = _complete_table("joint", robot.joints, joints)
    for link in robot.links.values():
        link.name = new_links[link.name]
    for joint in robot.joints.values():
        joint.name = new_joints[joint.name]
        joint.parent, joint.child = new_links[joint.parent], new_links[joint.child]
        if joint.mimic is not None:
            joint.mimic.joint = new_joints[joint.mimic.joint]
    robot.links = {link.name: link for link in robot.links.values()}
    robot.joints = {joint.name: joint for joint in robot.joints.values()}
    for extension in robot.extensions:
        _rename_extension(extension, new_links, new_joints)


def _complete_table(
    element_kind: str, element_names: Collection[str], renaming_table: Mapping[str, str]
) -> dict[str, str]:
    """Return the new name of each name; raise ConfigError for unknown or doubled names."""
    for old_name in renaming_table:
        if old_name not in element_names:
            message = f"the robot has no {element_kind} '{old_name}' to rename"
            raise ConfigError("rename-unknown", message, hint=nearest(old_name, element_names))
    old_names: dict[str, str] = {}
    for old_name in element_names:
        new_name = renaming_table.get(old_name, old_name)
        if not new_name or new_name in old_names:
            message = f"{element_kind} '{old_name}' would have no name"
            if new_name:
                both_names = f"'{old_names[new_name]}' and '{old_name}'"
                message = f"{element_kind}s {both_names} would both be '{new_name}'"
            raise ConfigError("rename-doubled", message, hint="give each a name of its own")
        old_names[new_name] = old_name
    return {old_name: new_name for new_name, old_name in old_names.items()}


def _rename_extension(
    extension: Extension, links: Mapping[str, str], joints: Mapping[str, str]
) -> None:
    """Rename the links and joints that an element of another program refers to.

    In its text, ``reference`` names a link or a joint, ``<joint name>`` a joint, ``<link name>``
    a link.
    """
    links_and_joints = {**joints, **links}
    if extension.reference is not None:
        extension.reference = links_and_joints.get(extension.reference, extension.reference)
    for sensor in extension.sensors:
        sensor.on = links_and_joints.get(sensor.on, sensor.on)
    for closing_joint in extension.joints:
        closing_joint.parent = links.get(closing_joint.parent, closing_joint.parent)
        closing_joint.child = links.get(closing_joint.child, closing_joint.child)
    extension.motors = [joints.get(joint_name, joint_name) for joint_name in extension.motors]
    extension.rotors = {
        joints.get(joint_name, joint_name): rotor_inertia
        for joint_name, rotor_inertia in extension.rotors.items()
    }
    extension.starts = {
        joints.get(joint_name, joint_name): start_position
        for joint_name, start_position in extension.starts.items()
    }
    xml_root = etree.fromstring(extension.xml, safe_parser(recover=True))
    xml_before = etree.tostring(xml_root)
    for element in xml_root.iter(etree.Element):
        names_of_kind = {"joint": joints, "link": links}.get(str(element.tag), {})
        for attribute, names_by_element in (
            ("reference", links_and_joints),
            ("name", names_of_kind),
        ):
            element_name = element.get(attribute)
            if element_name is not None and element_name in names_by_element:
                element.set(attribute, names_by_element[element_name])
    if etree.tostring(xml_root) != xml_before:
        extension.xml = etree.tostring(xml_root, encoding="unicode")
