"""Loops: add cuts that close kinematic loops, which a URDF cannot express.

Beyond the method.  A cut ties two points: ``ball`` makes them coincide (3 constraints), ``rod``
keeps their distance (1), ``solid`` fixes one body to the other (6).  Cuts come from the config, and
from SDF joints inside ``<gazebo>`` between two links of the robot.  SDF places these where all
joints are at zero, whatever the start position.

Each independent constraint makes one joint dependent: a joint whose column of the constraints'
Jacobian, at the start position, is linearly independent of those chosen before.  Joints without a
motor come first, and joints further out before joints nearer to the base.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, dist, sqrt
from typing import TYPE_CHECKING, Literal, NamedTuple

import msgspec

from urdf2mbs.plugin import (
    IDENTITY,
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
    add,
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
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_project.ranges import End
from urdf2mbs_project.simulation import Simulation

if TYPE_CHECKING:
    from urdf2mbs_project.mass import Array, MassModel

#: A loop is closed up to this (m or rad).
CLOSED = 1e-6
#: A column of the Jacobian depends on others if no more than this is independent of them, relative
#: to the largest element.
SINGULAR = 1e-6
#: ... and it is far from all others above this.
WELL_CONDITIONED = 1e-2
#: Distance from one ball to the other along the axis of a revolute joint (m).
BALL_DISTANCE = 0.1
#: The SDF joints that cuts can replace.
CUT_TYPES = ("ball", "universal", "revolute", "continuous", "fixed")

CutKind = Literal["ball", "rod", "solid"]


class Cut(msgspec.Struct, forbid_unknown_fields=True):
    """A cut between points of two links."""

    ends: tuple[End, End]
    """``[{link: a, at: [x, y, z]}, {link: b, at: [x, y, z]}]``"""
    kind: CutKind = "ball"
    """``ball`` (3 constraints), ``rod`` (1) or ``solid`` (6)."""
    length: PositiveLength | None = None
    """Of a rod (m); none: the distance at the start position."""


class Loops(Pass):
    """Add the cuts of loops, and choose the joints that become dependent."""

    reads = ("robot", "bodies", "inertias", "joints", "couplings", "anchors", "posture")
    writes = ("couplings", "anchors", "forces")

    cuts: dict[str, Cut] = {}
    """Name: ``{kind: ball, rod or solid, ends: [{link, at}, {link, at}], length}``."""
    from_urdf: bool = True
    """Use the joints inside ``<gazebo>`` that close a loop."""
    dependent: list[str] = []
    """Patterns of the joints that become dependent, in place of the pass's own choice."""

    def run(self, conversion: Conversion) -> None:
        """Add the cuts, and make one joint dependent for each independent constraint."""
        mbs = conversion.mbs
        cuts = dict(self.cuts)
        optional = self._add_urdf_cuts(conversion, cuts) if self.from_urdf else set()
        if not cuts:
            return
        from urdf2mbs_project.mass import MassModel

        _add_cuts(conversion, cuts)
        mass = MassModel(mbs)
        placement = mass.placement
        for connection in mbs.cuts:
            if connection.kind == "rod":
                length = cuts[connection.name].length
                distance = dist(*_compute_end_positions(placement, mbs, connection))
                connection.length = distance if length is None else length
        _drop_redundant_cuts(conversion, mass, optional)
        dependent = self._choose_dependent(conversion, mass)
        joints = [placement.joints[index].joint for index in dependent]
        for joint in joints:
            joint.nature = "dependent"
            joint.actuated = False
        for cut in mbs.cuts:
            _warn_if_open(conversion, placement, cut)
        conversion.report["loops"] = {"cuts": mbs.cuts, "dependent": joints}
        conversion.note(
            "loops",
            f"{counted(len(mbs.cuts), 'cut')} {'makes' if len(mbs.cuts) == 1 else 'make'} "
            f"{counted(len(joints), 'joint')} dependent: "
            f"{', '.join(joint.name for joint in joints) or 'none'}",
        )

    def _add_urdf_cuts(self, conversion: Conversion, cuts: dict[str, Cut]) -> set[str]:
        """Add the cuts of the joints inside ``<gazebo>``, and warn of those that have none.

        Returns:
            The names of the cuts that may add no constraint.
        """
        optional: set[str] = set()
        left_out: dict[str, list[ClosingJoint]] = {}
        for extension in conversion.robot.extensions:
            for joint in extension.joints:
                if joint.name not in self.cuts:
                    replacement = replace_sdf_joint(conversion, joint)
                    if replacement.reason:
                        left_out.setdefault(replacement.reason, []).append(joint)
                    optional |= name_cuts(conversion, joint, replacement.cuts, cuts)
                    conversion.state(Placed).elements.append(extension)
        for reason, joints in left_out.items():
            names = some((f"joint '{joint.name}'" for joint in joints), 4)
            message = f"a joint in <gazebo> is left out: {reason}: {names}"
            first = joints[0]
            conversion.warn("loop-left-out", message, joint=first.name, line=first.line)
        return optional

    def _choose_dependent(self, conversion: Conversion, mass: MassModel) -> list[int]:
        """Choose the indices of the joints that become dependent.

        Raises:
            ConfigError: The option names too few joints.
        """
        jacobian = compute_cut_jacobian(conversion, mass)
        candidates = _order_candidates(conversion, mass.placement, self.dependent or ["*"])
        dependent = choose_independent_columns(jacobian, candidates)
        if not self.dependent:
            return dependent
        n_constraints = _compute_rank(jacobian)
        if len(dependent) < n_constraints:
            message = (
                f"loops: the cuts make {n_constraints} joints dependent, of which "
                f"{len(dependent)} can be among those in 'dependent'"
            )
            hint = "name more, or leave 'dependent' out to have them chosen"
            raise ConfigError("loops-dependent", message, hint=hint)
        return dependent


# --- where cuts come from ---


class Replacement(NamedTuple):
    """The cuts that replace an SDF joint; without cuts, the reason."""

    cuts: list[Cut]
    reason: str = ""


def replace_sdf_joint(conversion: Conversion, joint: ClosingJoint) -> Replacement:
    r"""Replace an SDF joint by cuts.

    A ball holds the joint's point.  A revolute joint has a second ball on its axis.  A universal
    joint has a rod from the first axis, in the parent, to the second one, in the child, which
    holds the angle between them::

        revolute              universal

        --o-----o--  axis         o first axis
          ball  ball              | \\
                                  |   \\ rod
                             ball o----o second axis
    """
    if joint.type not in CUT_TYPES:
        reason = f"it closes a loop by a {joint.type} joint, for which Robotran has no cut"
        return Replacement([], reason)
    poses = conversion.robot.poses()
    child_to_parent = compose(inverse(poses[joint.parent]), poses[joint.child])

    def make_cut(kind: CutKind, parent_point: Vec, child_point: Vec) -> Cut:
        """Return a cut between two points (m), both in the frame of the child."""
        in_parent = compose(child_to_parent, Pose(parent_point)).xyz
        length = dist(parent_point, child_point) if kind == "rod" else None
        return Cut((End(joint.parent, in_parent), End(joint.child, child_point)), kind, length)

    origin = joint.pose.xyz
    cuts = [make_cut("solid" if joint.type == "fixed" else "ball", origin, origin)]
    axes = [unit(axis) for axis in joint.axes] or [rotate(joint.pose.rot, (0.0, 0.0, 1.0))]
    points = [
        add(origin, (BALL_DISTANCE * x, BALL_DISTANCE * y, BALL_DISTANCE * z)) for x, y, z in axes
    ]
    if joint.type in ("revolute", "continuous"):
        cuts.append(make_cut("ball", points[0], points[0]))
    elif joint.type == "universal":
        if not BALL_DISTANCE < dist(points[0], points[-1]) < 1.9 * BALL_DISTANCE:
            return Replacement([], "a universal joint requires two axes, at right angles")
        cuts.append(make_cut("rod", points[0], points[-1]))
    return Replacement(cuts)


def name_cuts(
    conversion: Conversion, joint: ClosingJoint, new_cuts: list[Cut], cuts: dict[str, Cut]
) -> set[str]:
    """Add the cuts of an SDF joint to all cuts, by names that no cut or link has.

    Returns:
        The name of the second cut, which may add no constraint.
    """
    optional: set[str] = set()
    used_names = {*cuts, *conversion.robot.links}
    for number, cut in enumerate(new_cuts, start=1):
        name = joint.name if len(new_cuts) == 1 else f"{joint.name}_{number}"
        unique_name = free_name(name, used_names)
        used_names.add(unique_name)
        if unique_name != name:
            message = (
                f"joint '{joint.name}' in <gazebo>: '{name}' is a cut or a link already, and the "
                f"cut is called '{unique_name}'"
            )
            conversion.warn("loop-renamed", message, line=joint.line)
        cuts[unique_name] = cut
        if number == 2:
            optional.add(unique_name)
    return optional


def _add_cuts(conversion: Conversion, cuts: dict[str, Cut]) -> None:
    """Add the cuts to the model, with the points where they end."""
    for name, cut in cuts.items():
        if name in conversion.robot.links:
            raise ConfigError("loops-name", f"loops: a cut and a link are both called '{name}'")
        if cut.length is not None and cut.kind != "rod":
            message = f"loops: cut '{name}' ({cut.kind}) has the length {cut.length}"
            raise ConfigError("loops-length", message, hint="only a rod has a length")
        text = f"loops: cut '{name}' ends at"
        ends = [
            conversion.add_point(f"{name}_{number}", end.link, end.at, "loops-link", text)
            for number, end in enumerate(cut.ends, start=1)
        ]
        first, second = ((body, point.name) for body, point in ends)
        conversion.mbs.cuts.append(Connection(cut.kind, name, first, second))


# --- the Jacobian ---


def _compute_end_positions(
    placement: Placement, mbs: Mbs, connection: Connection
) -> tuple[Vec, Vec]:
    """Compute the positions (m, in the base) of the two ends of a cut."""
    first, second = connection.endpoint1, connection.endpoint2
    return (
        compute_point_position(placement, mbs, *first),
        compute_point_position(placement, mbs, *second),
    )


def compute_cut_jacobian(conversion: Conversion, mass: MassModel) -> Array:
    """Compute the Jacobian of the constraints of all cuts.

    Returns:
        (k, n), the derivatives of the k constraints by the n joints.  The column of a follower
        (mimic) is added to its leader's; that of a driven joint is 0.
    """
    import numpy as np

    from urdf2mbs_project.stability import compute_constraint_rows

    joints = [placed.joint for placed in mass.placement.joints]
    rows = [row for cut in conversion.mbs.cuts for row in compute_constraint_rows(mass, cut)]
    jacobian: Array = np.reshape(np.array(rows, float), (-1, len(joints)))
    jacobian[:, [joint.nature == "driven" for joint in joints]] = 0.0
    index = {id(joint): k for k, joint in enumerate(joints)}
    for coupling in conversion.state(Simulation).couplings:
        follower, leader = index[id(coupling.follower)], index[id(coupling.leader)]
        jacobian[:, leader] += coupling.multiplier * jacobian[:, follower]
        jacobian[:, follower] = 0.0
    return jacobian


def _order_candidates(
    conversion: Conversion, placement: Placement, patterns: list[str]
) -> list[int]:
    """Return the indices of the joints that may become dependent, the best first."""
    candidates = {
        id(joint)
        for step, joint in conversion.single_coordinates()
        if joint.nature == "independent" and fits(step.joint.name, patterns)
    }
    indices = [k for k, placed in enumerate(placement.joints) if id(placed.joint) in candidates]
    return sorted(indices, key=lambda k: (placement.joints[k].joint.actuated, -k))


def choose_independent_columns(jacobian: Array, candidates: Sequence[int]) -> list[int]:
    """Choose linearly independent columns of a matrix, by Gram and Schmidt's method.

    Args:
        jacobian: (k, n).
        candidates: Indices of columns, the preferred ones first.
    """
    import numpy as np

    scale = np.abs(jacobian).max(initial=0.0)
    basis = np.zeros((len(jacobian), 0))
    chosen: list[int] = []
    # Columns that are far from all others come first, so that constraints can be solved for them.
    for least in (WELL_CONDITIONED, SINGULAR):
        for column in candidates:
            rest = jacobian[:, column]
            for _ in range(2):  # The second time regains the digits that the first one lost.
                rest = rest - basis @ (basis.T @ rest)
            length = np.linalg.norm(rest)
            if length > least * scale:
                chosen.append(column)
                basis = np.column_stack([basis, rest / length])
    return chosen


def _compute_rank(jacobian: Array) -> int:
    """Return the number of independent constraints."""
    return len(choose_independent_columns(jacobian, range(jacobian.shape[1])))


def _drop_redundant_cuts(conversion: Conversion, mass: MassModel, optional: set[str]) -> None:
    """Drop those of the optional cuts that add no constraint, and their points."""
    mbs = conversion.mbs
    optional_cuts = [cut for cut in mbs.cuts if cut.name in optional]
    if not optional_cuts:
        return
    # a cut is dropped only if the rank stays
    rank = _compute_rank(compute_cut_jacobian(conversion, mass))
    for cut in optional_cuts:
        mbs.cuts.remove(cut)
        if _compute_rank(compute_cut_jacobian(conversion, mass)) < rank:
            mbs.cuts.append(cut)
            continue
        ends = (cut.endpoint1, cut.endpoint2)
        for name, owner in mbs.base_and_bodies():
            owner.points = [point for point in owner.points if (name, point.name) not in ends]


# --- loops that are open ---


def _warn_if_open(conversion: Conversion, placement: Placement, cut: Connection) -> None:
    """Warn of a loop that is open at the start position."""
    first, second = _compute_end_positions(placement, conversion.mbs, cut)
    distance = dist(first, second)
    if cut.kind == "rod":
        distance = abs(distance - (cut.length or 0.0))
    angle = _compute_solid_angle(placement, cut) if cut.kind == "solid" else 0.0
    if max(distance, angle) <= CLOSED:
        return
    from urdf2mbs_equations.constraints import find_constant_gaps  # seldom needed: slow
    from urdf2mbs_equations.files import NEVER_CLOSES  # seldom needed: slow

    gaps = [message for name, message in find_constant_gaps(conversion.mbs) if name == cut.name]
    for message in gaps:
        conversion.warn("loop-never-closes", message, hint=NEVER_CLOSES)
    if not gaps:
        gap = f"{distance:.3g} m"
        if angle > CLOSED:
            gap += f" and {angle:.3g} rad"
        message = (
            f"cut '{cut.name}' is open at the start position, by {gap}: Robotran will try to "
            "close it"
        )
        hint = "give a start position that closes it: 'passes: {posture: {joints: ...}}'"
        conversion.warn("loop-open", message, hint=hint)


def _compute_solid_angle(placement: Placement, cut: Connection) -> float:
    """Compute the angle (rad) between two bodies whose axes a solid keeps parallel.

    A rotation R by the angle a has ``|R - 1| = 8^(1/2) sin(a / 2)``.
    """
    first, second = (placement.bodies[end[0]].rot for end in (cut.endpoint1, cut.endpoint2))
    chord = dist(multiply(transpose(first), second), IDENTITY)
    return 2.0 * asin(min(1.0, chord / sqrt(8.0)))
