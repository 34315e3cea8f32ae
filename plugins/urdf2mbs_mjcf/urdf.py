"""Write a compiled MJCF as URDF 1.2, which has quaternions and capsules.

The zero of each joint is MuJoCo's ``qpos0``; that of a free joint is the world's frame, as for a
URDF whose base floats, and the place of the body is a start position.  A body of MuJoCo may have
several joints, each at a point of its own; links without mass are between them.  The link of a body
has its frame at the last joint::

    MJCF   body A -------------------------> body B  (frame anywhere)
                   joint 1 at p1, joint 2 at p2 of B

    URDF   link A --[joint 1]-- link B_joint 1 --[joint 2]-- link B
                     at p1                         at p2     frame at p2, axes of B
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from urdf2mbs.plugin import HERE, Vec, absolute_path, free_name, spatial, stem
from urdf2mbs_mjcf.frames import Frame, negate
from urdf2mbs_mjcf.losses import MOTION_SENSORS, Losses
from urdf2mbs_mjcf.model import Actuator, Body, Compiled, Geom, Joint

#: The URDF joints of MuJoCo's.  A hinge with limits is revolute.
JOINT_TYPES = {
    "free": "floating",
    "ball": "ball",
    "slide": "prismatic",
    "hinge": "continuous",
}
#: The joints with one coordinate.
SINGLE = ("slide", "hinge")
#: A frame this far from another is another one (m).
TINY = 1e-9
#: Groups of geoms that MuJoCo shows by default.
_SHOWN_GROUPS = 3
_ORIGIN: Vec = HERE.xyz


class UrdfWriter:
    """Writes one robot.

    Args:
        model: What MuJoCo has compiled.
        source: The MJCF; meshes are named relative to its folder.
        losses: Gets what a URDF cannot say.
    """

    def __init__(self, model: Compiled, source: Path, losses: Losses) -> None:
        self.model = model
        self.losses = losses
        self._folder = Path(absolute_path(source)).parent
        self._root = etree.Element("robot", name=model.name or stem(source), version="1.2")
        self._link_names: set[str] = set()
        self._joint_names: set[str] = set()
        self.links = [
            self._claim(self._link_names, body.name or f"body{number}")
            for number, body in enumerate(model.bodies)
        ]
        """The link of each body."""
        self.joints = [
            self._claim(self._joint_names, joint.name or f"joint{number}")
            for number, joint in enumerate(model.joints)
        ]
        """The URDF's name of each joint."""
        self.shifts: list[Vec] = [_ORIGIN] * len(model.bodies)
        """Position of each link's frame in that of its body (m)."""
        self.leaders: dict[int, int] = {}
        """The joint that each joint with ``<mimic>`` follows."""
        self._elements: dict[str, Any] = {}
        self._joint_elements: list[Any] = []

    def write(self) -> bytes:
        """Return the URDF."""
        self._add_link(self.links[0])
        for number in range(1, len(self.model.bodies)):
            self._add_body(number)
        for number, body in enumerate(self.model.bodies[1:], start=1):
            self._add_inertial(number, body)
        for geom in self.model.geoms:
            self._add_geom(geom)
        self._add_sites()
        self._add_followers()
        self._add_motors()
        self._add_start()
        etree.indent(self._root)
        return etree.tostring(self._root, encoding="utf-8")

    def to_link(self, body: int, frame: Frame) -> Frame:
        """Return a frame of a body in the frame of its link."""
        return Frame(negate(self.shifts[body])).compose(frame)

    def list_links(self) -> set[str]:
        """Return the names of all links."""
        return self._link_names

    # --- the tree ---

    def _claim(self, names: set[str], wanted: str) -> str:
        name = free_name(wanted, names)
        names.add(name)
        return name

    def _add_link(self, name: str) -> None:
        self._elements[name] = add(self._root, "link", name=name)

    def _add_joint(self, name: str, kind: str, parent: str, child: str, origin: Frame) -> Any:
        """Add a joint and its child link; return the joint's element."""
        element = add(self._root, "joint", name=name, type=kind)
        add(element, "parent", link=parent)
        add(element, "child", link=child)
        _add_origin(element, origin)
        self._add_link(child)
        return element

    def _add_body(self, number: int) -> None:
        """Add the link of a body, with its joints and the links between them."""
        body = self.model.bodies[number]
        parent, link = self.links[body.parentid], self.links[number]
        origin = self.to_link(body.parentid, Frame(body.pos, body.quat))
        indices = range(body.jntadr, body.jntadr + body.jntnum)
        if not indices:
            name = self._claim(self._joint_names, f"{link}_fixed")
            self._add_joint(name, "fixed", parent, link, origin)
        position = _ORIGIN
        for index in indices:
            joint = self.model.joints[index]
            anchor = _ORIGIN if joint.type == "free" else joint.pos
            step = Frame(negate(position)).compose(Frame(anchor))
            child = link
            if index != indices[-1]:
                child = self._claim(self._link_names, f"{link}_{self.joints[index]}")
            if joint.type == "free":
                origin = Frame()
            kind = JOINT_TYPES[joint.type]
            if joint.type == "hinge" and joint.limited:
                kind = "revolute"
            element = self._add_joint(self.joints[index], kind, parent, child, origin.compose(step))
            self._joint_elements.append(element)
            self._add_laws(index, joint, element)
            parent, origin, position = child, Frame(), anchor
        self.shifts[number] = position
        if max(map(abs, position)) > TINY:
            kind = "links with their frame at the last joint, not at the frame of MJCF's body"
            self.losses.add("mjcf-frame", kind, link)

    def _add_laws(self, index: int, joint: Joint, element: Any) -> None:
        """Add axis, limits, damping, friction and spring of a joint."""
        dof = self.model.dofs[joint.dofadr]
        if joint.type not in SINGLE:
            kind = f"limits, springs, damping, friction or armature of {joint.type} joints"
            if joint.limited or joint.stiffness or dof.damping or dof.frictionloss or dof.armature:
                self.losses.add("mjcf-limit", kind, self.joints[index])
            return
        add(element, "axis", xyz=text(*joint.axis))
        zero, effort = self.model.qpos0[joint.qposadr], self._find_effort(index, joint)
        if joint.limited or effort is not None:
            limit = add(element, "limit")
            if joint.limited:
                lower, upper = joint.range
                limit.attrib.update({"lower": text(lower - zero), "upper": text(upper - zero)})
            if effort is not None:
                limit.set("effort", text(effort))
        if dof.damping or dof.frictionloss:
            add(element, "dynamics", damping=text(dof.damping), friction=text(dof.frictionloss))
        if joint.stiffness:
            rest = self.model.qpos_spring[joint.qposadr] - zero
            spring = add(self._root, "gazebo", reference=self.joints[index])
            add(spring, "springStiffness", text(joint.stiffness))
            add(spring, "springReference", text(rest))

    def _add_inertial(self, number: int, body: Body) -> None:
        """Add mass and inertia, which MuJoCo has about the principal axes."""
        if body.mass == 0.0 and not any(body.inertia):
            return
        inertial = add(self._elements[self.links[number]], "inertial")
        _add_origin(inertial, self.to_link(number, Frame(body.ipos, body.iquat)))
        add(inertial, "mass", value=text(body.mass))
        x, y, z = map(text, body.inertia)
        add(inertial, "inertia", ixx=x, ixy="0", ixz="0", iyy=y, iyz="0", izz=z)

    # --- shapes and frames ---

    def _add_geom(self, geom: Geom) -> None:
        """Add a shape that is seen, collides, or both."""
        roles = ["visual"] if geom.group < _SHOWN_GROUPS else []
        roles += ["collision"] if geom.contype or geom.conaffinity else []
        shape = self._make_shape(geom) if roles else None
        if shape is None:
            if roles and geom.bodyid:  # the ground is no part of a robot
                kind = f"geoms that are a {geom.type}"
                self.losses.add("mjcf-shape", kind, geom.name or self.links[geom.bodyid])
            return
        frame, tag, sizes = shape
        for role in roles:
            element = add(self._elements[self.links[geom.bodyid]], role)
            _add_origin(element, self.to_link(geom.bodyid, frame))
            add(add(element, "geometry"), tag, **sizes)
            if role == "visual":
                rgba = geom.rgba
                if geom.matid >= 0:
                    rgba = self.model.materials[geom.matid].rgba
                add(add(element, "material", name=""), "color", rgba=text(*rgba))

    def _make_shape(self, geom: Geom) -> tuple[Frame, str, dict[str, str]] | None:
        """Return the frame of a shape in its body, its tag and sizes; None if a URDF has none."""
        frame, size = Frame(geom.pos, geom.quat), geom.size
        if geom.type == "box":
            return frame, "box", {"size": text(*(2.0 * half for half in size))}
        if geom.type == "sphere":
            return frame, "sphere", {"radius": text(size[0])}
        if geom.type in ("cylinder", "capsule"):
            return frame, geom.type, {"radius": text(size[0]), "length": text(2.0 * size[1])}
        if geom.type != "mesh":
            return None
        mesh = self.model.meshes[geom.dataid]
        if not mesh.file or mesh.file.lower().endswith(".msh"):
            return None
        # a vertex v of the file is scaled R^T (v - p), of the frame (p, R) that the MJCF refers to;
        # then MuJoCo has moved it to the centre of the mesh
        x, y, z = mesh.scale
        if not x == y == z and any(mesh.refquat[1:]):
            return None
        moved = Frame(mesh.pos, mesh.quat).inverse()
        offset = (x * mesh.refpos[0], y * mesh.refpos[1], z * mesh.refpos[2])
        meant = Frame(offset, mesh.refquat).inverse()
        name = os.path.relpath(mesh.file, self._folder)
        sizes = {"filename": Path(name).as_posix(), "scale": text(*mesh.scale)}
        return frame.compose(moved.compose(meant)), "mesh", sizes

    def _add_sites(self) -> None:
        """Add a link without mass for each site, with the sensors of motion on it."""
        for number, site in enumerate(self.model.sites):
            link = self._claim(self._link_names, site.name or f"site{number}")
            name = self._claim(self._joint_names, f"{link}_fixed")
            origin = self.to_link(site.bodyid, Frame(site.pos, site.quat))
            self._add_joint(name, "fixed", self.links[site.bodyid], link, origin)
            if any(
                sensor.type in MOTION_SENSORS and (sensor.objtype, sensor.objid) == ("site", number)
                for sensor in self.model.sensors
            ):
                extension = add(self._root, "gazebo", reference=link)
                add(extension, "sensor", name=f"{link}_imu", type="imu")

    # --- what couples and drives joints ---

    def _add_followers(self) -> None:
        """Add ``<mimic>`` for equalities ``q1 = a + b q2``, both from ``qpos0``."""
        for equality in self.model.equalities:
            if equality.type != "joint" or not equality.active0:
                continue
            follower, leader = equality.obj1id, equality.obj2id
            if leader < 0 or any(equality.data[2:5]) or self._leads(follower, leader):
                continue
            self.leaders[follower] = leader
            offset, multiplier = equality.data[:2]
            mimic = {"multiplier": text(multiplier), "offset": text(offset)}
            add(self._joint_elements[follower], "mimic", joint=self.joints[leader], **mimic)

    def _leads(self, follower: int, leader: int) -> bool:
        """Return True if a joint follows already, or leads its leader."""
        joint: int | None = leader
        while joint is not None and joint != follower:
            joint = self.leaders.get(joint)
        return joint == follower or follower in self.leaders

    def list_motors(self) -> Iterator[tuple[Actuator, int, float]]:
        """Yield the actuators of hinges and slides, each with its joint and gear ratio."""
        for actuator in self.model.actuators:
            joint = actuator.trnid[0]
            is_of_joint = actuator.trntype in ("joint", "jointinparent")
            if is_of_joint and self.model.joints[joint].type in SINGLE:
                yield actuator, joint, actuator.gear[0]

    def _find_effort(self, index: int, joint: Joint) -> float | None:
        """Return the largest force of a joint's motors (N m or N); None if it is not limited."""
        if joint.actfrclimited:
            return max(map(abs, joint.actfrcrange))
        efforts: list[float] = []
        for actuator, motor_joint, gear in self.list_motors():
            if motor_joint != index:
                continue
            if actuator.forcelimited:
                efforts.append(abs(gear) * max(map(abs, actuator.forcerange)))
            elif actuator.ctrllimited and _is_motor(actuator):
                gain = abs(gear * actuator.gainprm[0])
                efforts.append(gain * max(map(abs, actuator.ctrlrange)))
            else:
                return None
        return sum(efforts) if efforts else None

    def _add_motors(self) -> None:
        """Add a transmission for each joint with a motor, and the armature of all joints."""
        motor_joints = {joint for _, joint, _ in self.list_motors()}
        driven = {id(actuator) for actuator, _, _ in self.list_motors()}
        for actuator in self.model.actuators:
            if id(actuator) not in driven:
                kind = "actuators of tendons, sites, bodies, balls"
                self.losses.add("mjcf-actuator", kind, actuator.name)
        for index in sorted(motor_joints):
            name = f"{self.joints[index]}_motor"
            transmission = add(self._root, "transmission", name=name)
            add(transmission, "type", "transmission_interface/SimpleTransmission")
            add(transmission, "joint", name=self.joints[index])
            add(transmission, "actuator", name=name)
        rotors = None
        for index, joint in enumerate(self.model.joints):
            armature = self.model.dofs[joint.dofadr].armature
            if armature and joint.type in SINGLE:
                # within <ros2_control>, where it is the inertia of a rotor, and no motor
                if rotors is None:
                    rotors = add(self._root, "ros2_control", name="armature", type="system")
                name = f"{self.joints[index]}_armature"
                transmission = add(rotors, "transmission", name=name)
                add(transmission, "joint", name=self.joints[index])
                add(add(transmission, "actuator", name=name), "motorInertia", text(armature))

    def _add_start(self) -> None:
        """Add the position of the keyframe ``home``, or of the first, as start positions."""
        keys = self.model.keys
        key = next((key for key in keys if key.name == "home"), keys[0] if keys else None)
        qpos = self.model.qpos0 if key is None else key.qpos
        starts = [
            start
            for joint, name in zip(self.model.joints, self.joints, strict=True)
            for start in self._list_start(joint, name, qpos)
        ]
        if any(value for _, value in starts):
            control = add(self._root, "ros2_control", name="start", type="system")
            for coordinate, value in starts:
                element = add(control, "joint", name=coordinate)
                state = add(element, "state_interface", name="position")
                add(state, "param", text(value), name="initial_value")

    def _list_start(
        self, joint: Joint, name: str, qpos: list[float]
    ) -> Iterator[tuple[str, float]]:
        """Yield the coordinates of a joint in a keyframe, from its zero."""
        zero = self.model.qpos0
        address = joint.qposadr
        if joint.type in SINGLE:
            yield name, qpos[address] - zero[address]
            return
        moved = _read_frame(joint, qpos)
        if joint.type == "free":
            for number, shift in enumerate(moved.xyz, start=1):
                yield f"{name}_T{number}", shift
        for number, angle in enumerate(spatial.to_xyz_angles(moved.rot), start=1):
            yield f"{name}_R{number}", angle


def _is_motor(actuator: Actuator) -> bool:
    """Return True if the force of an actuator is its control times its gain."""
    return (actuator.gaintype, actuator.biastype) == ("fixed", "none")


def _read_frame(joint: Joint, qpos: list[float]) -> Frame:
    """Return the frame of a free joint, or the turn of a ball joint."""
    address = joint.qposadr
    xyz = _ORIGIN
    if joint.type == "free":
        xyz = (qpos[address], qpos[address + 1], qpos[address + 2])
        address += 3
    w, x, y, z = qpos[address : address + 4]
    return Frame(xyz, (w, x, y, z))


def _add_origin(parent: Any, frame: Frame) -> None:
    w, x, y, z = frame.quat
    add(parent, "origin", xyz=text(*frame.xyz), quat_xyzw=text(x, y, z, w))


def text(*numbers: float) -> str:
    """Return numbers as URDF has them, without loss."""
    return " ".join(repr(float(number)) for number in numbers)


def add(parent: Any, tag: str, content: str | None = None, /, **attributes: str) -> Any:
    """Add an element, and return it."""
    element = etree.SubElement(parent, tag, attributes)
    element.text = content
    return element
