"""The sensors, joints and motors in ``<gazebo>``, ``<sensor>``, ``<transmission>`` and
``<ros2_control>``, and the friction in Bullet's ``<contact>``.

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

from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import HERE, ZERO, Pose, compose, from_rpy, inverse, rotate, transpose
from urdf2mbs.urdf.model import ClosingJoint, Dynamics, Extension, Sensor

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from urdf2mbs.spatial import Vec
    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading

#: What ``<gazebo>`` says of a link or a joint by one number or truth value.
NUMBERS = ("mu1", "kp", "kd", "springStiffness", "springReference", "turnGravityOff")
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

    @cached_property
    def frames(self) -> dict[str, Pose]:
        """The frames that a pose may name, seen from the root link, all joints at zero."""
        links = self.robot.poses()
        joints = {joint.name: links[joint.child] for joint in self.robot.joints.values()}
        return {**joints, **links, MODEL: HERE}

    def read(self, element: Any, extension: Extension) -> None:
        """Read the sensors, joints and motors in an element of another program."""
        tag, self.reading.owner = extension.tag, ("robot", "")
        if tag == "contact":
            self.reading.owner = ("link", extension.reference or "")
            for friction in element.iterchildren("lateral_friction"):
                number = self.number(friction, "<lateral_friction>", friction.get("value"))
                if number is not None:
                    extension.numbers["mu1"] = number
        if tag in ("gazebo", "sensor"):
            for sensor in [element] if tag == "sensor" else element.iterchildren("sensor"):
                if sensor.get("type") in (*MOTION, FORCE_TORQUE):
                    self.read_sensor(sensor, extension)
        if tag == "gazebo":
            for joint in element.iterchildren("joint"):
                self.read_closing_joint(joint, extension)
            self.read_numbers(element, extension)
        elif tag in ("transmission", "ros2_control"):
            self.read_motors(element, extension)

    def read_motors(self, element: Any, extension: Extension) -> None:
        """Add the motors, rotors and start positions of a ``<transmission>`` or a
        ``<ros2_control>``."""
        extension.motors = [
            name
            for joint in element.iter("joint", "{*}joint")
            if (name := joint.get("name"))
            and (extension.tag == "transmission" or joint.find("command_interface") is not None)
        ]
        for name in extension.motors:
            if name not in self.robot.joints:
                self.reading.warn(
                    "actuator-unknown", f"a <{extension.tag}> drives a joint that does not exist",
                    extension.line, owner=("joint", name),
                    detail=nearest(name, self.robot.joints) or "",
                )  # fmt: skip
        for transmission in element.iter("transmission"):
            self.read_rotor(transmission, extension)
        for start in element.iterfind("joint/state_interface[@name='position']/param"):
            name = start.getparent().getparent().get("name")
            if start.get("name") == "initial_value" and name:
                value = self.number(start, f"the initial_value of joint '{name}'")
                if value is not None:
                    extension.starts[name] = value

    def read_rotor(self, element: Any, extension: Extension) -> None:
        """Add the rotor of a ``<transmission>`` of one joint and one actuator.

        The joint feels ``motorInertia`` times ``mechanicalReduction`` squared.
        """
        joints, actuators = element.findall("joint"), element.findall("actuator")
        inertia = element.find("actuator/motorInertia")
        if len(joints) != 1 or len(actuators) != 1 or inertia is None:
            return
        reduction = element.find("actuator/mechanicalReduction")
        if reduction is None:
            reduction = element.find("joint/mechanicalReduction")
        what = "the inertia of a rotor"
        own = self.number(inertia, what) or 0.0
        ratio = 1.0 if reduction is None else self.number(reduction, what) or 0.0
        if own * ratio**2 > 0.0 and joints[0].get("name"):
            extension.rotors[joints[0].get("name")] = own * ratio**2

    def read_numbers(self, element: Any, extension: Extension) -> None:
        """Add what ``<gazebo reference="...">`` says in elements of a number."""
        for child in element.iterchildren(*NUMBERS):
            written = child.get("value") or text(child)
            if child.tag == "turnGravityOff":
                extension.numbers[child.tag] = float(written.lower() in ("true", "1"))
                continue
            number = self.number(child, f"<{child.tag}> of <gazebo>", written)
            if number is not None:
                extension.numbers[child.tag] = number
        owner = extension.reference or ""
        link, joint = self.robot.links.get(owner), self.robot.joints.get(owner)
        for name, field in SPRING.items():
            if joint is not None and name in extension.numbers:
                joint.dynamics = joint.dynamics or Dynamics()
                setattr(joint.dynamics, field, extension.numbers[name])
        unread = []
        if link is not None and link.inertial is not None and link.inertial.mass != 0.0:
            unread.append(("turnGravityOff", "link", "the link has its weight here"))
        if joint is None or joint.type not in ("revolute", "continuous", "prismatic"):
            unread.append(("springStiffness", "joint", "the joint has no spring here"))
        for name, kind, why in unread:
            if extension.numbers.get(name):
                what = f"<{name}> of <gazebo> has no effect, as {why}"
                self.reading.warn("mechanics-unread", what, extension.line, owner=(kind, owner))

    def number(self, element: Any, what: str, written: str | None = None) -> float | None:
        """The number in an element; None, with a warning, where there is none."""
        try:
            return self.reading.number(element, "the text", written or text(element))
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
        """Add an SDF ``<joint>``, which closes a loop of the robot."""
        parent, child = text(element.find("parent")), text(element.find("child"))
        name, kind = element.get("name") or "", element.get("type") or ""
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
        words = text(element) or "0 0 0 0 0 0"
        x, y, z, roll, pitch, yaw = self.reading.numbers(element, "the text", words, 6)
        pose = Pose((x, y, z), from_rpy((roll, pitch, yaw)))
        frame = element.get("relative_to") or element.get("frame") or link
        self.check(element, "seen from frame", frame, self.frames)
        if frame == link:
            return pose
        return compose(compose(inverse(self.frames[link]), self.frames[frame]), pose)

    def read_axis(self, element: Any, pose: Pose, link: str) -> Vec:
        """``<axis>``, as a direction in a link's frame; ``pose`` is that of its joint."""
        if text(element.find("use_parent_model_frame")).lower() in ("true", "1"):
            what, hint = "<use_parent_model_frame> is not read", f'write expressed_in="{MODEL}"'
            self.reading.fail("number-invalid", what, element, hint)
        xyz = element.find("xyz")
        if xyz is None:
            return rotate(pose.rot, (0.0, 0.0, 1.0))
        x, y, z = self.reading.numbers(xyz, "the text", text(xyz), 3)
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
                hint = "'base: fixed' ties the root link to the world"
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


def text(element: Any) -> str:
    """The text of an element, without comments and without blanks around it."""
    if element is None:
        return ""
    whole = str(element.xpath("string()")) if len(element) else element.text or ""
    return whole.strip()
