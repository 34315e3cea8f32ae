"""What an .mbs file means: an evaluator of the file's own words, in numpy.

It shares no code with ``urdf2mbs``: it parses the bytes itself, follows the rules by which
Robotran reads the format, and is as strict as Robotran's own programs are careless: what
these would drop in silence (a doubled name, a child before its parent, a body without a
joint, an empty number) is a ``ValueError`` here.

Units are m, kg, rad, s; rotations take coordinates in the turned frame to the outer one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from lxml import etree

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

GROUND = "base"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
AXES = {"1": (1.0, 0.0, 0.0), "2": (0.0, 1.0, 0.0), "3": (0.0, 0.0, 1.0)}


def translation(xyz: Sequence[float] | Array) -> Array:
    """The 4x4 pose of a frame shifted by xyz (m)."""
    pose = np.eye(4)
    pose[:3, 3] = xyz
    return pose


def rotations(axes: Array, angles: Array) -> Array:
    """Rodrigues' formula: (n, 3, 3) rotations by angles (n,) about unit axes (n, 3)."""
    k = np.zeros((len(angles), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -axes[:, 2], axes[:, 1], -axes[:, 0]
    k -= k.transpose(0, 2, 1)
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + s * k + (1.0 - c) * (k @ k)


def rotation(axis: Sequence[float] | Array, angle: float) -> Array:
    """The 3x3 rotation by an angle about one unit axis."""
    return np.asarray(rotations(np.array([axis], dtype=float), np.array([float(angle)]))[0])


@dataclass
class Inertia:
    """Mass (kg), centre of mass (3,) and inertia (3, 3) about it, in the axes of a frame."""

    mass: float
    com: Array
    tensor: Array

    def seen_from(self, pose: Array) -> Inertia:
        """The same matter, from the frame in which this one's frame has the 4x4 ``pose``."""
        rot = pose[:3, :3]
        return Inertia(self.mass, pose[:3, 3] + rot @ self.com, rot @ self.tensor @ rot.T)


def lump(parts: Iterable[Inertia]) -> Inertia:
    """All of them as one rigid body (Steiner), about the common centre of mass."""
    parts = list(parts)
    mass = sum(part.mass for part in parts)
    com = np.zeros(3)
    if mass:
        com = np.sum([part.mass * part.com for part in parts], axis=0) / mass
    tensor = np.zeros((3, 3))
    for part in parts:
        d = part.com - com
        tensor += part.tensor + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Inertia(mass, com, tensor)


@dataclass
class Node:
    """A frame: a constant pose (4x4) in its parent's, then one elementary motion.

    ``kind`` is R (a turn about ``axis``), T (a shift along it) or empty (none). Matter
    fixed to the frame is in ``matter``.
    """

    name: str
    parent: int
    pose: Array
    kind: str = ""
    axis: Sequence[float] | Array = (1.0, 0.0, 0.0)
    matter: list[Inertia] = field(default_factory=list)


class Multibody:
    """A tree of nodes, each after its parent; node 0 is the ground.

    Equations of motion ``M(q) qdd + c(q, qd) + g(q) = tau`` by virtual power over
    geometric Jacobians, the centres of mass as points of reference.
    """

    def __init__(self, nodes: list[Node], gravity: Sequence[float] | Array) -> None:
        self.nodes = nodes
        self.gravity = np.array(gravity, dtype=float)
        self.index = {node.name: i for i, node in enumerate(nodes) if node.kind}
        self._pose = np.array([node.pose for node in nodes])
        self._axis = np.array([node.axis for node in nodes], dtype=float)
        self._turns = np.array([node.kind == "R" for node in nodes])
        self._parent = [node.parent for node in nodes]
        bodies = [(i, part) for i, node in enumerate(nodes) for part in node.matter]
        self._on = np.array([i for i, _ in bodies], dtype=int)
        self._mass = np.array([part.mass for _, part in bodies])
        self._com = np.array([part.com for _, part in bodies]).reshape(-1, 3)
        self._tensor = np.array([part.tensor for _, part in bodies]).reshape(-1, 3, 3)

    def vector(self, q: Mapping[str, float]) -> Array:
        """Values by joint name as an array over all nodes, 0 where not given."""
        out = np.zeros(len(self.nodes))
        for name, value in q.items():
            out[self.index[name]] = value
        return out

    def frames(self, q: Mapping[str, float]) -> Array:
        """(nodes, 4, 4): every frame after its own motion, in the ground's axes."""
        values = self.vector(q)
        local = np.zeros((len(self.nodes), 4, 4))
        local[:] = np.eye(4)
        local[:, :3, :3] = rotations(self._axis, np.where(self._turns, values, 0.0))
        local[:, :3, 3] = np.where(self._turns, 0.0, values)[:, None] * self._axis
        local = self._pose @ local
        for i in range(1, len(self.nodes)):
            local[i] = local[self._parent[i]] @ local[i]
        return local

    def ancestry(self, dofs: Sequence[str]) -> NDArray[np.bool_]:
        """(nodes, dofs): whether the node moves with the joint."""
        column = {self.index[name]: k for k, name in enumerate(dofs)}
        out = np.zeros((len(self.nodes), len(dofs)), dtype=bool)
        for i in range(1, len(self.nodes)):
            out[i] = out[self._parent[i]]
            if i in column:
                out[i, column[i]] = True
        return out

    def carried_mass(self, dofs: Sequence[str]) -> Array:
        """(dofs,): the mass that each joint moves (kg)."""
        return np.asarray(self.ancestry(dofs)[self._on].T @ self._mass)

    def jacobians(self, frames: Array, dofs: Sequence[str]) -> tuple[Array, Array]:
        """Two (bodies, 3, dofs): of the centres' velocities and of the angular velocities."""
        moved = self.ancestry(dofs)[self._on]
        at = [self.index[name] for name in dofs]
        axes = np.einsum("nij,nj->ni", frames[at, :3, :3], self._axis[at])
        turns = self._turns[at]
        arms = self.centres(frames)[:, None, :] - frames[at, :3, 3][None]
        linear = np.where(turns[None, :, None], np.cross(axes[None], arms), axes[None])
        angular = np.where(turns[:, None], axes, 0.0)[None].repeat(len(moved), axis=0)
        keep = moved[:, :, None]
        return (linear * keep).transpose(0, 2, 1), (angular * keep).transpose(0, 2, 1)

    def centres(self, frames: Array) -> Array:
        """(bodies, 3): the centres of mass in the ground's axes."""
        on = frames[self._on]
        return np.asarray(on[:, :3, 3] + np.einsum("bij,bj->bi", on[:, :3, :3], self._com))

    def tensors(self, frames: Array) -> Array:
        """(bodies, 3, 3): the inertias about the centres, in the ground's axes."""
        rot = frames[self._on, :3, :3]
        return np.asarray(rot @ self._tensor @ rot.transpose(0, 2, 1))

    def mass_matrix(self, q: Mapping[str, float], dofs: Sequence[str]) -> Array:
        """(dofs, dofs): the sum of ``J^T M J`` over all bodies."""
        frames = self.frames(q)
        linear, angular = self.jacobians(frames, dofs)
        turned = self.tensors(frames) @ angular
        return np.asarray(
            np.einsum("b,bki,bkj->ij", self._mass, linear, linear, optimize=True)
            + np.einsum("bki,bkj->ij", angular, turned, optimize=True)
        )

    def gravity_forces(self, q: Mapping[str, float], dofs: Sequence[str]) -> Array:
        """(dofs,): the forces (N, N m) that hold the system against gravity."""
        linear, _ = self.jacobians(self.frames(q), dofs)
        return np.asarray(-np.einsum("b,bki,k->i", self._mass, linear, self.gravity))

    def inverse_dynamics(
        self,
        q: Mapping[str, float],
        qd: Mapping[str, float],
        qdd: Mapping[str, float],
        dofs: Sequence[str],
    ) -> Array:
        """(dofs,): the forces that give these accelerations at these positions and rates."""
        frames, rate, acceleration = self.frames(q), self.vector(qd), self.vector(qdd)
        axes = np.einsum("nij,nj->ni", frames[:, :3, :3], self._axis)
        n = len(self.nodes)
        w, dw, a = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        for i in range(1, n):
            p = self._parent[i]
            arm = frames[i, :3, 3] - frames[p, :3, 3]
            own = axes[i] * rate[i]
            w[i], dw[i] = w[p], dw[p]
            a[i] = a[p] + _cross(dw[p], arm) + _cross(w[p], _cross(w[p], arm))
            if self._turns[i]:
                w[i] = w[p] + own
                dw[i] = dw[p] + axes[i] * acceleration[i] + _cross(w[p], own)
            else:
                a[i] += axes[i] * acceleration[i] + 2.0 * _cross(w[p], own)
        wb, dwb = w[self._on], dw[self._on]
        arm = self.centres(frames) - frames[self._on, :3, 3]
        ac = a[self._on] + np.cross(dwb, arm) + np.cross(wb, np.cross(wb, arm))
        tensors = self.tensors(frames)
        force = self._mass[:, None] * (ac - self.gravity)
        spin = np.einsum("bij,bj->bi", tensors, wb)
        torque = np.einsum("bij,bj->bi", tensors, dwb) + np.cross(wb, spin)
        linear, angular = self.jacobians(frames, dofs)
        return np.asarray(
            np.einsum("bki,bk->i", linear, force) + np.einsum("bki,bk->i", angular, torque)
        )


def _cross(a: Array, b: Array) -> Array:
    """The product of two single vectors; ``np.cross`` takes ten times as long for these."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


@dataclass
class Joint:
    """One ``<joint>``: ``type`` T1 .. R3, ``nature``, initial position, body, node number."""

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
        elements = dict.fromkeys(("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"), 0.0)
        if tensor is not None:
            for key in elements:
                elements[key] = _number(tensor, key, 0.0)
        xx, xy, xz, yy, yz, zz = elements.values()
        body.inertia = Inertia(
            _number(element, "mass", 0.0),
            np.zeros(3) if com is None else _vector(com),
            np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
        )
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

    def positions(self, q: Mapping[str, float]) -> Poses:
        return Poses(self, self.system.frames({**self.driven, **q}))

    def mass_matrix(self, q: Mapping[str, float], dofs: Sequence[str]) -> Array:
        """(dofs, dofs) over the chosen joints (kg, kg m, kg m^2)."""
        return self.system.mass_matrix({**self.driven, **q}, dofs)

    def gravity_forces(self, q: Mapping[str, float], dofs: Sequence[str]) -> Array:
        """(dofs,): what holds the system against gravity (N, N m)."""
        return self.system.gravity_forces({**self.driven, **q}, dofs)

    def inverse_dynamics(
        self,
        q: Mapping[str, float],
        qd: Mapping[str, float],
        qdd: Mapping[str, float],
        dofs: Sequence[str],
    ) -> Array:
        """(dofs,): the forces (N, N m) for these accelerations; what is not given is at rest."""
        return self.system.inverse_dynamics({**self.driven, **q}, qd, qdd, dofs)

    def total_mass(self) -> float:
        return sum(body.inertia.mass for body in self.bodies.values())

    def mover(self, body: str, joint: str | None = None) -> str | None:
        """The last joint that is not driven on the way from the ground to a body's frame (or
        to the frame after one of its joints); None when nothing moves it."""
        node = self.joints[joint].node if joint else self.bodies[body].node
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

    def point(self, body: str, point: str) -> Array:
        """(3,): an anchor point (m)."""
        frame = self.body(body)
        return np.asarray(frame[:3, 3] + frame[:3, :3] @ self._mbs.bodies[body].points[point])


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
    size: tuple[float, ...] = ()
    if kind == "box":
        size = tuple(_vector(_child(element, "size")))
    elif kind in {"cylinder", "cone"}:
        size = (_number(element, "radius"), _number(element, "height"))
    elif kind == "sphere":
        size = (_number(element, "radius"),)
    else:
        _require(kind == "inline", f"shape <{kind}>")
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
