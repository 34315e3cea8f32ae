"""Random robots: URDF files as hypothesis draws them, nastier than real ones.

They are valid, and have at least one link with mass that the base carries.
"""

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np
from hypothesis import strategies as st
from lxml import etree

from support.oracle.multibody import Array, rotation

Draw = Callable[[st.SearchStrategy[Any]], Any]


LINK_NAMES = (
    "base",
    "origin",
    "ground",
    "world",
    "hip",
    "hip_body",
    "left/foot",
    "left-foot",
    "left foot",
    "left_foot",
    "1st",
    "_x",
    "double",
    "tête",
    "n_1st",
    "a",
    "b",
    "c",
)
JOINT_NAMES = (
    "hip",
    "hip_origin_R3",
    "hip_axis_R2",
    "hip_back_R3",
    "hip_T1",
    "hip_R3",
    "floating_base",
    "fixed_base",
    "floating_base_T1",
    "base",
    "origin",
    "left/foot",
    "left-foot",
    "left foot",
    "2nd",
    "int",
    "a",
    "b",
    "genou gauche",
)
MOVING = ("revolute", "continuous", "prismatic", "planar", "floating")

ANGLES = st.sampled_from(
    (
        0.0,
        0.0,
        pi / 2,
        -pi / 2,
        pi,
        -pi,
        1.5708,
        -1.5708,
        1.57079632679,
        3.14159,
        3.1415926535897,
        1e-12,
        -1e-9,
        0.7853981633974483,
        0.3,
        -1.1,
        2.7,
        7.0,
    )
)
LENGTHS = st.sampled_from((0.0, 0.0, 0.0, 0.1, -0.25, 1.0, -0.0, 1e-7, 0.3333333333333333, 2.5))
OFF_AXIS = (1e-12, -1e-10, 9e-10, 2e-9, 1e-8, -1e-6)
AXIS_LENGTHS = st.sampled_from((1.0, 1.0, 2.0, 1e-3, 1e4))


def unit(k: int, sign: float = 1.0) -> Array:
    axis = np.zeros(3)
    axis[k] = sign
    return axis


@st.composite
def axes(draw: Draw) -> tuple[float, float, float]:
    """Along a coordinate axis, next to one, in a coordinate plane, next to one, or any."""
    kind = draw(st.sampled_from(("aligned", "near", "plane", "near plane", "any")))
    k = draw(st.integers(0, 2))
    axis = unit(k, draw(st.sampled_from((1.0, -1.0))))
    if kind != "aligned":
        axis[(k + 1) % 3] = draw(st.sampled_from(OFF_AXIS)) if kind == "near" else draw(COMPONENTS)
    if kind == "near plane":
        axis[(k + 2) % 3] = draw(st.sampled_from(OFF_AXIS))
    if kind == "any":
        axis[(k + 2) % 3] = draw(COMPONENTS)
    x, y, z = axis * draw(AXIS_LENGTHS)
    return float(x), float(y), float(z)


COMPONENTS = st.sampled_from((1.0, -1.0, 0.5, -2.0, 0.01, 3.7))


@st.composite
def inertias(draw: Draw) -> tuple[float, Array]:
    """Mass and inertia (3, 3): a solid, a rod, a point, inertia without mass, or nothing."""
    kind = draw(st.sampled_from(("solid", "solid", "solid", "rod", "point", "massless", "none")))
    mass = draw(st.sampled_from((1.0, 12.5, 1e-3, 0.07)))
    size = draw(st.sampled_from((1.0, 0.1, 1e-3)))
    if kind == "none":
        return 0.0, np.zeros((3, 3))
    if kind == "point":
        return mass, np.zeros((3, 3))
    a, b, c = (1.0, 0.0, 0.0) if kind == "rod" else (0.5, 0.2, 0.1)
    tensor = np.diag([b + c, a + c, a + b]) * mass * size**2
    turn = rotation(unit(2), draw(ANGLES)) @ rotation(unit(1), draw(ANGLES))
    tensor = turn @ tensor @ turn.T
    return (0.0 if kind == "massless" else mass), (tensor + tensor.T) / 2


#: How the numbers of a file are spelt, and what stands between them.
SPELLINGS = (("{!r}", " "), ("{:+.17e}", "  "), ("{:.17g}", "\n\t "))


@st.composite
def robots(draw: Draw, most: int = 7) -> bytes:
    """A URDF file of up to ``most`` links."""
    count = draw(st.integers(1, most))
    links = draw(st.permutations(LINK_NAMES))[:count]
    joints = draw(st.permutations(JOINT_NAMES))[: count - 1]
    spelling, blank = draw(st.sampled_from(SPELLINGS))

    def text(values: Any) -> str:
        return blank.join(spelling.format(float(value)) for value in np.atleast_1d(values))

    def origin(parent: etree._Element) -> None:
        if draw(st.booleans()):
            shift = [draw(LENGTHS) for _ in range(3)]
            turn = [draw(ANGLES) for _ in range(3)]
            element = etree.SubElement(parent, "origin")
            part = draw(st.sampled_from(("both", "both", "both", "xyz", "rpy")))
            if part != "rpy":
                element.set("xyz", text(shift))
            if part != "xyz":
                element.set("rpy", text(turn))

    elements = []
    # the last link is a leaf, or the only one: it has mass
    for i, name in enumerate(links):
        link = etree.Element("link", name=name)
        mass, tensor = draw(inertias())
        if i == count - 1 and not (mass or tensor.any()):
            mass = 1.0
        if mass or tensor.any() or draw(st.booleans()):
            inertial = etree.SubElement(link, "inertial")
            if draw(st.booleans()):
                etree.SubElement(inertial, "mass", value=text(mass))
                origin(inertial)
            else:
                origin(inertial)
                etree.SubElement(inertial, "mass", value=text(mass))
            tensor_element = etree.SubElement(inertial, "inertia")
            for key, (r, c) in {
                "ixx": (0, 0),
                "ixy": (0, 1),
                "ixz": (0, 2),
                "iyy": (1, 1),
                "iyz": (1, 2),
                "izz": (2, 2),
            }.items():
                tensor_element.set(key, text(tensor[r, c]))
        for _ in range(draw(st.sampled_from((0, 0, 1, 2)))):
            visual = etree.SubElement(link, "visual")
            if draw(st.booleans()):
                visual.set("name", draw(st.sampled_from(("v", "w x"))))
            origin(visual)
            _geometry(draw, etree.SubElement(visual, "geometry"), text)
            look = draw(st.sampled_from((None, "red", "own", "both")))
            if look is not None:
                material = etree.SubElement(visual, "material")
                if look != "own":
                    material.set("name", "red")
                if look != "red":
                    rgba = (0.9, 0.1, 0.2, 0.75) if look == "both" else (0.2, 0.4, 0.6, 0.5)
                    etree.SubElement(material, "color", rgba=text(rgba))
        elements.append(link)
    for i, name in enumerate(joints, start=1):
        kind = draw(st.sampled_from(("fixed", "revolute", *MOVING)))
        joint = etree.Element("joint", name=name, type=kind)
        parts = [
            etree.Element("parent", link=links[draw(st.integers(0, i - 1))]),
            etree.Element("child", link=links[i]),
        ]
        if kind in {"revolute", "prismatic"}:
            parts.append(etree.Element("limit", lower="-1", upper="1", effort="10", velocity="1"))
        if kind not in {"fixed", "floating"} and draw(st.sampled_from((True, True, False))):
            parts.append(etree.Element("axis", xyz=text(draw(axes()))))
        holder = etree.Element("holder")
        origin(holder)
        parts += list(holder)
        for part in draw(st.permutations(parts)):
            joint.append(part)
        elements.append(joint)
    red = etree.Element("material", name="red")
    etree.SubElement(red, "color", rgba=text((0.9, 0.1, 0.2, 0.75)))
    elements.append(red)
    root = etree.Element("robot", name=draw(st.sampled_from(("r", "my robot", "base"))))
    if draw(st.booleans()):
        root.append(etree.Comment(" drawn by hypothesis "))
    for element in draw(st.permutations(elements)):
        root.append(element)
    return etree.tostring(root, xml_declaration=True, encoding="utf-8")


SHAPES: dict[str, dict[str, Any]] = {
    "box": {"size": (0.1, 0.25, 1.5)},
    "cylinder": {"radius": 0.05, "length": 0.7},
    "sphere": {"radius": 0.3},
    "mesh": {},
}


def _geometry(draw: Draw, parent: etree._Element, text: Callable[[Any], str]) -> None:
    kind = draw(st.sampled_from((*SHAPES,)))
    sizes = {name: text(size) for name, size in SHAPES[kind].items()}
    element = etree.SubElement(parent, kind, sizes)
    if kind == "mesh":
        element.set("filename", draw(st.sampled_from(("a.stl", "deep/a.STL", "../b c.dae"))))
        if draw(st.booleans()):
            element.set("scale", text((0.001, -1.0, 2.0)))


def snapped(text: bytes) -> float:
    """How far (rad, at most 1e-9 each) all axes together may be moved to where they belong: the
    format treats an axis so near to a coordinate axis or plane as lying on it."""
    total = 0.0
    for axis in etree.fromstring(text).iterfind("joint/axis"):
        xyz = np.array([float(word) for word in axis.get("xyz").split()])
        xyz /= np.linalg.norm(xyz)
        total += float(np.abs(xyz[np.abs(xyz) <= 1.0000001e-9]).sum())
    return total
