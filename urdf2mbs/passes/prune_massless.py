"""Prune massless: the method's "Creation of the bodytree".

"For each URDF link found (except the null mass links which are neglected), a MBS body is
added in the bodytree".  Neglected are the links, never their frames nor their children;
``docs/passes/prune-massless.md`` lists what becomes of them.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion, Segment, Step, fits
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Body
from urdf2mbs.messages.diagnostics import counted, some
from urdf2mbs.spatial import HERE, ZERO, Pose, compose, inverse
from urdf2mbs.states import Estimates, OnPurpose
from urdf2mbs.urdf.mimic import follow
from urdf2mbs.urdf.model import JOINT_TYPES, Joint


class PruneMassless(Pass):
    reads = ("robot",)
    writes = ("bodies",)

    keep: list[str] = []
    """Patterns (``*`` for all) of massless links that stay, as bodies without mass."""

    def run(self, conversion: Conversion) -> None:
        robot = conversion.robot
        root = robot.root()
        order = robot.depth_first()
        children = robot.children()

        bodied = {
            link.name
            for link in robot.links.values()
            if not link.massless or fits(link.name, self.keep)
        }
        needed = _with_way(bodied | {root}, order)
        if conversion.settings.project is not None:
            # only a project's code couples joints
            bodied |= _leaders(conversion, needed)
            needed = _with_way(needed | bodied, order)
        if not any(joint.child in needed for joint in order):
            bodied = needed = set(robot.links)
        if all(link.massless for link in robot.links.values()):
            _warn_of_no_mass(conversion)

        chained = _chain(conversion, order, children, bodied, needed)
        _make_segments(conversion, root, order, needed, chained)
        _attach_frames(conversion, order, needed)


def _with_way(links: set[str], order: list[Joint]) -> set[str]:
    """These links and all links on the way to them."""
    links = set(links)
    for joint in reversed(order):
        if joint.child in links:
            links.add(joint.parent)
    return links


def _leaders(conversion: Conversion, needed: set[str]) -> set[str]:
    """The massless links whose joint feels the inertia of joints that follow it."""
    joints = conversion.robot.joints
    leaders: dict[str, str] = {}
    for joint in joints.values():
        if joint.mimic is None or joint.child not in needed:
            continue
        name, multiplier, _ = follow(conversion.robot, joint.name)
        leader = joints[name]
        if multiplier and leader.child not in needed and JOINT_TYPES[leader.type] == 1:
            leaders[leader.name] = leader.child
    for name in leaders:
        conversion.note(
            "mimic-massless",
            f"joint '{name}' moves nothing that has mass, and feels the inertia of the joints "
            f"that follow it: its link '{leaders[name]}' is a body without mass",
            joint=name,
        )
    return set(leaders.values())


def _warn_of_no_mass(conversion: Conversion) -> None:
    links = conversion.robot.links.values()
    shown = any(link.visuals or link.collisions for link in links)
    conversion.warn(
        "no-mass",
        "NO DYNAMICS: no link has a mass or an inertia; links become bodies without mass, and no "
        "force can move them",
        hint="estimate-inertia: {total_mass: KG} estimates them from the geometry"
        if shown and conversion.state(Estimates).links is None
        else "give each link an <inertial>, or each body its mass in the .mbs",
    )


def _chain(
    conversion: Conversion, order: list[Joint], children: dict[str, list[Joint]], bodied: set[str],
    needed: set[str],
) -> dict[str, Pose | None]:  # fmt: skip
    """The massless links whose joints go to the body behind them.

    The value is the link's constant pose in this body, or None if a moving joint lies between the
    two.  Then the link must carry nothing: no body could carry it.
    """
    chained: dict[str, Pose | None] = {}
    for joint in reversed(order):
        link = joint.child
        if link in bodied or link not in needed:
            continue
        onward = [j for j in children[link] if j.child in needed]
        if len(onward) != 1 or onward[0].origin.xyz != ZERO:
            continue
        ahead = chained.get(onward[0].child, HERE)
        if not onward[0].moves and ahead is not None:
            chained[link] = compose(ahead, inverse(onward[0].origin.pose))
        elif len(children[link]) == 1 and not conversion.robot.links[link].visuals:
            chained[link] = None
    return chained


def _make_segments(
    conversion: Conversion, root: str, order: list[Joint], needed: set[str],
    chained: dict[str, Pose | None],
) -> None:  # fmt: skip
    segments = {root: Segment(root, None, [], {root: HERE}, conversion.mbs.base)}
    pending: dict[str, tuple[str, list[Step]]] = {}
    rigid: list[str] = []
    for joint in order:
        link = joint.child
        if link not in needed:
            continue
        parent, steps = pending.pop(joint.parent, (joint.parent, []))
        steps.append(Step.of(joint))
        if link in chained:
            pending[link] = (parent, steps)
            if chained[link] is None:
                steps[-1].frames = {link: HERE}
            else:
                rigid.append(link)
            continue
        segment = Segment(link, parent, steps, {link: HERE}, Body(link))
        for massless in rigid:
            segment.parts[massless] = chained[massless] or HERE
        rigid.clear()
        segments[link] = segment
    conversion.regroup(segments)


def _attach_frames(conversion: Conversion, order: list[Joint], needed: set[str]) -> None:
    """Make the links that no body needs parts of the segments they hang on."""
    parts = conversion.parts()
    held: list[Joint] = []
    for joint in order:
        if joint.child in needed:
            continue
        segment, pose = parts[joint.parent]
        at = segment.parts[joint.child] = compose(pose, joint.origin.pose)
        parts[joint.child] = (segment, at)
        if joint.moves:
            conversion.frozen[joint.name] = "nothing that it moves has mass"
            conversion.state(OnPurpose).massless.add(joint.name)
            held.append(joint)
    if held:
        _warn_of_held_joints(conversion, held)


def _warn_of_held_joints(conversion: Conversion, held: list[Joint]) -> None:
    first, moves = held[0], "move"
    does = f"{counted(len(held), 'joint')} are left out, and their links stay"
    if len(held) == 1:
        moves = "moves"
        does = f"its degree of freedom is left out, and link '{first.child}' stays"
    listed = some(f"joint '{joint.name}' ({joint.type})" for joint in held)
    conversion.warn(
        "massless-leaf",
        f"{listed} {moves} nothing that has mass: {does} where the joint is at zero",
        joint=first.name, link=first.child,
    )  # fmt: skip
