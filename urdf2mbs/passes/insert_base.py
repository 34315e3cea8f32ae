"""Insert the base: the method's "Creation of the base element" (Figure A.4a).

"A proper MBS base element does not have any parent and does not have any inertial
property": a root link with inertia gets a link without above it.  "The humanoid robots
models are based on a floating base representation [...] a 6-DOF joint": T1 T2 T3 R1 R2 R3.
"""

from __future__ import annotations

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import NoOptions, Pass
from urdf2mbs.urdf.model import Joint, Link, Robot


def run(conversion: Conversion, options: NoOptions) -> None:
    robot = conversion.robot
    conversion.mbs.base.gravity = conversion.settings.gravity
    root = robot.root()
    welded, floating = _welded_to(robot, root)
    asked = conversion.settings.base

    if floating is not None:
        conversion.floating = False
        why = f"joint '{floating}' already lets it float"
    elif asked != "auto":
        conversion.floating = asked == "floating"
        why = "as asked for"
    elif "world" in welded:
        conversion.floating = False
        why = f"root link '{root}' is " + ("called" if root == "world" else "welded to") + " world"
    else:
        conversion.floating = True
        why = f"nothing ties root link '{root}' to the world"
    kind = "floating" if conversion.floating else "fixed"
    conversion.note("base", f"{kind} base: {why}", link=root)

    # a robot of one link without mass must have a body, too
    if conversion.floating or not robot.links[root].massless or not robot.joints:
        ground = _unused("ground", robot)
        joint = Joint(
            name=_unused(f"{kind}_base", robot), type=kind,
            parent=ground, child=root,
        )  # fmt: skip
        conversion.inserted = joint.name
        conversion.robot = msgspec.structs.replace(
            robot,
            links={ground: Link(ground), **robot.links},
            joints={joint.name: joint, **robot.joints},
        )


def _welded_to(robot: Robot, root: str) -> tuple[set[str], str | None]:
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


def _unused(name: str, robot: Robot) -> str:
    taken = robot.links.keys() | robot.joints.keys()
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    return free


PASS = Pass("insert-base", run, changes=("robot",), gives=("base",))
