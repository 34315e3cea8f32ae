"""Elements that URDF does not allow, but that have one meaning, are rewritten as URDF.

The XML is rewritten, so that each reader of the text sees the same robot.
"""

from __future__ import annotations

from copy import deepcopy
from itertools import chain, count
from typing import Any

from lxml import etree

from urdf2mbs.urdf.elements import ELEMENTS, is_drake, split_tag
from urdf2mbs.urdf.model import JOINT_TYPES

#: The axes of the revolute joints that a joint of several rotations is made of, by its type.
#: ``spherical`` is a word of MoveIt's fork, ``ball`` of SDF and Drake, ``universal`` of Drake.
ROTATIONS = {
    "spherical": ("1 0 0", "0 1 0", "0 0 1"),
    "ball": ("1 0 0", "0 1 0", "0 0 1"),
    "universal": ("1 0 0", "0 1 0"),
}


def rename_drake_joints(robot_element: Any) -> None:
    """Make a ``<joint>`` of each ``<drake:joint>`` whose type means the same in URDF.

    Drake reads the children of both elements alike ("URDF Support" of its documentation).
    """
    for joint in robot_element:
        if not isinstance(joint.tag, str) or not is_drake(joint.tag):
            continue
        if split_tag(joint.tag)[0] == "joint" and joint.get("type") in (*JOINT_TYPES, *ROTATIONS):
            joint.tag = "joint"
            for child in joint.iterchildren(etree.Element):
                bare_tag = split_tag(child.tag)[0]
                if is_drake(child.tag) and bare_tag in ELEMENTS["joint"].children:
                    child.tag = bare_tag


def split_joints(robot_element: Any) -> list[tuple[str, int]]:
    """Make continuous joints, one an axis, of each joint that rotates about several axes.

    The first has the joint's origin; between the joints are links without mass.

    Returns:
        The name of each joint that was split, and how many joints it became.
    """
    split = []
    used_names = _list_names(robot_element)
    for joint in list(robot_element.iterchildren("joint")):
        axes = ROTATIONS.get(joint.get("type"))
        joint_name, child_element = joint.get("name"), joint.find("child")
        if axes is None or not joint_name or child_element is None or joint.find("parent") is None:
            continue  # the reader reports a missing name, parent or child
        split_names = [
            _choose_free(f"{joint_name}_R{rotation_number}", used_names)
            for rotation_number in range(1, len(axes) + 1)
        ]
        _split_joint(joint, split_names, axes)
        split.append((joint_name, len(axes)))
    return split


def _split_joint(joint: Any, split_names: list[str], axes: tuple[str, ...]) -> None:
    """Replace a joint by several, each about one axis.

    ``parent --[NAME_R1]-- link NAME_R1 --[NAME_R2]-- link NAME_R2 --[NAME_R3]-- child``
    """
    dynamics = joint.findall("dynamics")
    for joint_child in list(joint):
        if joint_child.tag in ("axis", "limit", "dynamics", "mimic"):
            joint.remove(joint_child)
    joint.set("type", "continuous")
    child_element = joint.find("child")
    child_links = [*split_names[:-1], child_element.get("link")]
    split_joint = joint
    for rotation_index, (split_name, axis, child_link) in enumerate(
        zip(split_names, axes, child_links, strict=True)
    ):
        if rotation_index > 0:
            split_joint.addnext(etree.Element("link", name=child_links[rotation_index - 1]))
            split_joint.getnext().addnext(etree.Element("joint", type="continuous"))
            split_joint = split_joint.getnext().getnext()
            etree.SubElement(split_joint, "parent", link=child_links[rotation_index - 1])
            child_element = etree.SubElement(split_joint, "child")
        split_joint.set("name", split_name)
        child_element.set("link", child_link)
        etree.SubElement(split_joint, "axis", xyz=axis)
        split_joint.extend(deepcopy(dynamics))
        for element in split_joint.iter(etree.Element):
            element.sourceline = joint.sourceline


def rename_doubled(robot_element: Any) -> dict[str, str]:
    """Rename each joint that has the name of another one, if nothing refers to the name.

    A joint that leads to the same link is the same joint, and stays.

    Returns:
        The old name of each new one.
    """
    children: dict[str, set[str | None]] = {}
    renamed: dict[str, str] = {}
    used_names = _list_names(robot_element)
    referenced_names: set[str] = set()
    for joint in robot_element.iterchildren("joint"):
        joint_name, child_element = joint.get("name"), joint.find("child")
        child_link = None if child_element is None else child_element.get("link")
        if (
            joint_name
            and child_link
            and child_link not in children.setdefault(joint_name, {child_link})
        ):
            children[joint_name].add(child_link)
            referenced_names = referenced_names or _list_references(robot_element)
            if joint_name not in referenced_names:
                new_name = _choose_free(joint_name, used_names)
                joint.set("name", new_name)
                renamed[new_name] = joint_name
    return renamed


def _list_names(robot_element: Any) -> set[str]:
    """Return the names of all links and joints."""
    return {element.get("name", "") for element in robot_element.iterchildren("link", "joint")}


def _choose_free(name: str, used_names: set[str]) -> str:
    """Return the name, or the first of ``NAME_2``, ``NAME_3`` ... not taken, and take it."""
    candidates = chain([name], (f"{name}_{suffix_number}" for suffix_number in count(2)))
    free_name = next(candidate for candidate in candidates if candidate not in used_names)
    used_names.add(free_name)
    return free_name


def _list_references(robot_element: Any) -> set[str]:
    """Return all attributes and texts that may refer to a joint."""
    texts = {""}
    for element in robot_element.iter(etree.Element):
        is_top_element = element.tag in ("joint", "link") and element.getparent() is robot_element
        if element.tag not in ("parent", "child"):
            texts |= {
                attribute_text
                for attribute_name, attribute_text in element.items()
                if not (is_top_element and attribute_name == "name")
            }
            texts.add((element.text or "").strip())
    return texts
