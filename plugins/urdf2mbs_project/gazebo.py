"""The sensors, joints and numbers in ``<gazebo>`` and ``<sensor>``, and Bullet's ``<contact>``.

SDF says where a sensor or a joint inside ``<gazebo>`` is ("Pose Frame Semantics" of sdformat.org,
versions 1.4 to 1.12):

* ``<pose>`` is ``x y z roll pitch yaw`` in m and rad; degrees and quaternions are not read;
* a pose is relative to ``relative_to`` (``frame`` until SDF 1.6), with all joints at zero; else a
  sensor's pose is relative to its link, and a joint's pose to its child link;
* an axis is in the joint's frame, or in ``expressed_in``; ``use_parent_model_frame`` of SDF 1.6
  is not read.

The name of a link is its frame, the name of a joint the frame of its child link, and
``__model__`` the frame of the root link.  A warning names an element that cannot be read.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import (
    HERE,
    OFF,
    ON,
    ZERO,
    ClosingJoint,
    ConversionError,
    Dynamics,
    Extension,
    Pose,
    compose,
    from_rpy,
    inverse,
    nearest,
    quote,
    rotate,
    some,
    transpose,
)
from urdf2mbs.plugin import UrdfSensor as Sensor
from urdf2mbs_project.actuation import ActuationReader
from urdf2mbs_project.followers import FollowerReader, get_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from urdf2mbs.plugin import Reading, Robot, Vec

#: What ``<gazebo>`` says of a link or a joint by one number or truth value.
NUMBERS = (
    "mu1",
    "kp",
    "kd",
    "springStiffness",
    "springReference",
    "turnGravityOff",
    "gravity",
    "static",
)
#: Those that are true or false.
SWITCHES = ("turnGravityOff", "gravity", "static")
#: The other children of ``<gazebo>`` that are read.
READ = frozenset((*NUMBERS, "sensor", "joint", "plugin"))
#: Children of ``<gazebo>`` for appearance, for collisions, and for the solver of Gazebo.
HARMLESS = frozenset(
    [
        "material",
        "visual",
        "collision",
        "selfCollide",
        "self_collide",
        "provideFeedback",
        "implicitSpringDamper",
        "disableFixedJointLumping",
        "preserveFixedJoint",
        "laserRetro",
        "laser_retro",
        "maxVel",
        "minDepth",
        "maxContacts",
        "mu2",
        "fdir1",
        "fudgeFactor",
        "cfm",
        "erp",
        "stopCfm",
        "stopErp",
        "stop_cfm",
        "stop_erp",
        "stopKp",
        "stopKd",
        "projector",
        "gripper",
        "canonicalBody",
        "enable_wind",
        "allow_auto_disable",
        "audio",
        "light",
        "cfmDamping",
    ]
)
#: Attributes of MuJoCo's ``<compiler>`` that change masses and inertias.
COMPILER_OF_MASSES = (
    "settotalmass",
    "balanceinertia",
    "boundmass",
    "boundinertia",
    "inertiafromgeom",
)
HARMLESS_OF_MUJOCO = frozenset(["compiler", "size", "visual", "asset", "statistic"])
#: Children of Bullet's ``<contact>`` that are read, or that are for its solver.
OF_CONTACT = frozenset(["lateral_friction", "contact_cfm", "contact_erp", "friction_anchor"])
#: Children of SDF's ``<joint>`` and its ``<axis>`` that are read, or that are for the solver.
OF_JOINT = frozenset(
    ["parent", "child", "pose", "axis", "axis2", "sensor", "physics", "provideFeedback"]
)
OF_AXIS = frozenset(["xyz", "use_parent_model_frame", "initial_position"])
#: Plugins that couple joints as ``<mimic>`` does, and others that change the mechanics.
MIMIC = re.compile(r"mimic", re.IGNORECASE)
MECHANICAL = re.compile(
    r"underactuated|lift_?-?drag|buoyan|hydrodynamic|thrust|propeller|spring|damper|gearbox"
    r"|differential(?!_?-?drive)|harness|tendon|freeze|detachable|motor_?model|underwater|uuv"
    r"|gravity|wind|wheel_?-?slip|link_?attach|fixed_?base|disable_?link|closed_?loop|vacuum",
    re.IGNORECASE,
)
#: What of them is a number of the joint's dynamics.
SPRING = {"springStiffness": "spring_stiffness", "springReference": "spring_reference"}
#: Sensors of motion, by their type in URDF and in SDF.
MOTION = ("imu", "accelerometer", "gyroscope")
FORCE_TORQUE = "force_torque"
#: The frame of an SDF model.
MODEL = "__model__"


class Extensions:
    """Reads the elements of other programs, once the links and joints of the robot are known."""

    def __init__(self, reading: Reading, robot: Robot) -> None:
        self.reading = reading
        self.robot = robot
        self.actuation = ActuationReader(reading, robot)
        self.followers = FollowerReader(reading, robot)

    @cached_property
    def rigid_with_root(self) -> set[str]:
        """The root link, and the links that are fixed to it."""
        rigid = {self.robot.root()}
        for joint in self.robot.depth_first():
            if joint.type == "fixed" and joint.parent in rigid:
                rigid.add(joint.child)
        return rigid

    @cached_property
    def frames(self) -> dict[str, Pose]:
        """The frames that a pose may name, seen from the root link, all joints at zero."""
        links = self.robot.poses()
        joints = {joint.name: links[joint.child] for joint in self.robot.joints.values()}
        return {**joints, **links, MODEL: HERE}

    def read(self, element: Any, extension: Extension) -> None:
        """Read an element of another program, and warn of mechanics in it that is not read."""
        tag, self.reading.owner = extension.tag, ("robot", "")
        if tag == "contact":
            self.read_contact(element, extension)
        if tag in ("gazebo", "sensor"):
            for sensor in [element] if tag == "sensor" else element.iterchildren("sensor"):
                if sensor.get("type") in (*MOTION, FORCE_TORQUE):
                    self.read_sensor(sensor, extension)
        if tag == "gazebo":
            self.reading.owner = self.find_owner(extension.reference)
            unread = [name for name in element.attrib if name not in ("reference", "name")]
            if unread:
                message = f"the attributes {some(unread)} of <gazebo> are not read"
                self.reading.warn("mechanics-unread", message, element.sourceline)
            for plugin in element.iterchildren("plugin"):
                self.read_plugin(plugin)
            self.reading.owner = ("robot", "")
            for joint in element.iterchildren("joint"):
                self.read_closing_joint(joint, extension)
            self.read_numbers(element, extension)
            self.reading.owner = self.find_owner(extension.reference)
            self.report_unread(element)
        elif tag == "mujoco":
            self.report_unread_of_mujoco(element)
        elif tag in ("transmission", "ros2_control"):
            self.actuation.read(element, extension)
            if tag == "ros2_control":
                self.followers.read_ros2_control(element)
        self.reading.owner = ("robot", "")

    def find_owner(self, reference: str | None) -> tuple[str, str]:
        """Return the kind and name of the link or joint that a ``<gazebo>`` is about."""
        if reference in self.robot.links:
            return "link", reference
        return ("joint", reference) if reference in self.robot.joints else ("robot", "")

    def read_contact(self, element: Any, extension: Extension) -> None:
        """Add the friction of Bullet's ``<contact>`` of a link."""
        self.reading.owner = ("link", extension.reference or "")
        for friction in element.iterchildren("lateral_friction"):
            number = self.number(friction, "<lateral_friction>", friction.get("value"))
            if number is not None:
                extension.numbers["mu1"] = number
                self.warn_of_negative(friction, extension.reference, number)
        unread = [child for child in element if child.tag not in OF_CONTACT]
        self.reading.unknown_children("contact", unread, ())

    def read_plugin(self, element: Any) -> None:
        """Read a plugin that couples joints, and warn of others that change the mechanics."""
        names = [element.get(key, "").rpartition("/")[2] for key in ("filename", "name")]
        name = next(filter(None, names), "")
        joins = any(end.getparent().find("child") is not None for end in element.iter("parent"))
        joins = joins or element.find(".//joint/parent") is not None
        if element.find("mimicJoint") is not None or MIMIC.search(name):
            self.followers.read_plugin(element)
        elif joins or any(map(MECHANICAL.search, names)):
            message = f"the plugin '{name}' in <gazebo> changes the mechanics, and is not read"
            self.reading.warn("mechanics-unread", message, element.sourceline)

    def report_unread_of_mujoco(self, element: Any) -> None:
        """Warn of what a ``<mujoco>`` says of mechanics: options, equalities, balanced masses."""
        unread = [child for child in element if child.tag not in HARMLESS_OF_MUJOCO]
        self.reading.unknown_children("mujoco", unread, ())
        for compiler in element.iterchildren("compiler"):
            names = [name for name in COMPILER_OF_MASSES if compiler.get(name, "false") != "false"]
            if names:
                message = f"<compiler> of <mujoco> changes masses by {some(names)}: it is not read"
                self.reading.warn("mechanics-unread", message, compiler.sourceline)

    def report_unread(self, element: Any) -> None:
        """Warn of what a ``<gazebo>`` says of mechanics, and nothing reads."""
        unread = []
        for child in element:
            if child.tag == "collision" and child.find(".//friction") is not None:
                message = "the friction of <collision> in <gazebo> is not read; <mu1> is"
                self.reading.warn("mechanics-unread", message, child.sourceline)
            elif child.tag not in READ and child.tag not in HARMLESS:
                unread.append(child)
        self.reading.unknown_children("gazebo", unread, NUMBERS)

    def read_numbers(self, element: Any, extension: Extension) -> None:
        """Add what a ``<gazebo>`` says in elements of one number or truth value."""
        for child in element.iterchildren(*NUMBERS):
            written = child.get("value") or get_text(child)
            is_true = written.lower() in ON
            if child.tag in SWITCHES and written.lower() not in ON | OFF:
                message = f"<{child.tag}> of <gazebo> is {quote(written)}; expected true or false"
                hint = "'gravity' of the config has the vector" if child.tag == "gravity" else None
                place, line = self.find_owner(extension.reference), child.sourceline
                self.reading.warn("mechanics-unread", message, line, owner=place, hint=hint)
            elif child.tag == "gravity":
                if not is_true:
                    extension.numbers["turnGravityOff"] = 1.0
            elif child.tag == "turnGravityOff":
                extension.numbers[child.tag] = float(is_true)
            elif child.tag == "static":
                if is_true and extension.reference:
                    message = "<static> of <gazebo> is of the whole robot: one link has none"
                    place, line = self.find_owner(extension.reference), child.sourceline
                    self.reading.warn("mechanics-unread", message, line, owner=place)
                elif is_true:
                    self.robot.fixed_by = "<static> of <gazebo>"
            else:
                number = self.number(child, f"<{child.tag}> of <gazebo>", written)
                if number is not None:
                    extension.numbers[child.tag] = number
                    self.warn_of_negative(child, extension.reference, number)
        owner = extension.reference or ""
        if owner and self.find_owner(owner)[1] != owner and extension.numbers:
            message = "what <gazebo> says of a link or joint that does not exist has no effect"
            hint = nearest(owner, [*self.robot.links, *self.robot.joints])
            place = ("gazebo", owner)
            self.reading.warn("mechanics-unread", message, extension.line, owner=place, hint=hint)
            return
        link, joint = self.robot.links.get(owner), self.robot.joints.get(owner)
        for name, field in SPRING.items():
            if joint is not None and name in extension.numbers:
                joint.dynamics = joint.dynamics or Dynamics()
                setattr(joint.dynamics, field, extension.numbers[name])
        unread = []
        if not owner:
            unread.append(("turnGravityOff", "robot", "'gravity' of the config is for all links"))
        elif link is not None and link.inertial is not None and link.inertial.mass != 0.0:
            unread.append(("turnGravityOff", "link", "the link has its weight here"))
        if joint is None or joint.type not in ("revolute", "continuous", "prismatic"):
            unread.append(("springStiffness", "joint", "the joint has no spring here"))
        for name, kind, why in unread:
            if extension.numbers.get(name):
                tag = name if element.find(name) is not None else "gravity"
                what = f"<{tag}> of <gazebo> has no effect, as {why}"
                self.reading.warn("mechanics-unread", what, extension.line, owner=(kind, owner))

    def warn_of_negative(self, element: Any, reference: str | None, number: float) -> None:
        """Warn of a number of friction or stiffness below zero."""
        if number < 0.0 and element.tag != "springReference":
            parent = element.getparent().tag
            message = f"<{element.tag}> of <{parent}> is below zero; expected zero or more"
            owner, line = self.find_owner(reference), element.sourceline
            self.reading.warn("number-negative", message, line, owner=owner, detail=f"{number!r}")

    def number(self, element: Any, what: str, written: str | None = None) -> float | None:
        """Return the number in an element; None, after a warning, where there is none."""
        try:
            return self.reading.number(element, "the text", written or get_text(element))
        except ConversionError as error:
            self.reading.warn_of_left_out(element, what, error)
            return None

    def read_sensor(self, element: Any, extension: Extension) -> None:
        """Add a ``<sensor>`` of motion, or of force and torque, to its extension."""
        kind, parent = element.get("type"), element.find("parent")
        on = extension.reference
        if parent is not None:
            on = parent.get("joint" if kind == FORCE_TORQUE else "link")
        name = element.get("name") or ""
        if not name:
            name = f"{on}_{kind}"
            what = f"a sensor has no name, and is called '{name}'"
            self.reading.warn("sensor-renamed", what, element.sourceline)
        with self.left_out("sensor", name):
            sensor = Sensor(name, kind, on or "", line=element.sourceline)
            origin = element.find("origin")
            if kind == FORCE_TORQUE:  # it measures where its joint is
                self.check(element, "on joint", sensor.on, self.robot.joints)
            else:
                self.check(element, "on link", sensor.on, self.robot.links)
                if origin is not None:
                    sensor.pose = self.reading.origin(origin).pose
                else:
                    sensor.pose = self.read_pose(element.find("pose"), sensor.on)
            extension.sensors.append(sensor)

    def read_closing_joint(self, element: Any, extension: Extension) -> None:
        """Add an SDF ``<joint>``, which closes a loop of the robot, or welds it to the world."""
        parent, child = (
            "" if end is None else get_text(end) or end.get("link", "")
            for end in (element.find("parent"), element.find("child"))
        )
        name, kind = element.get("name") or "", element.get("type") or ""
        ends = {end.rpartition("::")[2] for end in (parent, child)}  # without the model
        is_weld = kind.lower() == "fixed" and "world" in ends - self.robot.links.keys()
        if is_weld and not self.rigid_with_root.isdisjoint(ends):
            self.robot.fixed_by = f"joint '{name}' of <gazebo>"
            return
        self.reading.owner = ("joint", name)
        unread = [part for part in element if part.tag not in OF_JOINT]
        self.reading.unknown_children("joint", unread, ())
        for axis in element.iterchildren("axis", "axis2"):
            unread = [part for part in axis if part.tag not in OF_AXIS]
            self.reading.unknown_children("axis", unread, ())
        with self.left_out("loop", name):
            of_sdf = {link.get("name") for link in element.iterfind("../../gazebo/link")}
            for link in (parent, child):
                if link in of_sdf - self.robot.links.keys():
                    what = "it is on a link inside <gazebo>; no such link is read, nor its mass"
                    self.reading.fail("link-unknown", what, element)
                self.check(element, "on link", link, self.robot.links)
            pose = self.read_pose(element.find("pose"), child)
            axes = [
                self.read_axis(axis, pose, child)
                for tag in ("axis", "axis2")
                if (axis := element.find(tag)) is not None
            ]
            extension.joints.append(
                ClosingJoint(name, kind, parent, child, pose, axes, element.sourceline)
            )

    def read_pose(self, element: Any, link: str) -> Pose:
        """``<pose>``, seen from a link."""
        if element is None:
            return HERE
        degrees, form = element.get("degrees", "false"), element.get("rotation_format", "euler_rpy")
        if degrees not in ("false", "0") or form != "euler_rpy":
            what = "<pose> in degrees or with a quaternion is not read"
            hint = "write x y z roll pitch yaw, in m and rad"
            self.reading.fail("number-invalid", what, element, hint)
        words = get_text(element) or "0 0 0 0 0 0"
        x, y, z, roll, pitch, yaw = self.reading.numbers(element, "the text", words, 6)
        pose = Pose((x, y, z), from_rpy((roll, pitch, yaw)))
        frame = element.get("relative_to") or element.get("frame") or link
        self.check(element, "seen from frame", frame, self.frames)
        if frame == link:
            return pose
        return compose(compose(inverse(self.frames[link]), self.frames[frame]), pose)

    def read_axis(self, element: Any, pose: Pose, link: str) -> Vec:
        """``<axis>``, as a direction in a link's frame; ``pose`` is that of its joint."""
        if get_text(element.find("use_parent_model_frame")).lower() in ("true", "1"):
            what, hint = "<use_parent_model_frame> is not read", f'write expressed_in="{MODEL}"'
            self.reading.fail("number-invalid", what, element, hint)
        xyz = element.find("xyz")
        if xyz is None:
            return rotate(pose.rot, (0.0, 0.0, 1.0))
        x, y, z = self.reading.numbers(xyz, "the text", get_text(xyz), 3)
        if (x, y, z) == ZERO:
            hint = "give a direction, such as 0 0 1"
            self.reading.fail("number-invalid", "<axis> is zero", xyz, hint)
        frame = xyz.get("expressed_in")
        if frame is None:
            return rotate(pose.rot, (x, y, z))
        self.check(xyz, "seen from frame", frame, self.frames)
        return rotate(transpose(self.frames[link].rot), rotate(self.frames[frame].rot, (x, y, z)))

    def check(self, element: Any, how: str, name: str, known: Iterable[str]) -> None:
        """Refuse the name of a link, joint or frame that is not there."""
        if name not in known:
            what = f"it is {how} '{name}', which does not exist"
            hint = nearest(name, known)
            if name == "world":
                hint = "only a fixed joint of the root link to the world is read"
            what = what if name else f"it names no {how[3:]}"
            self.reading.fail("link-unknown", what, element, hint)

    @contextmanager
    def left_out(self, kind: str, name: str) -> Iterator[None]:
        """Warn of a sensor or joint that cannot be read."""
        reading = self.reading
        reading.owner = ("sensor" if kind == "sensor" else "joint", name)
        where = reading.where
        try:
            yield
        except ConversionError as error:
            reason = error.message.removeprefix(f"{where}: ")
            what = "a sensor" if kind == "sensor" else "a joint in <gazebo>"
            text = f"{what} is left out: {reason}"
            hint = None if reading.expanded else error.hint
            reading.warn(f"{kind}-left-out", text, error.line, hint=hint)
        finally:
            reading.owner = ("robot", "")
