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
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import (
    HERE,
    ZERO,
    Pose,
    compose,
    from_rpy,
    inverse,
    rotate,
    transpose,
)
from urdf2mbs.urdf.elements import plain
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


def read_extension(reading: Reading, element: Any) -> Extension:
    """An element of another program, with the sensors, joints and motors in it."""
    tag = plain(element.tag)
    xml = etree.tostring(element, encoding=str, with_tail=False)
    extension = Extension(tag, xml, element.get("reference"), element.sourceline)
    if tag == "contact":
        extension.reference = element.getparent().get("name")
        for friction in element.iterchildren("lateral_friction"):
            number = read_number(reading, friction, "<lateral_friction>", friction.get("value"))
            if isfinite(number):
                extension.numbers["mu1"] = number
    if tag in ("gazebo", "sensor"):
        for sensor in [element] if tag == "sensor" else element.iterchildren("sensor"):
            if sensor.get("type") in (*MOTION, FORCE_TORQUE):
                read_sensor(reading, sensor, extension)
    if tag == "gazebo":
        read_numbers(reading, element, extension)
        for joint in element.iterchildren("joint"):
            read_closing_joint(reading, joint, extension)
    elif tag in ("transmission", "ros2_control"):
        extension.motors = [
            name
            for joint in element.iter("joint", "{*}joint")
            if (name := joint.get("name"))
            and (tag == "transmission" or joint.find("command_interface") is not None)
        ]
        for transmission in element.iter("transmission"):
            read_rotor(reading, transmission, extension)
        for start in element.iterfind("joint/state_interface[@name='position']/param"):
            name = start.getparent().getparent().get("name")
            if start.get("name") == "initial_value" and name:
                value = read_number(reading, start, f"the initial_value of joint '{name}'")
                if isfinite(value):
                    extension.starts[name] = value
    return extension


def read_rotor(reading: Reading, element: Any, extension: Extension) -> None:
    """Add the rotor of a ``<transmission>`` of one joint and one actuator to its extension.

    The joint feels ``motorInertia`` times ``mechanicalReduction`` squared.
    """
    joints, actuators = element.findall("joint"), element.findall("actuator")
    inertia = element.find("actuator/motorInertia")
    if len(joints) != 1 or len(actuators) != 1 or inertia is None:
        return
    reduction = element.find("actuator/mechanicalReduction")
    if reduction is None:
        reduction = element.find("joint/mechanicalReduction")
    felt = read_number(reading, inertia, "the inertia of a rotor")
    if reduction is not None:
        felt *= read_number(reading, reduction, "the inertia of a rotor") ** 2
    if felt > 0.0 and joints[0].get("name"):
        extension.rotors[joints[0].get("name")] = felt


def read_numbers(reading: Reading, element: Any, extension: Extension) -> None:
    """Add to its extension what ``<gazebo reference="...">`` says in elements of a number."""
    for child in element.iterchildren(*NUMBERS):
        written = child.get("value") or text(child)
        if child.tag == "turnGravityOff":
            extension.numbers[child.tag] = float(written.lower() in ("true", "1"))
        else:
            number = read_number(reading, child, f"<{child.tag}> of <gazebo>", written)
            if isfinite(number):
                extension.numbers[child.tag] = number


def read_number(reading: Reading, element: Any, what: str, written: str | None = None) -> float:
    """The number in an element; nan, with a warning, where there is none."""
    try:
        return reading.number(element, "the text", written or text(element))
    except ConversionError as error:
        reading.warn_of_left_out(element, what, error)
        return nan


def read_sensor(reading: Reading, element: Any, extension: Extension) -> None:
    """Add a ``<sensor>`` of motion, or of force and torque, to its extension."""
    kind, parent = element.get("type"), element.find("parent")
    on = extension.reference
    if parent is not None:
        on = parent.get("joint" if kind == FORCE_TORQUE else "link")
    name = element.get("name") or ""
    if not name:
        name = f"{on}_{kind}"
        what = f"a sensor has no name, and is called '{name}'"
        reading.warn("sensor-renamed", what, element.sourceline)
    sensor = Sensor(name, kind, on or "", line=element.sourceline)
    origin = element.find("origin")
    with _left_out(reading, "sensor", sensor, extension.sensors):
        extension.sensors.append(sensor)
        if kind == FORCE_TORQUE:
            return  # it measures where its joint is
        if origin is not None:
            sensor.pose = reading.origin(origin).pose
        else:
            sensor.pose, sensor.relative_to = read_pose(reading, element.find("pose"))


def read_closing_joint(reading: Reading, element: Any, extension: Extension) -> None:
    """Add an SDF ``<joint>``, which closes a loop of the robot."""
    joint = ClosingJoint(
        element.get("name") or "", element.get("type") or "",
        text(element.find("parent")), text(element.find("child")), line=element.sourceline,
    )  # fmt: skip
    with _left_out(reading, "loop", joint, extension.joints):
        extension.joints.append(joint)
        joint.pose, joint.relative_to = read_pose(reading, element.find("pose"))
        axes = [axis for tag in ("axis", "axis2") if (axis := element.find(tag)) is not None]
        joint.axes = [read_axis(reading, axis) for axis in axes]


def read_pose(reading: Reading, element: Any) -> tuple[Pose, str | None]:
    """``<pose>``, and the frame from which it is seen where it names one."""
    if element is None:
        return HERE, None
    relative_to = element.get("relative_to") or element.get("frame") or None
    degrees, form = element.get("degrees", "false"), element.get("rotation_format", "euler_rpy")
    if degrees not in ("false", "0") or form != "euler_rpy":
        what = "<pose> in degrees or with a quaternion is not read"
        reading.fail("number-invalid", what, element, "write x y z roll pitch yaw, in m and rad")
    words = text(element)
    if not words:
        return HERE, relative_to
    x, y, z, *angles = reading.numbers(element, "the text", words, 6)
    roll, pitch, yaw = angles
    return Pose((x, y, z), from_rpy((roll, pitch, yaw))), relative_to


def read_axis(reading: Reading, element: Any) -> tuple[Vec, str | None]:
    """``<axis>``: its direction as written, and the frame in which it is expressed, if named."""
    if text(element.find("use_parent_model_frame")).lower() in ("true", "1"):
        what, hint = "<use_parent_model_frame> is not read", f'write expressed_in="{MODEL}"'
        reading.fail("number-invalid", what, element, hint)
    xyz = element.find("xyz")
    if xyz is None:
        return (0.0, 0.0, 1.0), None
    x, y, z = reading.numbers(xyz, "the text", text(xyz), 3)
    if (x, y, z) == ZERO:
        reading.fail("number-invalid", "<axis> is zero", xyz, "give a direction, such as 0 0 1")
    return (x, y, z), xyz.get("expressed_in")


def text(element: Any) -> str:
    """The text of an element, without comments and without blanks around it."""
    if element is None:
        return ""
    whole = str(element.xpath("string()")) if len(element) else element.text or ""
    return whole.strip()


def check_extensions(reading: Reading, robot: Robot) -> None:
    """See each sensor from its link, and each joint from its child link; leave out, with a
    warning, those whose link or frame is not there."""
    frames: dict[str, Pose] = {}
    for extension in robot.extensions:
        if not frames and (extension.sensors or extension.joints):
            links = robot.poses()
            frames = {joint.name: links[joint.child] for joint in robot.joints.values()}
            frames |= {**links, MODEL: HERE}
        for sensor in list(extension.sensors):
            with _left_out(reading, "sensor", sensor, extension.sensors):
                if sensor.type == FORCE_TORQUE:
                    _check(reading, sensor, "on joint", sensor.on, robot.joints)
                else:
                    _check(reading, sensor, "on link", sensor.on, robot.links)
                    _settle(reading, sensor, frames, sensor.on)
        for joint in list(extension.joints):
            with _left_out(reading, "loop", joint, extension.joints):
                _check(reading, joint, "on link", joint.parent, robot.links)
                _check(reading, joint, "on link", joint.child, robot.links)
                _settle(reading, joint, frames, joint.child)
                joint.axes = [
                    (_axis(reading, joint, frames, axis, seen_from), None)
                    for axis, seen_from in joint.axes
                ]
        _read_spring(robot, extension)
        _check_numbers(reading, robot, extension)
        for name in extension.motors:
            if name not in robot.joints:
                what = f"<{extension.tag}> is for joint '{name}', which does not exist"
                reading.warn("actuator-unknown", what, extension.line, like=(name, robot.joints))


def _read_spring(robot: Robot, extension: Extension) -> None:
    """Give a joint the spring that ``<gazebo>`` states of it."""
    joint = robot.joints.get(extension.reference or "")
    for element, name in SPRING.items():
        if joint is not None and element in extension.numbers:
            joint.dynamics = joint.dynamics or Dynamics()
            setattr(joint.dynamics, name, extension.numbers[element])


def _check_numbers(reading: Reading, robot: Robot, extension: Extension) -> None:
    """Warn of mechanics in ``<gazebo>`` that have no effect here."""
    link = robot.links.get(extension.reference or "")
    weighs = link is not None and link.inertial is not None and link.inertial.mass != 0.0
    joint = robot.joints.get(extension.reference or "")
    sprung = joint is not None and joint.type in ("revolute", "continuous", "prismatic")
    for name, kind, what in (
        ("turnGravityOff", "link", "it has its weight here" if weighs else ""),
        ("springStiffness", "joint", "" if sprung else "it has no spring here"),
    ):
        if extension.numbers.get(name) and what:
            reading.warn(
                "mechanics-unread", f"<{name}> of <gazebo> is without effect: {what}",
                extension.line, owner=(kind, extension.reference or ""),
            )  # fmt: skip


def _settle(
    reading: Reading, thing: Sensor | ClosingJoint, frames: dict[str, Pose], link: str
) -> None:
    """See a sensor or joint from its own link."""
    frame = thing.relative_to
    if frame is not None and frame != link:
        _check(reading, thing, "seen from frame", frame, frames)
        thing.pose = compose(compose(inverse(frames[link]), frames[frame]), thing.pose)
    thing.relative_to = None


def _axis(
    reading: Reading, joint: ClosingJoint, frames: dict[str, Pose], axis: Vec, frame: str | None
) -> Vec:
    """An axis in the frame of the joint's child link."""
    if frame is None:
        return rotate(joint.pose.rot, axis)
    _check(reading, joint, "seen from frame", frame, frames)
    return rotate(transpose(frames[joint.child].rot), rotate(frames[frame].rot, axis))


def _check(
    reading: Reading, thing: Sensor | ClosingJoint, how: str, name: str, known: Iterable[str]
) -> None:
    if name not in known:
        what = f"it is {how} '{name}', which does not exist" if name else f"it names no {how[3:]}"
        reading.fail(
            "link-unknown", what, thing.line,
            "'base: fixed' ties the root link to the world" if name == "world"
            else nearest(name, known),
        )  # fmt: skip


@contextmanager
def _left_out(reading: Reading, kind: str, thing: Any, things: list[Any]) -> Iterator[None]:
    """Take a sensor or joint out of its list, with a warning, where it cannot be read."""
    reading.owner = ("sensor" if kind == "sensor" else "joint", thing.name)
    where = f"{reading.where} in <gazebo>" if kind == "loop" else reading.where
    try:
        yield
    except ConversionError as error:
        things.remove(thing)
        reason = error.message.removeprefix(f"{reading.where}: ")
        reading.warn(
            f"{kind}-left-out", f"{where} is left out: {reason}", error.line,
            hint=error.hint, owner=("robot", ""),
        )  # fmt: skip
    finally:
        reading.owner = ("robot", "")
