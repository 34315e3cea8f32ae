"""The report of a conversion: what became of the robot, counted in the finished .mbs."""

from __future__ import annotations

from collections import Counter
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion, Names
from urdf2mbs.mbs.model import LinkFrame
from urdf2mbs.messages.diagnostics import Diagnostic, counted
from urdf2mbs.proof.verdict import NOT_CHECKED, Proof
from urdf2mbs.spatial import Vec
from urdf2mbs.states import Placed
from urdf2mbs.urdf.changes import RobotChange


class Joints(msgspec.Struct):
    """The numbers of joints; all but the first are of the finished .mbs."""

    urdf: int
    mbs: int
    independent: int
    dependent: int
    driven: int
    per_degree_of_freedom: float

    def __str__(self) -> str:
        """Return the numbers in words."""
        dependent = f"{self.dependent} dependent, " if self.dependent else ""
        joints = counted(self.mbs, "joint")
        return f"{joints}: {self.independent} independent, {dependent}{self.driven} driven"


class Report(msgspec.Struct):
    """The result of a conversion; ``--json`` prints it."""

    robot: str
    source: str
    output: str
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    base_reason: str
    """The reason for it, in a word or two."""
    floating_joints: list[str]
    """The URDF's own floating joints that are free in the .mbs."""
    links: int
    bodies: int
    joints: Joints
    mass: float
    """kg, of all bodies."""
    gravity: Vec
    """m/s^2, in base axes."""
    names: Names
    numbers: dict[str, int]
    """The number that Robotran gives each .mbs joint."""
    frames: dict[str, LinkFrame]
    """The place of each URDF link's frame in the .mbs."""
    frozen: dict[str, str]
    """The URDF joints that are locked at zero, and why."""
    changed: list[RobotChange]
    """The changes of the URDF's robot by passes."""
    left_out: dict[str, dict[str, dict[str, Any]]]
    """The numbers of URDF joints that are not in the .mbs: by joint, part and name."""
    verdict: str
    """``NOT CHECKED``, ``NOT the same robot``, or ``the same robot`` with the exceptions: intended
    changes, and properties that were not compared."""
    proof: Proof | None
    """The result of ``check``; None: it did not run."""
    robot_settings: dict[str, Any]
    """What the robot's own file states of the config's keys, and the config does not overrule."""
    diagnostics: list[Diagnostic]
    passes: dict[str, Any]
    """The parts of the report by passes, each under its name."""

    @property
    def no_dynamics(self) -> str:
        """The reason why no force can move the robot; empty if forces can."""
        if any(diagnostic.code == "no-mass" for diagnostic in self.diagnostics):
            return "NO DYNAMICS: no link has a mass"
        return f"NO DYNAMICS: the masses add up to {self.mass:.6g} kg" if self.mass < 0 else ""

    @property
    def base_in_words(self) -> str:
        """Whether the base floats, and why."""
        for diagnostic in self.diagnostics:
            if diagnostic.code in ("base", "base-guessed"):
                return diagnostic.message
        return f"{self.base} base"


def verdict(conversion: Conversion) -> str:
    """Return whether the .mbs is the same robot, in words."""
    proof = conversion.checked.proof
    if proof is None:
        return NOT_CHECKED
    return proof.describe([change.describe() for change in conversion.checked.changed])


def report(conversion: Conversion) -> Report:
    """Return the report of a conversion, counted in the .mbs as the last pass left it."""
    mbs, robot = conversion.mbs, conversion.robot
    natures = Counter(joint.nature for body in mbs.bodies for joint in body.joints)
    inserted = 1 if conversion.base.inserted else 0
    base, floating_joints = _find_floating(conversion)
    return Report(
        robot=robot.name,
        source=str(conversion.settings.source),
        output=str(conversion.settings.output),
        base=base,
        base_reason=conversion.base.reason,
        floating_joints=floating_joints,
        links=len(robot.links) - inserted,
        bodies=len(mbs.bodies),
        joints=Joints(
            urdf=len(robot.joints) - inserted,
            mbs=natures.total(),
            independent=natures["independent"],
            dependent=natures["dependent"],
            driven=natures["driven"],
            per_degree_of_freedom=natures.total() / max(natures["independent"], 1),
        ),
        mass=sum(body.mass or 0.0 for body in mbs.bodies),
        gravity=mbs.base.gravity,
        names=conversion.names,
        numbers=mbs.numbers(),
        frames=conversion.frames,
        frozen=conversion.frozen,
        changed=conversion.checked.changed,
        left_out=left_out(conversion),
        verdict=verdict(conversion),
        proof=conversion.checked.proof,
        robot_settings=conversion.input.settings,
        diagnostics=conversion.diagnostics,
        passes=conversion.report,
    )


def list_robot_settings(conversion: Conversion) -> list[str]:
    """Return the keys of a config that the robot's own file has set: ``rotors.armature (12)``.

    The number is that of the entries of a block.
    """
    settings = conversion.input.settings
    names = []
    if "base" in settings:
        names.append(f"base {settings['base']}")
    if "gravity" in settings:
        names.append("gravity " + " ".join(f"{number:g}" for number in settings["gravity"]))
    for pass_name, options in settings.get("passes", {}).items():
        for option, value in options.items():
            count = f" ({len(value)})" if isinstance(value, (dict, list)) else ""
            names.append(f"{pass_name}.{option}{count}")
    return names


#: The parts of a URDF joint for which an .mbs has no element, and the code of the note about each.
PARTS = {
    "limit": "limit",
    "dynamics": "joint-dynamics",
    "mimic": "mimic",
    "safety_controller": "safety-controller",
    "calibration": "calibration",
}


def left_out(conversion: Conversion) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the numbers of moving URDF joints for which no pass has found a place.

    Returns:
        For each joint and part its numbers by name, in the units of URDF.  A limit that is
        infinite, or could not be read, is None.
    """
    placed = conversion.state(Placed).joints
    numbers: dict[str, dict[str, dict[str, Any]]] = {}
    for joint in conversion.robot.joints.values():
        parts = {
            part: msgspec.structs.asdict(value)
            for part, code in PARTS.items()
            if (value := getattr(joint, part)) and joint.name not in placed.get(code, ())
        }
        if joint.moves and parts:
            numbers[joint.name] = parts
    return numbers


def _find_floating(conversion: Conversion) -> tuple[str, list[str]]:
    """Return whether the base floats, as a word, and the URDF's floating joints that are free."""
    natures = {joint.name: joint.nature for body in conversion.mbs.bodies for joint in body.joints}
    coordinates = conversion.names.coordinates
    base, floating_joints = "fixed", []
    rigid = {conversion.robot.root()} if conversion.robot.links else set()
    for joint in conversion.robot.depth_first() if rigid else ():
        if not joint.moves and joint.parent in rigid:
            rigid.add(joint.child)
        names = coordinates.get(joint.name, ())
        if joint.name in conversion.frozen or joint.type != "floating":
            continue
        if all(natures.get(n) == "independent" for n in names):
            if joint.parent in rigid:
                base = "floating"
            if joint.name != conversion.base.inserted and names:
                floating_joints.append(joint.name)
    return base, floating_joints
