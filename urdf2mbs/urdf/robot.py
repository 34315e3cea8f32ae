"""``<robot>``, the root: its links, joints and materials, and the elements of other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.elements import FOREIGN
from urdf2mbs.urdf.gazebo import Extensions
from urdf2mbs.urdf.joints import check_mimics, read_joint
from urdf2mbs.urdf.links import read_link
from urdf2mbs.urdf.materials import check_materials, read_global_material
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.rewrite import rename_doubled, split_balls
from urdf2mbs.urdf.tree import check_tree

if TYPE_CHECKING:
    from urdf2mbs.messages.diagnostics import Diagnostic
    from urdf2mbs.urdf.values import Reading

#: Roots of other kinds of file.
OTHER_ROOTS = {
    "sdf": "an SDF file (Gazebo)", "mujoco": "an MJCF file (MuJoCo)",
    "mbsDescR7": "an .mbs file (Robotran) already",
}  # fmt: skip


def read_root(reading: Reading, root: Any) -> tuple[Robot, list[Diagnostic]]:
    """The robot of a URDF's root element, and what is odd about it; raises ConversionError."""
    _check_root(reading, root)
    _rewrite(reading, root)
    reading.quaternions = root.get("version") in ("1.1", "1.2")
    robot = Robot("", file=reading.file)
    links, joints = robot.links, robot.joints
    foreign: list[Any] = []
    for child in root:
        tag = child.tag
        if tag in ("link", "joint"):
            try:
                if tag == "link":
                    read_link(reading, child, links)
                    foreign += child.iterchildren("contact")  # of Bullet
                else:
                    read_joint(reading, child, joints)
            except ConversionError as error:
                reading.keep(error)
        elif tag == "material":
            read_global_material(reading, child, robot)
        elif isinstance(tag, str):
            reading.owner = ("robot", "")
            if tag not in FOREIGN:
                if reading.report_xacro(child):
                    continue
                if "{" not in tag and ":" not in tag:
                    reading.unknown_child("robot", child, ("link", "joint", "material", *FOREIGN))
            foreign.append(child)
    reading.owner = ("robot", "")
    if reading.last is not None:  # the tree cannot be judged where links or joints are not known
        raise reading.last
    robot.name = reading.values(root).get("name", "").strip()
    if not robot.name:
        reading.warn("robot-unnamed", "<robot> has no name", root.sourceline)
    check_materials(reading, robot)
    check_tree(reading, robot, root.sourceline)
    check_mimics(reading, robot)
    extensions = Extensions(reading, robot)
    robot.extensions = [extensions.read(element) for element in foreign]
    return robot, reading.diagnostics()


def _rewrite(reading: Reading, root: Any) -> None:
    lines = {joint.get("name"): joint.sourceline for joint in root.iterchildren("joint")}
    for own, name in rename_doubled(root).items():
        reading.warn(
            "joint-renamed", f"several joints are called '{name}', and this one is renamed",
            lines.get(name), owner=("joint", own),
        )  # fmt: skip
    for name in split_balls(root):
        what = "a ball joint becomes three joints, NAME_R1, NAME_R2 and NAME_R3, without limits"
        reading.warn("joint-ball", what, lines.get(name), owner=("joint", name))


def _check_root(reading: Reading, root: Any) -> None:
    tag = root.tag
    if tag.startswith("{"):
        space = root.nsmap[root.prefix]
        tag = etree.QName(root).localname
        if tag == "robot":
            _strip_namespace(root, f"{{{space}}}")
    if tag == "robot":
        return
    looks = f": this looks like {OTHER_ROOTS[tag]}" if tag in OTHER_ROOTS else ""
    what = f"the root element is <{tag}>, not <robot>{looks}"
    reading.fail("wrong-root", what, root, "URDF and xacro files are read")


def _strip_namespace(root: Any, space: str) -> None:
    """A default namespace on <robot> says nothing: read the elements as if without it."""
    for child in root.iterchildren(*(space + tag for tag in ("link", "joint", "material"))):
        for element in child.iter(f"{space}*"):
            element.tag = element.tag[len(space) :]
    for child in root.iterchildren(f"{space}*"):
        child.tag = child.tag[len(space) :]
    root.tag = "robot"
