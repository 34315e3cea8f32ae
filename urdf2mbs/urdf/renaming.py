"""Rename links and joints of a robot, with all that refers to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from lxml import etree

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
    new_links = _complete("link", robot.links, links)
    new_joints = _complete("joint", robot.joints, joints)
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


def _complete(kind: str, names: Collection[str], table: Mapping[str, str]) -> dict[str, str]:
    """Return the new name of each name; raise ConfigError for unknown or doubled names."""
    for name in table:
        if name not in names:
            message = f"the robot has no {kind} '{name}' to rename"
            raise ConfigError("rename-unknown", message, hint=nearest(name, names))
    old_names: dict[str, str] = {}
    for name in names:
        new_name = table.get(name, name)
        if not new_name or new_name in old_names:
            message = f"{kind} '{name}' would have no name"
            if new_name:
                message = f"{kind}s '{old_names[new_name]}' and '{name}' would both be '{new_name}'"
            raise ConfigError("rename-doubled", message, hint="give each a name of its own")
        old_names[new_name] = name
    return {name: new_name for new_name, name in old_names.items()}


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
    for closing in extension.joints:
        closing.parent = links.get(closing.parent, closing.parent)
        closing.child = links.get(closing.child, closing.child)
    extension.motors = [joints.get(name, name) for name in extension.motors]
    extension.rotors = {joints.get(name, name): size for name, size in extension.rotors.items()}
    extension.starts = {joints.get(name, name): start for name, start in extension.starts.items()}
    root = etree.fromstring(extension.xml, etree.XMLParser(recover=True, resolve_entities=False))
    before = etree.tostring(root)
    for element in root.iter(etree.Element):
        of_kind = {"joint": joints, "link": links}.get(str(element.tag), {})
        for attribute, table in (("reference", links_and_joints), ("name", of_kind)):
            name = element.get(attribute)
            if name is not None and name in table:
                element.set(attribute, table[name])
    if etree.tostring(root) != before:
        extension.xml = etree.tostring(root, encoding="unicode")
