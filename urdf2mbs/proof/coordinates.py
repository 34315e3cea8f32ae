"""The coordinates that move in the .mbs as in the URDF: joints by name, type, nature and symbols,
joints that follow others, and cuts.

Robotran moves an ``independent`` joint by its equations, solves a ``dependent`` one from a
constraint, and holds a ``driven`` one where it starts.  Its generated equations have zero for a
q, qd or qdd that ``<symbols>`` leaves out.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import msgspec

from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs
from urdf2mbs.messages.diagnostics import some
from urdf2mbs.proof.groups import Side
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.rigid import HERE, compose, moved, turned
from urdf2mbs.proof.urdf_side import SIX, own_coordinates
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.urdf.model import Joint as UrdfJoint
from urdf2mbs.urdf.model import Robot

#: Elements of a Jacobian up to this (relative) are rounding.
SINGULAR = 1e-7


class Coordinates(msgspec.Struct):
    """The coordinates of both sides, and their differences."""

    names: dict[str, str] = {}
    """The URDF's coordinates that move in the .mbs too, and their names there."""
    held: dict[str, float] = {}
    """The URDF's coordinates that the .mbs holds, and where (rad, m)."""
    differences: list[Difference] = []
    but_for: dict[str, str] = {}
    not_compared: dict[str, str] = {}

    def differ(self, kind: str, message: str, **more: Any) -> None:
        self.differences.append(Difference(kind, message, **more))


def coordinates(
    robot: Robot, mbs: Mbs, joints: Mapping[str, Sequence[str]], frozen: Collection[str],
    orders: Mapping[str, tuple[str, ...]], driven: Collection[str],
) -> Coordinates:  # fmt: skip
    """Match the coordinates of a URDF with those of an .mbs, and note the differences.

    ``joints``, ``frozen`` and ``orders`` are as for ``compare``; ``driven`` are the .mbs joints
    that are driven on purpose, though the URDF has them follow others.
    """
    known = mbs.joints()
    out = Coordinates()
    tied = _loops(robot, mbs, out)
    taken: set[str] = set()
    for joint in robot.joints.values():
        if not joint.moves or joint.name in frozen:
            continue
        where: dict[str, Any] = {"link": joint.child, "joint": joint.name}
        ours = own_coordinates(joint, orders.get(joint.name, SIX))
        theirs = joints.get(joint.name, ())
        if len(theirs) != len(ours) or not known.keys() >= set(theirs):
            said = f"joint '{joint.name}' ({joint.type}) is not in the .mbs"
            out.differ("joint-missing", said, **where)
            continue
        for (own, kind, _), name in zip(ours, theirs, strict=True):
            moves = _nature(robot, joint, known[name], tied, driven, out)
            if name in taken:
                said = f"joint '{name}' is given for '{joint.name}' and for another joint"
                out.differ("joint-missing", said, **where)
            elif not moves:
                out.held[own] = known[name].q or 0.0
            elif known[name].type[0] != kind[0]:
                does = "shifts" if kind[0] == "R" else "turns"
                said = f"joint '{name}' is a {known[name].type}: it {does}, and should not"
                out.differ("type", said, urdf=joint.type, mbs=known[name].type, **where)
            else:
                out.names[own] = name
            taken.add(name)
    moving = set(out.names.values())
    for body in mbs.bodies:
        for extra in body.joints:
            if extra.nature != "driven" and extra.name not in taken:
                said = f"joint '{extra.name}' of body '{body.name}' moves in the .mbs only"
                out.differ("joint-extra", said, link=body.name, joint=extra.name)
            _symbols(body, extra, extra.nature != "driven" or extra.name in moving, out)
    return out


def _nature(
    robot: Robot, joint: UrdfJoint, own: Joint,
    tied: Collection[str], driven: Collection[str], out: Coordinates,
) -> bool:  # fmt: skip
    """True if a joint moves as its URDF joint does; notes a difference of its nature."""
    where: dict[str, Any] = {"link": joint.child, "joint": joint.name}
    if own.nature == "dependent" and own.name not in tied:
        said = f"joint '{own.name}' is dependent, and no cut or user constraint moves it"
        out.differ("nature", said, urdf="independent", mbs=own.nature, **where)
    if joint.mimic is None:
        if own.nature == "driven":
            said = f"joint '{own.name}' is driven, and should be independent"
            out.differ("nature", said, urdf="independent", mbs=own.nature, **where)
        return own.nature != "driven"
    leader, place = joint.mimic.joint, _place(robot, joint)
    if own.nature == "driven" and place is not None:
        held = own.q or 0.0
        if not abs(held - place) <= TOLERANCE:
            said = f"joint '{own.name}' is held at {held:.9g}, and should be at {place:.9g}"
            out.differ("zero", said, urdf=place, mbs=held, **where)
        return False
    if own.nature == "independent":
        out.but_for[f"joint '{joint.name}'"] = "free here, coupled by <mimic> in the URDF"
    elif own.nature == "dependent":
        out.not_compared[f"<mimic> of joint '{joint.name}'"] = (
            "held by the user functions (user_cons_hJ)"
        )
    elif own.name in driven:
        out.but_for[f"joint '{joint.name}'"] = f"driven, so that '{leader}' does not feel it"
    else:
        said = f"joint '{own.name}' is driven, and should follow '{leader}'"
        said += ", which then feels its inertia"
        out.differ("nature", said, urdf="dependent", mbs=own.nature, **where)
    return True


def _place(robot: Robot, joint: UrdfJoint) -> float | None:
    """Where a joint stands that follows with a multiplier of zero (rad, m); else None."""
    multiplier, place = 1.0, 0.0
    while joint.mimic is not None:
        place += multiplier * joint.mimic.offset
        multiplier *= joint.mimic.multiplier
        joint = robot.joints[joint.mimic.joint]
    return None if multiplier else place


def _symbols(body: Body, joint: Joint, moves: bool, out: Coordinates) -> None:
    """Note where Robotran's equations and the file's numbers of a joint disagree."""
    kept = ("q", "qd", "qdd") if joint.symbols is None else joint.symbols
    where: dict[str, Any] = {"link": body.name, "joint": joint.name}
    dropped = [symbol for symbol in ("q", "qd", "qdd") if symbol not in kept]
    if moves:
        if dropped:
            said = f"joint '{joint.name}' moves, and its <symbols> leave out {', '.join(dropped)}"
            out.differ("symbols", f"{said}: Robotran's equations have zero there", **where)
        return
    if joint.q and "q" in dropped:
        said = f"joint '{joint.name}' is held at {joint.q:.9g}, and its <symbols> leave out q"
        out.differ("symbols", f"{said}: Robotran's equations have zero there", **where)
    for symbol, value in (("qd", joint.qd), ("qdd", joint.qdd)):
        if value and symbol in kept:
            said = f"joint '{joint.name}' is held, and its {symbol} is {value:.9g}"
            out.differ("symbols", f"{said}: Robotran's equations have it move", **where)


# --- loops ---


def _loops(robot: Robot, mbs: Mbs, out: Coordinates) -> set[str]:
    """The joints that cuts and user constraints tie to each other; says what of these differs."""
    groups: list[tuple[list[Connection], list[dict[str, float]], set[str]]] = []
    if not mbs.cuts and not mbs.user_constraints:
        return set()
    nature = {name: joint.nature for name, joint in mbs.joints().items()}
    tied = [([cut], rows) for cut, rows in _rows(mbs)]
    for constraint in mbs.user_constraints:
        # the factors are in the user functions: some that no two rows share
        row = {name: 1.0 + 0.37 * len(tied) + k for k, name in enumerate(constraint.joints)}
        tied.append(([], [row]))
    for cuts, rows in tied:
        names = {name for row in rows for name in row if nature[name] != "driven"}
        for group in [group for group in groups if not names.isdisjoint(group[2])]:
            groups.remove(group)
            cuts, rows, names = group[0] + cuts, group[1] + rows, group[2] | names
        groups.append((cuts, rows, names))
    stated = {cut.name for cut in mbs.cuts if _is_stated(cut, robot)}
    for cuts, rows, names in groups:
        if cuts:
            own = all(cut.name in stated for cut in cuts)
            _loop(cuts, rows, sorted(names), nature, out, own=own)
    for cut in mbs.cuts:
        what = f"cut '{cut.name}' ({cut.kind})"
        if cut.name in stated:
            out.not_compared[what] = "in <gazebo> of the URDF, whose ends are not read here"
        else:
            out.but_for[what] = "not in the URDF"
    return {name for _, _, names in groups for name in names}


def _loop(
    cuts: list[Connection], rows: list[dict[str, float]], names: list[str],
    nature: Mapping[str, str], out: Coordinates, *, own: bool,
) -> None:  # fmt: skip
    """Compare how many joints of a loop are dependent with how many its constraints want.

    The URDF's ``own`` loop may leave nothing that moves.
    """
    import numpy as np

    matrix = np.array([[row.get(name, 0.0) for name in names] for row in rows])
    rank = int(np.linalg.matrix_rank(matrix, tol=SINGULAR * np.abs(matrix).max())) if names else 0
    who = "cut " + some(f"'{cut.name}'" for cut in cuts)
    dependent = sum(nature[name] == "dependent" for name in names)
    if names and rank >= len(names):
        if own:
            return
        said = f"{who}: nothing can move at {some(names)} any more"
        out.differ("cut", said, joint=names[0])
    elif dependent != rank:
        said = f"{who}: {rank} of {some(names)} must be dependent, and {dependent} are"
        out.differ("cut", said, joint=names[0] if names else None)


def _rows(mbs: Mbs) -> Iterator[tuple[Connection, list[dict[str, float]]]]:
    """The cuts, each with its constraints: their derivatives by the joints, at the start."""
    import numpy as np

    joints, points = mbs.joints(), mbs.points()
    side = mbs_side(mbs, {name for name, joint in joints.items() if joint.nature != "driven"})
    poses = [HERE]
    for group in side.groups[1:]:
        start = group.move(joints[group.coordinate].q or 0.0)
        poses.append(compose(compose(poses[group.parent], group.before), start))
    for cut in mbs.cuts:
        places, ways = [], []
        for body, point in (cut.endpoint1, cut.endpoint2):
            number, own = side.frames[body or ""]
            at = compose(poses[number], own)
            places.append(np.array(moved(at, points[body, point].coordinates) if point else at[9:]))
            ways.append(_way(side, number))
        line = places[1] - places[0]
        line /= np.linalg.norm(line) or 1.0
        parts = {"ball": np.eye(3, 6), "rod": np.array([[*line, 0.0, 0.0, 0.0]])}
        columns = {}
        # a joint that moves both ends alike does not move the cut
        for number in sorted(ways[0] ^ ways[1]):
            group, pose = side.groups[number], poses[number]
            end, sign = (1, 1.0) if number in ways[1] else (0, -1.0)
            axis = np.array(turned(pose, group.axis))
            shift = np.cross(axis, places[end] - pose[9:]) if group.turns else axis
            speed = sign * np.concatenate([shift, axis * group.turns])
            columns[group.coordinate] = parts.get(cut.kind, np.eye(6)) @ speed
        names, table = columns.keys(), zip(*columns.values(), strict=True)
        yield cut, [dict(zip(names, map(float, row), strict=True)) for row in table]


def _way(side: Side, number: int) -> set[int]:
    """The groups from one of them to the ground, without the ground."""
    way = set()
    while number:
        way.add(number)
        number = side.groups[number].parent
    return way


def _is_stated(cut: Connection, robot: Robot) -> bool:
    """True if a joint in the URDF's ``<gazebo>`` has the name of a cut."""
    names = {cut.name, cut.name.removesuffix("_1").removesuffix("_2")}
    return any(joint.name in names for extension in robot.extensions for joint in extension.joints)
