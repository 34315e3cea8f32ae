"""Compare an .mbs with a URDF: is it the same robot?  This is the proof, by a second route.

The .mbs is evaluated joint by joint, each an elementary shift or rotation along a current axis; the
URDF by Rodrigues' formula, with quaternions for its roll, pitch and yaw.  Neither shares a line
with the passes, nor with ``spatial``.

The *rigid groups* are compared: the bodies that no moving joint separates.

* Motion: at several random positions, zero included, each group must have the pose of its
  counterpart in the parent group, up to one constant pose between a group and its counterpart.
  Every pose in the world is a product of these.  So the poses at zero are compared, and then the
  motion of the joint from there, in the frame of the group that it moves.
* Order: of two joints that commute, as shifts do, either may come first (``reorder``).
* Inertia: mass, centre of mass and inertia tensor must be equal, transformed by that constant pose.
* Frames: the frame of each link, and the anchor point of its name, must be where they should be.
* Shapes: where the .mbs has the shape of a visual elsewhere, the verdict names it; it has no mass.

Why this suffices: where the same inertias move in the same way at every position, the kinetic
energy is the same function of positions and velocities, and with equal gravity so is the potential
energy; Lagrange's equations, hence the equations of motion, are then the same.  The pose of a joint
is a product of sines and cosines of its position, so two that agree at random positions but differ
elsewhere have probability zero.

Each deviation is relative to its own scale: a shift to the reach of the two groups that it is
between, a mass to that mass, an inertia to that inertia.  So the error of a finger on a crane is
found.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import msgspec

from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.proof.comparison import Comparison, ShapeComparison
from urdf2mbs.proof.coordinates import match_coordinates
from urdf2mbs.proof.match import Match
from urdf2mbs.proof.mbs_side import build_mbs_side
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.parameters import compare_parameters
from urdf2mbs.proof.reorder import reorder_joints
from urdf2mbs.proof.urdf_side import build_urdf_side, find_links_that_carry_mass
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Robot


class Expectation(msgspec.Struct, kw_only=True):
    """Expectations of an .mbs that its URDF does not state."""

    gravity: Vec = (0.0, 0.0, -9.81)
    """m/s^2."""
    massless: Collection[str] = ()
    """The locked joints of the URDF that are locked because they move no mass."""
    driven: Collection[str] = ()
    """The .mbs joints that user code moves on purpose, though they follow others in the URDF."""
    user_models: Sequence[UserModel] | None = None
    """The user models that the passes made; None if they are not known."""
    shapes: Mbs | None = None
    """The model whose shapes are compared with the visuals; None: they are not compared."""


def compare(
    robot: Robot,
    mbs: Mbs,
    match: Match,
    expectation: Expectation | None = None,
    tolerance: float = TOLERANCE,
) -> Proof:
    """Compare a URDF with an .mbs.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        match: Which joints and frames of the .mbs are those of the URDF.  Without frames, only the
            physics is compared.
        expectation: Expectations of the .mbs that the URDF does not state.
        tolerance: The largest deviation that is not a difference.
    """
    expectation = expectation or Expectation()
    coordinates = match_coordinates(robot, mbs, match, expectation.driven)
    parameters = compare_parameters(robot, mbs, match, expectation.user_models)
    urdf = build_urdf_side(robot, coordinates.names, coordinates.locked, match.floating_orders)
    urdf.gravity = expectation.gravity
    framed_joints = {frame.joint for frame in match.frames.values()}
    mbs_side = build_mbs_side(mbs, set(coordinates.names.values()), framed_joints)
    reorder_joints(urdf, mbs_side, coordinates.names)
    comparison = Comparison(
        urdf=urdf,
        mbs=mbs_side,
        names=coordinates.names,
        frames=match.frames,
        tolerance=tolerance,
    )
    comparison.differences += [
        *coordinates.differences,
        *parameters.differences,
        *_find_locked_mass(robot, expectation.massless),
    ]
    comparison.compare_gravity()
    comparison.compare_groups()
    comparison.compare_frames()
    comparison.compare_points(mbs)
    shapes = ShapeComparison({}, {})
    if expectation.shapes is not None:
        shapes = comparison.compare_shapes(robot, expectation.shapes)
    locked = {f"joint '{name}'": f"held at zero: {why}" for name, why in match.locked.items()}
    return comparison.create_proof(
        but_for=locked | coordinates.but_for | parameters.but_for | shapes.displaced,
        not_compared=coordinates.not_compared | parameters.not_compared | shapes.missing,
    )


def _find_locked_mass(robot: Robot, massless: Collection[str]) -> list[Difference]:
    """Find the joints that are left out as massless, and that move a mass.

    Args:
        robot: The robot of the URDF.
        massless: Names of the joints that are left out.
    """
    carriers = find_links_that_carry_mass(robot) if massless else set()
    return [
        Difference(
            "joint-missing",
            f"joint '{name}' is left out as massless, but it moves a mass",
            link=robot.joints[name].child,
            joint=name,
        )
        for name in massless
        if robot.joints[name].child in carriers
    ]
