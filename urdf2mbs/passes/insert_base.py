"""Insert the base: the method's "Creation of the base element" (Figure A.4a).

"A proper MBS base element does not have any parent and does not have any inertial
property": a root link with inertia gets a parent link without inertia.  "The humanoid robots
models are based on a floating base representation [...] a 6-DOF joint": T1 T2 T3 R1 R2 R3.

A URDF does not say if the base floats.  With ``auto`` the base floats if the root has mass and is
not tied to the world.  A root without mass is the foot of an arm: if it floated, the mass matrix
would be singular.
"""

from __future__ import annotations

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.names import free_name
from urdf2mbs.urdf.model import Joint, Link, Robot


class InsertBase(Pass):
    reads = ("robot",)
    writes = ("robot", "base")

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        conversion.mbs.base.gravity = conversion.settings.config.gravity
        root = robot.root()
        welded, floating = _find_welded(robot, root)
        asked = conversion.settings.config.base

        floats = False
        if floating is not None:
            reason, why = "own joint", f"joint '{floating}' lets it float, so none is added"
        elif asked != "auto":
            floats, reason, why = asked == "floating", "as asked", "as asked for"
        elif "world" in welded:
            reason = "world"
            why = f"root link '{root}' is {'called' if root == 'world' else 'welded to'} world"
        elif not any(_mass(robot.links[link]) for link in welded):
            reason, why = (
                "massless root",
                f"root link '{root}' has no mass, nor has what is fixed to it",
            )
        else:
            floats, reason = True, "free root"
            why = f"nothing ties root link '{root}' to the world, and it has mass"
        conversion.floating, conversion.base_reason = floats, reason
        kind = "floating" if floats else "fixed"
        conversion.note("base", why if floating else f"{kind} base: {why}", link=root)

        # a robot of one link without mass must have a body, too
        if floats or not robot.links[root].massless or not robot.joints:
            taken = robot.links.keys() | robot.joints.keys()
            ground = free_name("ground", taken)
            joint = Joint(free_name(f"{kind}_base", taken), kind, ground, root)
            conversion.inserted = joint.name
            conversion.robot = msgspec.structs.replace(
                robot,
                links={ground: Link(ground), **robot.links},
                joints={joint.name: joint, **robot.joints},
            )


def _mass(link: Link) -> float:
    return 0.0 if link.inertial is None else link.inertial.mass


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
