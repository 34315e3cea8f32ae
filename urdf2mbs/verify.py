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
from math import atan2, cos, hypot, pi, sin, sqrt
from random import Random
from typing import Any

import msgspec

from urdf2mbs.conversion import LinkFrame
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.spatial import Sym, Vec
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
    positions: int = POSITIONS

    @property
    def same(self) -> bool:
        return not self.differences


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
    R2 R3).  ``frames`` says where link frames are meant to be; without it only the physics is
    compared.  ``frozen`` joints are held at zero on the URDF's side.
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
    pairs = {0: 0}
    for urdf_name, mbs_name in names.items():
        pairs[one.created[urdf_name]] = two.created[mbs_name]
    size = _size(one)
    apart = _motion(one, two, names, pairs, size, tolerance, largest, found)
    if frames is None:
        turned = []
    else:
        turned = _frames(robot, one, two, frames, apart, pairs, size, tolerance, largest)
    _inertias(one, two, apart, pairs, size, tolerance, largest, found)
    found.sort(key=lambda difference: -difference.size)
    return Comparison(found, turned, largest, len(one.groups))


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


def _motion(
    one: _Side,
    two: _Side,
    names: Mapping[str, str],
    pairs: Mapping[int, int],
    size: float,
    tolerance: float,
    largest: dict[str, float],
    found: list[Difference],
) -> dict[int, Frame]:
    """Compare how the groups move; gives the constant pose of each group in its counterpart."""
    random = Random(20)
    apart: dict[int, Frame] = {}
    moved: dict[int, float] = {}
    for position in range(POSITIONS):
        ours = {own: 0.0 if position == 0 else random.uniform(-pi, pi) for own in names}
        theirs = {names[own]: value for own, value in ours.items()}
        here, there = one.world(ours), two.world(theirs)
        for mine, other in pairs.items():
            frame = _compose(_inverse(there[other]), here[mine])
            if position == 0:
                apart[mine] = frame
            else:
                off = _distance(frame, apart[mine], size)
                largest["motion"] = max(largest["motion"], off)
                if off > tolerance:
                    moved[mine] = max(moved.get(mine, 0.0), off)
    for mine, off in moved.items():
        parent = _paired(one, mine, pairs)
        # what hangs on a group that moves wrongly moves wrongly with it
        if parent not in moved:
            joint = one.groups[mine].joint
            link = next(link for link, (group, _) in one.frames.items() if group == mine)
            behind = sum(_behind(one, other, mine) for other in moved) - 1
            more = f", and {behind} groups behind it" if behind else ""
            found.append(
                Difference(
                    "motion", f"link '{link}' moves otherwise than by joint '{joint}'{more}", off,
                    link=link, joint=joint,
                )
            )  # fmt: skip
    return apart


def _paired(side: _Side, group: int, pairs: Mapping[int, int]) -> int:
    """The next group towards the ground that has a counterpart."""
    parent = side.groups[group].parent
    while parent not in pairs:
        parent = side.groups[parent].parent
    return parent


def _behind(side: _Side, group: int, root: int) -> bool:
    while group > root:
        group = side.groups[group].parent
    return group == root


def _frames(
    robot: Robot,
    one: _Side,
    two: _Side,
    frames: Mapping[str, LinkFrame],
    apart: Mapping[int, Frame],
    pairs: Mapping[int, int],
    size: float,
    tolerance: float,
    largest: dict[str, float],
) -> list[Difference]:
    """The links whose frame is not where it is said to be, nor where its parent's error puts it."""
    found: list[Difference] = []
    carried = {joint.child: joint for joint in robot.joints.values()}
    errors: dict[str, Frame] = {}
    for link in _parents_first(robot):
        group, pose = one.frames[link]
        joint = carried.get(link)
        at = frames.get(link)
        if at is None:
            found.append(Difference("frame-missing", f"link '{link}' has no frame", link=link))
            continue
        place = two.frames.get(at.joint or at.body or "")
        other, anchor = place if place else (-1, HERE)
        if group not in pairs or pairs[group] != other:
            found.append(
                Difference("frame", f"link '{link}' moves with another body", 1.0, link=link)
            )
            continue
        theirs = _compose(anchor, (*at.pose.rot, *at.pose.xyz))
        ours = _compose(apart[group], pose)
        off = _distance(ours, theirs, size)
        largest["frame"] = max(largest["frame"], off)
        if off <= tolerance:
            continue
        error = errors[link] = _compose(_inverse(theirs), ours)
        before = errors.get(joint.parent) if joint else None
        if before is not None and joint and _distance(error, before, size) <= tolerance:
            continue
        behind = f" (joint '{joint.name}' leads to it)" if joint else ""
        found.append(
            Difference(
                "frame", f"link '{link}': its frame is {_told(error)} off{behind}", off,
                link=link, joint=joint.name if joint else None,
                urdf=ours[9:], mbs=theirs[9:],
            )
        )  # fmt: skip
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
        who = f"link '{links[0]}'" if len(links) == 1 else f"links {', '.join(links)}"
        scale = {
            "mass": abs(ours[0]) or total,
            "centre": size,
            "inertia": max(map(abs, (*ours[2], *theirs[2]))) or 1.0,
        }
        off = {
            "mass": abs(ours[0] - theirs[0]) / scale["mass"],
            "centre": max(abs(a - b) for a, b in zip(ours[1], theirs[1], strict=True)) / size,
            "inertia": max(abs(a - b) for a, b in zip(ours[2], theirs[2], strict=True))
            / scale["inertia"],
        }
        if ours[0] == theirs[0] == 0.0:
            off["centre"] = 0.0  # of nothing
        values = {"mass": 0, "centre": 1, "inertia": 2}
        for kind, index in values.items():
            largest[kind] = max(largest[kind], off[kind])
            if off[kind] > tolerance:
                a, b = ours[index], theirs[index]
                found.append(
                    Difference(
                        kind, f"{who}: {kind} is {b} in the .mbs, and should be {a}", off[kind],
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
        u = _in_plane(axis)
        return [_shift(u), _shift(_cross(axis, u)), _spin(axis)]
    return [_shift(axis) if joint.type == "prismatic" else _spin(axis)]


def _direction(axis: Vec) -> Vec:
    largest = max(map(abs, axis))
    x, y, z = (c / largest for c in axis)
    length = sqrt(x * x + y * y + z * z)
    x, y, z = (0.0 if abs(c / length) <= ALIGNED else c for c in (x, y, z))
    length = sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length)


def _in_plane(axis: Vec) -> Vec:
    """The first of the two directions in which a planar joint shifts; URDF leaves it open."""
    x, y, z = axis
    if x == 0.0 and y != 0.0:
        return (0.0, -z, y)
    if y == 0.0 and z != 0.0:
        return (z, 0.0, -x)
    return (-y / hypot(x, y), x / hypot(x, y), 0.0)


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
    turn = max(abs(p - q) for p, q in zip(a[:9], b[:9], strict=True))
    shift = max(abs(p - q) for p, q in zip(a[9:], b[9:], strict=True))
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


def _parents_first(robot: Robot) -> list[str]:
    return [robot.root(), *(joint.child for joint in robot.depth_first())]


def _told(error: Frame) -> str:
    """A small frame in words: its turn as a vector (rad) and its shift (m)."""
    r = error
    cosine = min(1.0, max(-1.0, (r[0] + r[4] + r[8] - 1.0) / 2.0))
    w = ((r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2)
    sine = hypot(*w)
    angle = 0.0
    if sine > 0.0:
        angle = atan2(sine, cosine)
        w = (w[0] / sine, w[1] / sine, w[2] / sine)
    turn = f"turned by {angle:.6g} rad about ({w[0]:.4g}, {w[1]:.4g}, {w[2]:.4g})"
    shift = f"shifted by ({r[9]:.6g}, {r[10]:.6g}, {r[11]:.6g}) m"
    parts = [turn] * (angle > 1e-12) + [shift] * (hypot(*r[9:]) > 1e-12)
    return " and ".join(parts) or "a trace"
