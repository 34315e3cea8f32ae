"""What an .mbs file means, read by the file's own words.

It shares no code with ``urdf2mbs``: it parses the bytes itself, follows the rules by which
Robotran reads the format, and is as strict as Robotran's own programs are careless: what
these would drop in silence (a doubled name, a child before its parent, a body without a
joint, an empty number) is a ``ValueError`` here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from lxml import etree

from support.oracle.multibody import (
    Inertia,
    Multibody,
    Node,
    State,
    rotation,
    symmetric,
    translation,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from support.oracle.multibody import Array

GROUND = "base"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
AXES = {"1": (1.0, 0.0, 0.0), "2": (0.0, 1.0, 0.0), "3": (0.0, 0.0, 1.0)}


@dataclass
class Joint:
    """One ``<joint>``: ``type`` T1 .. R3, ``nature``, initial position, body, and the number of
    its node, which is Robotran's number of the joint."""

    name: str
    type: str
    nature: str
    q: float
    body: str
    node: int
    symbols: tuple[str, ...] | None


@dataclass(eq=False)
class Shape:
    """One 3D shape: 4x4 pose in the body frame (``T Rx Ry Rz``), then scale (3,).

    ``size`` is what the shape has of its own: (x, y, z), (radius, height), (radius,) or ().
    """

    kind: str
    name: str
    pose: Array
    scale: tuple[float, ...]
    size: tuple[float, ...]
    color: tuple[int, ...]
    transparency: float
    url: str | None


@dataclass
class Body:
    """One ``<body>``; the ground has neither joints nor inertia."""

    name: str
    node: int
    parent: str | None = None
    point: str | None = None
    joints: list[str] = field(default_factory=list)
    inertia: Inertia = field(default_factory=lambda: Inertia(0.0, np.zeros(3), np.zeros((3, 3))))
    points: dict[str, Array] = field(default_factory=dict)
    shapes: list[Shape] = field(default_factory=list)


class Evaluator:
    """An .mbs file, ready to be asked.

    Positions are given by joint name; a driven joint that is not given stands at its
    initial position, any other at 0.
    """

    def __init__(self, data: bytes) -> None:
        root = etree.fromstring(data)
        _require(root.tag == "mbsDescR7", f"the root is <{root.tag}>")
        base, tree = _child(root, "base"), _child(root, "bodytree")
        ground = Body(GROUND, 0)
        self.base_name = _text(base, "baseBodyName")
        self.gravity = _vector(_child(base, "gravity"))
        self.bodies: dict[str, Body] = {GROUND: ground}
        self.joints: dict[str, Joint] = {}
        self._taken = {GROUND, "origin", self.base_name}
        self._nodes = [Node(GROUND, -1, np.eye(4))]
        self._fill(ground, base)
        for element in tree:
            if isinstance(element.tag, str):
                _require(element.tag == "body", f"<{element.tag}> in bodytree")
                self._body(element)
        self.system = Multibody(self._nodes, self.gravity)
        self.driven = {j.name: j.q for j in self.joints.values() if j.nature == "driven"}
        self.moving = [j.name for j in self.joints.values() if j.nature != "driven"]

    def _name(self, element: etree._Element, tag: str) -> str:
        first = next(child for child in element if isinstance(child.tag, str))
        _require(first.tag == tag, f"line {element.sourceline}: {tag} is not the first child")
        name = _text(element, tag)
        _require(name not in self._taken, f"the name {name} is taken")
        self._taken.add(name)
        return name

    def _body(self, element: etree._Element) -> None:
        name = self._name(element, "bodyname")
        above = _child(element, "parent")
        parent, point = _text(above, "bodyname"), _text(above, "pointname")
        _require(parent in self.bodies, f"{name}: its parent {parent} does not stand before it")
        _require(
            point == "origin" or point in self.bodies[parent].points,
            f"{name}: {parent} has no point {point}",
        )
        body = Body(name, 0, parent, point)
        body.node = self.bodies[parent].node
        pose = np.eye(4) if point == "origin" else translation(self.bodies[parent].points[point])
        for joint in element.findall("joint"):
            self._joint(body, joint, pose)
            pose = np.eye(4)
        _require(bool(body.joints), f"{name} has no joint")
        com, tensor = element.find("com"), element.find("inertia")
        keys = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
        elements = np.zeros(6) if tensor is None else [_number(tensor, key, 0.0) for key in keys]
        com = np.zeros(3) if com is None else _vector(com)
        body.inertia = Inertia(_number(element, "mass", 0.0), com, symmetric(elements))
        self._nodes[body.node].matter.append(body.inertia)
        self.bodies[name] = body
        self._fill(body, element)

    def _joint(self, body: Body, element: etree._Element, pose: Array) -> None:
        name, kind = self._name(element, "jointname"), _text(element, "type")
        nature = _text(element, "nature")
        _require(kind in {"T1", "T2", "T3", "R1", "R2", "R3"}, f"{name}: type {kind}")
        _require(nature in {"independent", "dependent", "driven"}, f"{name}: nature {nature}")
        start, symbols = element.find("initialvalue"), element.find("symbols")
        q = 0.0 if start is None else _number(start, "q", 0.0)
        kept = None if symbols is None else tuple(s.tag for s in symbols)
        self._nodes.append(Node(name, body.node, pose, kind[0], AXES[kind[1]]))
        body.node = len(self._nodes) - 1
        body.joints.append(name)
        self.joints[name] = Joint(name, kind, nature, q, body.name, body.node, kept)

    def _fill(self, body: Body, element: etree._Element) -> None:
        for point in element.findall("point"):
            name = _text(point, "pointname")
            _require(name != "origin" and name not in body.points, f"{body.name}: point {name}")
            body.points[name] = _vector(point)
        shapes = element.find("graphics/x3D/x3D_shapes")
        for shape in [] if shapes is None else shapes:
            body.shapes.append(_shape(shape))

    def vector(self, q: Mapping[str, float]) -> Array:
        """Values by joint name, as an array over the nodes; 0 where not given."""
        out = np.zeros(len(self._nodes))
        for name, value in q.items():
            out[self.joints[name].node] = value
        return out

    def positions(self, q: Mapping[str, float]) -> Poses:
        return Poses(self, State(self.system, self.vector({**self.driven, **q})).frames)

    def total_mass(self) -> float:
        return sum(body.inertia.mass for body in self.bodies.values())

    def mover(self, body: str) -> str | None:
        """The last joint that is not driven on the way from the ground to a body's frame; None
        when nothing moves it."""
        node = self.bodies[body].node
        while node and self.joints[self._nodes[node].name].nature == "driven":
            node = self._nodes[node].parent
        return self._nodes[node].name if node else None


class Poses:
    """Where everything is at one position of the joints, in the ground's axes."""

    def __init__(self, mbs: Evaluator, frames: Array) -> None:
        self._mbs = mbs
        self._frames = frames

    def body(self, name: str) -> Array:
        """4x4 of the body frame (after the body's last joint)."""
        return np.asarray(self._frames[self._mbs.bodies[name].node])

    def joint(self, name: str) -> Array:
        """4x4 of the frame after a joint."""
        return np.asarray(self._frames[self._mbs.joints[name].node])


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


def _child(element: etree._Element, tag: str) -> etree._Element:
    found = element.findall(tag)
    _require(len(found) == 1, f"line {element.sourceline}: {len(found)} <{tag}>")
    return found[0]


def _text(element: etree._Element, tag: str) -> str:
    text = _child(element, tag).text
    _require(bool(text and text.strip()), f"line {element.sourceline}: empty <{tag}>")
    return str(text).strip()


def _number(element: etree._Element, tag: str, default: float | None = None) -> float:
    if default is not None and element.find(tag) is None:
        return default
    text = _text(element, tag)
    _require(bool(NUMBER.fullmatch(text)), f"line {element.sourceline}: <{tag}> is {text}")
    return float(text)


def _vector(element: etree._Element) -> Array:
    """(3,) of ``<coordinates>`` with x, y and z, or of these three themselves."""
    inner = element.find("coordinates")
    element = element if inner is None else inner
    return np.array([_number(element, key) for key in "xyz"])


def _shape(element: etree._Element) -> Shape:
    kind = str(element.tag)
    alpha, beta, gamma = _vector(_child(element, "rotation"))
    pose = translation(_vector(_child(element, "position")))
    pose[:3, :3] = (
        rotation(AXES["1"], alpha) @ rotation(AXES["2"], beta) @ rotation(AXES["3"], gamma)
    )
    color = _child(element, "color")
    own = {"cylinder": ("radius", "height"), "cone": ("radius", "height"), "sphere": ("radius",)}
    size = tuple(_number(element, key) for key in own.get(kind, ()))
    if kind == "box":
        size = tuple(_vector(_child(element, "size")))
    _require(bool(size) or kind == "inline", f"shape <{kind}>")
    return Shape(
        kind,
        _text(element, "name"),
        pose,
        tuple(_vector(_child(element, "scale"))),
        size,
        tuple(int(color.get(c, "")) for c in "RGB"),
        _number(element, "transparency"),
        _text(element, "url") if kind == "inline" else None,
    )
