"""Insert the base: the method's "Creation of the base element" (Figure A.4a).

"A proper MBS base element does not have any parent and does not have any inertial
property": a root link with inertia gets a link without above it.  "The humanoid robots
models are based on a floating base representation [...] a 6-DOF joint": T1 T2 T3 R1 R2 R3.

Whether it floats is not in the URDF.  By ``auto`` it does if it can: if the root is not tied to
the world, and has mass.  A floating root without mass is an arm's foot, and its mass matrix
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
        welded, floating = _welded_to(robot, root)
        asked = conversion.settings.config.base

        if floating is not None:
            conversion.floating, conversion.base_reason = False, "own joint"
            why = f"joint '{floating}' lets it float, so none is added"
        elif asked != "auto":
            conversion.floating, conversion.base_reason = asked == "floating", "as asked"
            why = "as asked for"
        elif "world" in welded:
            conversion.floating, conversion.base_reason = False, "world"
            why = (
                f"root link '{root}' is "
                + ("called" if root == "world" else "welded to")
                + " world"
            )
        elif not any(_mass(robot.links[link]) for link in welded):
            conversion.floating, conversion.base_reason = False, "massless root"
            why = f"root link '{root}' has no mass, nor has what is fixed to it"
        else:
            conversion.floating, conversion.base_reason = True, "free root"
            why = f"nothing ties root link '{root}' to the world, and it has mass"
        kind = "floating" if conversion.floating else "fixed"
        said = why if floating is not None else f"{kind} base: {why}"
        conversion.note("base", said, link=root)

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


def _mass(link: Link) -> float:
    return 0.0 if link.inertial is None else link.inertial.mass


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
    return free_name(name, robot.links.keys() | robot.joints.keys())
