"""Joints that follow others by the elements of other programs, as URDF's ``<mimic>`` couples them.

``<ros2_control>`` couples a joint by parameters (gz_ros2_control and gazebo_ros2_control)::

    <joint name="right"><param name="mimic">left</param><param name="multiplier">-1</param></joint>

and plugins of Gazebo Classic by elements::

    <plugin filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">
      <joint>left</joint> <mimicJoint>right</mimicJoint> <multiplier>-1</multiplier>
    </plugin>
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import ConversionError, Mimic, nearest

if TYPE_CHECKING:
    from urdf2mbs.plugin import Reading, Robot


class FollowerReader:
    """Couples the joints of a robot, once its links and joints are known."""

    def __init__(self, reading: Reading, robot: Robot) -> None:
        self.reading = reading
        self.robot = robot
        self.sources: dict[str, str] = {}
        """What coupled each joint that the URDF does not couple, as a message names it."""

    def read_ros2_control(self, element: Any) -> None:
        """Couple the joints of a ``<ros2_control>`` with a parameter or attribute ``mimic``."""
        for joint in element.iterchildren("joint"):
            name = joint.get("name") or ""
            parameters = {part.get("name"): part for part in joint.iterchildren("param")}
            if "mimic" in parameters:
                leader = get_text(parameters["mimic"])
                numbers = (parameters.get("multiplier"), parameters.get("offset"))
                self.couple(name, leader, numbers, joint, "<ros2_control>")
            switch = (joint.get("mimic") or "").lower()
            if name in self.robot.joints and switch in ("true", "false"):
                is_follower = self.robot.joints[name].mimic is not None
                if is_follower != (switch == "true"):
                    state = "has a <mimic>" if is_follower else "has no <mimic>"
                    message = (
                        f'<ros2_control> says mimic="{switch}" of a joint that {state} in the URDF'
                    )
                    owner, line = ("joint", name), joint.sourceline
                    self.reading.warn("mimic-conflict", message, line, owner=owner)

    def read_plugin(self, plugin: Any) -> None:
        """Couple the joints of a mimic plugin of Gazebo; warn if it does not name them."""
        follower, leader = get_text(plugin.find("mimicJoint")), get_text(plugin.find("joint"))
        if not follower or not leader:
            message = "a mimic plugin in <gazebo> has no <joint> or no <mimicJoint>: it is not read"
            self.reading.warn("mimic-left-out", message, plugin.sourceline)
            return
        numbers = (plugin.find("multiplier"), plugin.find("offset"))
        self.couple(follower, leader, numbers, plugin, "a plugin of <gazebo>")

    def couple(
        self, follower: str, leader: str, numbers: tuple[Any, Any], element: Any, source: str
    ) -> None:
        """Couple a joint to another, unless the URDF couples it otherwise.

        The reader of the URDF warns of a leader that does not exist.

        Args:
            follower: The name of the joint that follows.
            leader: The name of the joint that it follows.
            numbers: The elements with the multiplier and the offset; None if they are missing.
            element: The element of lxml that couples them.
            source: The element, as a message names it.
        """
        owner, line = ("joint", follower), element.sourceline
        joint = self.robot.joints.get(follower)
        if joint is None:
            hint = nearest(follower, self.robot.joints)
            message = f"{source} couples a joint that does not exist to '{leader}'"
            self.reading.warn("mimic-left-out", message, line, owner=owner, hint=hint)
            return
        try:
            rule = self._read_rule(leader, *numbers)
        except ConversionError as error:
            message = f"{source} does not couple a joint: {error.message}"
            hint = "write a number, such as -1.0"
            self.reading.warn("mimic-left-out", message, line, owner=owner, hint=hint)
            return
        if joint.mimic is None:
            joint.mimic = rule
            self.sources[follower] = source
        elif self._resolve(joint.mimic) != self._resolve(rule):
            first = self.sources.get(follower, "<mimic>")
            message = f"{first} and {source} contradict one another: {first} is used"
            detail = f"{follower} = {joint.mimic}, and {follower} = {rule}"
            self.reading.warn("mimic-conflict", message, line, owner=owner, detail=detail)

    def _read_rule(self, leader: str, multiplier: Any, offset: Any) -> Mimic:
        """Return the rule of a follower; raise ConversionError if a number cannot be read."""
        rule = Mimic(leader)
        if multiplier is not None:
            rule.multiplier = self.reading.number(multiplier, "multiplier", get_text(multiplier))
        if offset is not None:
            rule.offset = self.reading.number(offset, "offset", get_text(offset))
        return rule

    def _resolve(self, rule: Mimic) -> Mimic:
        """Return a rule by the leader at the end of its chain, or by a joint of its circle."""
        visited: set[str] = set()
        while rule.joint not in visited and rule.joint in self.robot.joints:
            visited.add(rule.joint)
            leader_rule = self.robot.joints[rule.joint].mimic
            if leader_rule is None:
                break
            offset = rule.offset + rule.multiplier * leader_rule.offset
            multiplier = rule.multiplier * leader_rule.multiplier
            rule = Mimic(leader_rule.joint, multiplier, offset)
        return rule


def get_text(element: Any) -> str:
    """Return the text of an element, without comments and without blanks around it."""
    if element is None:
        return ""
    text = str(element.xpath("string()")) if len(element) else element.text or ""
    return text.strip()


def read_number(reading: Reading, element: Any, name: str) -> float | None:
    """Return the number in an attribute ``value`` or text; None, after a warning, if it has none.

    Args:
        reading: The URDF that is read.
        element: The element of lxml.
        name: The element, as a message names it.
    """
    try:
        return reading.number(element, "the text", element.get("value") or get_text(element))
    except ConversionError as error:
        reading.warn_of_left_out(element, name, error)
        return None
