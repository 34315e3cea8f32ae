"""What others say of a URDF: pinocchio, and a reading of our own by Rodrigues' formula.

Neither shares code with ``urdf2mbs``, nor pinocchio any with the other. ``Comparison`` sets a
conversion against either.

Units are m, kg, rad, s.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from evaluator import Evaluator, Inertia, Multibody, Node, lump, rotation, translation
from lxml import etree

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from evaluator import Array, Shape

    from urdf2mbs import Result

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
        return "world" not in welded and mass > 0.0 and not self._is_arm(welded)

    def _is_arm(self, welded: list[str]) -> bool:
        """Whether one limb of four joints or more, without two wheels, is all that moves."""
        moving = [joint for joint in self.joints.values() if joint.type != "fixed"]
        first = [joint for joint in moving if joint.parent in welded]
        ends = [joint for joint in moving if not self._carries(joint.child)]
        wheels = [joint for joint in ends if joint.type == "continuous"]
        lone = len(first) == 1 and first[0].type != "planar"
        return lone and len(moving) >= 4 and len(wheels) < 2

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
    value = {k: _numbers(tensor, f"i{k}", "0")[0] for k in ("xx", "xy", "xz", "yy", "yz", "zz")}
    full = np.array(
        [
            [value["xx"], value["xy"], value["xz"]],
            [value["xy"], value["yy"], value["yz"]],
            [value["xz"], value["yz"], value["zz"]],
        ]
    )
    at_com = Inertia(_numbers(mass, "value", "0")[0], np.zeros(3), full)
    return at_com.seen_from(_origin(inertial))


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
    if element.tag == "box":
        return UrdfShape("box", pose, tuple(_numbers(element, "size", "")))
    if element.tag == "sphere":
        return UrdfShape("sphere", pose, tuple(_numbers(element, "radius", "")))
    if element.tag == "cylinder":
        size = *_numbers(element, "radius", ""), *_numbers(element, "length", "")
        return UrdfShape("cylinder", pose, size)
    scale = tuple(_numbers(element, "scale", "1 1 1"))
    return UrdfShape("inline", pose, scale=scale, mesh=element.get("filename", ""))


def _joint(element: etree._Element) -> UrdfJoint:
    axis = _numbers(element.find("axis"), "xyz", "1 0 0")
    if element.get("type") in {"fixed", "floating"}:
        axis = X
    axis = axis / np.abs(axis).max()  # else the square of a very long or short one is inf or 0
    return UrdfJoint(
        element.get("name", ""),
        element.get("type", ""),
        element.find("parent").get("link", ""),
        element.find("child").get("link", ""),
        _origin(element),
        axis / np.linalg.norm(axis),
        tuple(_numbers(element.find("origin"), "rpy", "0 0 0")),
    )


class Reference:
    """A URDF by Rodrigues' formula: ``poses``, ``groups``, ``mass_matrix``, ...

    The coordinates of a joint are called by its name; of a planar joint NAME#0 to NAME#2, of a
    floating one (and of the floating base) NAME#0 to NAME#5, in the order T1 T2 T3 R1 R2 R3.
    URDF defines no basis in the plane of a planar joint: ``planar`` gives its first vector, in
    the child's frame.
    """

    name = "rodrigues"

    def __init__(
        self,
        urdf: Urdf,
        *,
        floating: bool,
        frozen: Sequence[str] = (),
        planar: Mapping[str, Array] | None = None,
    ) -> None:
        self.urdf = urdf
        self.coordinates: dict[str, list[str]] = {}
        self._nodes = [Node("ground", -1, np.eye(4))]
        self._of: dict[str, int] = {}
        """Every link's node."""
        self._mover: dict[str, str | None] = {urdf.root: None}
        here = 0
        if floating:
            here = self._moves(FLOATING_BASE, 0, np.eye(4), _six())
            self._mover[urdf.root] = FLOATING_BASE
        self._place(urdf.root, here)
        for joint in urdf.outward:
            motions = [] if joint.name in frozen else _motions(joint, planar or {})
            self._mover[joint.child] = joint.name if motions else self._mover[joint.parent]
            self._place(
                joint.child,
                self._moves(joint.name, self._of[joint.parent], joint.origin, motions),
            )
        self.system = Multibody(self._nodes, GRAVITY)

    def _moves(
        self, joint: str, parent: int, origin: Array, motions: list[tuple[str, Array]]
    ) -> int:
        if not motions:
            self._nodes.append(Node(joint, parent, origin))
            return len(self._nodes) - 1
        self.coordinates[joint] = names = _coordinates(joint, motions)
        for name, (kind, axis) in zip(names, motions, strict=True):
            self._nodes.append(Node(name, parent, origin, kind, axis))
            parent, origin = len(self._nodes) - 1, np.eye(4)
        return parent

    def _place(self, link: str, node: int) -> None:
        self._of[link] = node
        inertia = self.urdf.inertias[link]
        if inertia is not None:
            self._nodes[node].matter.append(inertia)

    @property
    def dofs(self) -> list[str]:
        return [name for names in self.coordinates.values() for name in names]

    def poses(self, q: Mapping[str, float]) -> dict[str, Array]:
        """Every link's frame, 4x4."""
        frames = self.system.frames(q)
        return {link: frames[node] for link, node in self._of.items()}

    def groups(self) -> dict[str | None, tuple[str, Inertia]]:
        """For each moving joint (None: the ground), the matter that it moves and that is rigid,
        as one body, in the frame of the link that is named first."""
        zero = self.poses({})
        members: dict[str | None, list[str]] = {}
        for link, mover in self._mover.items():
            members.setdefault(mover, []).append(link)
        out: dict[str | None, tuple[str, Inertia]] = {}
        for mover, links in members.items():
            back = np.linalg.inv(zero[links[0]])
            parts = [
                inertia.seen_from(back @ zero[link])
                for link in links
                if (inertia := self.urdf.inertias[link]) is not None
            ]
            out[mover] = links[0], lump(parts)
        return out

    def mass_matrix(self, q: Mapping[str, float]) -> Array:
        return self.system.mass_matrix(q, self.dofs)

    def gravity_forces(self, q: Mapping[str, float]) -> Array:
        return self.system.gravity_forces(q, self.dofs)

    def inverse_dynamics(
        self, q: Mapping[str, float], qd: Mapping[str, float], qdd: Mapping[str, float]
    ) -> Array:
        return self.system.inverse_dynamics(q, qd, qdd, self.dofs)


def _six() -> list[tuple[str, Array]]:
    return [("T", X), ("T", Y), ("T", Z), ("R", X), ("R", Y), ("R", Z)]


def _motions(joint: UrdfJoint, planar: Mapping[str, Array]) -> list[tuple[str, Array]]:
    """What the joint lets move, one elementary motion after the other: T or R, and its axis."""
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


def _coordinates(joint: str, motions: Sequence[tuple[str, Array]]) -> list[str]:
    return [joint] if len(motions) == 1 else [f"{joint}#{i}" for i in range(len(motions))]


_LINK = "link:"


class Pinocchio:
    """A URDF as pinocchio reads it, with the names of ``Reference``.

    Pinocchio gets the links' inertias and the joints only: what is drawn, limited, damped or
    mimicked does not change these equations (and a missing limit or an unreadable mesh
    would make it refuse). Planar joints, whose axis it ignores, and floating ones, whose
    coordinates are others than an .mbs's, it gets as three and six joints with massless links
    between. Numbers are trimmed, since urdfdom drops an inertial that has a line break after
    a number.
    """

    name = "pinocchio"

    def __init__(
        self,
        urdf: Urdf,
        text: bytes,
        *,
        floating: bool,
        frozen: Sequence[str] = (),
        planar: Mapping[str, Array] | None = None,
    ) -> None:
        import pinocchio as pin

        self.coordinates: dict[str, list[str]] = {}
        xml = self._plain(urdf, text, planar or {})
        if floating:
            root = pin.JointModelComposite()
            for part in ("PX", "PY", "PZ", "RX", "RY", "RZ"):
                root.addJoint(getattr(pin, f"JointModel{part}")())
            model = pin.buildModelFromXML(xml, root, FLOATING_BASE)
            self.coordinates[FLOATING_BASE] = [f"{FLOATING_BASE}#{i}" for i in range(6)]
        else:
            model = pin.buildModelFromXML(xml)
        locked = [name for joint in frozen for name in self.coordinates.pop(joint)]
        if locked:
            ids = [model.getJointId(name) for name in locked]
            model = pin.buildReducedModel(model, ids, pin.neutral(model))
        model.gravity = pin.Motion(np.array(GRAVITY), np.zeros(3))
        self._pin, self._model, self._data = pin, model, model.createData()
        self.dofs: list[str] = []
        for name in list(model.names)[1:]:
            self.dofs += self.coordinates[name] if name == FLOATING_BASE else [name]
        self._joint = {name: key for key, names in self.coordinates.items() for name in names}
        self._joint[FLOATING_BASE] = FLOATING_BASE
        self._frame = {
            frame.name.removeprefix(_LINK): i
            for i, frame in enumerate(model.frames)
            if frame.type == pin.BODY and frame.name.startswith(_LINK)
        }
        self._links = list(urdf.inertias)

    def _plain(self, urdf: Urdf, text: bytes, planar: Mapping[str, Array]) -> str:
        """The same links and joints in XML, and nothing else of them than their mechanics."""
        root = etree.fromstring(text, etree.XMLParser(remove_comments=True, remove_pis=True))
        for element in list(root):
            if element.tag not in {"link", "joint"}:
                root.remove(element)
                continue
            for child in list(element):
                if child.tag not in {"inertial", "origin", "parent", "child", "axis"}:
                    element.remove(child)
        for element in root.iter():
            for key, value in element.attrib.items():
                # a link and a joint of one name are too much for buildReducedModel
                if key == "link" or (element.tag == "link" and key == "name"):
                    element.set(key, _LINK + value)
                elif key != "name":
                    element.set(key, " ".join(value.split()))
        for element in root.findall("joint"):
            joint = urdf.joints[element.get("name", "")]
            if joint.type == "fixed":
                continue
            motions = _motions(joint, planar)
            if element.find("axis") is not None:
                # pinocchio squares it: what is very long or short would over- or underflow
                element.find("axis").set("xyz", _spelt(joint.axis))
            self.coordinates[joint.name] = names = _coordinates(joint.name, motions)
            if len(motions) > 1:
                root.remove(element)
                _series(root, element, names, motions)
        for element in root.findall("joint"):
            etree.SubElement(element, "limit", lower="-9", upper="9", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")

    def _vectors(self, q: Mapping[str, float]) -> tuple[Array, Array]:
        """(nq,) with cos and sin for continuous joints, and (nv,) as the values stand."""
        model = self._model
        values = np.array([q.get(name, 0.0) for name in self.dofs])
        configuration = np.zeros(model.nq)
        for joint in list(model.joints)[1:]:
            at = values[joint.idx_v : joint.idx_v + joint.nv]
            if joint.nq == 2 and joint.nv == 1:
                at = np.array([np.cos(at[0]), np.sin(at[0])])
            configuration[joint.idx_q : joint.idx_q + joint.nq] = at
        return configuration, values

    def poses(self, q: Mapping[str, float]) -> dict[str, Array]:
        """Every link's frame, 4x4."""
        self._pin.framesForwardKinematics(self._model, self._data, self._vectors(q)[0])
        return {
            link: np.array(self._data.oMf[self._frame[link]].homogeneous) for link in self._links
        }

    def groups(self) -> dict[str | None, tuple[str, Inertia]]:
        """As ``Reference.groups``: pinocchio has already merged what is fixed."""
        model = self._model
        zero = self.poses({})
        out: dict[str | None, tuple[str, Inertia]] = {}
        for link in self._links:
            joint = model.frames[self._frame[link]].parentJoint
            mover = self._joint[model.names[joint]] if joint else None
            if mover not in out:
                inertia = model.inertias[joint]
                merged = Inertia(inertia.mass, np.array(inertia.lever), np.array(inertia.inertia))
                pose = np.linalg.inv(zero[link]) @ np.array(self._data.oMi[joint].homogeneous)
                out[mover] = link, merged.seen_from(pose)
        return out

    def mass_matrix(self, q: Mapping[str, float]) -> Array:
        upper = np.triu(self._pin.crba(self._model, self._data, self._vectors(q)[0]))
        return np.asarray(upper + np.triu(upper, 1).T)

    def gravity_forces(self, q: Mapping[str, float]) -> Array:
        force = self._pin.computeGeneralizedGravity(self._model, self._data, self._vectors(q)[0])
        return np.array(force)

    def inverse_dynamics(
        self, q: Mapping[str, float], qd: Mapping[str, float], qdd: Mapping[str, float]
    ) -> Array:
        (configuration, _), (_, rate), (_, acceleration) = map(self._vectors, (q, qd, qdd))
        force = self._pin.rnea(self._model, self._data, configuration, rate, acceleration)
        return np.array(force)


def _series(
    root: etree._Element,
    joint: etree._Element,
    names: Sequence[str],
    motions: Sequence[tuple[str, Array]],
) -> None:
    """Adds one joint after the other in place of ``joint``, with massless links between."""
    ends = [joint.find("parent").get("link"), *(f"{name} link" for name in names[:-1])]
    ends.append(joint.find("child").get("link"))
    for i, (name, (kind, axis)) in enumerate(zip(names, motions, strict=True)):
        one = etree.SubElement(root, "joint", name=name)
        one.set("type", "continuous" if kind == "R" else "prismatic")
        if i > 0:
            etree.SubElement(root, "link", name=ends[i])
        elif (origin := joint.find("origin")) is not None:
            one.append(origin)
        etree.SubElement(one, "parent", link=ends[i])
        etree.SubElement(one, "child", link=ends[i + 1])
        etree.SubElement(one, "axis", xyz=_spelt(axis))


def _spelt(numbers: Array) -> str:
    return " ".join(repr(float(number)) for number in numbers)


Model = Reference | Pinocchio


class Comparison:
    """A conversion against a model of its URDF: the largest relative error of each kind.

    Each is relative to what it can be compared with at all:

    * ``pose``: positions to the farthest link, rotations as they are;
    * ``mass``, ``com``, ``inertia`` of each rigid group: its mass; the farthest link; its
      inertia plus mass times the distance of its centre squared;
    * ``matrix``: ``M_ij`` to ``sqrt(M_ii M_jj)``, so that a finger counts as much as the base;
    * ``gravity``: to ``9.81 sqrt(m M_ii)`` with the moved mass m, its bound by Cauchy-Schwarz;
    * ``dynamics``: forces over ``sqrt(M_ii)`` to the largest of these, weights included.

    A joint that moves almost nothing counts as if it moved its mass on 3e-3 of the size: its
    ``M_ii`` is a small difference of large numbers.
    """

    def __init__(
        self, result: Result, urdf: Urdf, *, floating: bool, ground_has_mass: bool = True
    ) -> None:
        self.result = result
        self.ground_has_mass = ground_has_mass
        self.urdf = urdf
        self.mbs = Evaluator(result.data)
        self.floating = floating
        self.frozen = sorted(result.frozen)
        self.reals: dict[str, list[str]] = {}
        """The .mbs joints that are each URDF joint's own coordinates, in their order."""
        for joint in urdf.joints.values():
            if joint.name not in self.frozen:
                self._real(joint.name, joint.name, joint.type)
        new = [name for name in result.names.joints if name not in urdf.joints]
        if floating:
            (base,) = new
            self._real(FLOATING_BASE, base, "floating")
        own = [name for names in self.reals.values() for name in names]
        assert sorted(own) == sorted(self.mbs.moving), "what moves is not what the URDF moves"

    def _real(self, key: str, joint: str, kind: str) -> None:
        names = self.result.names.joints.get(joint, [])
        real = [name for name in names if self.mbs.joints[name].nature != "driven"]
        count = {"fixed": 0, "planar": 3, "floating": 6}.get(kind, 1)
        assert len(real) == count, f"{joint} ({kind}) has become {names}"
        if real:
            self.reals[key] = real
        for name in real:
            kept = self.mbs.joints[name].symbols
            assert kept is None or {"q", "qd", "qdd"} <= set(kept), f"{name} moves, but {kept}"
        types = [self.mbs.joints[name].type for name in real]
        expected = {
            "fixed": [""],
            "revolute": ["R"],
            "continuous": ["R"],
            "prismatic": ["T"],
            "planar": ["TTR"],
            "floating": ["TTTRRR"],
        }[kind]
        assert "".join(t[0] for t in types) in expected, f"{joint} ({kind}) is {types}"

    @cached_property
    def planar(self) -> dict[str, Array]:
        """The first vector of each planar joint's basis, in the child's frame, off the .mbs: it
        must lie in the plane, and the second must follow from it and the axis."""
        planar = {}
        zero = self.mbs.positions({})
        at = self.link_poses({})
        for joint in self.urdf.joints.values():
            if joint.type == "planar" and joint.name in self.reals:
                first, _, turn = (self.mbs.joints[name] for name in self.reals[joint.name])
                back = at[joint.child][:3, :3].T
                axis = back @ zero.joint(turn.name)[:3, int(turn.type[1]) - 1]
                assert abs(axis - joint.axis).max() < 3e-9, f"{joint.name} does not turn about it"
                basis = back @ zero.joint(first.name)[:3, int(first.type[1]) - 1]
                assert abs(basis @ joint.axis) < 3e-9, f"{joint.name} shifts out of its plane"
                # an axis up to 1e-9 off is taken to be aligned, which turns the plane with it
                basis -= (basis @ joint.axis) * joint.axis
                planar[joint.name] = basis / np.linalg.norm(basis)
        return planar

    def reference(self) -> Reference:
        return Reference(self.urdf, floating=self.floating, frozen=self.frozen, planar=self.planar)

    def pinocchio(self, text: bytes) -> Pinocchio:
        return Pinocchio(
            self.urdf, text, floating=self.floating, frozen=self.frozen, planar=self.planar
        )

    def link_poses(self, q: Mapping[str, float]) -> dict[str, Array]:
        """Every URDF link's frame as the .mbs has it, 4x4; q by .mbs name."""
        poses = self.mbs.positions(q)
        out: dict[str, Array] = {}
        for link in self.urdf.inertias:
            frame = self.result.frames[link]
            at = np.eye(4)
            if frame.joint is not None:
                at = poses.joint(frame.joint)
            elif frame.body is not None:
                at = poses.body(frame.body)
            pose = translation(frame.pose.xyz)
            pose[:3, :3] = np.array(frame.pose.rot).reshape(3, 3)
            out[link] = at @ pose
        return out

    @cached_property
    def size(self) -> float:
        """The farthest link or matter (by its radius of gyration) from the root at zero (m)."""
        poses = Reference(self.urdf, floating=False).poses({})
        far = [np.linalg.norm(pose[:3, 3]) for pose in poses.values()]
        far += [
            np.linalg.norm(poses[link][:3, 3] + poses[link][:3, :3] @ inertia.com)
            + np.sqrt(abs(np.trace(inertia.tensor)) / (inertia.mass or 1.0))
            for link, inertia in self.urdf.inertias.items()
            if inertia is not None
        ]
        return float(max(far)) or 1.0

    def random(self, rng: np.random.Generator) -> dict[str, float]:
        """A value for every moving .mbs joint: any angle, shifts up to the robot's size."""
        return {
            name: rng.uniform(-np.pi, np.pi)
            if self.mbs.joints[name].type[0] == "R"
            else rng.uniform(-self.size, self.size)
            for name in self.mbs.moving
        }

    def errors(self, model: Model, positions: Sequence[Mapping[str, float]]) -> dict[str, float]:
        assert set(model.coordinates) == set(self.reals), "not the same joints"
        names = {
            ours: theirs
            for joint, real in self.reals.items()
            for ours, theirs in zip(real, model.coordinates[joint], strict=True)
        }
        # both in the model's order
        dofs = {theirs: ours for ours, theirs in names.items()}
        order = [dofs[name] for name in model.dofs]
        found = self._group_errors(model)
        for kind in ("pose", "matrix", "gravity", "dynamics"):
            found[kind] = 0.0
        rng = np.random.default_rng(1)
        for q in positions:
            theirs = {names[name]: value for name, value in q.items()}
            found["pose"] = max(found["pose"], self._pose_error(model, q, theirs))
            if order:
                for kind, error in self._force_errors(model, order, names, q, rng).items():
                    found[kind] = max(found[kind], error)
        return found

    def _pose_error(
        self, model: Model, q: Mapping[str, float], theirs: Mapping[str, float]
    ) -> float:
        ours, wanted = self.link_poses(q), model.poses(theirs)
        a = np.array([ours[link] for link in wanted])
        b = np.array(list(wanted.values()))
        far = max(np.abs(b[:, :3, 3]).max(), self.size)
        shift = np.abs(a[:, :3, 3] - b[:, :3, 3]).max() / far
        return float(max(shift, np.abs(a[:, :3, :3] - b[:, :3, :3]).max()))

    def _group_errors(self, model: Model) -> dict[str, float]:
        zero = self.mbs.positions({})
        link_at = self.link_poses({})
        key_of = {real[-1]: joint for joint, real in self.reals.items()}
        bodies: dict[str | None, list[str]] = {}
        for name in self.mbs.bodies:
            mover = self.mbs.mover(name)
            bodies.setdefault(key_of[mover] if mover else None, []).append(name)
        error = {"mass": 0.0, "com": 0.0, "inertia": 0.0}
        groups = model.groups()
        assert set(key_of.values()) <= set(groups), "a joint moves no link"
        total = 0.0
        for name in bodies.get(None, []) if None not in groups else []:
            inertia = self.mbs.bodies[name].inertia
            assert inertia.mass == 0.0, f"{name} cannot move"
            assert not inertia.tensor.any(), f"{name} cannot move"
        if not self.ground_has_mass:
            groups.pop(None, None)
        for key, (link, wanted) in groups.items():
            back = np.linalg.inv(link_at[link])
            ours = lump(
                self.mbs.bodies[name].inertia.seen_from(back @ zero.body(name))
                for name in bodies.get(key, [])
            )
            total += wanted.mass
            arm = max(float(np.linalg.norm(wanted.com)), 1e-4 * self.size)
            worth = np.abs(wanted.tensor).max() + wanted.mass * arm * arm
            for kind, difference, unit in (
                ("mass", ours.mass - wanted.mass, wanted.mass),
                # what has inertia but no mass has no centre
                ("com", (ours.com - wanted.com) * (wanted.mass != 0.0), self.size),
                ("inertia", ours.tensor - wanted.tensor, worth),
            ):
                largest = float(np.abs(difference).max())
                error[kind] = max(error[kind], largest / unit if unit else largest)
        if total:
            error["mass"] = max(error["mass"], abs(self.mbs.total_mass() - total) / total)
        return error

    def _force_errors(
        self,
        model: Model,
        order: list[str],
        names: Mapping[str, str],
        q: Mapping[str, float],
        rng: np.random.Generator,
    ) -> dict[str, float]:
        def by_model(values: Mapping[str, float]) -> dict[str, float]:
            return {names[name]: value for name, value in values.items()}

        wanted = model.mass_matrix(by_model(q))
        moved = self.mbs.system.carried_mass(order)
        lever = np.array(
            [self.size if self.mbs.joints[name].type[0] == "R" else 1.0 for name in order]
        )
        unit = np.sqrt(np.diag(wanted).clip(0.0) + 1e-5 * moved * lever**2)
        unit[unit == 0.0] = 1.0
        matrix = np.abs(self.mbs.mass_matrix(q, order) - wanted) / np.outer(unit, unit)
        gravity = self.mbs.gravity_forces(q, order) - model.gravity_forces(by_model(q))
        bound = 9.81 * np.sqrt(moved) * unit
        bound[bound == 0.0] = 1.0
        qd, qdd = (dict(zip(order, rng.uniform(-1, 1, len(order)), strict=True)) for _ in "12")
        for name in order:
            if self.mbs.joints[name].type[0] == "T":
                qd[name] *= self.size
                qdd[name] *= self.size
        force = model.inverse_dynamics(by_model(q), by_model(qd), by_model(qdd))
        difference = self.mbs.inverse_dynamics(q, qd, qdd, order) - force
        largest = max(np.abs(force / unit).max(), 9.81 * np.sqrt(moved).max()) or 1.0
        return {
            "matrix": float(matrix.max()),
            "gravity": float(np.abs(gravity / bound).max()),
            "dynamics": float(np.abs(difference / unit).max() / largest),
        }


def lost_shapes(comparison: Comparison, tolerance: float = 1e-12) -> list[str]:
    """The visuals that the .mbs does not show where the URDF does, and shapes it has besides."""
    result, urdf = comparison.result, comparison.urdf
    left = {name: list(body.shapes) for name, body in comparison.mbs.bodies.items()}
    lost: list[str] = []
    pairs: set[tuple[str, str]] = set()
    for link, visuals in urdf.shapes.items():
        frame = result.frames[link]
        if visuals and frame.joint is not None:
            lost.append(f"{link} has no body to show its shapes on")
            continue
        at = translation(frame.pose.xyz)
        at[:3, :3] = np.array(frame.pose.rot).reshape(3, 3)
        there = left["base" if frame.body is None else frame.body]
        for visual in visuals:
            match = [s for s in there if _same(s, visual, at @ visual.pose, tolerance)]
            if match:
                there.remove(match[0])
                if visual.mesh is not None:
                    pairs.add((visual.mesh, str(match[0].url).lower()))
            else:
                lost.append(f"{link}: {visual.kind} {visual.size}")
    lost += [f"{name}: {s.kind} {s.name} is of no link" for name in left for s in left[name]]
    # one file for each mesh, also where letter case does not count
    if not len(pairs) == len({mesh for mesh, _ in pairs}) == len({url for _, url in pairs}):
        lost.append(f"meshes are mixed up: {sorted(pairs)}")
    return lost


def _same(shape: Shape, visual: UrdfShape, at: Array, tolerance: float) -> bool:
    if (shape.kind, shape.size, shape.scale) != (visual.kind, visual.size, visual.scale):
        return False
    if visual.color is not None:
        *color, alpha = np.clip(visual.color, 0.0, 1.0)
        if np.abs(np.array(shape.color) - 255 * np.array(color)).max() > 0.5:
            return False
        if abs(shape.transparency - (1.0 - alpha)) > 1e-12:
            return False
    ours, wanted = shape.pose[:3, :3], at[:3, :3]
    if shape.kind == "sphere":
        turned = 0.0
    elif shape.kind == "cylinder":  # .mbs's axis is y, URDF's z; which end is which is not seen
        turned = min(np.abs(ours[:, 1] - sign * wanted[:, 2]).max() for sign in (1.0, -1.0))
    else:
        turned = np.abs(ours - wanted).max()
    unit = max(1.0, float(np.abs(at[:3, 3]).max()))
    shifted = np.abs(shape.pose[:3, 3] - at[:3, 3]).max() / unit
    return bool(max(turned, shifted) <= tolerance)


#: Those of what C and the format have for themselves that the tests try.
KEYWORDS = {"base", "origin", "int", "double"}


def _is_identifier(name: str) -> bool:
    return re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) is not None


def structure_faults(comparison: Comparison, *, faithful: bool = True) -> list[str]:
    """What the .mbs must hold besides its equations: names, anchors, quiet joints, gravity;
    the faithful one, every angle and mass of the URDF to its last digit too."""
    result, urdf, mbs = comparison.result, comparison.urdf, comparison.mbs
    faults: list[str] = []
    if tuple(mbs.gravity) != GRAVITY:
        faults.append(f"gravity is {mbs.gravity}")
    faults += [
        f"{name!r} is no identifier"
        for name in [*mbs.bodies, *mbs.joints, mbs.base_name]
        if not _is_identifier(name)
    ]
    faults += [
        f"{joint.name}: stands still, but {joint.symbols} are in the equations"
        for joint in mbs.joints.values()
        if joint.nature == "driven" and joint.symbols != ("q",)
    ]
    faults += [
        f"{joint.name}: starts at {joint.q}"
        for joint in mbs.joints.values()
        if joint.nature != "driven" and joint.q != 0.0
    ]
    for joint in urdf.joints.values():
        names = result.names.joints.get(joint.name, [])
        real = [name for name in names if mbs.joints[name].nature != "driven"]
        usable = _is_identifier(joint.name) and joint.name not in {*KEYWORDS, mbs.base_name}
        if len(real) == 1 and usable and joint.name not in mbs.moving:
            faults.append(f"{joint.name} is called {real[0]}")
        if not faithful:
            continue
        r, p, y = joint.rpy
        wanted = [turn for turn in (("R3", y), ("R2", p), ("R1", r)) if turn[1]]
        found = [(mbs.joints[name].type, mbs.joints[name].q) for name in names[: len(wanted)]]
        if names and found != wanted:
            faults.append(f"{joint.name} is turned by {found}, not {wanted}")
    for link in urdf.inertias:
        frame = result.frames[link]
        body = mbs.bodies["base" if frame.body is None else frame.body]
        own = result.names.bodies.get(link)
        inertia = urdf.inertias[link]
        if faithful and own is None and not urdf.massless(link):
            faults.append(f"{link} has mass, but no body")
        elif (
            faithful and own is not None and body.inertia.mass != (inertia.mass if inertia else 0.0)
        ):
            faults.append(f"{link} has another mass than body {own}, if by a rounding only")
        elif own is not None and (frame.body, frame.joint) != (own, None):
            faults.append(f"{link} is body {own}, but its frame is said to be in {frame.body}")
        elif own is None and frame.joint is None and (frame.body or link != urdf.root):
            at = [p for p in body.points.values() if tuple(p) == tuple(frame.pose.xyz)]
            if not at:
                faults.append(f"{link} is neither body nor anchor point")
    return faults
