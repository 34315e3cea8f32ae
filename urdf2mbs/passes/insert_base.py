"""Insert base: the method's "Creation of the base element" (Figure A.4a).

"A proper MBS base element does not have any parent and does not have any inertial
property": a root link with inertia gets a parent link without inertia.  "The humanoid robots
models are based on a floating base representation [...] a 6-DOF joint": T1 T2 T3 R1 R2 R3.

A URDF does not say if the base floats, so ``auto`` guesses; ``docs/passes/insert-base.md`` has the
rules.  A guess is a warning if it may well be wrong: the root has mass and carries two arms or one
leg, or the robot has no wheels and stands on its root.  One arm is bolted down: a note.
"""

from __future__ import annotations

import re

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.names import free_name
from urdf2mbs.states import Estimates
from urdf2mbs.urdf.model import Joint, Link, Robot

#: A limb has at least so many moving joints; less may be a sensor or a head.
LIMB = 4
#: An arm of which some joints are fixed has so many links with mass in a row, and joints that move.
LINKS, MOVING = 6, 3
#: What a robot or a link is called that rolls, flies or swims, though no joint may turn it.
DRIVES = re.compile(r"wheel|caster|propell|rotor|copter|thruster|flying", re.IGNORECASE)
#: What a link is called that is no arm's.
LEGS = re.compile(r"leg|foot|feet|ankle|hip|thigh|calf|shank|tibia", re.IGNORECASE)
#: A limb on wheels has at least so many ends that turn without limits; an arm may have one.
WHEELS = 2
#: A head beside two arms has at most so many joints, and the links of arms rise by more (m).
HEAD, LEVEL = 1, 1e-6
#: What the limbs say of the root.
WHY = {
    "one limb": "{} carries one limb, and no wheels or propellers, as an arm's foot does",
    "two arms": "{} carries two limbs that rise above it, as a torso carries arms",
    "free root": "nothing ties {} to the world, and it has mass",
}


class InsertBase(Pass):
    reads = ("robot",)
    writes = ("robot", "base")

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        conversion.mbs.base.gravity = conversion.settings.config.gravity
        root = robot.root()
        welded, floating = _find_welded(robot, root)
        asked = conversion.settings.config.base
        estimated = set(conversion.state(Estimates).links or ())

        floats = guessed = False
        if floating is not None:
            reason, why = "own joint", f"joint '{floating}' lets it float"
        elif asked != "auto":
            floats, reason, why = asked == "floating", "as asked", "as asked for"
        elif robot.fixed_by:
            reason, why = "fixed by another program", f"{robot.fixed_by} ties the root to the world"
        elif "world" in welded:
            reason = "world"
            why = f"root link '{root}' is {'called' if root == 'world' else 'welded to'} world"
        elif not any(_mass(robot.links[link]) for link in welded - estimated):
            reason = "massless root"
            why = f"root link '{root}' has no mass, nor has what is fixed to it"
            guessed = not welded.isdisjoint(estimated)
        else:
            reason, guessed = _guess(robot, welded)
            floats, why = reason == "free root", WHY[reason].format(f"root link '{root}'")
        conversion.base.floating, conversion.base.reason = floats, reason
        kind = "floating" if floats else "fixed"
        text = f"{'floating' if floating else kind} base: {why}"
        if guessed:
            other = "fixed" if floats else "floating"
            hint = f"'base: {other}', if the guess is wrong; 'base: {kind}' ends this warning"
            conversion.warn("base-guessed", text, link=root, hint=hint)
        else:
            conversion.note("base", text, link=root)

        # a robot of one link without mass must have a body, too
        if floats or not robot.links[root].massless or not robot.joints:
            taken = robot.links.keys() | robot.joints.keys()
            ground = free_name("ground", taken)
            joint = Joint(free_name(f"{kind}_base", taken), kind, ground, root)
            conversion.base.inserted = joint.name
            conversion.robot = msgspec.structs.replace(
                robot,
                links={ground: Link(ground), **robot.links},
                joints={joint.name: joint, **robot.joints},
            )


def _mass(link: Link) -> float:
    return 0.0 if link.inertial is None else link.inertial.mass


def _guess(robot: Robot, welded: set[str]) -> tuple[str, bool]:
    """Why the base floats, or does not, by the limbs of the robot; and if this may well be wrong.

    A planar joint is no limb's: it leads to a cart.
    """
    children = robot.children()
    first = [joint for link in welded for joint in children[link] if joint.moves]
    moving = [joint for joint in robot.joints.values() if joint.moves]
    reach: dict[str, int] = {}  # the most joints that move in a row, from a link outwards
    row: dict[str, int] = {}  # the most links with mass in a row, likewise
    for joint in reversed(robot.depth_first()):
        heavy = _mass(robot.links[joint.child]) > 0.0
        for most, counts in ((reach, joint.moves), (row, heavy)):
            count = most.get(joint.child, 0) + counts
            most[joint.parent] = max(count, most.get(joint.parent, 0))
    turning = [j for j in moving if not reach.get(j.child) and j.type == "continuous"]
    if not moving or len(turning) >= WHEELS:
        return "free root", False
    one = len(first) == 1 and first[0].type != "planar"
    driven = any(DRIVES.search(name) for name in (robot.name, *welded))
    legs = any(LEGS.search(link) for link in robot.links)
    arm = len(moving) >= (MOVING if row.get(robot.root(), 0) >= LINKS else LIMB)
    if one and arm and not driven:
        return "one limb", legs
    heights = {link: pose.xyz[2] for link, pose in robot.poses().items()}
    foot = min(heights[link] for link in welded)
    rise = sum(height - foot for link, height in heights.items() if link not in welded)
    limbs = sorted((1 + reach.get(joint.child, 0) for joint in first), reverse=True)
    two = len(limbs) > 1 and limbs[1] >= LIMB and sum(limbs[2:]) <= HEAD
    if two and rise > LEVEL:
        return "two arms", True
    arms = one or (two and not legs)
    return "free root", not driven and (arms or foot <= min(heights.values()))


def _find_welded(robot: Robot, root: str) -> tuple[set[str], str | None]:
    """The links rigid with the root, and the first floating joint that leaves them."""
    children = robot.children()
    welded, todo, floating = {root}, [root], None
    while todo:
        for joint in children[todo.pop()]:
            if not joint.moves:
                welded.add(joint.child)
                todo.append(joint.child)
            elif joint.type == "floating":
                floating = floating or joint.name
    return welded, floating
