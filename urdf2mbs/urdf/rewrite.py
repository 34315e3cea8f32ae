"""Elements that URDF does not allow, but that have one meaning, in the words of URDF.

The rewriting works on the XML, so that each reader of the text sees the same robot.
"""

from __future__ import annotations

from copy import deepcopy
from itertools import chain, count
from typing import Any

from lxml import etree

#: Types of joints that turn about three axes: those of MoveIt's fork and of SDF.
BALLS = ("spherical", "ball")
AXES = ("1 0 0", "0 1 0", "0 0 1")


def split_balls(root: Any) -> list[str]:
    """Make three continuous joints, about x, y and z, of each ball joint; gives their names.

    The first has the joint's origin; between the joints are links without mass.
    """
    split = []
    taken = _names(root)
    for joint in [joint for joint in root.iterchildren("joint") if joint.get("type") in BALLS]:
        name, child = joint.get("name"), joint.find("child")
        if not name or child is None or joint.find("parent") is None:
            continue  # the reader says what is missing
        names = [_free(f"{name}_R{k}", taken) for k in (1, 2, 3)]
        dynamics = joint.findall("dynamics")
        for part in list(joint):
            if part.tag not in ("origin", "parent", "child"):
                joint.remove(part)
        joint.set("type", "continuous")
        links = [*names[:2], child.get("link")]
        single = joint
        for k, own in enumerate(names):
            if k > 0:
                single.addnext(etree.Element("link", name=links[k - 1]))
                single.getnext().addnext(etree.Element("joint", type="continuous"))
                single = single.getnext().getnext()
                etree.SubElement(single, "parent", link=links[k - 1])
                child = etree.SubElement(single, "child")
            single.set("name", own)
            child.set("link", links[k])
            etree.SubElement(single, "axis", xyz=AXES[k])
            single.extend(deepcopy(dynamics))
            for element in single.iter(etree.Element):
                element.sourceline = joint.sourceline
        split.append(name)
    return split


def rename_doubled(root: Any) -> dict[str, str]:
    """Give each joint the name of which another has a free one, if nothing refers to the name.

    Gives the old name of each new one.  A joint that leads to the same link stays: it is no other.
    """
    children: dict[str, set[str | None]] = {}
    renamed: dict[str, str] = {}
    taken = _names(root)
    used: set[str] = set()
    for joint in root.iterchildren("joint"):
        name, child = joint.get("name"), joint.find("child")
        link = None if child is None else child.get("link")
        if name and link and link not in children.setdefault(name, {link}):
            children[name].add(link)
            used = used or _used(root)
            if name not in used:
                own = _free(name, taken)
                joint.set("name", own)
                renamed[own] = name
    return renamed


def _names(root: Any) -> set[str]:
    return {element.get("name", "") for element in root.iterchildren("link", "joint")}


def _free(name: str, taken: set[str]) -> str:
    """The name, or the first of ``NAME_2``, ``NAME_3`` ... that is not taken; then it is."""
    own = next(n for n in chain([name], (f"{name}_{k}" for k in count(2))) if n not in taken)
    taken.add(own)
    return own


def _used(root: Any) -> set[str]:
    """All that elements name, but for the names of links that joints have."""
    used = {""}
    for element in root.iter(etree.Element):
        own = element.tag in ("joint", "link") and element.getparent() is root
        if element.tag not in ("parent", "child"):
            used |= {text for key, text in element.items() if not (own and key == "name")}
            used.add((element.text or "").strip())
    return used
