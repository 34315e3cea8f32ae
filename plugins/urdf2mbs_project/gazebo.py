"""The elements of other programs: ``<gazebo>``, ``<sensor>``, ``<mujoco>``, ``<transmission>`` ...

The sensors, joints and numbers that a conversion uses are added to the element's extension.  A
warning names each element that changes the mechanics and is not read.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import (
    OFF,
    ON,
    Dynamics,
    Extension,
    nearest,
    quote,
    some,
)
from urdf2mbs_project.actuation import ActuationReader
from urdf2mbs_project.followers import FollowerReader, get_text, read_number
from urdf2mbs_project.sdf import SdfReader

if TYPE_CHECKING:
    from urdf2mbs.plugin import Reading, Robot

#: Elements of ``<gazebo>`` that are one number or truth value of a link or a joint.
NUMBER_TAGS = (
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
SWITCH_TAGS = ("turnGravityOff", "gravity", "static")
#: The other children of ``<gazebo>`` that are read.
READ_TAGS = frozenset((*NUMBER_TAGS, "sensor", "joint", "plugin"))
#: Children of ``<gazebo>`` for appearance, for collisions, and for the solver of Gazebo.
HARMLESS_TAGS = frozenset(
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
MASS_ATTRIBUTES = (
    "settotalmass",
    "balanceinertia",
    "boundmass",
    "boundinertia",
    "inertiafromgeom",
)
HARMLESS_MUJOCO_TAGS = frozenset(["compiler", "size", "visual", "asset", "statistic"])
#: Children of Bullet's ``<contact>`` that are read, or that are for its solver.
CONTACT_CHILDREN = frozenset(["lateral_friction", "contact_cfm", "contact_erp", "friction_anchor"])
#: Plugins that couple joints as ``<mimic>`` does, and others that change the mechanics.
MIMIC_PLUGIN = re.compile(r"mimic", re.IGNORECASE)
MECHANICAL_PLUGIN = re.compile(
    r"underactuated|lift_?-?drag|buoyan|hydrodynamic|thrust|propeller|spring|damper|gearbox"
    r"|differential(?!_?-?drive)|harness|tendon|freeze|detachable|motor_?model|underwater|uuv"
    r"|gravity|wind|wheel_?-?slip|link_?attach|fixed_?base|disable_?link|closed_?loop|vacuum",
    re.IGNORECASE,
)
#: The numbers of `<gazebo>` that are one of the dynamics of a joint, and its field.
SPRING_FIELDS = {"springStiffness": "spring_stiffness", "springReference": "spring_reference"}


class ExtensionReader:
    """Reads the elements of other programs, once the links and joints of the robot are known."""

    def __init__(self, reading: Reading, robot: Robot) -> None:
        self.reading = reading
        self.robot = robot
        self.sdf = SdfReader(reading, robot)
        self.actuation = ActuationReader(reading, robot)
        self.followers = FollowerReader(reading, robot)

    def read(self, element: Any, extension: Extension) -> None:
        """Read an element of another program, and warn of mechanics in it that is not read.

        Args:
            element: The element of lxml.
            extension: Gets its data.
        """
        tag, self.reading.owner = extension.tag, ("robot", "")
        if tag == "contact":
            self.read_contact(element, extension)
        elif tag == "sensor":
            self.sdf.read_sensor(element, extension)
        elif tag == "gazebo":
            self.read_gazebo(element, extension)
        elif tag == "mujoco":
            self.warn_of_mujoco(element)
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

    # --- <contact>, <mujoco> ---

    def read_contact(self, element: Any, extension: Extension) -> None:
        """Add the friction of Bullet's ``<contact>`` of a link."""
        self.reading.owner = ("link", extension.reference or "")
        for friction in element.iterchildren("lateral_friction"):
            number = read_number(self.reading, friction, "<lateral_friction>")
            if number is not None:
                extension.numbers["mu1"] = number
                self.warn_of_negative(friction, extension.reference, number)
        unread = [child for child in element if child.tag not in CONTACT_CHILDREN]
        self.reading.unknown_children("contact", unread, ())

    def warn_of_mujoco(self, element: Any) -> None:
        """Warn of mechanics in a ``<mujoco>``: options, equalities, balanced masses."""
        unread = [child for child in element if child.tag not in HARMLESS_MUJOCO_TAGS]
        self.reading.unknown_children("mujoco", unread, ())
        for compiler in element.iterchildren("compiler"):
            names = [name for name in MASS_ATTRIBUTES if compiler.get(name, "false") != "false"]
            if names:
                message = f"<compiler> of <mujoco> changes masses by {some(names)}: it is not read"
                self.reading.warn("mechanics-unread", message, compiler.sourceline)

    # --- <gazebo> ---

    def read_gazebo(self, element: Any, extension: Extension) -> None:
        """Read the sensors, plugins, joints and numbers of a ``<gazebo>``."""
        for sensor in element.iterchildren("sensor"):
            self.sdf.read_sensor(sensor, extension)
        self.reading.owner = self.find_owner(extension.reference)
        unread = [name for name in element.attrib if name not in ("reference", "name")]
        if unread:
            message = f"the attributes {some(unread)} of <gazebo> are not read"
            self.reading.warn("mechanics-unread", message, element.sourceline)
        for plugin in element.iterchildren("plugin"):
            self.read_plugin(plugin)
        self.reading.owner = ("robot", "")
        for joint in element.iterchildren("joint"):
            self.sdf.read_closing_joint(joint, extension)
        self.read_numbers(element, extension)
        self.reading.owner = self.find_owner(extension.reference)
        self.warn_of_gazebo(element)

    def read_plugin(self, element: Any) -> None:
        """Read a plugin that couples joints, and warn of others that change the mechanics."""
        names = [element.get(key, "").rpartition("/")[2] for key in ("filename", "name")]
        name = next(filter(None, names), "")
        joins = any(end.getparent().find("child") is not None for end in element.iter("parent"))
        joins = joins or element.find(".//joint/parent") is not None
        if element.find("mimicJoint") is not None or MIMIC_PLUGIN.search(name):
            self.followers.read_plugin(element)
        elif joins or any(map(MECHANICAL_PLUGIN.search, names)):
            message = f"the plugin '{name}' in <gazebo> changes the mechanics, and is not read"
            self.reading.warn("mechanics-unread", message, element.sourceline)

    def warn_of_gazebo(self, element: Any) -> None:
        """Warn of mechanics in a ``<gazebo>`` that is not read."""
        unread = []
        for child in element:
            if child.tag == "collision" and child.find(".//friction") is not None:
                message = "the friction of <collision> in <gazebo> is not read; <mu1> is"
                self.reading.warn("mechanics-unread", message, child.sourceline)
            elif child.tag not in READ_TAGS and child.tag not in HARMLESS_TAGS:
                unread.append(child)
        self.reading.unknown_children("gazebo", unread, NUMBER_TAGS)

    # --- the numbers of <gazebo> ---

    def read_numbers(self, element: Any, extension: Extension) -> None:
        """Read the elements of a ``<gazebo>`` that are one number or truth value."""
        for child in element.iterchildren(*NUMBER_TAGS):
            if child.tag in SWITCH_TAGS:
                self.read_switch(child, extension)
            else:
                number = read_number(self.reading, child, f"<{child.tag}> of <gazebo>")
                if number is not None:
                    extension.numbers[child.tag] = number
                    self.warn_of_negative(child, extension.reference, number)
        reference = extension.reference or ""
        exists = reference in self.robot.links or reference in self.robot.joints
        if reference and not exists and extension.numbers:
            message = "what <gazebo> says of a link or joint that does not exist has no effect"
            hint = nearest(reference, [*self.robot.links, *self.robot.joints])
            owner = ("gazebo", reference)
            self.reading.warn("mechanics-unread", message, extension.line, owner=owner, hint=hint)
            return
        joint = self.robot.joints.get(reference)
        for tag, field in SPRING_FIELDS.items():
            if joint is not None and tag in extension.numbers:
                joint.dynamics = joint.dynamics or Dynamics()
                setattr(joint.dynamics, field, extension.numbers[tag])
        self.warn_of_unused_numbers(element, extension)

    def read_switch(self, element: Any, extension: Extension) -> None:
        """Read an element of a ``<gazebo>`` that is true or false."""
        written = element.get("value") or get_text(element)
        is_true = written.lower() in ON
        owner, line = self.find_owner(extension.reference), element.sourceline
        if written.lower() not in ON | OFF:
            message = f"<{element.tag}> of <gazebo> is {quote(written)}; expected true or false"
            hint = "'gravity' of the config has the vector" if element.tag == "gravity" else None
            self.reading.warn("mechanics-unread", message, line, owner=owner, hint=hint)
        elif element.tag == "gravity":
            if not is_true:
                extension.numbers["turnGravityOff"] = 1.0
        elif element.tag == "turnGravityOff":
            extension.numbers[element.tag] = float(is_true)
        elif is_true and extension.reference:
            message = "<static> of <gazebo> is of the whole robot: one link has none"
            self.reading.warn("mechanics-unread", message, line, owner=owner)
        elif is_true:
            self.robot.fixed_by = "<static> of <gazebo>"

    def warn_of_unused_numbers(self, element: Any, extension: Extension) -> None:
        """Warn of numbers that have no effect on the link or joint of a ``<gazebo>``."""
        reference = extension.reference or ""
        link, joint = self.robot.links.get(reference), self.robot.joints.get(reference)
        unused = []
        if not reference:
            unused.append(("turnGravityOff", "robot", "'gravity' of the config is for all links"))
        elif link is not None and link.inertial is not None and link.inertial.mass != 0.0:
            unused.append(("turnGravityOff", "link", "the link has its weight here"))
        if joint is None or joint.type not in ("revolute", "continuous", "prismatic"):
            unused.append(("springStiffness", "joint", "the joint has no spring here"))
        for name, kind, reason in unused:
            if extension.numbers.get(name):
                tag = name if element.find(name) is not None else "gravity"
                message = f"<{tag}> of <gazebo> has no effect, as {reason}"
                owner = (kind, reference)
                self.reading.warn("mechanics-unread", message, extension.line, owner=owner)

    def warn_of_negative(self, element: Any, reference: str | None, number: float) -> None:
        """Warn of a number of friction or stiffness below zero."""
        if number < 0.0 and element.tag != "springReference":
            parent = element.getparent().tag
            message = f"<{element.tag}> of <{parent}> is below zero; expected zero or more"
            owner, line = self.find_owner(reference), element.sourceline
            self.reading.warn("number-negative", message, line, owner=owner, detail=f"{number!r}")
