"""Joints that follow others by the elements of other programs, as URDF's ``<mimic>`` couples them.

``<ros2_control>`` couples a joint by parameters (gz_ros2_control and gazebo_ros2_control)::

    <joint name="right"><param name="mimic">left</param><param name="multiplier">-1</param></joint>

and the plugins of Gazebo Classic whose file is called ``mimic`` by elements::

    <plugin filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">
      <joint>left</joint> <mimicJoint>right</mimicJoint> <multiplier>-1</multiplier>
    </plugin>
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.urdf.model import Mimic

if TYPE_CHECKING:
    from urdf2mbs.urdf.model import Robot
    from urdf2mbs.urdf.values import Reading


def read_ros2_control(reading: Reading, robot: Robot, element: Any) -> None:
    """Couple the joints of a ``<ros2_control>`` that have a parameter or attribute ``mimic``."""
    for joint in element.iterchildren("joint"):
        name = joint.get("name") or ""
        parameters = {parameter.get("name"): parameter for parameter in joint.iterchildren("param")}
        if "mimic" in parameters:
            leader = get_text(parameters["mimic"])
            rule = _read_rule(
                reading, leader, parameters.get("multiplier"), parameters.get("offset")
            )
            couple(reading, robot, name, rule, joint, "<ros2_control>")
        switch = (joint.get("mimic") or "").lower()
        if name in robot.joints and switch in ("true", "false"):
            has_rule = robot.joints[name].mimic is not None
            if has_rule != (switch == "true"):
                has = "has a <mimic>" if has_rule else "has no <mimic>"
                message = f'<ros2_control> says mimic="{switch}" of a joint that {has} in the URDF'
                reading.warn("mimic-conflict", message, joint.sourceline, owner=("joint", name))


def read_mimic_plugin(reading: Reading, robot: Robot, plugin: Any) -> None:
    """Couple the joints of a Gazebo plugin; warn if it does not name them."""
    follower, leader = plugin.find("mimicJoint"), plugin.find("joint")
    if follower is None or leader is None:
        message = "a mimic plugin in <gazebo> has no <joint> or no <mimicJoint>, and is not read"
        reading.warn("mimic-left-out", message, plugin.sourceline)
        return
    rule = _read_rule(reading, get_text(leader), plugin.find("multiplier"), plugin.find("offset"))
    couple(reading, robot, get_text(follower), rule, plugin, "a plugin of <gazebo>")


def _read_rule(reading: Reading, leader: str, multiplier: Any, offset: Any) -> Mimic | None:
    """Return how a joint follows its leader; None, after a warning, if a number is unreadable."""
    rule = Mimic(leader)
    try:
        if multiplier is not None:
            rule.multiplier = reading.number(multiplier, "the text", get_text(multiplier))
        if offset is not None:
            rule.offset = reading.number(offset, "the text", get_text(offset))
    except ConversionError as error:
        reading.warn("mimic-left-out", f"a joint moves freely: {error.message}", error.line)
        return None
    return rule


def couple(
    reading: Reading, robot: Robot, follower: str, rule: Mimic | None, element: Any, source: str
) -> None:
    """Let a joint follow another, unless the URDF says otherwise.

    The reader of the URDF warns of a leader that does not exist.

    Args:
        reading: The file being read.
        robot: The robot, whose joint gets the rule.
        follower: The name of the joint that follows.
        rule: How it follows; None: unreadable.
        element: The element of lxml that says so.
        source: The element, as a message names it.
    """
    if rule is None:
        return
    joint = robot.joints.get(follower)
    owner, line = ("joint", follower), element.sourceline
    if joint is None:
        hint = nearest(follower, robot.joints)
        message = f"{source} lets a joint follow '{rule.joint}' that does not exist"
        reading.warn("mimic-left-out", message, line, owner=owner, hint=hint)
    elif joint.mimic is None:
        joint.mimic = rule
    elif joint.mimic != rule:
        message = f"<mimic> of the joint and {source} contradict one another: <mimic> is used"
        detail = f"{follower} = {joint.mimic}, and {follower} = {rule}"
        reading.warn("mimic-conflict", message, line, owner=owner, detail=detail)


def get_text(element: Any) -> str:
    """Return the text of an element, without comments and without blanks around it."""
    if element is None:
        return ""
    text = str(element.xpath("string()")) if len(element) else element.text or ""
    return text.strip()
