"""What became of the robot, counted in the finished .mbs."""

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
from urdf2mbs.urdf.changes import RobotChange, describe_changes


class Joints(msgspec.Struct):
    """How many joints there are; all but the first count those of the finished .mbs."""

    urdf: int
    mbs: int
    independent: int
    dependent: int
    driven: int
    per_degree_of_freedom: float

    def __str__(self) -> str:
        dependent = f"{self.dependent} dependent, " if self.dependent else ""
        joints = counted(self.mbs, "joint")
        return f"{joints}: {self.independent} independent, {dependent}{self.driven} driven"


class Report(msgspec.Struct):
    """What became of the robot; ``--json`` prints it."""

    robot: str
    source: str
    output: str
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    base_reason: str
    """Why it is so, in a word or two."""
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
    """Where each URDF link's frame is in the .mbs."""
    frozen: dict[str, str]
    """Moving URDF joints that are held at zero, and why."""
    changed: list[RobotChange]
    """What passes have changed of the robot that the URDF states."""
    left_out: dict[str, dict[str, dict[str, Any]]]
    """What the URDF's joints have and has found no place in the .mbs: every number by its name."""
    verdict: str
    """``NOT CHECKED``, ``NOT the same robot``, or ``the same robot`` with what it is but for, and
    what was not compared."""
    proof: Proof | None
    """What ``check`` found; None: it did not run."""
    diagnostics: list[Diagnostic]
    passes: dict[str, Any]
    """What passes have added, each under its name."""

    @property
    def no_dynamics(self) -> str:
        """Why no forces can move the robot; empty if they can."""
        if any(said.code == "no-mass" for said in self.diagnostics):
            return "NO DYNAMICS: no link has a mass"
        return f"NO DYNAMICS: the masses add up to {self.mass:.6g} kg" if self.mass < 0 else ""

    @property
    def base_in_words(self) -> str:
        """Whether the base floats, and why."""
        told = [said.message for said in self.diagnostics if said.code in ("base", "base-guessed")]
        return told[0] if told else f"{self.base} base"


def verdict(conversion: Conversion) -> str:
    """Whether the .mbs is the same robot, in words."""
    proof = conversion.checked.proof
    if proof is None:
        return NOT_CHECKED
    changes = [
        f"what {c.by} changed: {describe_changes(c.changes)}" for c in conversion.checked.changed
    ]
    return proof.describe(changes)


def report(conversion: Conversion) -> Report:
    """What became of the robot, counted in the .mbs as the last pass left it."""
    mbs, robot = conversion.mbs, conversion.robot
    natures = Counter(joint.nature for body in mbs.bodies for joint in body.joints)
    inserted = 1 if conversion.base.inserted else 0
    base, floating_joints = _floating(conversion)
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
            len(robot.joints) - inserted, natures.total(),
            natures["independent"], natures["dependent"], natures["driven"],
            natures.total() / max(natures["independent"], 1),
        ),
        mass=sum(body.mass or 0.0 for body in mbs.bodies),
        gravity=mbs.base.gravity,
        names=conversion.names, numbers=mbs.numbers(),
        frames=conversion.frames, frozen=conversion.frozen,
        changed=conversion.checked.changed, left_out=left_out(conversion),
        verdict=verdict(conversion), proof=conversion.checked.proof,
        diagnostics=conversion.diagnostics, passes=conversion.report,
    )  # fmt: skip


#: The parts of a joint that are not in an .mbs by themselves, and the code that says so.
PARTS = {
    "limit": "limit", "dynamics": "joint-dynamics", "mimic": "mimic",
    "safety_controller": "safety-controller", "calibration": "calibration",
}  # fmt: skip


def left_out(conversion: Conversion) -> dict[str, dict[str, dict[str, Any]]]:
    """By URDF joint that moves and part, each number with its name (units: those of URDF), if no
    pass has found a place for the part.

    A limit that is not there, as it is infinite or could not be read, is None.
    """
    kept = conversion.state(Placed).joints
    left_out: dict[str, dict[str, dict[str, Any]]] = {}
    for joint in conversion.robot.joints.values():
        parts = {
            part: msgspec.structs.asdict(value)
            for part, code in PARTS.items()
            if (value := getattr(joint, part)) and joint.name not in kept.get(code, ())
        }
        if joint.moves and parts:
            left_out[joint.name] = parts
    return left_out


def _floating(conversion: Conversion) -> tuple[str, list[str]]:
    """Whether the base floats in the .mbs, and the URDF's own joints that float there."""
    natures = {joint.name: joint.nature for body in conversion.mbs.bodies for joint in body.joints}
    coordinates = conversion.names.coordinates
    base, own = "fixed", []
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
                own.append(joint.name)
    return base, own
