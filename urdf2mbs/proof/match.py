"""Match the joints and links of a URDF with the joints and frames of an .mbs by their names.

The .mbs may have been drawn or edited by hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from urdf2mbs.mbs.model import BASE, ORIGIN, Body, Joint, LinkFrame, Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.proof.urdf_side import FLOATING_ORDER, find_links_that_carry_mass
from urdf2mbs.spatial import ZERO, Pose, axis_turns
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Robot

#: Joints that a conversion drives before a joint, to rotate its axis to a coordinate axis.
ROTATION_BEFORE_JOINT = re.compile(r"_(origin|axis)_R[123](_joint(_\d+)?)?$")


class Exchange(msgspec.Struct):
    """Two URDF joints that names would exchange, and numbers do not."""

    joints: tuple[str, str]
    differing: int
    """How many joints would differ if they were exchanged."""


class Match(msgspec.Struct):
    """The joints and frames of an .mbs that are those of a URDF."""

    joints: dict[str, tuple[str, ...]] = {}
    """The .mbs joints of each URDF joint that moves: one; three of a planar joint (two shifts and
    the rotation); six of a floating one."""
    frames: dict[str, LinkFrame] = {}
    """Where the frame of each link should be in the .mbs, as far as it is known."""
    locked: dict[str, str] = {}
    """The URDF joints that are constant at zero in the .mbs, each with the reason."""
    floating_orders: dict[str, tuple[str, ...]] = {}
    """Order of the coordinates of floating joints, if it is not ``FLOATING_ORDER``."""
    by: dict[str, str] = {}
    """How each joint was matched: by its ``name``, a ``map`` or its ``place``."""
    equal: list[list[str]] = []
    """Groups of URDF joints that may be exchanged, with as few differences."""
    against: list[Exchange] = []
    """Exchanges of two joints that names ask for, and numbers refuse."""
    turned: bool = False
    """Whether another pose of the whole robot leaves as few differences."""
    instead_of_names: int = 0
    """How many joints would differ if all joints of the same name were matched."""


class OwnedJoint(NamedTuple):
    """A joint of an .mbs, and the body that has it."""

    body: Body
    joint: Joint


def match_by_name(
    robot: Robot, mbs: Mbs, given: Mapping[str, tuple[str, ...]] | None = None
) -> Match:
    """Match a URDF by name with an .mbs that may have been drawn or edited by hand.

    A joint has its name in the URDF, or the identifier that a conversion makes of it.  The six
    joints of a floating base are found by their types.  The frame of a link that a moving joint
    leads to should be that of the joint's body; the frame of any other link, that of the body of
    its name.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        given: The .mbs joints of some URDF joints, as a map states them, whatever their names.
    """
    given = given or {}
    all_joints = {
        joint.name: OwnedJoint(body, joint) for body in mbs.bodies for joint in body.joints
    }
    taken = {name for names in given.values() for name in names}
    mbs_joints = {name: owned for name, owned in all_joints.items() if name not in taken}
    carriers = find_links_that_carry_mass(robot)
    moving_joints = [
        joint for joint in _list_as_written(robot) if joint.moves and joint.name not in given
    ]
    match = Match()
    # Names that become the same identifier are matched in the order of the file, unless a joint
    # that is needed is then left over.
    for order in (moving_joints, sorted(moving_joints, key=lambda j: j.child not in carriers)):
        match.joints = _match_joints(order, mbs_joints, carriers)
        if all(joint.name in match.joints for joint in moving_joints if joint.child in carriers):
            break
    floating_joints = find_floating_joints(mbs)
    if taken.isdisjoint(floating_joints):
        _match_floating_base(match, moving_joints, floating_joints, mbs_joints)
    for joint in moving_joints:
        if joint.name not in match.joints and joint.child not in carriers:
            match.locked[joint.name] = "nothing that it moves has mass"
    match.by = dict.fromkeys(match.joints, "name") | dict.fromkeys(given, "map")
    match.joints |= given
    match.joints = {name: match.joints[name] for name in robot.joints if name in match.joints}
    _match_moving_frames(match, robot, all_joints)
    _match_fixed_frames(match, robot, mbs)
    return match


def has_unmatched(match: Match, robot: Robot, mbs: Mbs) -> bool:
    """Return whether both sides have joints that move and have no partner.

    A joint of the same name that does not move, or in another way, is no partner yet.
    """
    joints = mbs.joints()
    partners = {
        name
        for joint, names in match.joints.items()
        if match.by.get(joint) == "map"
        or joint not in robot.joints  # a pass may have taken it away
        or _moves_alike(robot.joints[joint], names, joints)
        for name in names
    }
    used = {name for names in match.joints.values() for name in names}
    return any(
        joint.moves and partners.isdisjoint(match.joints.get(joint.name, ()))
        for joint in robot.joints.values()
    ) and any(joint.nature != "driven" and name not in used for name, joint in joints.items())


def _moves_alike(joint: UrdfJoint, names: tuple[str, ...], joints: Mapping[str, Joint]) -> bool:
    """Return whether .mbs joints shift and rotate as a URDF joint does."""
    if joint.mimic is None and any(joints[name].nature == "driven" for name in names):
        return False
    letter = "T" if joint.type == "prismatic" else "R"
    return len(names) > 1 or joints[names[0]].type[0] == letter


# --- joints ---


def _list_as_written(robot: Robot) -> list[UrdfJoint]:
    """List the joints in the order in which a conversion writes and names them.

    That is depth first, and branches at the origin of the root before the others.
    """
    joints = robot.depth_first()
    first_of_branch: dict[str, UrdfJoint] = {}
    for joint in joints:
        first_of_branch[joint.child] = first_of_branch.get(joint.parent, joint)
    return sorted(joints, key=lambda joint: first_of_branch[joint.child].origin.xyz != ZERO)


def _match_joints(
    order: list[UrdfJoint], mbs_joints: Mapping[str, OwnedJoint], carriers: set[str]
) -> dict[str, tuple[str, ...]]:
    """Find the .mbs joints of URDF joints; exact names first, then those of a conversion.

    Args:
        order: The URDF joints; if two have the same name in the .mbs, the first one gets it.
        mbs_joints: The joints of the .mbs, by name.
        carriers: The links that have or carry mass.  Other joints may be driven in the .mbs; then
            they have no counterpart.
    """
    joints: dict[str, tuple[str, ...]] = {}
    free_joints = dict(mbs_joints)
    for exact in (True, False):
        for joint in order:
            if joint.name in joints:
                continue
            names = _find_joint(joint, free_joints, exact=exact)
            is_driven = any(free_joints[name].joint.nature == "driven" for name in names)
            if names and (joint.child in carriers or not is_driven):
                joints[joint.name] = names
                for name in names:
                    del free_joints[name]
    return joints


class _NamedCoordinate(NamedTuple):
    """A coordinate of a URDF joint as a conversion names it."""

    suffix: str
    """What comes after the name of the URDF joint."""
    letter: str
    """T for a shift, R for a rotation."""


def _find_joint(
    joint: UrdfJoint, free_joints: Mapping[str, OwnedJoint], *, exact: bool
) -> tuple[str, ...]:
    """Find the .mbs joints that have the name and the coordinates of a URDF joint.

    Args:
        joint: The URDF joint.
        free_joints: The .mbs joints that are not those of another URDF joint, by name.
        exact: Whether a joint must have the very name, and move in the right way.

    Returns:
        Names of joints of one body; empty if a coordinate has none.
    """
    for coordinates in _list_named_coordinates(joint):
        by_body: dict[str, list[list[str]]] = {}
        for index, coordinate in enumerate(coordinates):
            name = joint.name + coordinate.suffix
            spellings = [name] if exact else list_spellings(name, "joint")
            named = [spelling for spelling in spellings if spelling in free_joints]
            # Those that move in the right way; if there are none, those of the name.
            candidates = [
                spelling
                for spelling in named
                if free_joints[spelling].joint.nature != "driven"
                and free_joints[spelling].joint.type[0] == coordinate.letter
            ]
            for candidate in candidates or ([] if exact else named):
                body = free_joints[candidate].body.name
                names_of_body = by_body.setdefault(body, [[] for _ in coordinates])
                names_of_body[index].append(candidate)
        for names_of_body in by_body.values():
            if all(names_of_body):
                return tuple(names[0] for names in names_of_body)
    return ()


def _list_named_coordinates(joint: UrdfJoint) -> list[list[_NamedCoordinate]]:
    """List how the coordinates of a joint may be named in an .mbs, the likeliest first."""
    if joint.type == "floating":
        return [[_NamedCoordinate(f"_{kind}", kind[0]) for kind in FLOATING_ORDER]]
    if joint.type == "planar":
        # The conversion rotates one of the coordinate axes to the normal of the plane.
        _, normal = axis_turns(joint.axis)
        return [
            [
                _NamedCoordinate(f"_T{axis % 3 + 1}", "T"),
                _NamedCoordinate(f"_T{(axis + 1) % 3 + 1}", "T"),
                _NamedCoordinate(f"_R{axis}", "R"),
            ]
            for axis in sorted((1, 2, 3), key=lambda axis: axis != normal)
        ]
    return [[_NamedCoordinate("", "T" if joint.type == "prismatic" else "R")]]


def list_spellings(name: str, kind: str) -> list[str]:
    """List the names that a conversion may have made of a name.

    Args:
        name: The name in the URDF.
        kind: ``joint``, ``body`` or ``point``: the suffix of a name that is taken.
    """
    identifier = identifiers([name], (BASE, ORIGIN), f"_{kind}")[0]
    suffixed = identifier if identifier.endswith(f"_{kind}") else f"{identifier}_{kind}"
    return [name, identifier, suffixed, *(f"{suffixed}_{number}" for number in range(2, 6))]


# --- the base ---


def find_floating_joints(mbs: Mbs) -> tuple[str, ...]:
    """Find the six joints of a floating base, in the order of the file; empty if it is fixed."""
    for body in mbs.bodies:
        first_six = [joint for joint in body.joints if joint.nature != "driven"][:6]
        if body.parent is None and sorted(j.type[0] for j in first_six) == list("RRRTTT"):
            return tuple(joint.name for joint in first_six)
    return ()


def is_fixed_to_world(robot: Robot, inserted_joint: str) -> bool:
    """Return True if a link called ``world`` is fixed to the root, but for the inserted base."""
    rigid_links = {robot.root()}
    for joint in robot.depth_first():
        is_rigid = not joint.moves or joint.name == inserted_joint
        if joint.parent in rigid_links and is_rigid:
            rigid_links.add(joint.child)
    return "world" in rigid_links


def _match_floating_base(
    match: Match,
    moving_joints: list[UrdfJoint],
    floating_joints: tuple[str, ...],
    mbs_joints: Mapping[str, OwnedJoint],
) -> None:
    """Match the first floating joint of a URDF with the six joints of a floating base.

    If one of the six has the name of another URDF joint, they are that joint's.
    """
    owner = next(
        (
            name
            for name, names in match.joints.items()
            if not set(floating_joints).isdisjoint(names)
        ),
        None,
    )
    for joint in moving_joints:
        if joint.type == "floating" and floating_joints and owner in (None, joint.name):
            types = tuple(mbs_joints[name].joint.type for name in floating_joints)
            if set(types) == set(FLOATING_ORDER):
                match.floating_orders[joint.name] = types
            match.joints[joint.name] = floating_joints
            return


# --- frames ---


def _match_moving_frames(match: Match, robot: Robot, mbs_joints: Mapping[str, OwnedJoint]) -> None:
    """Match the frames of the links that moving joints lead to."""
    fixed_joints = [joint.name for joint in robot.joints.values() if not joint.moves]
    fixed_names = {name for joint in fixed_joints for name in list_spellings(joint, "joint")}
    for joint in robot.joints.values():
        names = match.joints.get(joint.name)
        if names is not None and match.by[joint.name] == "name":
            body = mbs_joints[names[-1]].body
            last_joint = _find_last_joint(body, names[-1], fixed_names)
            match.frames[joint.child] = LinkFrame(body.name, last_joint, Pose())


def _match_fixed_frames(match: Match, robot: Robot, mbs: Mbs) -> None:
    """Match the frames of the links that fixed joints lead to with bodies of their names."""
    bodies = {body.name for body in mbs.bodies}
    bodies -= {frame.body for frame in match.frames.values() if frame.joint is None}
    links = [joint.child for joint in _list_as_written(robot) if not joint.moves]
    for exact in (True, False):
        for link in links:
            if link in match.frames:
                continue
            spellings = [link] if exact else list_spellings(link, "body")
            body = next((spelling for spelling in spellings if spelling in bodies), None)
            if body is not None:
                match.frames[link] = LinkFrame(body, None, Pose())
                bodies.remove(body)


def _find_last_joint(body: Body, name: str, fixed_names: set[str]) -> str | None:
    """Find the joint of a body after which the frame of a link is.

    Args:
        body: The body.
        name: The joint of the body that moves the link.
        fixed_names: Names of the URDF's fixed joints.

    Returns:
        The last driven joint after it that belongs to it, or the joint itself; None if that is the
        last joint of the body.
    """
    names = [joint.name for joint in body.joints]
    end = names.index(name)
    for joint in body.joints[end + 1 :]:
        is_next = joint.name in fixed_names or ROTATION_BEFORE_JOINT.search(joint.name)
        if joint.nature != "driven" or is_next:
            return names[end]
        end += 1
    return None
