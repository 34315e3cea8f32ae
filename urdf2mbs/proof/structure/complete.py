"""Complete a match by name with what two robots have in common beside names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import partial

import numpy as np

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.compare import Expectation, compare
from urdf2mbs.proof.match import ROTATION_BEFORE_JOINT, Match
from urdf2mbs.proof.mbs_side import build_mbs_side
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.structure.match import Score, StructureMatch, match_by_structure
from urdf2mbs.proof.structure.placing import find_root_poses
from urdf2mbs.proof.structure.tree import Floats, Tree
from urdf2mbs.proof.urdf_side import FLOATING_ORDER, build_urdf_side, list_coordinates
from urdf2mbs.urdf.model import Robot

#: Names decide unless less than this share of their differences is left without them.
CLEARLY_FEWER = 0.7


def complete_match(
    robot: Robot,
    mbs: Mbs,
    match: Match,
    expectation: Expectation,
    tolerance: float,
) -> Match:
    """Match the joints that have no partner of their name by structure.

    The pairs of names are kept, unless clearly fewer joints differ without them; those of a map
    are kept in any case.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        match: The joints that are matched by a map or by name.
        expectation: Expectations of the .mbs.
        tolerance: The largest deviation that is no difference.
    """
    completion = _Completion(robot, mbs, match, expectation, tolerance)
    if not completion.is_possible:
        return match
    result = completion.find(match.joints)
    mapped = {name: names for name, names in match.joints.items() if match.by.get(name) == "map"}
    named = len(match.joints) - len(mapped)
    if named and result.score.joints > 1:
        free = completion.find(mapped)
        if free.score.joints < CLEARLY_FEWER * result.score.joints:
            match.instead_of_names = result.score.joints
            result = free
    return completion.make_match(result)


def find_base_poses(robot: Robot, mbs: Mbs, match: Match) -> list[Floats]:
    """Find poses of a robot on its base that may be those of a model, the likeliest first.

    Args:
        robot: The robot of the URDF.
        mbs: The model.
        match: The joints that are matched, of which a floating base is used.

    Returns:
        Poses (3, 4) of the first robot's base in that of the second.
    """
    completion = _Completion(robot, mbs, match, Expectation(), TOLERANCE)
    if not completion.is_possible or min(len(completion.first), len(completion.second)) < 2:
        return []
    return find_root_poses(completion.first, completion.second)


class _Completion:
    """The trees of both robots, and the judge."""

    def __init__(
        self, robot: Robot, mbs: Mbs, match: Match, expectation: Expectation, tolerance: float
    ) -> None:
        self.robot = robot
        self.mbs = mbs
        self.match = match
        self.expectation = expectation
        self.tolerance = tolerance
        self.base = {name: names for name, names in match.joints.items() if len(names) == 6}
        """The floating base, which its six joints tell."""
        self.joint_of_coordinate = {
            coordinate.name: joint.name
            for joint in robot.joints.values()
            if joint.moves and joint.name not in self.base
            for coordinate in list_coordinates(joint, FLOATING_ORDER)
        }
        self.coordinate_counts = Counter(self.joint_of_coordinate.values())
        taken = {name for names in self.base.values() for name in names}
        every = [joint for joint in mbs.joints().values() if joint.name not in taken]
        moving = {joint.name for joint in every if joint.nature != "driven"}
        moving |= {name for names in match.joints.values() for name in names} - taken
        urdf = build_urdf_side(robot, dict.fromkeys(self.joint_of_coordinate, ""), {}, {})
        # a joint that a conversion holds to rotate an axis is no joint of the robot
        may_be_held = {j.name for j in every if not ROTATION_BEFORE_JOINT.search(j.name)}
        held = {
            joint.name: joint.q or 0.0
            for joint in every
            if joint.nature == "driven" and joint.name in may_be_held
        }
        make_tree = partial(Tree, carries_base=bool(self.base))
        with np.errstate(over="ignore", invalid="ignore"):  # of huge numbers
            self.first = make_tree(urdf)
            self.second = make_tree(build_mbs_side(mbs, moving))
            self.second_with_held = make_tree(build_mbs_side(mbs, may_be_held), held=held)

    @property
    def is_possible(self) -> bool:
        """Whether the numbers of both robots can be compared."""
        return self.first.is_measurable and self.second.is_measurable

    def find(self, kept: Mapping[str, tuple[str, ...]]) -> StructureMatch:
        """Match by structure.

        Args:
            kept: The .mbs joints of URDF joints that are kept.
        """
        numbers = {name: number for number, name in enumerate(self.first.names)}
        second_numbers = {name: number for number, name in enumerate(self.second.names)}
        pairs = {
            numbers[coordinate.name]: second_numbers[name]
            for joint, names in kept.items()
            if joint in self.robot.joints and joint not in self.base
            for coordinate, name in zip(
                list_coordinates(self.robot.joints[joint], FLOATING_ORDER), names, strict=True
            )
        }
        return match_by_structure(self.first, self.second, self.second_with_held, self.judge, pairs)

    def judge(self, names: Mapping[str, str]) -> Score:
        """Count the joints that differ if coordinates are matched so."""
        match = self._match(names)
        proof = compare(self.robot, self.mbs, match, self._expect(match), self.tolerance)
        total = sum(each.size for each in proof.differences)
        joints = {each.joint for each in proof.differences}
        joints |= {
            self.joint_of_coordinate.get(coordinate)
            for coordinate, name in names.items()
            if name in joints
        }
        coordinates = frozenset(
            coordinate for coordinate, joint in self.joint_of_coordinate.items() if joint in joints
        )
        return Score(proof.count_differing(), total, coordinates)

    def _expect(self, match: Match) -> Expectation:
        """Return the expectations, without those that do not depend on the match."""
        return Expectation(
            gravity=self.expectation.gravity,
            massless=[*match.locked],
            driven=self.expectation.driven,
        )

    def _match(self, names: Mapping[str, str]) -> Match:
        """Make a match of the names of coordinates."""
        names_of_joint: dict[str, list[str]] = {}
        for coordinate, joint in self.joint_of_coordinate.items():
            if coordinate in names:
                names_of_joint.setdefault(joint, []).append(names[coordinate])
        joints: dict[str, tuple[str, ...]] = dict(self.base)
        joints |= {
            joint: tuple(mbs_names)
            for joint, mbs_names in names_of_joint.items()
            if len(mbs_names) == self.coordinate_counts[joint]
        }
        return Match(
            joints={name: joints[name] for name in self.robot.joints if name in joints},
            locked={name: why for name, why in self.match.locked.items() if name not in joints},
            floating_orders=self.match.floating_orders,
        )

    def make_match(self, result: StructureMatch) -> Match:
        """Return the match of a result, and how each joint was found."""
        match = self._match(result.names | result.held)
        named = self.match.joints
        match.by = {
            name: self.match.by.get(name, "name") if named.get(name) == names else "place"
            for name, names in match.joints.items()
        }
        match.frames = {
            link: frame for link, frame in self.match.frames.items() if self._is_named(link, match)
        }
        match.equal = self._list_equal(result.equal)
        match.against = result.against
        match.turned = result.turned
        match.instead_of_names = self.match.instead_of_names
        return match

    def _is_named(self, link: str, match: Match) -> bool:
        """Return whether the joint of a link, and all before it, were matched by name."""
        joint_of_child = {joint.child: joint for joint in self.robot.joints.values()}
        while link in joint_of_child:
            joint = joint_of_child[link]
            if joint.moves and match.by.get(joint.name) == "place":
                return False
            link = joint.parent
        return True

    def _list_equal(self, pairs: Iterable[tuple[str, str]]) -> list[list[str]]:
        """Return groups of joints that may be exchanged."""
        groups: list[set[str]] = []
        for pair in pairs:
            joints = {self.joint_of_coordinate[coordinate] for coordinate in pair}
            for group in [each for each in groups if not each.isdisjoint(joints)]:
                groups.remove(group)
                joints |= group
            groups.append(joints)
        return [[name for name in self.robot.joints if name in group] for group in groups]
