"""The .mbs joints and frames of a URDF's joints and links, by their names.

The .mbs may have been drawn or edited by hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import msgspec

from urdf2mbs.mbs.model import BASE, ORIGIN, Body, Joint, LinkFrame, Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.proof.urdf_side import SIX, carriers
from urdf2mbs.spatial import ZERO, Pose, axis_turns
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Robot


class Match(msgspec.Struct):
    """The .mbs joints and frames of a URDF's joints and links."""

    joints: dict[str, tuple[str, ...]] = {}
    frames: dict[str, LinkFrame] = {}
    frozen: dict[str, str] = {}
    orders: dict[str, tuple[str, ...]] = {}
    """In which order floating joints have their coordinates."""


def match(robot: Robot, mbs: Mbs) -> Match:
    """Match by name a URDF with an .mbs that may have been drawn or edited by hand.

    A joint's name counts as it is, or as the identifier that a conversion makes of it.  The
    floating base's six joints are known by their types.  A moving link's frame should be that
    of the body that its joint leads to; a fixed link's that of the body of its name.
    """
    owners = {joint.name: (body, joint) for body in mbs.bodies for joint in body.joints}
    useful = carriers(robot)
    found = Match()
    # names that are alike as identifiers go in the order of the file, unless that leaves one out
    written = [joint for joint in _as_written(robot) if joint.moves]
    for order in (written, sorted(written, key=lambda joint: joint.child not in useful)):
        found.joints = _named_joints(order, owners, useful)
        if all(j.name in found.joints for j in written if j.child in useful):
            break
    free = floating_joints(mbs)
    owner = next((n for n, names in found.joints.items() if not set(free).isdisjoint(names)), None)
    for joint in written:
        if joint.type == "floating" and free and owner in (None, joint.name):
            kinds = tuple(owners[name][1].type for name in free)
            if set(kinds) == set(SIX):
                found.orders[joint.name] = kinds
            found.joints[joint.name] = free
            free = ()
        elif joint.name not in found.joints and joint.child not in useful:
            found.frozen[joint.name] = "nothing that it moves has mass"
    found.joints = {name: found.joints[name] for name in robot.joints if name in found.joints}
    _match_frames(robot, mbs, owners, found)
    return found


def _named_joints(
    order: list[UrdfJoint], owners: Mapping[str, tuple[Body, Joint]], useful: set[str]
) -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    taken: set[str] = set()
    for exact in (True, False):  # a name that is right as it is goes first
        for joint in order:
            if joint.name in found:
                continue
            names = _named(joint, owners, taken, exact)
            driven = any(owners[name][1].nature == "driven" for name in names)
            if names and (joint.child in useful or not driven):
                found[joint.name] = names
                taken.update(names)
    return found


def _as_written(robot: Robot) -> list[UrdfJoint]:
    """The joints in the order in which a conversion writes and names them: depth first, what
    stands at the base's own origin before the rest."""
    order = robot.depth_first()
    branch: dict[str, UrdfJoint] = {}
    for joint in order:
        branch[joint.child] = branch.get(joint.parent, joint)
    return sorted(order, key=lambda joint: branch[joint.child].origin.xyz != ZERO)


def floating_joints(mbs: Mbs) -> tuple[str, ...]:
    """The six joints of a floating base, in the order of the file; none if it is fixed."""
    for body in mbs.bodies:
        first = [joint for joint in body.joints if joint.nature != "driven"][:6]
        if body.parent is None and sorted(j.type[0] for j in first) == list("RRRTTT"):
            return tuple(joint.name for joint in first)
    return ()


def fixed_to_world(robot: Robot, inserted: str) -> bool:
    """True if a link called ``world`` is rigid with the root, but for the inserted base."""
    rigid = {robot.root()}
    for joint in robot.depth_first():
        if joint.parent in rigid and (not joint.moves or joint.name == inserted):
            rigid.add(joint.child)
    return "world" in rigid


def _named(
    joint: UrdfJoint, owners: Mapping[str, tuple[Body, Joint]], taken: set[str], exact: bool
) -> tuple[str, ...]:
    """The .mbs joints of a URDF joint's name that have its coordinates, all in one body; none if
    one lacks."""
    for kinds in _kinds(joint):
        known: dict[str, list[list[str]]] = {}
        for index, (suffix, kind) in enumerate(kinds):
            name = joint.name + suffix
            spelt = [name] if exact else spellings(name, "joint")
            there = [n for n in spelt if n in owners and n not in taken]
            # those that move in the right way, else those of the name
            good = [n for n in there if owners[n][1].nature != "driven"]
            good = [n for n in good if owners[n][1].type[0] == kind] or ([] if exact else there)
            for n in good:
                known.setdefault(owners[n][0].name, [[] for _ in kinds])[index].append(n)
        for of_body in known.values():
            if all(of_body):
                return tuple(names[0] for names in of_body)
    return ()


def _kinds(joint: UrdfJoint) -> list[list[tuple[str, str]]]:
    """A URDF joint's coordinates in an .mbs: what follows its name, and T or R; all the ways."""
    if joint.type == "floating":
        return [[(f"_{kind}", kind[0]) for kind in SIX]]
    if joint.type == "planar":
        _, first = axis_turns(joint.axis)
        return [
            [(f"_T{k % 3 + 1}", "T"), (f"_T{(k + 1) % 3 + 1}", "T"), (f"_R{k}", "R")]
            for k in sorted((1, 2, 3), key=lambda k: k != first)
        ]
    kind = "T" if joint.type == "prismatic" else "R"
    return [[("", kind)]]


def spellings(name: str, kind: str) -> list[str]:
    """The names that a conversion may have made of a name."""
    plain = identifiers([name], (BASE, ORIGIN), f"_{kind}")[0]
    more = plain if plain.endswith(f"_{kind}") else f"{plain}_{kind}"
    return [name, plain, more, *(f"{more}_{number}" for number in range(2, 6))]


def _match_frames(
    robot: Robot, mbs: Mbs, owners: Mapping[str, tuple[Body, Joint]], found: Match
) -> None:
    bodies = {body.name: body for body in mbs.bodies}
    welds = [joint.name for joint in robot.joints.values() if not joint.moves]
    fixed = {name for weld in welds for name in spellings(weld, "joint")}
    taken: set[str] = set()
    for joint in robot.joints.values():
        names = found.joints.get(joint.name)
        if names is not None:
            body, _ = owners[names[-1]]
            after = _last_of(body, names[-1], fixed)
            found.frames[joint.child] = LinkFrame(body.name, after, Pose())
            if after is None:
                taken.add(body.name)
    still = [j.child for j in _as_written(robot) if not j.moves]
    for exact in (True, False):
        for link in still:
            if link in found.frames:
                continue
            for name in [link] if exact else spellings(link, "body"):
                if name in bodies and name not in taken:
                    found.frames[link] = LinkFrame(name, None, Pose())
                    taken.add(name)
                    break


#: What a conversion drives before a joint.
_BEFORE = re.compile(r"_(origin|axis)_R[123](_joint(_\d+)?)?$").search


def _last_of(body: Body, name: str, fixed: set[str]) -> str | None:
    """The last joint of a body that comes with a moving one: what is driven after it, up to the
    next URDF joint's; None if that is the body's last."""
    own = [joint.name for joint in body.joints]
    end = own.index(name)
    for joint in body.joints[end + 1 :]:
        if joint.nature != "driven" or joint.name in fixed or _BEFORE(joint.name):
            return own[end]
        end += 1
    return None
