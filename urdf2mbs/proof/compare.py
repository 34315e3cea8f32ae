"""Is an .mbs the same robot as a URDF?  The proof, by a second route.

The .mbs is walked joint by joint, each an elementary shift or turn along a current axis; the
URDF by Rodrigues' formula, with quaternions for its roll, pitch and yaw.  Neither shares a line
with the passes, nor with ``spatial``.

What is compared are the *rigid groups*: all that no moving joint separates.

* Motion: at several random positions, zero included, each group must stand on the group before
  it where its counterpart stands, up to one constant pose between a group and its counterpart.
  Every pose in the world is a product of these.  So the place at zero is compared, and then
  how the joint goes on from there, seen from the group that it moves.
* Inertia: seen through that constant pose, mass, centre and inertia must be equal.
* Frames: each link's frame, and the anchor point of its name, must be where they are said to be.
* Shapes: where the .mbs has a visual's shape elsewhere, the verdict names it; it has no mass.

Why this suffices: where the same inertias move the same way at every position, the kinetic
energy is the same function of positions and velocities, and with equal gravity so is the
potential energy; Lagrange's equations, hence the equations of motion, are then the same.
A joint's pose is a product of sines and cosines of its position, so two that agree at random
positions but differ elsewhere have probability zero.

Everything is relative to its own scale: a shift to the reach of the two groups it is between, a
mass to that mass, an inertia to that inertia.  So a finger's error counts on a crane.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from urdf2mbs.mbs.model import LinkFrame, Mbs, UserModel
from urdf2mbs.proof.comparison import Comparison
from urdf2mbs.proof.coordinates import coordinates
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.parameters import compare_parameters
from urdf2mbs.proof.urdf_side import carriers, urdf_side
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Robot


def compare(
    robot: Robot, mbs: Mbs, joints: Mapping[str, Sequence[str]], *,
    frames: Mapping[str, LinkFrame] | None = None, frozen: Mapping[str, str] | None = None,
    orders: Mapping[str, tuple[str, ...]] | None = None, weightless: Collection[str] = (),
    driven: Collection[str] = (), models: Sequence[UserModel] | None = None,
    gravity: Vec = (0.0, 0.0, -9.81), tolerance: float = TOLERANCE, drawn: Mbs | None = None,
) -> Proof:  # fmt: skip
    """Compare a URDF with an .mbs.

    ``joints`` maps each moving URDF joint to the .mbs joints that move with its coordinates
    (one; three of a planar joint: two shifts and the turn; six of a floating one: T1 T2 T3 R1
    R2 R3, or as ``orders`` has them).  ``frames`` says where link frames are meant to be, as far
    as that is known; without it only the physics is compared.  ``frozen`` joints are held at
    zero on the URDF's side; those of them that are ``weightless`` may move no mass.  ``driven``
    are the .mbs joints that are driven on purpose, though the URDF has them follow others;
    ``models`` the user models as they should be, where that is known.  ``drawn`` is the model
    whose shapes are compared; without it they are not.
    """
    frames, frozen, orders = frames or {}, frozen or {}, orders or {}
    known = coordinates(robot, mbs, joints, frozen, orders, driven)
    more, missing, not_compared = compare_parameters(robot, mbs, joints, frozen, models)
    framed = {at.joint for at in frames.values()}
    one = urdf_side(robot, known.names, known.held, orders)
    one.gravity = gravity
    two = mbs_side(mbs, set(known.names.values()), framed)
    comparison = Comparison(one, two, known.names, frames, tolerance)
    comparison.found += [*known.differences, *more, *_heavy(robot, weightless)]
    comparison.compare_gravity()
    comparison.compare_groups()
    comparison.compare_frames()
    comparison.compare_points(mbs)
    held = {f"joint '{name}'": f"held at zero: {why}" for name, why in frozen.items()}
    shifted, not_drawn = ({}, {}) if drawn is None else comparison.compare_shapes(robot, drawn)
    return comparison.proof(
        held | known.but_for | missing | shifted, known.not_compared | not_compared | not_drawn
    )


def _heavy(robot: Robot, weightless: Collection[str]) -> list[Difference]:
    """The joints that are left out as without mass, and that move a mass."""
    useful = carriers(robot) if weightless else set()
    return [
        Difference(
            "joint-missing", f"joint '{name}' is left out, and it moves what has mass",
            link=robot.joints[name].child, joint=name,
        )
        for name in weightless
        if robot.joints[name].child in useful
    ]  # fmt: skip
