"""Matches and compares two robots, and looks for one cause of many differences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.match import Match, has_unmatched
from urdf2mbs.proof.parameters import list_joint_parameters
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.states import SecondOpinions
from urdf2mbs.urdf.model import Joint, Robot
from urdf2mbs.verification.joint_map import JointMap
from urdf2mbs.verification.sides import Model, Reference

if TYPE_CHECKING:
    from urdf2mbs.verification.restate import Restatement


def match_and_compare(
    reference: Reference, model: Model, joint_map: JointMap | None, tolerance: float
) -> tuple[Reference, Match, Proof]:
    """Match and compare two robots.

    Joints are matched by a map and by name; those that have no partner, by structure.  If the
    robots still differ at several joints, one cause is looked for: other units, a turned base, or
    a loop that is cut elsewhere.

    Args:
        reference: The first robot.
        model: The second one.
        joint_map: The joints that people have matched.
        tolerance: The largest relative deviation that is no difference.

    Returns:
        The first robot as the second one states it, the joints that match, and the proof.
    """
    match = reference.match(reference.robot, model.mbs, joint_map)
    proof: Proof | None = None
    if not has_unmatched(match, reference.robot, model.mbs):
        proof = _prove(reference, model, match, tolerance)
        if proof.count_differing() < 2:
            return reference, match, proof
    return _Explanation(reference, model, joint_map, tolerance).find(match, proof)


class _Explanation:
    """The search for causes; see ``match_and_compare``."""

    def __init__(
        self, reference: Reference, model: Model, joint_map: JointMap | None, tolerance: float
    ) -> None:
        self.reference = reference
        self.model = model
        self.joint_map = joint_map
        self.causes: list[Difference] = []
        self._compare = partial(_prove, model=model, tolerance=tolerance)
        self._complete = partial(_complete, model=model, tolerance=tolerance)

    def find(self, named: Match, proof: Proof | None) -> tuple[Reference, Match, Proof]:
        """Return the first robot, restated, the joints that match, and the proof.

        The causes are differences of the proof.

        Args:
            named: The joints that are matched by a map and by name.
            proof: The comparison by these, if they are all joints.
        """
        from urdf2mbs.verification.restate import restate_angles, restate_lengths

        robot, mbs = self.reference.robot, self.model.mbs
        lengths = [*restate_lengths(robot, mbs)]
        if proof is None:
            self._start(lengths[0].robot if lengths else robot, named)
        else:
            self.match, self.proof = named, proof
        # both may be in other units
        both = [
            angles._replace(message=f"{each.message}; and {angles.message}")
            for each in lengths
            for angles in restate_angles(each.robot)
        ]
        if lengths and not self._try([*lengths, *both]) and proof is None:
            self._start(robot, named)
        robot = self.reference.robot
        self._try(restate_angles(robot))
        self._try(self._restate_root())
        self._try_other_cuts()
        self.proof.add_differences(self.causes)
        return self.reference, self.match, self.proof

    def _start(self, robot: Robot, named: Match) -> None:
        """Match a robot that may be restated; compare the robot as it is.

        Args:
            robot: The first robot, as the second one may state it.
            named: The joints that are matched by a map and by name, which do not depend on units.
        """
        self.match = self._complete(_restate(self.reference, robot), match=named)
        self.proof = self._compare(self.reference, match=self.match)

    def _match(self, reference: Reference) -> Match:
        """Match the joints of a restated robot."""
        named = reference.match(reference.robot, self.model.mbs, self.joint_map)
        return self._complete(reference, match=named)

    def _try(self, restatements: Iterable[Restatement]) -> bool:
        """Restate the first robot by that which explains most; return whether one does."""
        from urdf2mbs.verification.restate import is_explained

        before = self.proof.count_differing()
        if before < 2:
            return False
        best: tuple[int, Restatement] | None = None
        for restatement in restatements:
            trial = self._compare(_restate(self.reference, restatement.robot), match=self.match)
            differing = trial.count_differing()
            if is_explained(before, differing) and (best is None or differing < best[0]):
                best = differing, restatement
        if best is None:
            return False
        restatement = best[1]
        self.reference = _restate(self.reference, restatement.robot)
        self.causes.append(Difference(restatement.kind, restatement.message))
        match = self._match(self.reference)
        proof = self._compare(self.reference, match=match)
        if proof.count_differing() > best[0]:  # the match before was better
            proof = self._compare(self.reference, match=self.match)
        else:
            self.match = match
        self.proof = proof
        return True

    def _try_other_cuts(self) -> None:
        """Cut a loop of the first robot where the second one may have cut it."""
        from urdf2mbs.verification.loops import list_closures, recut
        from urdf2mbs.verification.restate import is_explained

        robot, before = self.reference.robot, self.proof.count_differing()
        if before < 2 or not self.model.mbs.cuts:
            return
        for trial in recut(robot, list_closures(robot, self.reference.mbs)):
            reference = _restate(self.reference, trial.robot)
            match = self._match(reference)
            proof = self._compare(reference, match=match)
            if is_explained(before, proof.count_differing()):
                before = proof.count_differing()
                self.reference, self.match, self.proof = reference, match, proof
                proof.but_for = {
                    item: why for item, why in proof.but_for.items() if not item.startswith("cut ")
                }
                reason = f"cut at '{trial.joint.name}' in the .mbs: the loop moves in a plane"
                proof.but_for[f"loop of '{trial.old.name}'"] = reason
                proof.add_differences(_compare_lost_numbers(trial.joint))
                self.reference.closures = trial.closures

    def _restate_root(self) -> Iterator[Restatement]:
        """Yield the first robot with its base turned."""
        from urdf2mbs.proof.structure.complete import find_base_poses
        from urdf2mbs.verification.restate import restate_root

        robot = self.reference.robot
        floating = [
            name
            for name, names in self.match.joints.items()
            if len(names) == 6 and name in robot.joints
        ]
        base = robot.joints[floating[0]].child if floating else robot.root()
        poses = find_base_poses(robot, self.model.mbs, self.match)
        yield from restate_root(robot, base, poses)


def _restate(reference: Reference, robot: Robot) -> Reference:
    """Return a reference whose robot is stated otherwise."""
    return msgspec.structs.replace(reference, robot=robot)


def _complete(reference: Reference, model: Model, match: Match, tolerance: float) -> Match:
    """Match by structure the joints that a map and names have left."""
    if not has_unmatched(match, reference.robot, model.mbs):
        return match
    from urdf2mbs.proof.structure.complete import complete_match  # imports scipy

    expectation = reference.expect(match, model)
    return complete_match(reference.robot, model.mbs, match, expectation, tolerance)


def _prove(reference: Reference, model: Model, match: Match, tolerance: float) -> Proof:
    """Compare two robots whose joints are matched."""
    expectation = reference.expect(match, model)
    proof = compare(reference.robot, model.mbs, match, expectation, tolerance)
    proof.drop_differences(reference.own_faults, match.joints)
    proof.but_for |= reference.accepted
    proof.add_differences(reference.undeclared)
    if model.conversion is not None:
        _compare_followers(reference.robot, model, match, proof)
    for conversion in (reference.conversion, model.conversion):
        if conversion is not None:
            conversion.state(SecondOpinions).add_to(proof)
    return proof


def _compare_lost_numbers(joint: Joint) -> list[Difference]:
    """Return the difference of a joint that is a cut in the second robot, which has no numbers."""
    numbers = [*list_joint_parameters(joint)]
    if not numbers:
        return []
    message = f"joint '{joint.name}' is a cut in the .mbs, without its {', '.join(numbers)}"
    return [Difference("parameter", message, link=joint.child, joint=joint.name)]


def _compare_followers(robot: Robot, model: Model, match: Match, proof: Proof) -> None:
    """Compare the ``<mimic>`` of two robots, which a plain .mbs cannot hold."""
    assert model.conversion is not None
    second = model.conversion.robot
    joint_of = {
        coordinates[0]: name
        for name, coordinates in model.conversion.names.coordinates.items()
        if coordinates
    }
    counterparts = {
        name: joint_of.get(names[0], name) for name, names in match.joints.items() if names
    }
    for joint in robot.joints.values():
        counterpart = second.joints.get(counterparts.get(joint.name, joint.name))
        if joint.mimic is not None and joint.name in match.joints:
            proof.but_for.pop(f"joint '{joint.name}'", None)
        expected = joint.mimic
        if expected is not None:
            leader = counterparts.get(expected.joint, expected.joint)
            expected = msgspec.structs.replace(expected, joint=leader)
        if counterpart is not None and expected != counterpart.mimic:
            message = f"joint '{joint.name}' has another <mimic>"
            difference = Difference("mimic", message, link=joint.child, joint=joint.name)
            proof.add_differences([difference])
