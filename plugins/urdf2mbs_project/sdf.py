"""The sensors and joints that are written as in SDF, inside ``<gazebo>`` and ``<sensor>``.

SDF says where a sensor or a joint is ("Pose Frame Semantics" of sdformat.org, versions 1.4 to
1.12):

* ``<pose>`` is ``x y z roll pitch yaw`` in m and rad; degrees and quaternions are not read;
* a pose is relative to ``relative_to`` (``frame`` until SDF 1.6), with all joints at zero; without
  it, a sensor's pose is relative to its link, and a joint's pose to its child link;
* an axis is in the joint's frame, or in ``expressed_in``; ``use_parent_model_frame`` of SDF 1.6
  is not read.

The name of a link is its frame, the name of a joint the frame of its child link, and
``__model__`` the frame of the root link.
"""

from __future__ import annotations

from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import (
    HERE,
    ZERO,
    ClosingJoint,
    ConversionError,
    Extension,
    Pose,
    UrdfSensor,
    compose,
    from_rpy,
    inverse,
    nearest,
    rotate,
    transpose,
)
from urdf2mbs_project.followers import get_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from urdf2mbs.plugin import Reading, Robot, Vec

#: Sensors of motion, by their type in URDF and in SDF.
MOTION = ("imu", "accelerometer", "gyroscope")
FORCE_TORQUE = "force_torque"
#: The frame of an SDF model.
MODEL_FRAME = "__model__"
#: Children of SDF's ``<joint>`` and its ``<axis>`` that are read, or that are for the solver.
JOINT_CHILDREN = frozenset(
    ["parent", "child", "pose", "axis", "axis2", "sensor", "physics", "provideFeedback"]
)
AXIS_CHILDREN = frozenset(["xyz", "use_parent_model_frame", "initial_position"])


class SdfReader:
    """Reads sensors and joints of SDF, once the links and joints of the robot are known."""

    def __init__(self, reading: Reading, robot: Robot) -> None:
        self.reading = reading
        self.robot = robot

    @cached_property
    def rigid_with_root(self) -> set[str]:
        """The root link, and the links that are fixed to it."""
        links = {self.robot.root()}
        for joint in self.robot.depth_first():
            if joint.type == "fixed" and joint.parent in links:
                links.add(joint.child)
        return links

    @cached_property
    def frames(self) -> dict[str, Pose]:
        """The frames that a pose may name, in the root link, all joints at zero."""
        links = self.robot.poses()
        joints = {joint.name: links[joint.child] for joint in self.robot.joints.values()}
        return {**joints, **links, MODEL_FRAME: HERE}

    # --- sensors and joints ---

    def read_sensor(self, element: Any, extension: Extension) -> None:
        """Add a ``<sensor>`` of motion, or of force and torque, to its extension.

        Args:
            element: The element of lxml.
            extension: The element of the URDF that has it; its reference is the sensor's link or
                joint, unless the sensor names its own.
        """
        kind, parent = element.get("type"), element.find("parent")
        if kind not in (*MOTION, FORCE_TORQUE):
            return
        owner = extension.reference
        if parent is not None:
            owner = parent.get("joint" if kind == FORCE_TORQUE else "link")
        name = element.get("name") or ""
        if not name:
            name = f"{owner}_{kind}"
            message = f"a sensor has no name, and is called '{name}'"
            self.reading.warn("sensor-renamed", message, element.sourceline)
        with self.warning_if_left_out("sensor", name):
            sensor = UrdfSensor(name, kind, owner or "", line=element.sourceline)
            origin = element.find("origin")
            if kind == FORCE_TORQUE:  # Its pose is that of its joint.
                self.check_name(element, "on joint", sensor.on, self.robot.joints)
            else:
                self.check_name(element, "on link", sensor.on, self.robot.links)
                if origin is not None:
                    sensor.pose = self.reading.origin(origin).pose
                else:
                    sensor.pose = self.read_pose(element.find("pose"), sensor.on)
            extension.sensors.append(sensor)

    def read_closing_joint(self, element: Any, extension: Extension) -> None:
        """Add a ``<joint>``, which closes a loop of the robot, or fixes it to the world."""
        parent, child = _get_end(element.find("parent")), _get_end(element.find("child"))
        name, kind = element.get("name") or "", element.get("type") or ""
        links = {end.rpartition("::")[2] for end in (parent, child)}  # without the model
        is_fixed_to_world = kind.lower() == "fixed" and "world" in links - self.robot.links.keys()
        if is_fixed_to_world and not self.rigid_with_root.isdisjoint(links):
            self.robot.fixed_by = f"joint '{name}' of <gazebo>"
            return
        self.reading.owner = ("joint", name)
        unread = [part for part in element if part.tag not in JOINT_CHILDREN]
        self.reading.unknown_children("joint", unread, ())
        for axis in element.iterchildren("axis", "axis2"):
            unread = [part for part in axis if part.tag not in AXIS_CHILDREN]
            self.reading.unknown_children("axis", unread, ())
        with self.warning_if_left_out("loop", name):
            self.check_ends(element, (parent, child))
            pose = self.read_pose(element.find("pose"), child)
            axes = [
                self.read_axis(axis, pose, child)
                for tag in ("axis", "axis2")
                if (axis := element.find(tag)) is not None
            ]
            extension.joints.append(
                ClosingJoint(name, kind, parent, child, pose, axes, element.sourceline)
            )

    # --- poses and axes ---

    def read_pose(self, element: Any, link: str) -> Pose:
        """Return the pose in a ``<pose>`` (m), relative to a link.

        Args:
            element: The element of lxml; None if it is not written.
            link: The link, which is also the frame of the pose by default.
        """
        if element is None:
            return HERE
        degrees, form = element.get("degrees", "false"), element.get("rotation_format", "euler_rpy")
        if degrees not in ("false", "0") or form != "euler_rpy":
            message = "<pose> in degrees or with a quaternion is not read"
            hint = "write x y z roll pitch yaw, in m and rad"
            self.reading.fail("number-invalid", message, element, hint)
        words = get_text(element) or "0 0 0 0 0 0"
        x, y, z, roll, pitch, yaw = self.reading.numbers(element, "the text", words, 6)
        pose = Pose((x, y, z), from_rpy((roll, pitch, yaw)))
        frame = element.get("relative_to") or element.get("frame") or link
        self.check_name(element, "seen from frame", frame, self.frames)
        if frame == link:
            return pose
        return compose(compose(inverse(self.frames[link]), self.frames[frame]), pose)

    def read_axis(self, element: Any, pose: Pose, link: str) -> Vec:
        """Return the direction in an ``<axis>``, in a link's frame.

        Args:
            element: The element of lxml.
            pose: The pose of the joint, relative to the link (m).
            link: The link.
        """
        if get_text(element.find("use_parent_model_frame")).lower() in ("true", "1"):
            message = "<use_parent_model_frame> is not read"
            hint = f'write expressed_in="{MODEL_FRAME}"'
            self.reading.fail("number-invalid", message, element, hint)
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
        self.check_name(xyz, "seen from frame", frame, self.frames)
        in_root = rotate(self.frames[frame].rot, (x, y, z))
        return rotate(transpose(self.frames[link].rot), in_root)

    # --- errors ---

    def check_ends(self, element: Any, links: tuple[str, str]) -> None:
        """Raise ConversionError if a joint is on a link that does not exist, or is of SDF."""
        sdf_links = {link.get("name") for link in element.iterfind("../../gazebo/link")}
        for link in links:
            if link in sdf_links - self.robot.links.keys():
                message = "it is on a link inside <gazebo>; no such link is read, nor its mass"
                self.reading.fail("link-unknown", message, element)
            self.check_name(element, "on link", link, self.robot.links)

    def check_name(self, element: Any, relation: str, name: str, names: Iterable[str]) -> None:
        """Raise ConversionError if a link, joint or frame does not exist.

        Args:
            element: The element of lxml that names it.
            relation: Its relation to the element, such as "on link".
            name: The name.
            names: All names that exist.
        """
        if name not in names:
            message = f"it is {relation} '{name}', which does not exist"
            if not name:
                message = f"it names no {relation[3:]}"
            hint = nearest(name, names)
            if name == "world":
                hint = "only a fixed joint of the root link to the world is read"
            self.reading.fail("link-unknown", message, element, hint)

    @contextmanager
    def warning_if_left_out(self, kind: str, name: str) -> Iterator[None]:
        """Turn an error of reading a sensor or a joint into a warning.

        Args:
            kind: ``sensor``, or ``loop`` for a joint.
            name: Its name.
        """
        reading = self.reading
        reading.owner = ("sensor" if kind == "sensor" else "joint", name)
        location = reading.where
        try:
            yield
        except ConversionError as error:
            reason = error.message.removeprefix(f"{location}: ")
            element = "a sensor" if kind == "sensor" else "a joint in <gazebo>"
            message = f"{element} is left out: {reason}"
            hint = None if reading.expanded else error.hint
            reading.warn(f"{kind}-left-out", message, error.line, hint=hint)
        finally:
            reading.owner = ("robot", "")


def _get_end(element: Any) -> str:
    """Return the link in a ``<parent>`` or ``<child>``, as text or as an attribute."""
    return "" if element is None else get_text(element) or element.get("link", "")
