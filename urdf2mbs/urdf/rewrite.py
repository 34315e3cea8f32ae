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


def rename_drake_joints(root: Any) -> None:
    """Make a ``<joint>`` of each ``<drake:joint>`` whose type means the same in URDF.

    Drake reads the children of both elements alike ("URDF Support" of its documentation).
    """
    for joint in root:
        if not isinstance(joint.tag, str) or not is_drake(joint.tag):
            continue
        if split_tag(joint.tag)[0] == "joint" and joint.get("type") in (*JOINT_TYPES, *ROTATIONS):
            joint.tag = "joint"
            for child in joint.iterchildren(etree.Element):
                name = split_tag(child.tag)[0]
                if is_drake(child.tag) and name in ELEMENTS["joint"].children:
                    child.tag = name


def split_joints(root: Any) -> list[tuple[str, int]]:
    """Make continuous joints, one an axis, of each joint that rotates about several axes.

    The first has the joint's origin; between the joints are links without mass.

    Returns:
        The name of each joint that was split, and how many joints it became.
    """
    split = []
    taken = _list_names(root)
    for joint in list(root.iterchildren("joint")):
        axes = ROTATIONS.get(joint.get("type"))
        name, child = joint.get("name"), joint.find("child")
        if axes is None or not name or child is None or joint.find("parent") is None:
            continue  # the reader reports a missing name, parent or child
        names = [_choose_free(f"{name}_R{number}", taken) for number in range(1, len(axes) + 1)]
        _split_joint(joint, names, axes)
        split.append((name, len(axes)))
    return split


def _split_joint(joint: Any, names: list[str], axes: tuple[str, ...]) -> None:
    """Replace a joint by several, each about one axis.

    ``parent --[NAME_R1]-- link NAME_R1 --[NAME_R2]-- link NAME_R2 --[NAME_R3]-- child``
    """
    dynamics = joint.findall("dynamics")
    for part in list(joint):
        if part.tag in ("axis", "limit", "dynamics", "mimic"):
            joint.remove(part)
    joint.set("type", "continuous")
    child = joint.find("child")
    links = [*names[:-1], child.get("link")]
    single = joint
    for number, (name, axis, link) in enumerate(zip(names, axes, links, strict=True)):
        if number > 0:
            single.addnext(etree.Element("link", name=links[number - 1]))
            single.getnext().addnext(etree.Element("joint", type="continuous"))
            single = single.getnext().getnext()
            etree.SubElement(single, "parent", link=links[number - 1])
            child = etree.SubElement(single, "child")
        single.set("name", name)
        child.set("link", link)
        etree.SubElement(single, "axis", xyz=axis)
        single.extend(deepcopy(dynamics))
        for element in single.iter(etree.Element):
            element.sourceline = joint.sourceline


def rename_doubled(root: Any) -> dict[str, str]:
    """Rename each joint that has the name of another one, if nothing refers to the name.

    A joint that leads to the same link is the same joint, and stays.

    Returns:
        The old name of each new one.
    """
    children: dict[str, set[str | None]] = {}
    renamed: dict[str, str] = {}
    taken = _list_names(root)
    used: set[str] = set()
    for joint in root.iterchildren("joint"):
        name, child = joint.get("name"), joint.find("child")
        link = None if child is None else child.get("link")
        if name and link and link not in children.setdefault(name, {link}):
            children[name].add(link)
            used = used or _list_references(root)
            if name not in used:
                new_name = _choose_free(name, taken)
                joint.set("name", new_name)
                renamed[new_name] = name
    return renamed


def _list_names(root: Any) -> set[str]:
    """Return the names of all links and joints."""
    return {element.get("name", "") for element in root.iterchildren("link", "joint")}


def _choose_free(name: str, taken: set[str]) -> str:
    """Return the name, or the first of ``NAME_2``, ``NAME_3`` ... not taken, and take it."""
    names = chain([name], (f"{name}_{number}" for number in count(2)))
    free_name = next(candidate for candidate in names if candidate not in taken)
    taken.add(free_name)
    return free_name


def _list_references(root: Any) -> set[str]:
    """Return all attributes and texts that may refer to a joint."""
    texts = {""}
    for element in root.iter(etree.Element):
        is_top = element.tag in ("joint", "link") and element.getparent() is root
        if element.tag not in ("parent", "child"):
            texts |= {text for key, text in element.items() if not (is_top and key == "name")}
            texts.add((element.text or "").strip())
    return texts
