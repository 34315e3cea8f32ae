"""What Pinocchio computes from a URDF, and from an .mbs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from lxml import etree

from support.oracle.generated import Data, PythonEquations, Sensor, error
from support.oracle.multibody import Array, Inertia, rotation, symmetric
from support.oracle.urdf import FLOATING_BASE, GRAVITY, Urdf, coordinate_names, motions_of

if TYPE_CHECKING:
    from urdf2mbs.mbs.model import Mbs

pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")

_LINK = "link:"


class Pinocchio:
    """A URDF as pinocchio reads it.  The coordinates of joints are called as in ``Reference``.

    Pinocchio gets the links' inertias and the joints only: what is drawn, limited, damped or
    mimicked does not change these equations (and a missing limit or an unreadable mesh
    would make it refuse). Planar joints, whose axis it ignores, and floating ones, whose
    coordinates are others than an .mbs's, it gets as three and six joints with massless links
    between. Numbers are trimmed, since urdfdom drops an inertial that has a line break after
    a number.
    """

    def __init__(
        self,
        urdf: Urdf,
        text: bytes,
        *,
        floating: bool,
        frozen: Sequence[str] = (),
        planar: Mapping[str, Array] | None = None,
    ) -> None:
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
        self._model, self._data = model, model.createData()
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
            motions = motions_of(joint, planar)
            if element.find("axis") is not None:
                # pinocchio squares it: what is very long or short would over- or underflow
                element.find("axis").set("xyz", _spelt(joint.axis))
            self.coordinates[joint.name] = names = coordinate_names(joint.name, motions)
            if len(motions) > 1:
                root.remove(element)
                _series(root, element, names, motions)
        for element in root.findall("joint"):
            etree.SubElement(element, "limit", lower="-9", upper="9", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")

    def _configuration(self, q: Array | None) -> Array:
        """(nq,): with cos and sin for continuous joints."""
        values = np.zeros(self._model.nv) if q is None else q
        configuration = np.zeros(self._model.nq)
        for joint in list(self._model.joints)[1:]:
            at = values[joint.idx_v : joint.idx_v + joint.nv]
            if joint.nq == 2 and joint.nv == 1:
                at = np.array([np.cos(at[0]), np.sin(at[0])])
            configuration[joint.idx_q : joint.idx_q + joint.nq] = at
        return configuration

    def poses(self, q: Array | None = None) -> dict[str, Array]:
        """Every link's frame, 4x4."""
        pin.framesForwardKinematics(self._model, self._data, self._configuration(q))
        return {
            link: np.array(self._data.oMf[self._frame[link]].homogeneous) for link in self._links
        }

    def groups(self) -> dict[str | None, tuple[str, Inertia]]:
        """For each moving joint (None: the ground), the matter that it moves and that is rigid, as
        one body, in the frame of the link that is named first."""
        model = self._model
        zero = self.poses()
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

    def dynamics(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array, Array]:
        """Mass matrix, forces that hold it against gravity, and forces of this motion."""
        model, data, at = self._model, self._data, self._configuration(q)
        upper = np.triu(pin.crba(model, data, at))
        holding = np.array(pin.computeGeneralizedGravity(model, data, at))
        forces = np.array(pin.rnea(model, data, at, qd, qdd))
        return upper + np.triu(upper, 1).T, holding, forces


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


def to_pinocchio(mbs: Mbs, *, held: bool = True) -> Any:
    """An .mbs as a ``pinocchio.Model``.

    Joints keep their names, each of one degree of freedom (PX PY PZ RX RY RZ), and stand depth
    first: with any other order Pinocchio's ``crba`` is wrong without a word.  Driven joints are
    ``held`` at their initial positions, or are joints as all others.  Each body is a frame of its
    name, and each of its points is BODY/POINT.  Units are m, kg, rad.
    """
    model = pin.Model()
    model.name = mbs.name
    model.gravity = pin.Motion(np.array(mbs.base.gravity), np.zeros(3))
    # each body: the Pinocchio joint that it moves with, and its pose in that joint's frame
    at: dict[str | None, tuple[int, Any]] = {None: (0, pin.SE3.Identity())}
    points = mbs.points()
    for body in mbs.depth_first():
        joint, pose = at[body.parent]
        if body.point is not None:
            place = np.array(points[body.parent, body.point].coordinates)
            pose = pose * pin.SE3(np.eye(3), place)
        for own in body.joints:
            turns, axis = own.type[0] == "R", int(own.type[1]) - 1
            if own.nature == "driven" and held:
                turn = rotation(np.eye(3)[axis], (own.q or 0.0) * turns)
                pose = pose * pin.SE3(turn, (own.q or 0.0) * (not turns) * np.eye(3)[axis])
            else:
                kind = f"JointModel{'R' if turns else 'P'}{'XYZ'[axis]}"
                joint = model.addJoint(joint, getattr(pin, kind)(), pose, own.name)
                pose = pin.SE3.Identity()
        at[body.name] = (joint, pose)
        inertia = pin.Inertia.Zero()  # its constructor refuses what no real body has
        inertia.mass = body.mass or 0.0
        inertia.lever = np.array(body.com or (0.0,) * 3)
        inertia.inertia = symmetric(body.inertia or (0.0,) * 6)
        model.appendBodyToJoint(joint, inertia, pose)
        model.addFrame(pin.Frame(body.name, joint, 0, pose, pin.FrameType.BODY))
        for point in body.points:
            there = pose * pin.SE3(np.eye(3), np.array(point.coordinates))
            name = f"{body.name}/{point.name}"
            model.addFrame(pin.Frame(name, joint, 0, there, pin.FrameType.OP_FRAME))
    return model


#: Between generated equations and Pinocchio, relative.
TOLERANCE = 1e-12


class Truth:
    """An .mbs in Pinocchio: one joint for each of the file's, by their numbers."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.model = model = to_pinocchio(mbs, held=False)
        self.ids = [0, *(model.getJointId(name) for name in mbs.joints())]
        #: The Pinocchio joint that moves each body.
        self.joint_of: dict[str | None, int] = {None: 0}
        for body in mbs.bodies:
            self.joint_of[body.name] = model.getJointId(body.joints[-1].name)
        self.points = {key: np.array(p.coordinates) for key, p in mbs.points().items()}
        self.data = model.createData()
        self.column = [model.joints[i].idx_v for i in self.ids[1:]]

    def vector(self, values: Array) -> Array:
        """By joint number, in pinocchio's order."""
        out = np.zeros(self.model.nv)
        out[self.column] = values[1:]
        return out

    def matrix(self, s: Data) -> Array:
        m = np.reshape(pin.crba(self.model, self.data, self.vector(s.q)), (self.model.nv, -1))
        m = np.triu(m) + np.triu(m, 1).T
        return np.asarray(m[np.ix_(self.column, self.column)])

    def forces(self, s: Data, *, accelerated: bool) -> Array:
        """Inverse dynamics with s.frc and s.trq, which act at the centres of mass."""
        loads = pin.StdVec_Force()
        for _ in range(self.model.njoints):
            loads.append(pin.Force.Zero())
        for body in self.mbs.bodies:
            at, number = self.joint_of[body.name], self.number(body.name)
            force, com = s.frc[1:, number], np.array(body.com or (0.0, 0.0, 0.0))
            loads[at] = pin.Force(force, s.trq[1:, number] + np.cross(com, force))
        qdd = self.vector(s.qdd) if accelerated else np.zeros(self.model.nv)
        tau = pin.rnea(self.model, self.data, self.vector(s.q), self.vector(s.qd), qdd, loads)
        return np.asarray(tau[self.column])

    def check_forces(self, eq: PythonEquations, s: Data) -> None:
        """Hold generated equations against ``matrix`` and ``forces``."""
        m, c = eq.dirdyna(s)
        assert error(m, self.matrix(s)) <= TOLERANCE
        assert error(c, self.forces(s, accelerated=False)) <= TOLERANCE
        assert error(eq.invdyna(s), self.forces(s, accelerated=True)) <= TOLERANCE

    def check_sensors(self, eq: PythonEquations, s: Data) -> None:
        """Hold what is measured behind each joint, and at each sensor, against ``sensor``."""
        sensors = [
            (self.number(body.name), np.array(point.coordinates))
            for body in self.mbs.bodies
            for point in body.points
            if point.sensor
        ]
        places = {
            "gensensor": [(k, np.zeros(3)) for k in range(1, s.njoint + 1)],
            "sensor": sensors,
        }
        for kind, number, (joint, at) in [
            (kind, *one) for kind, own in places.items() for one in enumerate(own, start=1)
        ]:
            found, wanted = eq.sensor(s, number, kind), self.sensor(s, joint, at)
            for name, value in vars(wanted).items():
                assert error(getattr(found, name), value) <= TOLERANCE, (kind, name)

    def number(self, body: str) -> int:
        """The number of a body's last joint."""
        return self.ids.index(self.joint_of[body])

    def sensor(self, s: Data, joint: int, at: Array) -> Sensor:
        """A point in the frame behind a joint."""
        model, data, i = self.model, self.data, self.ids[joint]
        q, qd, qdd = self.vector(s.q), self.vector(s.qd), self.vector(s.qdd)
        pin.forwardKinematics(model, data, q, qd, qdd)
        out = Sensor(s.njoint)
        pose = data.oMi[i] * pin.SE3(np.eye(3), at)
        here = pin.SE3(np.eye(3), at)
        v, a = here.actInv(data.v[i]), here.actInv(data.a[i])
        turn = pose.rotation
        out.P[1:], out.R[1:, 1:] = pose.translation, turn.T
        out.V[1:], out.OM[1:] = turn @ v.linear, turn @ v.angular
        out.A[1:] = turn @ (a.linear + np.cross(v.angular, v.linear))
        out.OMP[1:] = turn @ a.angular
        jacobian = pin.computeJointJacobian(model, data, q, i)
        jacobian = (
            pin.SE3(turn, np.zeros(3)).toActionMatrix() @ here.toActionMatrixInverse() @ jacobian
        )
        # of a model with one joint, pinocchio gives a vector
        out.J[1:, 1:] = np.reshape(jacobian, (6, -1))[:, self.column]
        return out
