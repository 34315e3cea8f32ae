r"""Align frames: turn each body's frame so that a coordinate axis lies along its joint's axis.

Beyond the method.  The method's Table A.2 turns the frame before a joint, and turns it back after
the joint.  Turning back is never needed: whatever is constant in a body can be written in any
frame.  So centre, inertia, points, visuals and the next joints are written in the frame that the
joint leaves.  The turns before a joint bring a coordinate axis onto the joint's direction u.  No
turn is needed if u is +x, +y or +z.  One turn is needed if u has a zero component or is a negative
axis, else two.  The joint's coordinate stays the URDF's: same zero, same sign.

Each body's frame may have any angle about its own joint's axis u, which is its x.  As by Denavit
and Hartenberg, y is in the plane of u and the axis p of the joint before; if the two are parallel,
p is the second axis of the frame before::

        y ^     p   (axis of the joint before)
          |    /
          |   /
          |  /
          | /
          |/
          +-----------> x = u

The four quarter turns of this frame about u are its *candidates*.  Dynamic programming chooses
among them: from the tips of the tree to the base, each joint adds to every candidate of its parent
frame the fewest turns of its branch; from the base to the tips, each frame takes its best one.
"""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

from urdf2mbs.plugin import (
    IDENTITY,
    ROUNDING,
    Conversion,
    Pass,
    Pose,
    Rot,
    Step,
    Tolerance,
    UrdfJoint,
    Vec,
    axis_turns,
    cross,
    direction,
    dot,
    drop_rounding,
    fewest_turns,
    from_turns,
    multiply,
    rotate,
    transpose,
    unit,
)

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class AlignFrames(Pass):
    """Turn the frame of each body along its joint, which saves driven joints."""

    reads = ("bodies",)
    writes = ("bodies",)

    tolerance: Tolerance = ROUNDING
    """A direction counts as on a coordinate axis or plane if it is at most this (rad) off.  The
    default is rounding; 1e-9 also takes angles written as 1.570796327, and says how far off they
    are."""

    def run(self, conversion: Conversion) -> None:
        """Choose the frames, and write all that is constant in a body in its new frame."""
        placed_steps = _place_steps(conversion, self.tolerance)
        joint_frames = [
            placed_step.frame for placed_step in placed_steps if placed_step.step.joint.moves
        ]
        for joint_frame in reversed(joint_frames):
            joint_frame.count_turns()
        for placed_step in placed_steps:
            placed_step.step.turns = ()
        for joint_frame in joint_frames:
            joint_frame.choose_candidate()
            if joint_frame.step.joint.type != "floating":
                _align_axis(conversion, joint_frame)
        conversion.aligned = True
        n_driven = sum(len(joint_frame.step.turns) for joint_frame in joint_frames)
        conversion.report["align-frames"] = {"driven": n_driven}
        _write_frames(conversion, placed_steps)


class JointFrame:
    """The frame after a moving joint, or that of the ground, which cannot be turned."""

    def __init__(
        self, step: Step, parent: JointFrame | None, rotation: Rot, tolerance: float
    ) -> None:
        self.step = step
        """The joint that moves the frame."""
        self.parent = parent or self
        """The frame before the joint; the ground's is its own parent."""
        self.rotation = rotation
        """Rotation of the URDF's link frame in that of the parent, the joint at zero."""
        self.tolerance = tolerance
        """An element of a rotation up to this counts as zero."""
        self.candidates = [IDENTITY]
        """The rotations to choose from, in the URDF's link frame."""
        if step.joint.type == "planar":
            self.candidates = [from_turns(axis_turns(step.axis)[0])]
        elif step.joint.type not in ("fixed", "floating"):
            self.candidates = self._list_quarter_turns(direction(step.axis))
        self.costs = [0] * len(self.candidates)
        """For each candidate, the fewest turns of all joints after this frame."""
        self.best_candidates: list[int] = []
        """For each candidate of the parent, the number of the best candidate of this frame."""
        self.chosen = 0
        """The number of the chosen candidate."""
        self.link_rotation = IDENTITY
        """Rotation of the URDF's link frame in the chosen frame."""

    def _list_quarter_turns(self, axis: Vec) -> list[Rot]:
        """Return the frame in the picture at the top of this file, and its three quarter turns.

        Args:
            axis: The joint's axis u, in the URDF's link frame.
        """
        parent_axes = multiply(transpose(self.rotation), self.parent.candidates[0])
        r11, r12, _, r21, r22, _, r31, r32, _ = parent_axes
        y_axis = _compute_rejection((r11, r21, r31), axis, self.tolerance)
        y_axis = y_axis or _compute_rejection((r12, r22, r32), axis, self.tolerance)
        assert y_axis is not None  # the joint is parallel to one of the two axes at most
        y, z = y_axis, cross(axis, y_axis)
        minus_y, minus_z = (-y[0], -y[1], -y[2]), (-z[0], -z[1], -z[2])
        axis_pairs = ((y, z), (z, minus_y), (minus_y, minus_z), (minus_z, y))
        return [
            transpose((*axis, *second_axis, *third_axis)) for second_axis, third_axis in axis_pairs
        ]

    def count_turns(self) -> None:
        """Add to each candidate of the parent the fewest turns of this branch."""
        for parent_index, parent_candidate in enumerate(self.parent.candidates):
            rotation = multiply(transpose(parent_candidate), self.rotation)
            turn_counts = [
                later_turns + self._count_joint_turns(multiply(rotation, candidate))
                for candidate, later_turns in zip(self.candidates, self.costs, strict=True)
            ]
            self.parent.costs[parent_index] += min(turn_counts)
            self.best_candidates.append(turn_counts.index(min(turn_counts)))

    def _count_joint_turns(self, rotation: Rot) -> int:
        """Count the turns of a rotation, after which the axes may be renumbered."""
        if self.step.joint.type == "floating":
            return len(fewest_turns(rotation))
        # Two turns leave some element zero; one turn leaves one axis where it is.
        axis_rows = rotation[:3], rotation[3:6], rotation[6:]
        n_zeros = [
            sum(abs(element) <= self.tolerance for element in axis_row) for axis_row in axis_rows
        ]
        if not any(n_zeros):
            return 3
        n_kept_axes = sum(
            zeros == 2 and sum(axis_row) > 0.0
            for zeros, axis_row in zip(n_zeros, axis_rows, strict=True)
        )
        return (2, 1, 1, 0)[n_kept_axes]

    def choose_candidate(self) -> None:
        """Choose the best candidate, and give the joint its turns; the parent has to be chosen."""
        self.chosen = self.best_candidates[self.parent.chosen]
        rotation = multiply(self.parent.link_rotation, self.rotation)
        frame_rotation = multiply(rotation, self.candidates[self.chosen])
        if self.step.joint.type == "floating":  # its axes are those of the URDF
            self.step.turns = fewest_turns(frame_rotation)
        else:
            renumbered = (_renumber_axes(frame_rotation, axis_shift) for axis_shift in range(3))
            self.step.turns = min(
                (fewest_turns(candidate, self.tolerance) for candidate in renumbered), key=len
            )
        self.link_rotation = multiply(transpose(from_turns(self.step.turns)), rotation)


class PlacedStep(NamedTuple):
    """A step, and the frames before and after it."""

    step: Step
    frame: JointFrame
    """That of the last moving joint up to the step, itself included."""
    rotation: Rot
    """Rotation of the URDF's frame after the step, in the URDF's link frame of ``frame``."""
    frame_before: JointFrame
    rotation_before: Rot
    """Rotation of the URDF's frame before the step, in the URDF's link frame of
    ``frame_before``."""


def _place_steps(conversion: Conversion, tolerance: float) -> list[PlacedStep]:
    """Return all steps with their frames, from the ground outwards."""
    ground_joint = UrdfJoint("", "fixed", "", conversion.ground.link)
    ground_frame = JointFrame(Step.of(ground_joint), None, IDENTITY, tolerance)
    segment_ends = {conversion.ground.link: (ground_frame, IDENTITY)}
    placed_steps: list[PlacedStep] = []
    for link, segment in conversion.segments.items():
        if segment.parent is None:
            continue
        frame, rotation = segment_ends[segment.parent]
        for step in segment.steps:
            frame_before, rotation_before = frame, rotation
            rotation = multiply(rotation, from_turns(step.turns))
            if step.joint.moves:
                frame = JointFrame(step, frame_before, rotation, tolerance)
                rotation = IDENTITY
            placed_step = PlacedStep(step, frame, rotation, frame_before, rotation_before)
            placed_steps.append(placed_step)
        segment_ends[link] = frame, rotation
    return placed_steps


def _write_frames(conversion: Conversion, placed_steps: list[PlacedStep]) -> None:
    """Write all that is constant in a body in its new frame."""
    rotations: dict[int, Rot] = {}  # of the URDF's frame after each step, in the new one
    for step, frame, rotation, frame_before, rotation_before in placed_steps:
        new_rotation_before = multiply(frame_before.link_rotation, rotation_before)
        step.xyz = drop_rounding(rotate(new_rotation_before, step.xyz))
        rotations[id(step)] = multiply(frame.link_rotation, rotation)
        step.frames = _rotate_poses(rotations[id(step)], step.frames)
    for segment in conversion.segments.values():
        if segment.steps:
            segment.parts = _rotate_poses(rotations[id(segment.steps[-1])], segment.parts)


def _rotate_poses(rotation: Rot, poses: dict[str, Pose]) -> dict[str, Pose]:
    """Return poses of one frame in another one, from the rotation of the one in the other."""
    return {
        link: Pose(drop_rounding(rotate(rotation, pose.xyz)), multiply(rotation, pose.rot))
        for link, pose in poses.items()
    }


def _align_axis(conversion: Conversion, joint_frame: JointFrame) -> None:
    """Replace a joint's axis by the nearest coordinate axis, and note how far off it is."""
    step = joint_frame.step
    axis = rotate(joint_frame.link_rotation, unit(step.axis))
    step.axis = max(AXES, key=lambda coordinate_axis: dot(coordinate_axis, axis))
    deviation = max(
        abs(component - exact_component)
        for component, exact_component in zip(axis, step.axis, strict=True)
    )
    if deviation > ROUNDING:
        conversion.note(
            "axis-aligned",
            f"joint '{step.joint.name}': its axis is {deviation:.1e} rad off a coordinate "
            "axis or plane of its body, and is taken to lie on it",
            joint=step.joint.name,
        )


def _compute_rejection(vector: Vec, axis: Vec, tolerance: float) -> Vec | None:
    """Return the direction of a unit vector's part across an axis; None if it is along the axis."""
    for _ in range(2):  # if the vector is nearly along the axis, the second round removes rounding
        length_along = dot(vector, axis)
        x, y, z = (
            vector_component - length_along * axis_component
            for vector_component, axis_component in zip(vector, axis, strict=True)
        )
        length_across = hypot(x, y, z)
        if length_across <= tolerance:
            return None
        vector = (x / length_across, y / length_across, z / length_across)
    return vector


def _renumber_axes(rotation: Rot, axis_shift: int) -> Rot:
    """Return the same frame with renumbered axes: for 1, x, y, z become y, z, x, and so on."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = rotation
    return (
        rotation,
        (r13, r11, r12, r23, r21, r22, r33, r31, r32),
        (r12, r13, r11, r22, r23, r21, r32, r33, r31),
    )[axis_shift]
