"""Compare two descriptions of a robot group by group: motion, inertia, frames, and shapes.

Here the deviations are computed.  ``causes`` finds and words the cause of those beyond tolerance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property, partial
from math import dist
from typing import NamedTuple

from urdf2mbs.mbs.model import LinkFrame, Mbs
from urdf2mbs.mbs.names import identifiers
from urdf2mbs.proof.causes import (
    explain_frame,
    explain_gravity,
    explain_inertia,
    explain_missing_frame,
    explain_motion,
    explain_parent,
)
from urdf2mbs.proof.groups import Group, PlacedFrame, Side
from urdf2mbs.proof.hand_drawn import find_best_pose
from urdf2mbs.proof.pair import POSITION_COUNT, GroupPair
from urdf2mbs.proof.rigid import (
    IDENTITY,
    IDENTITY_ROTATION,
    ORIGIN,
    Frame,
    compose,
    compute_deviation,
    compute_frame_deviation,
    inverse,
    sum_inertias,
    transform_point,
)
from urdf2mbs.proof.shapes import (
    Solid,
    convert_shape,
    convert_visual,
    describe_deviation,
    find_nearest,
)
from urdf2mbs.proof.urdf_side import compose_origin
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.urdf.model import Robot

#: Why a displaced shape is not a difference of the robots.
MASSLESS_SHAPE = "a shape has no mass"
#: Why a visual is not compared.
NO_SUCH_SHAPE = "the .mbs has no shape of their kind and size there"
#: Length added to the scale of each group, relative to the robot: a group whose joint is at the
#: origin of its parent still has the rounding errors of the bodies near it.
SCALE_MARGIN = 1e-4
#: A frame that the .mbs does not have.
MISSING_FRAME = PlacedFrame(-1, IDENTITY)


class ShapeComparison(NamedTuple):
    """Visuals that the .mbs shows differently: what, and the reason that it is no difference."""

    displaced: dict[str, str]
    missing: dict[str, str]


class Comparison:
    """A comparison of the two sides of a robot, and the differences that it has found."""

    def __init__(
        self,
        urdf: Side,
        mbs: Side,
        names: Mapping[str, str],
        frames: Mapping[str, LinkFrame],
        tolerance: float,
    ) -> None:
        """Pair the groups of both sides.

        Args:
            urdf: The URDF's side.
            mbs: The .mbs's side.
            names: The coordinates of the URDF that move on both sides, and their .mbs joints.
            frames: Where the frame of each link should be in the .mbs, as far as it is known.
            tolerance: A larger deviation is a difference.
        """
        self.urdf = urdf
        self.mbs = mbs
        self.frames = frames
        self.tolerance = tolerance
        self.differences: list[Difference] = []
        self.displaced_frames: list[Difference] = []
        self.largest = dict.fromkeys(("gravity", "motion", "mass", "centre", "inertia"), 0.0)
        #: The .mbs's group of each of the URDF's groups, parents first.
        self.counterparts = [
            0,
            *[mbs.group_of_coordinate[names[name]] for name in urdf.group_of_coordinate],
        ]
        margin = SCALE_MARGIN * max(g.reach for side in (urdf, mbs) for g in side.groups) or 1.0
        #: Length (m) to which positions in each of the URDF's groups are relative.
        self.scales = [
            max(group.reach, mbs.groups[counterpart].reach) + margin
            for group, counterpart in zip(urdf.groups, self.counterparts, strict=True)
        ]
        #: X: pose of each of the URDF's groups in its counterpart.
        self.relative_poses: list[Frame] = [IDENTITY] * len(urdf.groups)

    def create_proof(self, but_for: dict[str, str], not_compared: dict[str, str]) -> Proof:
        """Create the result of the comparison.

        Args:
            but_for: Known deviations that are not differences, each with the reason.
            not_compared: What nothing here compares, each with the reason.
        """
        proof = Proof(
            same=True,
            positions=POSITION_COUNT,
            groups=len(self.urdf.groups),
            largest=self.largest,
            differences=[],
            frames=sorted(self.displaced_frames, key=lambda difference: -difference.size),
            urdf_mass=self.urdf.moving_mass,
            mbs_mass=self.mbs.moving_mass,
            but_for=but_for,
            not_compared=not_compared,
        )
        proof.add_differences(self.differences)
        return proof

    def _is_different(self, deviation: float) -> bool:
        """Return True if a deviation is beyond tolerance; NaN is."""
        return not deviation <= self.tolerance

    def _record(self, kind: str, deviation: float) -> None:
        """Record a deviation, if it is the largest of its kind."""
        self.largest[kind] = max(self.largest.get(kind, 0.0), deviation)

    def compare_gravity(self) -> None:
        """Compare gravity, relative to its largest component."""
        urdf, mbs = self.urdf.gravity, self.mbs.gravity
        deviation = compute_deviation(urdf, mbs, max(map(abs, (*urdf, *mbs))) or 1.0)
        self.largest["gravity"] = deviation
        if self._is_different(deviation):
            self.differences.append(explain_gravity(urdf, mbs, deviation))

    # --- group by group ---

    def compare_groups(self) -> None:
        """Compare how each group moves in its parent group, and its inertia.

        Each joint is compared alone, so each error is reported once, for the joint that has it.
        The ground has no parent, and needs no inertia.
        """
        first_links = {frame.group: link for link, frame in reversed(self.urdf.frames.items())}
        for number in range(1, len(self.counterparts)):
            pair = self._create_pair(number)
            if not self._has_same_parent(number):
                difference = explain_parent(pair.urdf)
                # The coordinates of one joint follow each other; it is reported once.
                if not self.differences or self.differences[-1].message != difference.message:
                    self.differences.append(difference)
            expected_pose = self._find_expected_pose(number, first_links.get(number))
            self.relative_poses[number] = self._compare_motion(number, pair, expected_pose)
            self._compare_inertia(pair, self.relative_poses[number])

    @cached_property
    def _mbs_zero_poses(self) -> list[Frame]:
        """Poses of the .mbs's groups in the ground, all joints at zero."""
        return self.mbs.compute_poses()

    def _has_same_parent(self, number: int) -> bool:
        """Return True if a group and its counterpart are attached to the same group."""
        urdf, mbs = self.urdf.groups[number], self.mbs.groups[self.counterparts[number]]
        return mbs.parent == self.counterparts[urdf.parent]

    def _create_pair(self, number: int) -> GroupPair:
        """Create the pair of a group of the URDF, whose parent has been compared."""
        counterpart = self.counterparts[number]
        urdf, mbs = self.urdf.groups[number], self.mbs.groups[counterpart]
        mbs_joint_frame = mbs.joint_frame
        if not self._has_same_parent(number):
            expected_parent = self._mbs_zero_poses[self.counterparts[urdf.parent]]
            mbs_joint_frame = compose(inverse(expected_parent), self._mbs_zero_poses[counterpart])
        parent_pose = self.relative_poses[urdf.parent]
        return GroupPair(
            urdf=urdf,
            mbs=mbs,
            parent_pose=parent_pose,
            urdf_joint_frame=compose(parent_pose, urdf.joint_frame),
            mbs_joint_frame=mbs_joint_frame,
            urdf_inertia=sum_inertias([*urdf.inertias.values()]),
            mbs_inertia=sum_inertias([*mbs.inertias.values()]),
            scale=self.scales[number],
            find_children=partial(self._find_children, number),
        )

    def _find_children(self, number: int) -> list[tuple[Group, Group]]:
        """Find the groups (URDF, .mbs) that are attached to a group and to its counterpart."""
        pairs = [
            (self.urdf.groups[child], self.mbs.groups[self.counterparts[child]])
            for child in self.urdf.groups[number].children
        ]
        return [(urdf, mbs) for urdf, mbs in pairs if mbs.parent == self.counterparts[number]]

    def _find_expected_pose(self, number: int, link: str | None) -> Frame | None:
        """Find the relative pose of a group by where the frame of its first link should be.

        Returns:
            None if that is not known, or if the frame is in another group.
        """
        frame = None if link is None else self.frames.get(link)
        if frame is None:
            return None
        group, pose = self._locate(frame)
        if group != self.counterparts[number]:
            return None
        return IDENTITY if pose == IDENTITY else pose

    def _compare_motion(self, number: int, pair: GroupPair, expected_pose: Frame | None) -> Frame:
        """Compare the motion of a group with that of its counterpart; return the relative pose."""
        has_same_parent = self._has_same_parent(number)
        pose = pair.compute_zero_pose() if expected_pose is None else expected_pose
        deviation = pair.compute_motion_deviation(pose) if has_same_parent else 0.0
        is_pose_known = (
            expected_pose is not None
            or max(pair.compute_inertia_deviations(pose).values()) <= self.tolerance
        )
        if self._is_different(deviation) or not is_pose_known:
            pose = find_best_pose(pair, expected_pose, self.tolerance)
            deviation = pair.compute_motion_deviation(pose) if has_same_parent else 0.0
        self._record("motion", deviation)
        if self._is_different(deviation):
            self.differences.append(explain_motion(pair, pose, deviation, self.tolerance))
        return pose

    def _compare_inertia(self, pair: GroupPair, relative_pose: Frame) -> None:
        """Compare the mass, centre of mass and inertia tensor of two groups."""
        deviations = pair.compute_inertia_deviations(relative_pose)
        for kind, deviation in deviations.items():
            self._record(kind, deviation)
        if self._is_different(max(deviations.values())):
            self.differences += explain_inertia(pair, relative_pose, self.frames, self.tolerance)

    # --- frames and points ---

    def _locate(self, frame: LinkFrame) -> PlacedFrame:
        """Find where the frame of a link should be in the .mbs: its group, and its pose there."""
        if frame.joint is not None:
            group, pose = self.mbs.frames_after_joints.get(frame.joint, MISSING_FRAME)
        else:
            group, pose = self.mbs.frames.get(frame.body or "", MISSING_FRAME)
        if frame.pose.xyz != ORIGIN or frame.pose.rot != IDENTITY_ROTATION:
            pose = compose(pose, (*frame.pose.rot, *frame.pose.xyz))
        return PlacedFrame(group, pose)

    def compare_frames(self) -> None:
        """Compare where the frame of each link is with where it should be."""
        for link, frame in self.frames.items():
            if link not in self.urdf.frames:
                continue
            group, pose = self.urdf.frames[link]
            mbs = self._locate(frame)
            if self.counterparts[group] != mbs.group:
                is_present = mbs.group >= 0
                difference = explain_missing_frame(link, frame, is_present=is_present)
                self.displaced_frames.append(difference)
                continue
            urdf_pose = compose(self.relative_poses[group], pose)
            deviation = compute_frame_deviation(urdf_pose, mbs.pose, self.scales[group])
            self._record("frame", deviation)
            if self._is_different(deviation):
                displacement = compose(inverse(urdf_pose), mbs.pose)
                self.displaced_frames.append(explain_frame(link, displacement, deviation))

    def compare_points(self, mbs: Mbs) -> None:
        """Compare the anchor points that have the name of a link of their group with its frame."""
        links = _find_links_by_point_name(self.urdf.frames)
        for (body, _), point in mbs.points().items():
            link = links.get(point.name)
            if link is None:
                continue
            frame = self.mbs.frames[body or ""]
            group, pose = self.urdf.frames[link]
            if self.counterparts[group] != frame.group:
                continue
            urdf_point = transform_point(self.relative_poses[group], pose[9:])
            mbs_point = transform_point(frame.pose, point.coordinates)
            deviation = compute_deviation(urdf_point, mbs_point, self.scales[group])
            if self._is_different(deviation):
                distance = dist(urdf_point, mbs_point)
                message = f"link '{link}': point '{point.name}' of body '{body}' is "
                message += f"{distance:.3g} m from the frame of the link"
                self.displaced_frames.append(Difference("point", message, deviation, link=link))

    # --- shapes ---

    def compare_shapes(self, robot: Robot, mbs: Mbs) -> ShapeComparison:
        """Compare where the shapes of an .mbs are with the visuals of the URDF.

        Args:
            robot: The robot of the URDF.
            mbs: The model whose shapes are compared; its bodies are those of the .mbs.
        """
        solids_of_group = self._convert_shapes(mbs)
        comparison = ShapeComparison({}, {})
        for link, (group, pose) in self.urdf.frames.items():
            candidates = solids_of_group.get(self.counterparts[group], [])
            scale = self.scales[group]
            for visual in robot.links[link].visuals:
                frame = compose(self.relative_poses[group], compose_origin(pose, visual.origin))
                for solid in convert_visual(visual.geometry, frame):
                    nearest = find_nearest(solid, candidates, scale)
                    if nearest is None:
                        comparison.missing[f"visuals of link '{link}'"] = NO_SUCH_SHAPE
                    elif deviation := describe_deviation(solid, nearest, scale):
                        shape = f"visual of link '{link}' {deviation}"
                        comparison.displaced[shape] = MASSLESS_SHAPE
        return comparison

    def _convert_shapes(self, mbs: Mbs) -> dict[int, list[Solid]]:
        """Convert the shapes of an .mbs to solids, by the numbers of their groups."""
        solids_of_group: dict[int, list[Solid]] = {}
        for name, owner in mbs.base_and_bodies():
            group, frame = self.mbs.frames.get(name or "", MISSING_FRAME)
            solids = (convert_shape(shape, frame) for shape in owner.shapes)
            solids_of_group.setdefault(group, []).extend(s for s in solids if s is not None)
        return solids_of_group


def _find_links_by_point_name(links: Iterable[str]) -> dict[str, str | None]:
    """Find the link for each name that a point may have; None if several links share the name."""
    link_of_name: dict[str, str | None] = {}
    for link in links:
        name = link if link.isascii() and link.isidentifier() else identifiers([link])[0]
        link_of_name[name] = None if name in link_of_name else link
    return link_of_name
