"""A robot of many joints, and the same one under other names, in another order."""

from __future__ import annotations

import re
from random import Random
from typing import NamedTuple

from lxml import etree

from support.build import joint, link, robot
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import convert_text


class Nameless(NamedTuple):
    """A robot without its names."""

    data: bytes
    """The URDF, or the .mbs."""
    names: dict[str, str]
    """The new name of each joint that moves."""


def solid(mass: float, x: float, y: float, z: float) -> str:
    """An inertia that is alike in no two directions, its centre at x, y, z (m)."""
    return (
        f'<inertial><origin xyz="{x} {y} {z}"/><mass value="{mass}"/><inertia '
        f'ixx="{0.011 * mass}" iyy="{0.012 * mass}" izz="{0.009 * mass}" '
        f'ixy="{0.0004 * mass}" ixz="0" iyz="{0.0002 * mass}"/></inertial>'
    )


def make_humanoid() -> str:
    """Make a robot with two legs, two arms and a head: 16 joints, left and right mirrored."""
    elements = [link("pelvis", solid(8, 0.01, 0, 0.05)), link("chest", solid(12, 0, 0, 0.2))]
    elements += [joint("pelvis", "chest", xyz="0 0 0.15", axis="0 0 1", name="waist")]
    elements += [link("head", solid(3, 0.02, 0, 0.1))]
    elements += [joint("chest", "head", xyz="0 0 0.45", axis="0 1 0", name="neck")]
    for side, sign in (("left", 1), ("right", -1)):
        chains = {
            "leg": [
                ("hip_roll", "0 {} -0.1", 0.1, "1 0 0", 1.5),
                ("hip_pitch", "0 {} 0", 0.02, "0 1 0", 4.0),
                ("knee", "0 {} -0.4", 0.0, "0 1 0", 3.0),
                ("ankle", "0 {} -0.38", 0.0, "0 1 0", 1.0),
            ],
            "arm": [
                ("shoulder", "0 {} 0.35", 0.22, "0 1 0", 2.0),
                ("elbow", "0 {} -0.3", 0.01, "0 0 1", 1.2),
                ("wrist", "0 {} -0.25", 0.0, "1 0 0", 0.5),
            ],
        }
        for limb, steps in chains.items():
            parent = "pelvis" if limb == "leg" else "chest"
            for name, place, y, axis, mass in steps:
                child = f"{side}_{name}_link"
                centre = solid(mass, 0.01, sign * 0.01, -0.1)
                elements.append(link(child, centre))
                xyz = place.format(sign * y)
                elements.append(joint(parent, child, xyz=xyz, axis=axis, name=f"{side}_{name}"))
                parent = child
    return robot(*elements)


def rename_urdf(text: str, seed: int) -> Nameless:
    """Rename and shuffle all links and joints of a URDF."""
    random = Random(seed)
    root = etree.fromstring(text)
    links = [element.get("name", "") for element in root.findall("link")]
    joints = [element.get("name", "") for element in root.findall("joint")]
    kinds = {each.get("name", ""): each.get("type") for each in root.findall("joint")}
    names = {name: f"x{k}" for k, name in enumerate(random.sample(links, len(links)))}
    names["world"] = "world"  # it says that the robot is fixed
    for element in root.findall("link"):
        element.set("name", names[element.get("name", "")])
    new = {name: f"y{k}" for k, name in enumerate(random.sample(joints, len(joints)))}
    for element in root.findall("joint"):
        element.set("name", new[element.get("name", "")])
        for end in ("parent", "child"):
            node = element.find(end)
            assert node is not None
            node.set("link", names[node.get("link", "")])
    for follower in root.iter("mimic"):
        follower.set("joint", new[follower.get("joint", "")])
    for extension in (*root.findall("gazebo"), *root.findall("transmission")):
        _rename_extension(extension, names | new)
    elements = list(root)
    random.shuffle(elements)
    root[:] = elements
    moving = {
        old: name
        for old, name in new.items()
        if kinds[old] in ("revolute", "continuous", "prismatic")
    }
    return Nameless(etree.tostring(root), moving)


def _rename_extension(extension: etree._Element, names: dict[str, str]) -> None:
    """Rename the links and joints in an element of another program."""
    for element in extension.iter(etree.Element):
        for key in ("reference", "name"):
            if element.get(key) in names:
                element.set(key, names[element.get(key, "")])
        if (element.text or "").strip() in names:
            element.text = names[(element.text or "").strip()]


def rename_mbs(text: str, seed: int) -> Nameless:
    """Convert a URDF, rename all bodies and joints of the .mbs, and shuffle its bodies."""
    random = Random(seed)
    result = convert_text(text)
    mbs = result.mbs
    bodies = {
        body.name: f"x{k}" for k, body in enumerate(random.sample(mbs.bodies, len(mbs.bodies)))
    }
    every = [joint for body in mbs.bodies for joint in body.joints]
    joints = {joint.name: f"y{k}" for k, joint in enumerate(random.sample(every, len(every)))}
    for body in mbs.bodies:
        body.name = bodies[body.name]
        body.parent = bodies.get(body.parent or "")
        for part in body.joints:
            part.name = joints[part.name]
    random.shuffle(mbs.bodies)
    mbs.bodies = mbs.depth_first()
    mbs.user_models = []
    coordinates = result.names.coordinates
    names = {name: joints[found[0]] for name, found in coordinates.items() if len(found) == 1}
    return Nameless(write(mbs), names)


def leave_out(text: str, joint: str) -> str:
    """Leave out a joint and its link, which carries nothing."""
    root = etree.fromstring(text)
    (element,) = root.xpath(f"joint[@name='{joint}']")
    (child,) = root.xpath(f"link[@name='{element.find('child').get('link')}']")
    root.remove(element)
    root.remove(child)
    return etree.tostring(root).decode()


def change(text: str, pattern: str, new: str, count: int = 1) -> str:
    """Replace what a regular expression matches, so many times."""
    changed, found = re.subn(pattern, new, text, flags=re.DOTALL)
    assert found == count, (pattern, found)
    return changed
