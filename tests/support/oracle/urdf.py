"""A URDF by a reading of our own and Rodrigues' formula.

It shares no code with ``urdf2mbs``.  Units are m, kg, rad, s.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
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
    from collections.abc import Mapping, Sequence

    from support.oracle.multibody import Array

GRAVITY = (0.0, 0.0, -9.81)
#: What has no colour.
GREY = (128 / 255, 128 / 255, 128 / 255, 1.0)
X, Y, Z = np.eye(3)
FLOATING_BASE = "<the base that floats>"


@dataclass
class UrdfJoint:
    """``origin`` is 4x4, child frame in the parent's at zero; ``axis`` a unit vector; ``rpy``
    the origin's angles as written."""

    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array
    rpy: tuple[float, ...]


@dataclass
class UrdfShape:
    """A visual: 4x4 pose in the link frame; ``size`` as the evaluator's ``Shape`` has it; colour
    r g b a, each 0 to 1, None where files that define a material twice leave it open."""

    kind: str
    pose: Array
    size: tuple[float, ...] = ()
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    mesh: str | None = None
    color: tuple[float, ...] | None = None


@dataclass
class Urdf:
    """A URDF file, read straight off its XML; links and joints in the order of the file."""

    inertias: dict[str, Inertia | None]
    shapes: dict[str, list[UrdfShape]]
    joints: dict[str, UrdfJoint]
    children: dict[str, list[UrdfJoint]] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: bytes) -> Urdf:
        root = etree.fromstring(text)
        inertias = {link.get("name", ""): _inertia(link) for link in root.findall("link")}
        colors: dict[str, set[tuple[float, ...]]] = {}
        for color in root.iterfind(".//material/color"):
            name = color.getparent().get("name", "")
            colors.setdefault(name, set()).add(tuple(_numbers(color, "rgba", "")))
        shapes = {
            link.get("name", ""): [_shape(visual, colors) for visual in link.findall("visual")]
            for link in root.findall("link")
        }
        joints = {joint.get("name", ""): _joint(joint) for joint in root.findall("joint")}
        urdf = cls(inertias, shapes, joints, {name: [] for name in inertias})
        for joint in joints.values():
            urdf.children[joint.parent].append(joint)
        return urdf

    @cached_property
    def root(self) -> str:
        below = {joint.child for joint in self.joints.values()}
        (root,) = [name for name in self.inertias if name not in below]
        return root

    @cached_property
    def outward(self) -> list[UrdfJoint]:
        """All joints, parents before children."""
        order = list(self.children[self.root])
        for joint in order:  # grows as it goes
            order += self.children[joint.child]
        return order

    def massless(self, link: str) -> bool:
        inertia = self.inertias[link]
        return inertia is None or not (inertia.mass or inertia.tensor.any())

    def moving_nothing(self) -> set[str]:
        """The moving joints behind which no link has mass or inertia."""
        heavy = {link for link in self.inertias if not self.massless(link)}
        for joint in reversed(self.outward):
            if joint.child in heavy:
                heavy.add(joint.parent)
        return {j.name for j in self.outward if j.type != "fixed" and j.child not in heavy}

    def floats(self, base: str) -> bool:
        """Whether the method puts a floating base under it, as the issue words it."""
        welded = [self.root]
        for link in welded:
            for joint in self.children[link]:
                if joint.type == "floating":
                    return False
                if joint.type == "fixed":
                    welded.append(joint.child)
        if base != "auto":
            return base == "floating"
        mass = sum(found.mass for link in welded if (found := self.inertias[link]) is not None)
        return "world" not in welded and mass > 0.0 and not self._has_arms(welded)

    def _has_arms(self, welded: list[str]) -> bool:
        """Whether one limb of four joints or more is all that moves, or two limbs of so many
        joints in a row that rise above the root, and a head of one joint; without two wheels."""
        moving = [joint for joint in self.joints.values() if joint.type != "fixed"]
        first = [joint for joint in moving if joint.parent in welded]
        ends = [joint for joint in moving if not self._carries(joint.child)]
        if sum(joint.type == "continuous" for joint in ends) >= 2:
            return False
        if len(first) == 1 and first[0].type != "planar":
            return len(moving) >= 4
        poses = {self.root: np.eye(4)}
        for joint in self.outward:
            poses[joint.child] = poses[joint.parent] @ joint.origin
        lowest = min(poses[link][2, 3] for link in welded)
        rises = [poses[link][2, 3] - lowest for link in poses if link not in welded]
        limbs = sorted(self._length(joint) for joint in first)
        return sum(rises) > 1e-6 and len(limbs) > 1 and limbs[-2] >= 4 and sum(limbs[:-2]) <= 1

    def _length(self, joint: UrdfJoint) -> int:
        """How many joints move in a row, from this one outwards."""
        beyond = [self._length(after) for after in self.children[joint.child]]
        return (joint.type != "fixed") + max(beyond, default=0)

    def _carries(self, link: str) -> bool:
        return any(j.type != "fixed" or self._carries(j.child) for j in self.children[link])


def _numbers(element: etree._Element | None, key: str, default: str) -> Array:
    text = default if element is None else element.get(key, default)
    return np.array([float(word) for word in text.split()])


def _origin(element: etree._Element) -> Array:
    """4x4: ``Rz(yaw) Ry(pitch) Rx(roll)`` at xyz."""
    origin = element.find("origin")
    pose = translation(_numbers(origin, "xyz", "0 0 0"))
    r, p, y = _numbers(origin, "rpy", "0 0 0")
    pose[:3, :3] = rotation(Z, y) @ rotation(Y, p) @ rotation(X, r)
    return pose


def _inertia(link: etree._Element) -> Inertia | None:
    """In link axes, about the centre of mass; None where the link states none."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    full = symmetric([_numbers(tensor, key, "0")[0] for key in keys])
    at_com = Inertia(_numbers(mass, "value", "0")[0], np.zeros(3), full)
    return at_com.seen_from(_origin(inertial))


def read_collisions(link: etree._Element) -> list[UrdfShape]:
    """Return the shapes by which a link touches: those of ``<collision>``, or else its visuals."""
    elements = link.findall("collision") or link.findall("visual")
    return [_geometry(element, _origin(element)) for element in elements]


def _shape(visual: etree._Element, colors: dict[str, set[tuple[float, ...]]]) -> UrdfShape:
    shape = _geometry(visual, _origin(visual))
    material = visual.find("material")
    if material is None:
        shape.color = GREY
    elif not material.get("name") and (color := material.find("color")) is not None:
        shape.color = tuple(_numbers(color, "rgba", ""))
    else:
        known = colors.get(material.get("name", ""), {GREY})
        shape.color = next(iter(known)) if len(known) == 1 else None
    return shape


def _geometry(visual: etree._Element, pose: Array) -> UrdfShape:
    (element,) = [e for e in visual.find("geometry") if isinstance(e.tag, str)]
    own = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length")}
    if element.tag in own:
        size = [number for key in own[element.tag] for number in _numbers(element, key, "")]
        return UrdfShape(element.tag, pose, tuple(size))
    scale = tuple(_numbers(element, "scale", "1 1 1"))
    return UrdfShape("inline", pose, scale=scale, mesh=element.get("filename", ""))


def _joint(element: etree._Element) -> UrdfJoint:
    axis = _numbers(element.find("axis"), "xyz", "1 0 0")
    if element.get("type") in {"fixed", "floating"}:
        axis = X
    axis = axis / np.abs(axis).max()  # else the square of a very long or short one is inf or 0
    parent, child = (element.find(end).get("link", "") for end in ("parent", "child"))
    rpy = tuple(_numbers(element.find("origin"), "rpy", "0 0 0"))
    axis = axis / np.linalg.norm(axis)
    return UrdfJoint(
        element.get("name", ""), element.get("type", ""), parent, child, _origin(element), axis, rpy
    )


class Reference:
    """A URDF as a tree of frames.

    The coordinates of a joint are called by its name; of a planar joint NAME#0 to NAME#2, of a
    floating one (and of the floating base) NAME#0 to NAME#5, in the order T1 T2 T3 R1 R2 R3.
    """

    def __init__(
        self,
        urdf: Urdf,
        *,
        floating: bool,
        frozen: Sequence[str] = (),
        gravity: Sequence[float] = GRAVITY,
    ) -> None:
        self.urdf = urdf
        self.coordinates: dict[str, list[str]] = {}
        self._nodes = [Node("ground", -1, np.eye(4))]
        self.node_of: dict[str, int] = {}
        """Every link's node."""
        root = self._moves(FLOATING_BASE, 0, np.eye(4), _six()) if floating else 0
        self._place(urdf.root, root)
        for joint in urdf.outward:
            motions = [] if joint.name in frozen else motions_of(joint, {})
            self._place(
                joint.child,
                self._moves(joint.name, self.node_of[joint.parent], joint.origin, motions),
            )
        self.system = Multibody(self._nodes, gravity)

    def _moves(
        self, joint: str, parent: int, origin: Array, motions: list[tuple[str, Array]]
    ) -> int:
        if not motions:
            self._nodes.append(Node(joint, parent, origin))
            return len(self._nodes) - 1
        self.coordinates[joint] = names = coordinate_names(joint, motions)
        for name, (kind, axis) in zip(names, motions, strict=True):
            self._nodes.append(Node(name, parent, origin, kind, axis))
            parent, origin = len(self._nodes) - 1, np.eye(4)
        return parent

    def _place(self, link: str, node: int) -> None:
        self.node_of[link] = node
        inertia = self.urdf.inertias[link]
        if inertia is not None:
            self._nodes[node].matter.append(inertia)

    def poses(self) -> dict[str, Array]:
        """Every link's frame at zero, 4x4."""
        frames = State(self.system, np.zeros(len(self._nodes))).frames
        return {link: frames[node] for link, node in self.node_of.items()}


def _six() -> list[tuple[str, Array]]:
    return [("T", X), ("T", Y), ("T", Z), ("R", X), ("R", Y), ("R", Z)]


def motions_of(joint: UrdfJoint, planar: Mapping[str, Array]) -> list[tuple[str, Array]]:
    """What the joint lets move, one elementary motion after the other: T or R, and its axis.

    URDF defines no basis in the plane of a planar joint: ``planar`` gives its first vector, in
    the child's frame.
    """
    if joint.type in {"revolute", "continuous"}:
        return [("R", joint.axis)]
    if joint.type == "prismatic":
        return [("T", joint.axis)]
    if joint.type == "floating":
        return _six()
    if joint.type == "planar":
        # at zero any vector in the plane will do
        first = planar.get(joint.name, _across(joint.axis))
        return [("T", first), ("T", np.cross(joint.axis, first)), ("R", joint.axis)]
    return []


def _across(axis: Array) -> Array:
    """Some unit vector normal to a unit vector."""
    other = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    return np.asarray(other / np.linalg.norm(other))


def coordinate_names(joint: str, motions: Sequence[tuple[str, Array]]) -> list[str]:
    return [joint] if len(motions) == 1 else [f"{joint}#{i}" for i in range(len(motions))]
