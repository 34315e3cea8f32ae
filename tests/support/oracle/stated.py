"""What a URDF states beside its mechanism, read straight off its XML.

Limits, damping, friction and springs of joints, joints that follow others, shapes that may touch
the ground, sensors, and where joints start.  Units are m, kg, rad, s.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from lxml import etree

from support.oracle.multibody import Array, rotation, translation
from support.oracle.urdf import UrdfShape, X, Y, Z, read_collisions

#: Sensors that read a motion.
MOTION_SENSORS = ("imu", "accelerometer", "gyroscope")


@dataclass
class Mimic:
    """The rule of a follower: its q is ``multiplier`` times the leader's, plus ``offset``."""

    leader: str
    multiplier: float
    offset: float


@dataclass
class StatedSensor:
    """A sensor of a motion; ``pose`` is 4x4, in the frame of its link."""

    link: str
    name: str
    pose: Array


class Stated:
    """The statements of a URDF.

    Args:
        text: The URDF.
    """

    def __init__(self, text: bytes) -> None:
        root = etree.fromstring(text)
        self.links = [str(link.get("name")) for link in root.iterfind("link")]
        #: The numbers of each joint: q_min, q_max, effort, damping, friction, spring_stiffness,
        #: spring_reference; those that are not stated, or that state nothing, are left out.
        self.numbers = {str(j.get("name")): _joint_numbers(j) for j in root.iterfind("joint")}
        self.mimics = {
            str(mimic.getparent().get("name")): Mimic(
                str(mimic.get("joint")),
                float(mimic.get("multiplier", 1.0)),
                float(mimic.get("offset", 0.0)),
            )
            for mimic in root.iterfind("joint/mimic")
        }
        #: The shapes of each link that may touch the ground.
        self.collisions: dict[str, list[UrdfShape]] = {
            str(link.get("name")): read_collisions(link) for link in root.iterfind("link")
        }
        #: Coulomb's coefficient of friction, by link.
        self.ground_friction: dict[str, float] = {}
        self.sensors: list[StatedSensor] = []
        for element in root.iterfind("gazebo"):
            self._read_gazebo(element, str(element.get("reference")))
        #: Where joints start (rad or m).
        self.starts = {
            str(start.getparent().getparent().get("name")): float(start.text or "nan")
            for start in root.iterfind(
                "ros2_control/joint/state_interface[@name='position']/param[@name='initial_value']"
            )
        }

    def _read_gazebo(self, element: etree._Element, reference: str) -> None:
        words = {"springStiffness": "spring_stiffness", "springReference": "spring_reference"}
        for tag, name in words.items():
            for child in element.iterfind(tag):
                self.numbers[reference][name] = float(child.get("value") or child.text or "nan")
        for child in element.iterfind("mu1"):
            self.ground_friction[reference] = float(child.get("value") or child.text or "nan")
        for sensor in element.iterfind("sensor"):
            if sensor.get("type") in MOTION_SENSORS:
                numbers = [float(word) for word in sensor.findtext("pose", "0 0 0 0 0 0").split()]
                pose = translation(np.array(numbers[:3]))
                roll, pitch, yaw = numbers[3:]
                pose[:3, :3] = rotation(Z, yaw) @ rotation(Y, pitch) @ rotation(X, roll)
                self.sensors.append(StatedSensor(reference, str(sensor.get("name")), pose))


def _joint_numbers(joint: etree._Element) -> dict[str, float]:
    """Return the numbers of a joint's limits and dynamics.

    A continuous joint has no limits of its position; neither has one whose lower limit is above
    its upper one, or equal to it.
    """
    numbers: dict[str, float] = {}
    limit, dynamics = joint.find("limit"), joint.find("dynamics")
    if limit is not None:
        stated = {key: float(text) for key, text in limit.attrib.items() if isfinite(float(text))}
        if "effort" in stated:
            numbers["effort"] = stated["effort"]
        low, high = stated.get("lower"), stated.get("upper")
        if joint.get("type") != "continuous" and (low is None or high is None or low < high):
            numbers |= {"q_min": low} if low is not None else {}
            numbers |= {"q_max": high} if high is not None else {}
    for key in ("damping", "friction") if dynamics is not None else ():
        if number := float(dynamics.get(key, 0.0)):
            numbers[key] = number
    return numbers
