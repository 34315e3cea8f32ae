"""The motors, rotors and start positions in ``<transmission>`` and ``<ros2_control>``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import nearest, split_tag
from urdf2mbs_project.followers import get_text, read_number

if TYPE_CHECKING:
    from urdf2mbs.plugin import Extension, Reading, Robot

#: Types of transmissions that couple several joints, and parts that only such ones have.
COUPLING = re.compile(r"differential|four_?bar|pushrod", re.IGNORECASE)
COUPLING_PARTS = ("leftActuator", "rightActuator", "gap_joint", "passive_joint", "rollJoint")
#: Parts of a transmission with a mechanics of their own, which no pass reads.
UNREAD_PARTS = ("compensator", "flexJoint", "friction", "damping", "stiffness", "springStiffness")
#: Names of the inertia of a rotor and of its reduction, in ROS 1, ROS 2 and Drake.
ROTOR_INERTIA = ("motorInertia", "motor_inertia", "rotorInertia", "rotor_inertia")
REDUCTION = ("mechanicalReduction", "mechanical_reduction", "gear_ratio")


class ActuationReader:
    """Reads the transmissions of a robot, once its links and joints are known."""

    def __init__(self, reading: Reading, robot: Robot) -> None:
        self.reading = reading
        self.robot = robot
        self.joints_of_actuator: dict[str, list[str]] = {}

    def read(self, element: Any, extension: Extension) -> None:
        """Add the motors, rotors and start positions of an element to its extension.

        Args:
            element: A ``<transmission>`` or ``<ros2_control>`` of lxml.
            extension: Gets its data.
        """
        self._read_motors(element, extension)
        for transmission in element.iter("transmission"):
            self._read_rotor(transmission, extension)
            self._warn_of_coupling(transmission)
        if extension.tag == "ros2_control":
            self._read_starts(element, extension)

    def _read_motors(self, element: Any, extension: Extension) -> None:
        """Add the joints that have a motor."""
        extension.motors = [
            name
            for joint in element.iter("joint", "{*}joint")
            if (name := joint.get("name"))
            and (extension.tag == "transmission" or joint.find("command_interface") is not None)
        ]
        for name in extension.motors:
            if name not in self.robot.joints:
                message = f"a <{extension.tag}> drives a joint that does not exist"
                detail = nearest(name, self.robot.joints) or ""
                owner = ("joint", name)
                self.reading.warn(
                    "actuator-unknown", message, extension.line, owner=owner, detail=detail
                )

    def _read_starts(self, element: Any, extension: Extension) -> None:
        """Add the positions (rad or m) at which joints start."""
        for start in element.iterfind("joint/state_interface[@name='position']/param"):
            name = start.getparent().getparent().get("name")
            if start.get("name") == "initial_value" and name:
                value = read_number(self.reading, start, f"the initial_value of joint '{name}'")
                if value is not None:
                    extension.starts[name] = value

    def _read_rotor(self, element: Any, extension: Extension) -> None:
        """Add the rotor of a ``<transmission>`` of one joint and one actuator.

        The joint feels the inertia of the rotor times the reduction squared.  Drake calls them
        ``drake:rotor_inertia`` and ``drake:gear_ratio``.
        """
        joints, actuators = element.findall("joint"), element.findall("actuator")
        if len(joints) != 1 or len(actuators) != 1 or not joints[0].get("name"):
            return
        parts: dict[str, Any] = {}
        for parent in (actuators[0], joints[0], element):
            for child in parent.iterchildren():
                if isinstance(child.tag, str):
                    parts.setdefault(split_tag(child.tag)[0], child)
        inertia = next((parts[name] for name in ROTOR_INERTIA if name in parts), None)
        if inertia is None:
            return
        reduction = next((parts[name] for name in REDUCTION if name in parts), None)
        text = "the inertia of a rotor"
        rotor_inertia = read_number(self.reading, inertia, text)
        ratio = 1.0 if reduction is None else read_number(self.reading, reduction, text)
        if rotor_inertia is None or ratio is None:
            return
        name = joints[0].get("name")
        if rotor_inertia < 0.0:
            message = "the inertia of a rotor is below zero, and is left out"
            line = inertia.sourceline
            self.reading.warn("number-negative", message, line, owner=("joint", name))
        elif rotor_inertia > 0.0 and ratio == 0.0:
            message = "the reduction of a transmission is 0, and its rotor is left out"
            line = element.sourceline
            self.reading.warn("number-left-out", message, line, owner=("joint", name))
        elif rotor_inertia * ratio**2 > 0.0:
            extension.rotors[name] = rotor_inertia * ratio**2

    def _warn_of_coupling(self, element: Any) -> None:
        """Warn of a transmission that couples several joints, which no pass reads."""
        names = [joint.get("name") or "" for joint in element.findall("joint")]
        actuators = [actuator.get("name") or "" for actuator in element.findall("actuator")]
        kind = get_text(element.find("type")) or get_text(element.find("plugin"))
        kind = kind or element.get("type") or ""
        unread = [child for child in element if child.tag in UNREAD_PARTS]
        self.reading.unknown_children("transmission", unread, ())
        couples = any(element.find(part) is not None for part in COUPLING_PARTS)
        if len(set(names)) > 1 or len(actuators) > 1 or couples or COUPLING.search(kind):
            kind = kind.rpartition("/")[2].rpartition("::")[2] or "of several joints"
            message = f"a <transmission> ({kind}) couples joints, which is not read"
            for name in names or [""]:
                owner = ("joint", name) if name in self.robot.joints else ("robot", "")
                self.reading.warn("mechanics-unread", message, element.sourceline, owner=owner)
        elif actuators and actuators[0] and names and names[0]:
            driven = self.joints_of_actuator.setdefault(actuators[0], [])
            if names[0] not in driven:
                driven.append(names[0])
            message = (
                "an actuator of several transmissions couples their joints, which is not read: "
                "they move freely"
            )
            for name in driven if len(driven) > 1 else ():
                owner, detail = ("joint", name), f"of actuator '{actuators[0]}'"
                line = element.sourceline
                self.reading.warn("mechanics-unread", message, line, owner=owner, detail=detail)
