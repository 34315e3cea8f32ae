"""Rename links and joints, by table and by pattern.

In a config::

    plugins: [rename_links.py]
    after: {expand: rename-links}
    passes:
      rename-links:
        links: {base_link: pelvis}              # old name: new name
        link_patterns: {"^l_(.*)": 'left_\\1'}   # regular expression: what takes its place
        joint_patterns: {"_joint$": ""}

A name in a table is given its new one, and no pattern is tried on it; every other name goes
through all the patterns, in their order.  Joints, mimics, and what ``<gazebo>``,
``<transmission>`` and the like refer to follow.
"""

import re

from urdf2mbs.plugin import ConfigError, Pass, hookimpl, nearest


class RenameLinks(Pass):
    """Rename links and joints, and all that refers to them."""

    writes = ("robot",)

    links: dict[str, str] = {}
    """Link: its new name."""
    joints: dict[str, str] = {}
    """Joint: its new name."""
    link_patterns: dict[str, str] = {}
    """Regular expression: what takes the place of all that it finds in a link's name."""
    joint_patterns: dict[str, str] = {}
    """The same for joints."""

    def run(self, conversion):
        robot = conversion.robot
        links = new_names("link", robot.links, self.links, self.link_patterns)
        joints = new_names("joint", robot.joints, self.joints, self.joint_patterns)

        for link in robot.links.values():
            link.name = links[link.name]
        for joint in robot.joints.values():
            joint.name = joints[joint.name]
            joint.parent, joint.child = links[joint.parent], links[joint.child]
            if joint.mimic is not None:
                joint.mimic.joint = joints[joint.mimic.joint]
        robot.links = {link.name: link for link in robot.links.values()}
        robot.joints = {joint.name: joint for joint in robot.joints.values()}
        for extension in robot.extensions:
            rename_extension(extension, links, joints)

        changed = {
            "links": {old: new for old, new in links.items() if old != new},
            "joints": {old: new for old, new in joints.items() if old != new},
        }
        conversion.report["rename-links"] = changed
        conversion.note(
            "renamed", f"{len(changed['links'])} links and {len(changed['joints'])} joints renamed"
        )


def new_names(kind, elements, table, patterns):
    """Every old name and its new one; raises ConfigError for what cannot be meant."""
    for name in table:
        if name not in elements:
            raise ConfigError(
                "rename-unknown", f"rename-links: the robot has no {kind} '{name}'",
                hint=nearest(name, elements),
            )  # fmt: skip
    names = {}
    for name in elements:
        new = table.get(name, name)
        if name not in table:
            for pattern, replacement in patterns.items():
                try:
                    new = re.sub(pattern, replacement, new)
                except (re.error, IndexError) as error:
                    raise ConfigError(
                        "rename-pattern", f"rename-links: pattern '{pattern}': {error}",
                        hint="patterns are Python's regular expressions",
                    ) from None  # fmt: skip
        names[name] = new
        if not new:
            raise ConfigError("rename-empty", f"rename-links: {kind} '{name}' would have no name")
    old = {}
    for name, new in names.items():
        if new in old:
            raise ConfigError(
                "rename-doubled",
                f"rename-links: {kind}s '{old[new]}' and '{name}' would both be called '{new}'",
                hint=f"name one of them under '{kind}s'",
            )
        old[new] = name
    return names


def rename_extension(extension, links, joints):
    """``reference`` names a link or a joint, ``<joint name>`` a joint, ``<link name>`` a link."""
    from lxml import etree

    either = links | joints
    if extension.reference is not None:
        extension.reference = either.get(extension.reference, extension.reference)
    root = etree.fromstring(extension.xml, etree.XMLParser(recover=True, resolve_entities=False))
    changed = False
    for element in root.iter(etree.Element):
        for attribute, names in (
            ("reference", either),
            ("name", {"joint": joints, "link": links}.get(element.tag, {})),
        ):
            name = element.get(attribute)
            if name is not None and names.get(name, name) != name:
                element.set(attribute, names[name])
                changed = True
    if changed:
        extension.xml = etree.tostring(root, encoding="unicode")


@hookimpl
def urdf2mbs_passes():
    return [RenameLinks]
