"""Prune massless: the method's "Creation of the bodytree".

"For each URDF link found (except the null mass links which are neglected), a MBS body is added in
the bodytree".  Neglected are the links, never their frames nor their children;
``docs/passes/prune-massless.md`` lists what becomes of them.

Often a joint of several axes is a chain of joints with massless links between them, as a hip with
three axes through one point.  Its joints all go to the body at the end of the chain::

    URDF   pelvis ---yaw---> (hip_1) ---roll---> (hip_2) ---pitch---> thigh
                             massless            massless

    .mbs   pelvis ---yaw, roll, pitch---> thigh

A massless link is *chained* in this way if one joint alone leads from it to bodies, and the origin
of this joint is that of the link.  If this joint moves, the link's frame is between two joints of
the .mbs, where no shape and no anchor point can be, so the link must carry nothing else.  If the
joint is fixed, the link is rigid with the body.
"""

from __future__ import annotations

import msgspec

from urdf2mbs.conversion import Conversion, Segment, Step, fits
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.model import Body
from urdf2mbs.messages.diagnostics import counted, some
from urdf2mbs.spatial import HERE, ZERO, Pose, compose, inverse
from urdf2mbs.states import Estimates, OnPurpose
from urdf2mbs.urdf.mimic import follow
from urdf2mbs.urdf.model import JOINT_TYPES, Joint


class PruneMassless(Pass):
    """Decide which links become bodies, and which joints lead to them."""

    reads = ("robot",)
    writes = ("bodies",)

    keep: list[str] = []
    """Patterns (``*`` for all) of massless links that stay, as bodies without mass."""

    def run(self, conversion: Conversion) -> None:
        """Group the links into segments, one for each body."""
        tree = _select_bodies(conversion, self.keep)
        if all(link.massless for link in conversion.robot.links.values()):
            _warn_of_no_mass(conversion)
        chained = _find_chained_links(conversion, tree)
        _make_segments(conversion, tree, chained)
        _attach_frames(conversion, tree)


class Tree(msgspec.Struct):
    """The tree of the URDF, and the links in it that become bodies."""

    joints: list[Joint]
    """All joints, parents first."""
    children: dict[str, list[Joint]]
    """The joints that lead from each link."""
    bodies: set[str]
    """Links that become bodies."""
    needed: set[str]
    """The bodies, the root, and all links between them."""


def _select_bodies(conversion: Conversion, keep: list[str]) -> Tree:
    """Select the links that become bodies: those with mass, and those that the user keeps."""
    robot = conversion.robot
    joints = robot.depth_first()
    bodies = {
        link.name for link in robot.links.values() if not link.massless or fits(link.name, keep)
    }
    needed = _add_ancestors(bodies | {robot.root()}, joints)
    if conversion.settings.project is not None:
        # Only the code of a project couples joints.
        bodies |= _find_massless_leaders(conversion, needed)
        needed = _add_ancestors(needed | bodies, joints)
    if not any(joint.child in needed for joint in joints):
        bodies = needed = set(robot.links)
    return Tree(joints, robot.children(), bodies, needed)


def _add_ancestors(links: set[str], joints: list[Joint]) -> set[str]:
    """Return some links and all their ancestors; ``joints`` are all joints, parents first."""
    links = set(links)
    for joint in reversed(joints):
        if joint.child in links:
            links.add(joint.parent)
    return links


def _find_massless_leaders(conversion: Conversion, needed: set[str]) -> set[str]:
    """Find the massless links whose joint feels the inertia of joints that follow it."""
    joints = conversion.robot.joints
    leaders: dict[str, str] = {}
    for joint in joints.values():
        if joint.mimic is None or joint.child not in needed:
            continue
        name, multiplier, _ = follow(conversion.robot, joint.name)
        leader = joints[name]
        if multiplier and leader.child not in needed and JOINT_TYPES[leader.type] == 1:
            leaders[leader.name] = leader.child
    for name, link in leaders.items():
        conversion.note(
            "mimic-massless",
            f"joint '{name}' moves nothing that has mass, and feels the inertia of the joints "
            f"that follow it: its link '{link}' is a body without mass",
            joint=name,
        )
    return set(leaders.values())


def _warn_of_no_mass(conversion: Conversion) -> None:
    """Warn that the model has no dynamics, as no link has mass."""
    has_shapes = any(link.visuals or link.collisions for link in conversion.robot.links.values())
    if has_shapes and conversion.state(Estimates).links is None:
        hint = "estimate-inertia: {total_mass: KG} estimates them from the geometry"
    else:
        hint = "give each link an <inertial>, or each body its mass in the .mbs"
    conversion.warn(
        "no-mass",
        "NO DYNAMICS: no link has a mass or an inertia; links become bodies without mass, and no "
        "force can move them",
        hint=hint,
    )


def _find_chained_links(conversion: Conversion, tree: Tree) -> dict[str, Pose | None]:
    """Find the massless links whose joints go to the body at the end of their chain.

    Returns:
        For each chained link its constant pose in this body; None if a moving joint is between
        the two.
    """
    chained: dict[str, Pose | None] = {}
    for joint in reversed(tree.joints):
        link = joint.child
        if link in tree.bodies or link not in tree.needed:
            continue
        next_joints = [child for child in tree.children[link] if child.child in tree.needed]
        if len(next_joints) != 1 or next_joints[0].origin.xyz != ZERO:
            continue
        (next_joint,) = next_joints
        next_pose = chained.get(next_joint.child, HERE)
        if not next_joint.moves and next_pose is not None:
            chained[link] = compose(next_pose, inverse(next_joint.origin.pose))
        elif len(tree.children[link]) == 1 and not conversion.robot.links[link].visuals:
            chained[link] = None
    return chained


def _make_segments(conversion: Conversion, tree: Tree, chained: dict[str, Pose | None]) -> None:
    """Make a segment of each needed link that is not chained, with the joints that lead to it."""
    root = conversion.robot.root()
    segments = {root: Segment(root, None, [], {root: HERE}, conversion.mbs.base)}
    # Of each chained link: the segment that its chain begins at, and the steps up to the link.
    chains: dict[str, tuple[str, list[Step]]] = {}
    rigid_links: list[str] = []
    for joint in tree.joints:
        link = joint.child
        if link not in tree.needed:
            continue
        parent, steps = chains.pop(joint.parent, (joint.parent, []))
        steps.append(Step.of(joint))
        if link in chained:
            chains[link] = (parent, steps)
            if chained[link] is None:
                steps[-1].frames = {link: HERE}
            else:
                rigid_links.append(link)
            continue
        segment = Segment(link, parent, steps, {link: HERE}, Body(link))
        for rigid_link in rigid_links:
            segment.parts[rigid_link] = chained[rigid_link] or HERE
        rigid_links.clear()
        segments[link] = segment
    conversion.regroup(segments)


def _attach_frames(conversion: Conversion, tree: Tree) -> None:
    """Make the links that no body needs parts of the segments that they are attached to."""
    parts = conversion.parts()
    locked_joints: list[Joint] = []
    for joint in tree.joints:
        if joint.child in tree.needed:
            continue
        segment, parent_pose = parts[joint.parent]
        pose = compose(parent_pose, joint.origin.pose)
        segment.parts[joint.child] = pose
        parts[joint.child] = (segment, pose)
        if joint.moves:
            conversion.frozen[joint.name] = "nothing that it moves has mass"
            conversion.state(OnPurpose).massless.add(joint.name)
            locked_joints.append(joint)
    if locked_joints:
        _warn_of_locked_joints(conversion, locked_joints)


def _warn_of_locked_joints(conversion: Conversion, joints: list[Joint]) -> None:
    """Warn of the joints that are locked at zero because they move no mass."""
    first = joints[0]
    listed = some(f"joint '{joint.name}' ({joint.type})" for joint in joints)
    if len(joints) == 1:
        verb, effect = "moves", "it is locked at zero, and is not in the .mbs"
    else:
        count = counted(len(joints), "joint")
        verb, effect = "move", f"{count} are locked at zero, and are not in the .mbs"
    conversion.warn(
        "massless-leaf",
        f"{listed} {verb} nothing that has mass: {effect}",
        joint=first.name,
        link=first.child,
    )
