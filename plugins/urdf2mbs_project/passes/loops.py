"""Loops: cuts that close kinematic loops, which a URDF cannot.

Beyond the method.  A cut ties two points: ``ball`` makes them coincide (3 constraints), ``rod``
keeps their distance (1), ``solid`` fixes one body to the other (6).  Cuts come from the config, and
from SDF joints inside ``<gazebo>`` between two links of the robot.  SDF places these where all
joints are at zero, whatever the start position.

Each independent constraint makes one joint dependent: a joint whose column of the constraints'
Jacobian, at the start position, is independent of those chosen before.  Joints without a motor come
first, and joints further out before joints nearer to the base.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import asin, dist
from typing import TYPE_CHECKING, Literal

import msgspec

from urdf2mbs.plugin import (
    ClosingJoint,
    ConfigError,
    Connection,
    Conversion,
    Mbs,
    Pass,
    Placed,
    Placement,
    Pose,
    PositiveLength,
    Vec,
    compose,
    counted,
    fits,
    free_name,
    inverse,
    multiply,
    rotate,
    some,
    transpose,
    unit,
)
from urdf2mbs_project.places import point_at
from urdf2mbs_project.ranges import End
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, Mass

#: A loop counts as closed up to this (m or rad).
CLOSED = 1e-6
#: A column of the Jacobian that is so near to others, relative to the largest element, depends on
#: them.
SINGULAR = 1e-6
#: From one ball to the other along the axis of a revolute joint (m).
APART = 0.1


CutKind = Literal["ball", "rod", "solid"]


class Cut(msgspec.Struct, forbid_unknown_fields=True):
    ends: tuple[End, End]
    """``[{link: a, at: [x, y, z]}, {link: b, at: [x, y, z]}]``"""
    kind: CutKind = "ball"
    """``ball`` (3 constraints), ``rod`` (1) or ``solid`` (6)."""
    length: PositiveLength | None = None
    """Of a rod (m); none: the distance at the start position."""


class Loops(Pass):
    reads = ("robot", "bodies", "inertias", "joints", "couplings", "anchors", "posture")
    writes = ("couplings", "anchors", "forces")

    cuts: dict[str, Cut] = {}
    """Name: ``{kind: ball, rod or solid, ends: [{link, at}, {link, at}], length}``."""
    from_urdf: bool = True
    """Use the joints inside ``<gazebo>`` that close a loop."""
    dependent: list[str] = []
    """Patterns of the joints that become dependent, in place of the pass's own choice."""

    def run(self, conversion: Conversion) -> None:
        mbs = conversion.mbs
        cuts = dict(self.cuts)
        doubtful: set[str] = set()
        left_out: dict[str, list[ClosingJoint]] = {}
        for extension in conversion.robot.extensions if self.from_urdf else ():
            for joint in extension.joints:
                if joint.name not in self.cuts:
                    why = _from_sdf(conversion, joint, cuts, doubtful)
                    if why:
                        left_out.setdefault(why, []).append(joint)
                    conversion.state(Placed).elements.append(extension)
        for why, (first, *others) in left_out.items():
            joints = some((f"joint '{joint.name}'" for joint in (first, *others)), 4)
            text = f"a joint in <gazebo> is left out: {why}: {joints}"
            conversion.warn("loop-left-out", text, joint=first.name, line=first.line)
        if not cuts:
            return
        from urdf2mbs_project.mass import Mass

        _add_cuts(conversion, cuts)
        mass = Mass(mbs)
        placement = mass.placement
        for connection in mbs.cuts:
            if connection.kind == "rod":
                given = cuts[connection.name].length
                distance = dist(*_ends(placement, mbs, connection))
                connection.length = distance if given is None else given
        _drop_needless(conversion, mass, doubtful)
        jacobian = _jacobian(conversion, mass)
        dependent = independent_columns(jacobian, _order(conversion, placement, self))
        if self.dependent and len(dependent) < _rank(jacobian):
            raise ConfigError(
                "loops-dependent",
                f"loops: the cuts make {_rank(jacobian)} joints dependent, of which "
                f"{len(dependent)} can be among those in 'dependent'",
                hint="name more, or leave 'dependent' out to have them chosen",
            )
        for index in dependent:
            placement.joints[index].joint.nature = "dependent"
            placement.joints[index].joint.actuated = False
        _warn_of_open(conversion, placement)
        names = [placement.joints[index].joint for index in dependent]
        conversion.report["loops"] = {"cuts": mbs.cuts, "dependent": names}
        conversion.note(
            "loops",
            f"{counted(len(mbs.cuts), 'cut')} {'makes' if len(mbs.cuts) == 1 else 'make'} "
            f"{counted(len(names), 'joint')} dependent: "
            f"{', '.join(joint.name for joint in names) or 'none'}",
        )


# --- where cuts come from ---


def _from_sdf(
    conversion: Conversion, joint: ClosingJoint, cuts: dict[str, Cut], doubtful: set[str]
) -> str:
    """Add the cuts of an SDF joint; gives why there is none.

    The names of those that may add no constraint go to ``doubtful``.

    A ball holds the joint's point.  A revolute joint has a second ball on its axis; a universal
    joint has a rod from the first axis, in the parent, to the second one, in the child, which
    holds the angle between them.
    """

    if joint.type not in ("ball", "universal", "revolute", "continuous", "fixed"):
        return f"it closes a loop by a {joint.type} joint, for which Robotran has no cut"
    poses = conversion.robot.poses()
    seen = compose(inverse(poses[joint.parent]), poses[joint.child])

    def cut(kind: CutKind, at_parent: Vec, at_child: Vec) -> Cut:
        there = compose(seen, Pose(at_parent)).xyz
        length = dist(at_parent, at_child) if kind == "rod" else None
        return Cut((End(joint.parent, there), End(joint.child, at_child)), kind, length)

    at = joint.pose.xyz
    parts = [cut("solid" if joint.type == "fixed" else "ball", at, at)]
    axes = [unit(axis) for axis in joint.axes] or [rotate(joint.pose.rot, (0.0, 0.0, 1.0))]
    ends = [(at[0] + APART * x, at[1] + APART * y, at[2] + APART * z) for x, y, z in axes]
    if joint.type in ("revolute", "continuous"):
        parts.append(cut("ball", ends[0], ends[0]))
    elif joint.type == "universal":
        if not APART < dist(ends[0], ends[-1]) < 1.9 * APART:
            return "a universal joint wants two axes, at right angles"
        parts.append(cut("rod", ends[0], ends[-1]))
    taken = {*cuts, *conversion.robot.links}
    for number, part in enumerate(parts, start=1):
        name = joint.name if len(parts) == 1 else f"{joint.name}_{number}"
        own = free_name(name, taken)
        taken.add(own)
        if own != name:
            conversion.warn(
                "loop-renamed",
                f"joint '{joint.name}' in <gazebo>: '{name}' is a cut or a link already, and the "
                f"cut is called '{own}'",
                line=joint.line,
            )
        cuts[own] = part
        if number == 2:
            doubtful.add(own)
    return ""


def _add_cuts(conversion: Conversion, cuts: dict[str, Cut]) -> None:
    """Add the cuts to the model, with the points where they end."""
    for name, cut in cuts.items():
        if name in conversion.robot.links:
            raise ConfigError("loops-name", f"loops: a cut and a link are both called '{name}'")
        if cut.length is not None and cut.kind != "rod":
            raise ConfigError(
                "loops-length", f"loops: cut '{name}' ({cut.kind}) has the length {cut.length}",
                hint="only a rod has a length",
            )  # fmt: skip
        what = f"loops: cut '{name}' ends at"
        ends = [
            conversion.add_point(f"{name}_{number}", end.link, end.at, "loops-link", what)
            for number, end in enumerate(cut.ends, start=1)
        ]
        one, two = ((body, point.name) for body, point in ends)
        conversion.mbs.cuts.append(Connection(cut.kind, name, one, two))


# --- the Jacobian ---


def _ends(placement: Placement, mbs: Mbs, connection: Connection) -> tuple[Vec, Vec]:
    one, two = connection.endpoint1, connection.endpoint2
    return point_at(placement, mbs, *one), point_at(placement, mbs, *two)


def _jacobian(conversion: Conversion, mass: Mass) -> Array:
    """The derivatives of the constraints of all cuts by the joints, a row for each constraint.

    The derivative by a follower (mimic) is added to its leader's; that by a driven joint is 0.
    """
    import numpy as np

    from urdf2mbs_project.stability import closing_rows

    joints = [placed.joint for placed in mass.placement.joints]
    rows = [row for cut in conversion.mbs.cuts for row in closing_rows(mass, cut)]
    jacobian: Array = np.reshape(np.array(rows, float), (-1, len(joints)))
    jacobian[:, [joint.nature == "driven" for joint in joints]] = 0.0
    index = {id(joint): k for k, joint in enumerate(joints)}
    for coupling in conversion.state(Simulation).couplings:
        follower, leader = index[id(coupling.follower)], index[id(coupling.leader)]
        jacobian[:, leader] += coupling.multiplier * jacobian[:, follower]
        jacobian[:, follower] = 0.0
    return jacobian


def _order(conversion: Conversion, placement: Placement, options: Loops) -> list[int]:
    """The joints that may become dependent, the best first."""
    free = {
        id(joint)
        for step, joint in conversion.single_coordinates()
        if joint.nature == "independent" and fits(step.joint.name, options.dependent or ["*"])
    }
    indices = [i for i, placed in enumerate(placement.joints) if id(placed.joint) in free]
    return sorted(indices, key=lambda i: (placement.joints[i].joint.actuated, -i))


def independent_columns(jacobian: Array, order: Iterable[int]) -> list[int]:
    """As many of the columns in ``order`` as are linearly independent, the first before others
    (Gram and Schmidt)."""
    import numpy as np

    scale = np.abs(jacobian).max(initial=0.0)
    basis = np.zeros((len(jacobian), 0))
    chosen: list[int] = []
    # first the columns that are far from all others, so that constraints can be solved for them
    for least in (1e-2, SINGULAR):
        for column in order:
            rest = jacobian[:, column]
            for _ in range(2):  # once more, for the digits that the first time has lost
                rest = rest - basis @ (basis.T @ rest)
            length = np.linalg.norm(rest)
            if length > least * scale:
                chosen.append(column)
                basis = np.column_stack([basis, rest / length])
    return chosen


def _rank(jacobian: Array) -> int:
    """The number of independent constraints."""
    return len(independent_columns(jacobian, range(jacobian.shape[1])))


def _drop_needless(conversion: Conversion, mass: Mass, doubtful: set[str]) -> None:
    """Drop the cuts that add no constraint."""
    mbs = conversion.mbs
    for cut in [cut for cut in mbs.cuts if cut.name in doubtful]:
        before = _rank(_jacobian(conversion, mass))
        mbs.cuts.remove(cut)
        if _rank(_jacobian(conversion, mass)) < before:
            mbs.cuts.append(cut)
            continue
        ends = (cut.endpoint1, cut.endpoint2)
        for name, owner in mbs.base_and_bodies():
            owner.points = [point for point in owner.points if (name, point.name) not in ends]


def _warn_of_open(conversion: Conversion, placement: Placement) -> None:
    """Warn of each loop that is open at the start position."""
    mbs = conversion.mbs
    for cut in mbs.cuts:
        one, two = _ends(placement, mbs, cut)
        off = dist(one, two)
        if cut.kind == "rod":
            off = abs(off - (cut.length or 0.0))
        gap = f"{off:.3g} m"
        if cut.kind == "solid":
            a, b = (placement.bodies[end[0]].rot for end in (cut.endpoint1, cut.endpoint2))
            turned = multiply(transpose(a), b)
            # a solid keeps the axes of the two bodies parallel
            chord = dist(turned, (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
            angle = 2.0 * asin(min(1.0, chord / 8**0.5))  # |R - 1| = 8^(1/2) sin(angle / 2)
            if angle > CLOSED:
                gap += f" and {angle:.3g} rad"
                off = max(off, angle)
        if off > CLOSED:
            from urdf2mbs_equations.constraints import constant_gaps  # seldom needed: slow
            from urdf2mbs_equations.files import NEVER_CLOSES  # seldom needed: slow

            gaps = [message for name, message in constant_gaps(mbs) if name == cut.name]
            for message in gaps:
                conversion.warn("loop-never-closes", message, hint=NEVER_CLOSES)
            if not gaps:
                conversion.warn(
                    "loop-open",
                    f"cut '{cut.name}' is open at the start position, by {gap}: Robotran will try "
                    "to close it",
                    hint="give a start position that closes it: 'passes: {posture: {joints: ...}}'",
                )
