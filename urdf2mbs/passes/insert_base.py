"""Insert base: the method's "Creation of the base element" (Figure A.4a).

"A proper MBS base element does not have any parent and does not have any inertial property": a
root link with inertia gets a parent link without inertia.  "The humanoid robots models are based
on a floating base representation [...] a 6-DOF joint": T1 T2 T3 R1 R2 R3.

A URDF does not say if the base floats.  The first of these rules that applies decides; welded
links are those that fixed joints attach to the root:

    ======================  =========================================  ========  =============
    reason                  rule                                       base      example
    ======================  =========================================  ========  =============
    own joint               a floating joint leads from the root       as it is  Walk-Man
    as asked                the config says ``fixed`` or ``floating``  as asked
    fixed by another        ``<gazebo>`` fixes the root to the world   fixed
    program
    world                   root or a welded link is called ``world``  fixed     UR5
    massless root           root and welded links have no mass         fixed     ABB IRB 2400
    free root               nothing moves, or two ends are wheels      floating  Leo rover
    one limb                one joint from the root, four in all, and  fixed     Franka FR3
                            no name of a wheel or a propeller
    two arms                two limbs of four joints rise above the    fixed     two FR3
                            root, with at most a head beside them
    free root               otherwise                                  floating  Atlas
    ======================  =========================================  ========  =============

The last four rules guess.  A guess that may well be wrong is a warning; all else is a note:

* massless root: the root has a mass that is only an estimate;
* one limb: links are named as those of a leg, so it may be a hopper;
* two arms: always;
* free root, if no name is one of a wheel or a propeller: the root carries one limb; or two limbs
  below it, and no link is named as a leg's; or the robot rests on its root, as a hand does.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.names import free_name
from urdf2mbs.states import Estimates
from urdf2mbs.urdf.model import Joint, Link, Robot

#: A limb has at least this many moving joints; fewer may be a sensor or a head.
MIN_LIMB_JOINTS = 4
#: An arm of which some joints are fixed has at least this many links with mass in a row, ...
MIN_ARM_LINKS = 6
#: ... and at least this many moving joints.
MIN_ARM_JOINTS = 3
#: A limb on wheels has at least this many ends that turn without limits; an arm may have one.
MIN_WHEELS = 2
#: A head beside two arms has at most this many joints.
MAX_HEAD_JOINTS = 1
#: The origins of the links of arms are above the root, by more than this in all (m).
MIN_RISE = 1e-6
#: Name of a robot or link that rolls, flies or swims, though no joint may turn its wheels.
DRIVE_NAME = re.compile(r"wheel|caster|propell|rotor|copter|thruster|flying", re.IGNORECASE)
#: Name of a link that is part of a leg, and not of an arm.
LEG_NAME = re.compile(r"leg|foot|feet|ankle|hip|thigh|calf|shank|tibia", re.IGNORECASE)
#: Why the base floats or not, by the reason that is guessed.
EXPLANATIONS = {
    "one limb": "{} carries one limb, and no wheels or propellers, as an arm's foot does",
    "two arms": "{} carries two limbs that rise above it, as a torso carries arms",
    "free root": "nothing ties {} to the world, and it has mass",
}


class InsertBase(Pass):
    """Decide if the base floats, and insert the joint that attaches the root to it."""

    reads = ("robot",)
    writes = ("robot", "base")

    def run(self, conversion: Conversion) -> None:
        """Decide, report the decision, and insert a base link if the root cannot be the base."""
        conversion.mbs.base.gravity = conversion.settings.config.gravity
        decision = _decide(conversion)
        conversion.base.floating = decision.floats
        conversion.base.reason = decision.reason
        _report(conversion, decision)
        robot = conversion.robot
        # A robot of one link without mass must have a body, too.
        if decision.floats or not robot.links[robot.root()].massless or not robot.joints:
            _insert_base(conversion, "floating" if decision.floats else "fixed")


class Decision(NamedTuple):
    """If the base floats, and why."""

    floats: bool
    reason: str
    explanation: str
    is_doubtful: bool = False
    """True if it is a guess that may well be wrong."""


def _decide(conversion: Conversion) -> Decision:
    """Apply the rules at the top of this file."""
    robot = conversion.robot
    root = robot.root()
    base = conversion.settings.config.base
    welded_links, floating_joint = _find_welded_links(robot)
    if floating_joint is not None:
        return Decision(False, "own joint", f"joint '{floating_joint}' lets it float")
    if base != "auto":
        return Decision(base == "floating", "as asked", "as asked for")
    if robot.fixed_by:
        explanation = f"{robot.fixed_by} ties the root to the world"
        return Decision(False, "fixed by another program", explanation)
    if "world" in welded_links:
        relation = "called" if root == "world" else "welded to"
        return Decision(False, "world", f"root link '{root}' is {relation} world")
    estimated_links = set(conversion.state(Estimates).links or ())
    if not any(_get_mass(robot.links[link]) for link in welded_links - estimated_links):
        explanation = f"root link '{root}' has no mass, nor has what is fixed to it"
        is_doubtful = not welded_links.isdisjoint(estimated_links)
        return Decision(False, "massless root", explanation, is_doubtful)
    reason, is_doubtful = _guess(robot, welded_links)
    explanation = EXPLANATIONS[reason].format(f"root link '{root}'")
    return Decision(reason == "free root", reason, explanation, is_doubtful)


def _find_welded_links(robot: Robot) -> tuple[set[str], str | None]:
    """Find the root with the links fixed to it, and the first floating joint that leaves them."""
    children = robot.children()
    root = robot.root()
    welded_links, pending, floating_joint = {root}, [root], None
    while pending:
        for joint in children[pending.pop()]:
            if not joint.moves:
                welded_links.add(joint.child)
                pending.append(joint.child)
            elif joint.type == "floating":
                floating_joint = floating_joint or joint.name
    return welded_links, floating_joint


class Limbs(NamedTuple):
    """The limbs that a root carries, each on a moving joint."""

    lengths: list[int]
    """For each limb, the most moving joints in a row; the longest limb first."""
    n_joints: int
    """Moving joints of all limbs together."""
    n_wheels: int
    """Ends of limbs that turn without limits."""
    n_links: int
    """The most links with mass in a row, the root excluded."""
    on_cart: bool
    """True if the first limb is on a planar joint, which leads to a cart."""


def _measure_limbs(robot: Robot, welded_links: set[str]) -> Limbs:
    """Measure the limbs of a robot, from the tips to the root."""
    moving_joints = [joint for joint in robot.joints.values() if joint.moves]
    n_joints: dict[str, int] = {}  # the most moving joints in a row, from each link outwards
    n_links: dict[str, int] = {}  # the most links with mass in a row, likewise
    for joint in reversed(robot.depth_first()):
        has_mass = _get_mass(robot.links[joint.child]) > 0.0
        for longest, is_counted in ((n_joints, joint.moves), (n_links, has_mass)):
            length = longest.get(joint.child, 0) + is_counted
            longest[joint.parent] = max(length, longest.get(joint.parent, 0))
    children = robot.children()
    first_joints = [joint for link in welded_links for joint in children[link] if joint.moves]
    lengths = sorted((1 + n_joints.get(joint.child, 0) for joint in first_joints), reverse=True)
    wheels = [
        joint
        for joint in moving_joints
        if joint.type == "continuous" and not n_joints.get(joint.child)
    ]
    on_cart = bool(first_joints) and first_joints[0].type == "planar"
    return Limbs(lengths, len(moving_joints), len(wheels), n_links.get(robot.root(), 0), on_cart)


def _guess(robot: Robot, welded_links: set[str]) -> tuple[str, bool]:
    """Guess if the base floats, from the limbs that the root carries.

    Returns:
        A key of ``EXPLANATIONS``, and True if the guess may well be wrong.
    """
    limbs = _measure_limbs(robot, welded_links)
    if not limbs.n_joints or limbs.n_wheels >= MIN_WHEELS:
        return "free root", False
    drives = any(DRIVE_NAME.search(name) for name in (robot.name, *welded_links))
    has_legs = any(LEG_NAME.search(link) for link in robot.links)
    has_one_limb = len(limbs.lengths) == 1 and not limbs.on_cart
    min_joints = MIN_ARM_JOINTS if limbs.n_links >= MIN_ARM_LINKS else MIN_LIMB_JOINTS
    if has_one_limb and limbs.n_joints >= min_joints and not drives:
        return "one limb", has_legs

    heights = {link: pose.xyz[2] for link, pose in robot.poses().items()}
    root_height = min(heights[link] for link in welded_links)
    rise = sum(height - root_height for link, height in heights.items() if link not in welded_links)
    has_two_limbs = (
        len(limbs.lengths) > 1
        and limbs.lengths[1] >= MIN_LIMB_JOINTS
        and sum(limbs.lengths[2:]) <= MAX_HEAD_JOINTS
    )
    if has_two_limbs and rise > MIN_RISE:
        return "two arms", True
    may_be_arms = has_one_limb or (has_two_limbs and not has_legs)
    rests_on_root = root_height <= min(heights.values())
    return "free root", not drives and (may_be_arms or rests_on_root)


def _get_mass(link: Link) -> float:
    """Return the mass of a link (kg); 0 without an inertial."""
    return 0.0 if link.inertial is None else link.inertial.mass


def _report(conversion: Conversion, decision: Decision) -> None:
    """Note the decision, or warn if it may well be wrong."""
    root = conversion.robot.root()
    floats = decision.floats or decision.reason == "own joint"
    message = f"{'floating' if floats else 'fixed'} base: {decision.explanation}"
    if decision.is_doubtful:
        guess, alternative = ("floating", "fixed") if floats else ("fixed", "floating")
        hint = f"'base: {alternative}', if the guess is wrong; 'base: {guess}' ends this warning"
        conversion.warn("base-guessed", message, link=root, hint=hint)
    else:
        conversion.note("base", message, link=root)


def _insert_base(conversion: Conversion, joint_type: str) -> None:
    """Give the root a parent link without inertia, on a joint of this type."""
    robot = conversion.robot
    names = robot.links.keys() | robot.joints.keys()
    ground = free_name("ground", names)
    joint = Joint(free_name(f"{joint_type}_base", names), joint_type, ground, robot.root())
    conversion.base.inserted = joint.name
    conversion.robot = msgspec.structs.replace(
        robot,
        links={ground: Link(ground), **robot.links},
        joints={joint.name: joint, **robot.joints},
    )
