"""Is an .mbs the same robot as a URDF?  The proof, by a second route.

The .mbs is walked joint by joint, each an elementary shift or turn along a current axis; the
URDF by Rodrigues' formula, with quaternions for its roll, pitch and yaw.  Neither shares a line
with the passes, nor with ``spatial``.

What is compared are the *rigid groups*: all that no moving joint separates.

* Motion: at several random positions of all joints, zero included, each group must stand where
  its counterpart stands, up to one constant pose between the two groups' frames.
* Inertia: seen through that constant pose, mass, centre and inertia must be equal.
* Frames: each link's frame must be where the conversion says that it is.

Why this suffices: where the same inertias move the same way at every position, the kinetic
energy is the same function of positions and velocities, and with equal gravity so is the
potential energy; Lagrange's equations, hence the equations of motion, are then the same.
Poses are products of sines and cosines of the positions, so two that agree at a random
position but differ elsewhere have probability zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, hypot, pi, sin, sqrt
from operator import sub
from random import Random
from typing import Any

import msgspec

from urdf2mbs.conversion import LinkFrame
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.spatial import Pose, Sym, Vec, fewest_turns
from urdf2mbs.urdf.model import Joint, Robot

#: What a difference must exceed to count, relative to the robot's size, its inertia, ...
TOLERANCE = 1e-9
#: Positions at which the motion is compared, zero included.
POSITIONS = 4
#: Components of a unit axis up to this are zero for a conversion (it says so in a note).
ALIGNED = 1e-9

#: A frame: a rotation matrix row by row, then the origin (m).
Frame = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]  # fmt: skip
#: Mass (kg), centre (m), and inertia about it (kg m^2), in some frame.
Inertia = tuple[float, Vec, Sym]

HERE: Frame = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


class Difference(msgspec.Struct, omit_defaults=True):
    """One thing that is not the same; ``size`` is relative, and 1 where there is no measure."""

    kind: str
    message: str
    size: float = 1.0
    link: str | None = None
    joint: str | None = None
    urdf: Any = None
    mbs: Any = None


class Comparison(msgspec.Struct):
    """What ``compare`` found."""

    differences: list[Difference]
    """By size, the largest first."""
    frames: list[Difference]
    """Link frames that are elsewhere in the .mbs; a matter of convention, not of physics."""
    largest: dict[str, float]
    """The largest relative deviation of each kind, differences or not."""
    groups: int
    urdf_mass: float
    """kg, of all links."""
    mbs_mass: float
    """kg, of all bodies."""
    positions: int = POSITIONS

    @property
    def same(self) -> bool:
        return not self.differences


class Match(msgspec.Struct):
    """Which .mbs joints and frames are a URDF's, by their names."""

    joints: dict[str, tuple[str, ...]]
    frames: dict[str, LinkFrame]
    frozen: dict[str, str]


def match(robot: Robot, mbs: Mbs) -> Match:
    """Match by name a URDF with an .mbs that may have been drawn or edited by hand.

    A joint's name counts as it is, or as the identifier that a conversion makes of it.  The
    floating base's six joints are known by their types.  A moving link's frame should be that
    of the body that its joint leads to; a fixed link's that of the body of its name.
    """
    owners = {joint.name: body for body in mbs.bodies for joint in body.joints}
    bodies = {body.name: body for body in mbs.bodies}
    free = floating_joints(mbs)
    found = Match({}, {}, {})
    useful = _carries_mass(robot)
    for joint in robot.joints.values():
        if not joint.moves:
            body = next((bodies[n] for n in _spellings(joint.child, "body") if n in bodies), None)
            if body is not None:
                found.frames[joint.child] = LinkFrame(body.name, None, Pose())
            continue
        names = _named(joint, owners) or (free if joint.type == "floating" else ())
        if names:
            found.joints[joint.name] = names
            body = owners[names[-1]]
            own = [joint.name for joint in body.joints]
            end = own.index(names[-1])
            while end + 1 < len(own) and own[end + 1].startswith(f"{names[-1]}_back_"):
                end += 1
            after = None if end == len(own) - 1 else own[end]
            found.frames[joint.child] = LinkFrame(body.name, after, Pose())
        elif joint.child not in useful:
            found.frozen[joint.name] = "nothing that it moves has mass"
    return found


def floating_joints(mbs: Mbs) -> tuple[str, ...]:
    """The six joints of a floating base, in the order T1 T2 T3 R1 R2 R3; none if it is fixed."""
    for body in mbs.bodies:
        first = [joint for joint in body.joints if joint.nature != "driven"][:6]
        kinds = {joint.type: joint.name for joint in first}
        if body.parent is None and len(kinds) == 6:
            return tuple(kinds[kind] for kind in ("T1", "T2", "T3", "R1", "R2", "R3"))
    return ()


def _spellings(name: str, kind: str) -> list[str]:
    plain = identifiers([name])[0]
    return [name, plain, f"{plain}_{kind}"]


def _named(joint: Joint, owners: Mapping[str, Any]) -> tuple[str, ...]:
    """The .mbs joints of a URDF joint's name that have its coordinates."""
    for name in _spellings(joint.name, "joint"):
        if joint.type == "floating":
            names = tuple(f"{name}_{kind}" for kind in ("T1", "T2", "T3", "R1", "R2", "R3"))
        elif joint.type == "planar":
            k = 1 + max(range(3), key=lambda i: f"{name}_R{i + 1}" in owners)
            names = (f"{name}_T{k % 3 + 1}", f"{name}_T{(k + 1) % 3 + 1}", f"{name}_R{k}")
        else:
            names = (name,)
        if all(one in owners for one in names):
            return names
    return ()


def _carries_mass(robot: Robot) -> set[str]:
    """The links that have mass or carry what has."""
    useful = {link.name for link in robot.links.values() if not link.massless}
    for joint in reversed(robot.depth_first()):
        if joint.child in useful:
            useful.add(joint.parent)
    return useful


class _Group(msgspec.Struct):
    """A rigid group: how it hangs on its parent group, and what is in it."""

    parent: int
    before: Frame
    """Where its joint stands in the parent group."""
    move: Callable[[float], Frame]
    coordinate: str
    joint: str
    inertias: list[Inertia]


class _Side(msgspec.Struct):
    """One of the two descriptions, as rigid groups; group 0 is the ground."""

    groups: list[_Group]
    frames: dict[str, tuple[int, Frame]]
    """Link (URDF) or body and joint (.mbs) frames: their group and pose in it."""
    created: dict[str, int]
    """The group that each coordinate moves."""

    def world(self, q: Mapping[str, float]) -> list[Frame]:
        """The pose of every group at a position."""
        out = [HERE]
        for group in self.groups[1:]:
            joint = _compose(out[group.parent], group.before)
            out.append(_compose(joint, group.move(q.get(group.coordinate, 0.0))))
        return out


def compare(
    robot: Robot,
    mbs: Mbs,
    joints: Mapping[str, tuple[str, ...]],
    *,
    frames: Mapping[str, LinkFrame] | None = None,
    frozen: Mapping[str, str] | None = None,
    gravity: Vec = (0.0, 0.0, -9.81),
    tolerance: float = TOLERANCE,
) -> Comparison:
    """Compare a URDF with an .mbs.

    ``joints`` maps each moving URDF joint to the .mbs joints that move with its coordinates
    (one; three of a planar joint: two shifts and the turn; six of a floating one: T1 T2 T3 R1
    R2 R3).  ``frames`` says where link frames are meant to be, as far as that is known; without
    it only the physics is compared.  ``frozen`` joints are held at zero on the URDF's side.
    """
    frozen = frozen or {}
    one = _urdf_side(robot, frozen)
    two = _mbs_side(mbs)
    found: list[Difference] = []
    largest = {"gravity": 0.0, "motion": 0.0, "mass": 0.0, "centre": 0.0, "inertia": 0.0}
    if frames is not None:
        largest["frame"] = 0.0

    off = max(abs(a - b) for a, b in zip(gravity, mbs.base.gravity, strict=True))
    largest["gravity"] = off / (max(abs(g) for g in (*gravity, *mbs.base.gravity)) or 1.0)
    if largest["gravity"] > tolerance:
        found.append(
            Difference(
                "gravity", f"gravity is {mbs.base.gravity}, and should be {gravity} m/s^2",
                largest["gravity"], urdf=gravity, mbs=mbs.base.gravity,
            )
        )  # fmt: skip

    names = _coordinates(robot, mbs, joints, frozen, two, found)
    found_pairs = ((one.created[own], two.created[name]) for own, name in names.items())
    pairs = dict(sorted([(0, 0), *found_pairs]))  # parents first
    size = _size(one)
    named = _named_frames(one, two, frames or {})
    turned: list[Difference] = []
    apart = _motion(
        one, two, names, pairs, named, size, tolerance, largest, found, turned, _driven(mbs)
    )
    if frames is not None:
        turned += _frames(one, two, named, apart, pairs, size, tolerance, largest)
    _inertias(one, two, apart, pairs, size, tolerance, largest, found)
    found.sort(key=lambda difference: -difference.size)
    turned.sort(key=lambda difference: -difference.size)
    masses = [sum(m for group in side.groups for m, _, _ in group.inertias) for side in (one, two)]
    return Comparison(found, turned, largest, len(one.groups), masses[0], masses[1])


def _coordinates(
    robot: Robot,
    mbs: Mbs,
    joints: Mapping[str, tuple[str, ...]],
    frozen: Mapping[str, str],
    two: _Side,
    found: list[Difference],
) -> dict[str, str]:
    """The URDF's coordinates that the .mbs has too, under its names."""
    natures = {joint.name: joint.nature for body in mbs.bodies for joint in body.joints}
    names: dict[str, str] = {}
    for joint in robot.joints.values():
        if not joint.moves or joint.name in frozen:
            continue
        ours = _own_coordinates(joint)
        theirs = joints.get(joint.name, ())
        if len(theirs) != len(ours) or any(name not in natures for name in theirs):
            found.append(
                Difference(
                    "joint-missing", f"joint '{joint.name}' ({joint.type}) is not in the .mbs",
                    link=joint.child, joint=joint.name,
                )
            )  # fmt: skip
            continue
        for own, name in zip(ours, theirs, strict=True):
            nature = natures[name]
            if nature == "driven" or (nature == "dependent" and joint.mimic is None):
                found.append(
                    Difference(
                        "nature", f"joint '{name}' is {nature}, and should be independent",
                        link=joint.child, joint=joint.name, urdf="independent", mbs=nature,
                    )
                )  # fmt: skip
            if name in two.created:
                names[own] = name
    known = set(names.values())
    found.extend(
        Difference("joint-extra", f"joint '{name}' moves in the .mbs only", joint=name)
        for name in two.created
        if name not in known
    )
    return names


def _named_frames(
    one: _Side, two: _Side, frames: Mapping[str, LinkFrame]
) -> dict[str, tuple[int, Frame]]:
    """Each link's .mbs group, and the pose in it of the URDF's group as the frames have it."""
    named: dict[str, tuple[int, Frame]] = {}
    for link, (_, pose) in one.frames.items():
        at = frames.get(link)
        if at is not None:
            group, anchor = two.frames.get(at.joint or at.body or "", (-1, HERE))
            theirs = _compose(anchor, (*at.pose.rot, *at.pose.xyz))
            named[link] = (group, _compose(theirs, _inverse(pose)))
    return named


def _motion(
    one: _Side,
    two: _Side,
    names: Mapping[str, str],
    pairs: Mapping[int, int],
    named: Mapping[str, tuple[int, Frame]],
    size: float,
    tolerance: float,
    largest: dict[str, float],
    found: list[Difference],
    turned: list[Difference],
    driven: Mapping[str, str],
) -> dict[int, Frame]:
    """Compare how each group moves on the one before it; gives its pose in its counterpart.

    Joint by joint, so that each difference is named where it arises: all poses are products of
    these, hence equal if they are.
    """
    random = Random(20)
    positions = {own: [random.uniform(-pi, pi) for _ in range(POSITIONS - 1)] for own in names}
    counterparts = {other: mine for mine, other in pairs.items()}
    leader: dict[int, str] = {}
    for first, (group, _) in one.frames.items():
        leader.setdefault(group, first)
    apart: dict[int, Frame] = {0: HERE}
    for mine, other in pairs.items():
        if mine == 0:
            continue
        ours, theirs = one.groups[mine], two.groups[other]
        parent, ours_on = _on(one, mine, pairs)
        theirs_parent, theirs_on = _on(two, other, counterparts)
        link, joint = leader.get(mine, ""), ours.joint
        if pairs[parent] != theirs_parent:
            before = one.groups[parent].joint or "the ground"
            instead = two.groups[theirs_parent].joint or "the ground"
            found.append(
                Difference(
                    "parent", f"joint '{joint}' hangs on '{instead}', and should on '{before}'",
                    link=link or None, joint=joint,
                )
            )  # fmt: skip
        placed = _compose(_inverse(theirs_on), _compose(apart[parent], ours_on))
        values = positions[ours.coordinate]
        moves = [(ours.move(value), theirs.move(value)) for value in values]
        ours_in, theirs_in = _merge(ours.inertias), _merge(theirs.inertias)
        motion = _unlike(placed, moves, size)
        apart[mine] = placed
        group, meant = named.get(link, (-1, HERE))
        off = _distance(meant, placed, size)
        if group == other:
            largest["frame"] = max(largest["frame"], off)
        if group == other and off <= tolerance:
            apart[mine] = meant  # so that rounding does not add up along the chain
        elif group == other:
            # a frame elsewhere: either all in it is expressed in it, or what it has is misplaced
            motion_meant = _unlike(meant, moves, size)
            inertia, inertia_meant = (
                max(_apart(_seen(ours_in, at), theirs_in, size).values()) for at in (placed, meant)
            )
            told = _told(_compose(_inverse(placed), meant))
            message = f"link '{link}': its frame is {told}, at joint '{joint}'"
            if driven.get(two.groups[other].joint):
                message += f" (driven before it: {driven[two.groups[other].joint]})"
            if max(inertia, inertia_meant) > tolerance:
                misplaced = inertia_meant < inertia
            else:
                misplaced = motion_meant < motion
            if misplaced:
                apart[mine] = meant
                motion = min(motion, motion_meant)
                message += ", and what it has is not expressed in it"
            (found if misplaced else turned).append(
                Difference("frame", message, off, link=link, joint=joint)
            )
        largest["motion"] = max(largest["motion"], motion)
        if motion > tolerance:
            found.append(
                Difference(
                    "motion", f"link '{link or joint}' moves otherwise than by joint '{joint}'",
                    motion, link=link or None, joint=joint,
                )
            )  # fmt: skip
    return apart


def _driven(mbs: Mbs) -> dict[str, str]:
    """What is driven before each moving joint, in its body."""
    told: dict[str, str] = {}
    for body in mbs.bodies:
        turns: list[str] = []
        for joint in body.joints:
            if joint.nature != "driven":
                told[joint.name] = ", ".join(turns)
                turns = []
            elif joint.q:
                turns.append(f"{joint.type} {joint.q:.6g}")
    return told


def _on(side: _Side, group: int, known: Mapping[int, int]) -> tuple[int, Frame]:
    """The next group towards the ground that has a counterpart, and the pose in it of a group's
    joint, the groups between held at zero."""
    at = side.groups[group].before
    parent = side.groups[group].parent
    while parent not in known:
        at = _compose(side.groups[parent].before, at)
        parent = side.groups[parent].parent
    return parent, at


def _unlike(at: Frame, moves: list[tuple[Frame, Frame]], size: float) -> float:
    """How far two groups, one of which stands ``at`` in the other, move apart."""
    return max(_distance(_compose(at, a), _compose(b, at), size) for a, b in moves)


def _frames(
    one: _Side,
    two: _Side,
    named: Mapping[str, tuple[int, Frame]],
    apart: Mapping[int, Frame],
    pairs: Mapping[int, int],
    size: float,
    tolerance: float,
    largest: dict[str, float],
) -> list[Difference]:
    """The links whose frame is not where it is said to be in its group."""
    found: list[Difference] = []
    leaders: set[int] = set()
    for link, (group, _) in one.frames.items():
        if link not in named:
            continue
        other, meant = named[link]
        if pairs.get(group) != other:
            found.append(Difference("frame", f"link '{link}' moves with another body", link=link))
            continue
        off = _distance(apart[group], meant, size)
        largest["frame"] = max(largest["frame"], off)
        if off > tolerance and (group == 0 or group in leaders):
            told = _told(_compose(_inverse(apart[group]), meant))
            found.append(Difference("frame", f"link '{link}': its frame is {told}", off, link=link))
        leaders.add(group)
    return found


def _inertias(
    one: _Side,
    two: _Side,
    apart: Mapping[int, Frame],
    pairs: Mapping[int, int],
    size: float,
    tolerance: float,
    largest: dict[str, float],
    found: list[Difference],
) -> None:
    """Compare what each pair of groups weighs, where, and how it resists turning."""
    members: dict[int, list[str]] = {}
    for link, (group, _) in one.frames.items():
        members.setdefault(group, []).append(link)
    total = sum(m for group in one.groups for m, _, _ in group.inertias) or 1.0
    for mine, other in pairs.items():
        if mine == 0:
            continue  # what is fixed to the ground needs no inertia
        ours = _seen(_merge(one.groups[mine].inertias), apart[mine])
        theirs = _merge(two.groups[other].inertias)
        links = members.get(mine, [])
        who = f"link '{links[0]}'" if links else f"joint '{one.groups[mine].joint}'"
        if len(links) > 1:
            who += f" and the {len(links) - 1} fixed to it"
        for index, (kind, off) in enumerate(_apart(ours, theirs, size).items()):
            largest[kind] = max(largest[kind], off)
            if off > tolerance:
                a, b = ours[index], theirs[index]
                told = f"{kind} is {_short(b)} in the .mbs, and should be {_short(a)}"
                found.append(
                    Difference(
                        kind, f"{who}: {told}", off,
                        link=links[0] if links else None, joint=one.groups[mine].joint,
                        urdf=a, mbs=b,
                    )
                )  # fmt: skip
    known = set(pairs.values())
    for number, unknown in enumerate(two.groups):
        mass = sum(m for m, _, _ in unknown.inertias)
        if number not in known and mass:
            found.append(
                Difference(
                    "mass", f"what joint '{unknown.joint}' moves weighs {mass} kg in the .mbs only",
                    mass / total, joint=unknown.joint, urdf=0.0, mbs=mass,
                )
            )  # fmt: skip


def _apart(ours: Inertia, theirs: Inertia, size: float) -> dict[str, float]:
    """How far two inertias are apart, each part relative to its own scale."""
    heaviest = max(abs(ours[0]), abs(theirs[0]))
    tensor = max(map(abs, (*ours[2], *theirs[2])))
    centre = max(abs(a - b) for a, b in zip(ours[1], theirs[1], strict=True))
    turning = max(abs(a - b) for a, b in zip(ours[2], theirs[2], strict=True))
    return {
        "mass": abs(ours[0] - theirs[0]) / (heaviest or 1.0),
        "centre": centre / size if heaviest else 0.0,  # nothing has no centre
        "inertia": turning / (tensor or 1.0),
    }


def _short(value: Any) -> str:
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{c:.9g}" for c in value) + ")"
    return f"{value:.9g}"


# --- the URDF's side: Rodrigues' formula -----------------------------------------------------


def _urdf_side(robot: Robot, frozen: Mapping[str, str]) -> _Side:
    root = robot.root()
    side = _Side([_Group(0, HERE, lambda _: HERE, "", "", [])], {root: (0, HERE)}, {})
    for joint in robot.depth_first():
        group, at = side.frames[joint.parent]
        at = _compose(at, (*_from_quaternion(joint.origin.rpy), *joint.origin.xyz))
        if joint.moves and joint.name not in frozen:
            for name, move in zip(_own_coordinates(joint), _moves(joint), strict=True):
                side.groups.append(_Group(group, at, move, name, joint.name, []))
                group, at = len(side.groups) - 1, HERE
                side.created[name] = group
        side.frames[joint.child] = (group, at)
    for name, link in robot.links.items():
        if link.inertial is not None:
            group, at = side.frames[name]
            origin = link.inertial.origin
            frame = _compose(at, (*_from_quaternion(origin.rpy), *origin.xyz))
            inertia = (link.inertial.mass, (0.0, 0.0, 0.0), link.inertial.inertia)
            side.groups[group].inertias.append(_seen(inertia, frame))
    return side


def _own_coordinates(joint: Joint) -> list[str]:
    count = {"floating": 6, "planar": 3}.get(joint.type, 1)
    return [joint.name] if count == 1 else [f"{joint.name}[{k}]" for k in range(count)]


def _moves(joint: Joint) -> list[Callable[[float], Frame]]:
    if joint.type == "floating":
        x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
        return [_shift(x), _shift(y), _shift(z), _spin(x), _spin(y), _spin(z)]
    axis = _direction(joint.axis)
    if joint.type == "planar":
        return [*map(_shift, in_plane(axis)), _spin(axis)]
    return [_shift(axis) if joint.type == "prismatic" else _spin(axis)]


def _direction(axis: Vec) -> Vec:
    largest = max(map(abs, axis))
    x, y, z = (c / largest for c in axis)
    length = sqrt(x * x + y * y + z * z)
    x, y, z = (0.0 if abs(c / length) <= ALIGNED else c for c in (x, y, z))
    length = sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length)


def in_plane(axis: Vec) -> tuple[Vec, Vec]:
    """The two directions in which a planar joint of a unit axis shifts; URDF leaves them open."""
    x, y, z = axis
    if x == 0.0 and y != 0.0:
        u = (0.0, -z, y)
    elif y == 0.0 and z != 0.0:
        u = (z, 0.0, -x)
    else:
        u = (-y / hypot(x, y), x / hypot(x, y), 0.0)
    return u, _cross(axis, u)


def _cross(a: Vec, b: Vec) -> Vec:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _shift(u: Vec) -> Callable[[float], Frame]:
    return lambda q: (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, q * u[0], q * u[1], q * u[2])


def _spin(u: Vec) -> Callable[[float], Frame]:
    """Rodrigues: R = 1 + sin(q) K + (1 - cos(q)) K^2, K the cross product with the unit axis."""
    x, y, z = u

    def turned(q: float) -> Frame:
        s, c = sin(q), 1.0 - cos(q)
        return (
            1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y,
            c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x,
            c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y),
            0.0, 0.0, 0.0,
        )  # fmt: skip

    return turned


def _from_quaternion(
    rpy: Vec,
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Roll, pitch, yaw to a rotation by way of the quaternion, as urdfdom does it."""
    if rpy == (0.0, 0.0, 0.0):
        return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    cr, cp, cy = (cos(angle / 2) for angle in rpy)
    sr, sp, sy = (sin(angle / 2) for angle in rpy)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


# --- the .mbs's side: elementary joints ------------------------------------------------------


def _mbs_side(mbs: Mbs) -> _Side:
    side = _Side([_Group(0, HERE, lambda _: HERE, "", "", [])], {"": (0, HERE)}, {})
    points: dict[tuple[str | None, str], Vec] = {
        (None, point.name): point.coordinates for point in mbs.base.points
    } | {(body.name, point.name): point.coordinates for body in mbs.bodies for point in body.points}
    for body in mbs.bodies:
        group, at = side.frames[body.parent or ""]
        if body.point is not None:
            x, y, z = points[body.parent, body.point]
            at = _compose(at, (*HERE[:9], x, y, z))
        for joint in body.joints:
            if joint.nature == "driven":
                at = _stepped(at, joint.type, joint.q or 0.0)
            else:
                # its position at start is where it starts from, not where it is held
                side.groups.append(
                    _Group(group, at, _elementary(joint.type), joint.name, joint.name, [])
                )
                group, at = len(side.groups) - 1, HERE
                side.created[joint.name] = group
            side.frames[joint.name] = (group, at)
        side.frames[body.name] = (group, at)
        if body.mass or body.inertia:
            inertia = (
                body.mass or 0.0,
                body.com or (0.0, 0.0, 0.0),
                body.inertia or (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            )
            side.groups[group].inertias.append(_seen(inertia, at))
    return side


def _elementary(kind: str) -> Callable[[float], Frame]:
    return lambda q: _stepped(HERE, kind, q)


def _stepped(at: Frame, kind: str, q: float) -> Frame:
    """A frame after one joint: T1 T2 T3 shift along, R1 R2 R3 turn about its current axes."""
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = at
    if kind == "T1":
        return (*at[:9], x + q * a11, y + q * a21, z + q * a31)
    if kind == "T2":
        return (*at[:9], x + q * a12, y + q * a22, z + q * a32)
    if kind == "T3":
        return (*at[:9], x + q * a13, y + q * a23, z + q * a33)
    c, s = cos(q), sin(q)
    if kind == "R1":
        return (
            a11, c * a12 + s * a13, c * a13 - s * a12,
            a21, c * a22 + s * a23, c * a23 - s * a22,
            a31, c * a32 + s * a33, c * a33 - s * a32, x, y, z,
        )  # fmt: skip
    if kind == "R2":
        return (
            c * a11 - s * a13, a12, c * a13 + s * a11,
            c * a21 - s * a23, a22, c * a23 + s * a21,
            c * a31 - s * a33, a32, c * a33 + s * a31, x, y, z,
        )  # fmt: skip
    return (
        c * a11 + s * a12, c * a12 - s * a11, a13,
        c * a21 + s * a22, c * a22 - s * a21, a23,
        c * a31 + s * a32, c * a32 - s * a31, a33, x, y, z,
    )  # fmt: skip


# --- frames and inertias ---------------------------------------------------------------------


def _compose(a: Frame, b: Frame) -> Frame:
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = a
    b11, b12, b13, b21, b22, b23, b31, b32, b33, bx, by, bz = b
    return (
        a11 * b11 + a12 * b21 + a13 * b31,
        a11 * b12 + a12 * b22 + a13 * b32,
        a11 * b13 + a12 * b23 + a13 * b33,
        a21 * b11 + a22 * b21 + a23 * b31,
        a21 * b12 + a22 * b22 + a23 * b32,
        a21 * b13 + a22 * b23 + a23 * b33,
        a31 * b11 + a32 * b21 + a33 * b31,
        a31 * b12 + a32 * b22 + a33 * b32,
        a31 * b13 + a32 * b23 + a33 * b33,
        ax + a11 * bx + a12 * by + a13 * bz,
        ay + a21 * bx + a22 * by + a23 * bz,
        az + a31 * bx + a32 * by + a33 * bz,
    )


def _inverse(a: Frame) -> Frame:
    a11, a12, a13, a21, a22, a23, a31, a32, a33, x, y, z = a
    return (
        a11, a21, a31, a12, a22, a32, a13, a23, a33,
        -(a11 * x + a21 * y + a31 * z),
        -(a12 * x + a22 * y + a32 * z),
        -(a13 * x + a23 * y + a33 * z),
    )  # fmt: skip


def _distance(a: Frame, b: Frame, size: float) -> float:
    """How far two frames are apart: the larger of the turn (rad) and the shift over ``size``."""
    turn: float = max(map(abs, map(sub, a[:9], b[:9])))
    shift: float = max(map(abs, map(sub, a[9:], b[9:])))
    return max(turn, shift / size)


def _merge(inertias: list[Inertia]) -> Inertia:
    """Several inertias in one frame as one, by the parallel-axis theorem."""
    if len(inertias) == 1:
        return inertias[0]
    mass = sum(m for m, _, _ in inertias)
    x, y, z = (sum(m * c[k] for m, c, _ in inertias) / (mass or 1.0) for k in range(3))
    xx = xy = xz = yy = yz = zz = 0.0
    for m, (cx, cy, cz), tensor in inertias:
        dx, dy, dz = cx - x, cy - y, cz - z
        xx += tensor[0] + m * (dy * dy + dz * dz)
        xy += tensor[1] - m * dx * dy
        xz += tensor[2] - m * dx * dz
        yy += tensor[3] + m * (dx * dx + dz * dz)
        yz += tensor[4] - m * dy * dz
        zz += tensor[5] + m * (dx * dx + dy * dy)
    return mass, (x, y, z), (xx, xy, xz, yy, yz, zz)


def _seen(inertia: Inertia, frame: Frame) -> Inertia:
    """An inertia given in a frame, from where the frame is given: R I R^T."""
    mass, (x, y, z), (xx, xy, xz, yy, yz, zz) = inertia
    a11, a12, a13, a21, a22, a23, a31, a32, a33, ax, ay, az = frame
    centre = (
        ax + a11 * x + a12 * y + a13 * z,
        ay + a21 * x + a22 * y + a23 * z,
        az + a31 * x + a32 * y + a33 * z,
    )
    p1, p2, p3 = (
        (a * xx + b * xy + c * xz, a * xy + b * yy + c * yz, a * xz + b * yz + c * zz)
        for a, b, c in ((a11, a12, a13), (a21, a22, a23), (a31, a32, a33))
    )
    return (
        mass,
        centre,
        (
            p1[0] * a11 + p1[1] * a12 + p1[2] * a13,
            p1[0] * a21 + p1[1] * a22 + p1[2] * a23,
            p1[0] * a31 + p1[1] * a32 + p1[2] * a33,
            p2[0] * a21 + p2[1] * a22 + p2[2] * a23,
            p2[0] * a31 + p2[1] * a32 + p2[2] * a33,
            p3[0] * a31 + p3[1] * a32 + p3[2] * a33,
        ),
    )


def _size(side: _Side) -> float:
    """The robot's size (m): how far from the ground its farthest frame is at zero."""
    world = side.world({})
    far = max(hypot(*_compose(world[group], pose)[9:]) for group, pose in side.frames.values())
    arms = (hypot(*c) for group in side.groups for _, c, _ in group.inertias)
    return max(far, *arms, 1e-3) if side.groups else 1e-3


def _told(apart: Frame) -> str:
    """A frame in words: the turns that lead to it (rad), and its shift (m)."""
    r = apart[:9]
    turns = ", ".join(f"{angle:.6g} about {'xyz'[k - 1]}" for k, angle in fewest_turns(r, 1e-7))
    shift = ", ".join(f"{c if abs(c) > 1e-12 else 0.0:.6g}" for c in apart[9:])
    parts = [f"turned by {turns}"] * bool(turns) + [f"shifted by ({shift})"] * (
        max(map(abs, apart[9:])) > 1e-9
    )
    return " and ".join(parts) or "slightly off"
