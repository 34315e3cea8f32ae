"""Compares two robots of any origin: a URDF, an .mbs, or what a config makes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.findings import find_causes
from urdf2mbs.proof.match import (
    Match,
    find_floating_joints,
    has_unmatched,
    is_fixed_to_world,
    list_spellings,
)
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.states import SecondOpinions
from urdf2mbs.urdf.model import Robot
from urdf2mbs.verification.joint_map import JointMap, read_joint_map
from urdf2mbs.verification.sides import (
    Model,
    Reference,
    Source,
    find_output,
    is_config,
    read_first,
    read_second,
    read_source,
)
from urdf2mbs.verification.verdict import Verdict

if TYPE_CHECKING:
    from urdf2mbs.verification.restate import Restatement


#: Where loops are closed, relative to their place; positions have rounding errors of all joints.
CLOSURE_TOLERANCE = 1e-9


def verify(
    source: Config | str | os.PathLike[str],
    model: Config | str | os.PathLike[str] | None = None,
    *,
    joint_map: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    frames: bool = False,
    tolerance: float = TOLERANCE,
    **fields: Any,
) -> Verdict:
    """Compare two robots: is the second the same as the first?

    Joints are matched by name; those that have no partner of their name, by their place, their
    mass and what they carry.

    Args:
        source: The first robot: a URDF or xacro file; an .mbs; or a config, whose passes make it.
        model: The second one, which may have been drawn or edited by hand: an .mbs, or its
            project's folder; or another robot, which is converted in memory.  Without it, the
            .mbs that the config writes.
        joint_map: Joints of the first robot, and their joints in the second one; or a YAML file of
            such lines.  They are matched in any case.
        frames: Whether a link's frame that is elsewhere in the .mbs is a difference, too.
        tolerance: The largest relative deviation that is no difference.
        fields: Those of ``Config``.  Of a URDF: how to read the robot.  Its ``base`` is what the
            .mbs should have; ``auto`` takes it from the .mbs, unless the URDF is tied to
            ``world``.  Its ``gravity`` is what the .mbs should have, since a URDF has none.

    Raises:
        ConversionError: A file or an option is wrong.
    """
    is_of_config = isinstance(source, Config) or is_config(source)
    first = read_source(source, fields if is_of_config else {}, is_first=True)
    second = None if model is None else read_source(model, {}, is_first=False)
    return verify_sides(
        first,
        second,
        joint_map=read_joint_map(joint_map),
        frames=frames,
        tolerance=tolerance,
        fields={} if is_of_config else fields,
    )


def verify_sides(
    first: Source,
    second: Source | None,
    *,
    joint_map: JointMap | None = None,
    frames: bool = False,
    tolerance: float = TOLERANCE,
    fields: dict[str, Any] | None = None,
) -> Verdict:
    """Compare two robots; see ``verify``.

    Args:
        first: The first robot.
        second: The second one; None for the output of a config.
        joint_map: The joints that people have matched.
        frames: Whether frames that are elsewhere are differences.
        tolerance: The largest relative deviation that is no difference.
        fields: Fields of ``Config`` for the reading of robots.
    """
    if not 0.0 < tolerance <= LARGEST_TOLERANCE:
        message = f"the tolerance is {tolerance}; expected above 0, at most {LARGEST_TOLERANCE}"
        raise ConfigError("tolerance-invalid", message, hint=f"such as {TOLERANCE}")
    fields = fields or {}
    if second is None:
        if first.config is None:
            raise _missing_side(first)
        second = find_output(first)
    elif first.is_model and not second.is_model:
        first, second = second, first
    model = read_second(second, fields)
    reference = read_first(first, model, fields)
    if joint_map is not None:
        joint_map.check(reference.robot, model.mbs)
    reference, match, proof = _match_and_compare(reference, model, joint_map, tolerance)
    _compare_closures(proof, reference, model, tolerance)
    _compare_base(proof, reference, match, fields.get("base", "auto"))
    verdict = _make_verdict(proof, reference, model, match, frames=frames)
    if first.is_model or not second.is_model:
        verdict.name_sides(*_name_sides(first, second))
    return verdict


def _match_and_compare(
    reference: Reference, model: Model, joint_map: JointMap | None, tolerance: float
) -> tuple[Reference, Match, Proof]:
    """Match and compare two robots: by a map and by name, and what is left by structure."""
    match = reference.match(reference.robot, model.mbs, joint_map)
    if not has_unmatched(match, reference.robot, model.mbs):
        proof = _prove(reference, model, match, tolerance)
        if proof.count_differing() < 2:
            return reference, match, proof
    return _Explanation(reference, model, joint_map, tolerance).find()


class _Explanation:
    """Looks for one cause of many differences: other units, or a base that is turned."""

    def __init__(
        self, reference: Reference, model: Model, joint_map: JointMap | None, tolerance: float
    ) -> None:
        self.reference = reference
        self.model = model
        self.found: list[Difference] = []
        """The causes that were found."""
        self._compare = partial(_prove, model=model, tolerance=tolerance)
        self._match = partial(_match, model=model, joint_map=joint_map, tolerance=tolerance)

    def find(self) -> tuple[Reference, Match, Proof]:
        """Return the first robot, restated, the joints that match, and the proof.

        The causes are differences of the proof.
        """
        from urdf2mbs.verification.restate import restate_angles, restate_lengths

        robot, mbs = self.reference.robot, self.model.mbs
        lengths = [*restate_lengths(robot, mbs)]
        self._start(lengths[0].robot if lengths else robot)
        # both may be in other units
        both = [
            angles._replace(message=f"{each.message}; and {angles.message}")
            for each in lengths
            for angles in restate_angles(each.robot)
        ]
        if lengths and not self._try([*lengths, *both]):
            self._start(robot)
        robot = self.reference.robot
        self._try(restate_angles(robot))
        self._try(self._restate_root())
        self._try_other_cuts()
        self.proof.add_differences(self.found)
        return self.reference, self.match, self.proof

    def _start(self, robot: Robot) -> None:
        """Match a robot that may be restated; compare the robot as it is."""
        self.match = self._match(_restate(self.reference, robot))
        self.proof = self._compare(self.reference, match=self.match)

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
        self.found.append(Difference(restatement.kind, restatement.message))
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
                self.reference.closures = trial.closures

    def _restate_root(self) -> Iterator[Restatement]:
        """Yield the first robot with its base turned."""
        from urdf2mbs.proof.structure.complete import find_base_poses
        from urdf2mbs.verification.restate import restate_root

        robot = self.reference.robot
        floating = [name for name, names in self.match.joints.items() if len(names) == 6]
        base = robot.joints[floating[0]].child if floating else robot.root()
        poses = find_base_poses(robot, self.model.mbs, self.match)
        yield from restate_root(robot, base, poses)


def _restate(reference: Reference, robot: Robot) -> Reference:
    """Return a reference whose robot is stated in other units."""
    return msgspec.structs.replace(reference, robot=robot)


def _match(
    reference: Reference, model: Model, joint_map: JointMap | None, tolerance: float
) -> Match:
    """Match the joints of two robots: by a map, by name, and what is left by structure."""
    match = reference.match(reference.robot, model.mbs, joint_map)
    if not has_unmatched(match, reference.robot, model.mbs):
        return match
    from urdf2mbs.proof.structure.complete import complete_match  # imports scipy

    expectation = reference.expect(match, model)
    return complete_match(reference.robot, model.mbs, match, expectation, tolerance)


def _prove(reference: Reference, model: Model, match: Match, tolerance: float) -> Proof:
    """Compare two robots whose joints are matched."""
    expectation = reference.expect(match, model)
    proof = compare(reference.robot, model.mbs, match, expectation, tolerance)
    proof.but_for |= reference.accepted
    proof.add_differences(reference.undeclared)
    if model.conversion is not None:
        _compare_followers(reference.robot, model, match, proof)
    for conversion in (reference.conversion, model.conversion):
        if conversion is not None:
            conversion.state(SecondOpinions).add_to(proof)
    return proof


def _name_sides(first: Source, second: Source) -> tuple[str, str]:
    """Return the names of two files; with their folders if the names are the same."""
    names = Path(first.name).name, Path(second.name).name
    return names if names[0] != names[1] else (first.name, second.name)


def _missing_side(given: Source) -> ConfigError:
    """Return the error for a command that names only one file, which is no config."""
    if given.is_model:
        message = f"no robot to compare with '{given.name}'"
        hint = f"name it first: urdf2mbs verify ROBOT {given.name}"
    else:
        message = f"no model to compare with '{given.name}'"
        hint = f"name it: urdf2mbs verify {given.name} MODEL.mbs; only a config names its own"
    return ConfigError("usage", message, hint=hint)


def _compare_base(proof: Proof, reference: Reference, match: Match, base: str) -> None:
    """Add a difference if the robot is fixed to the world, and the base of the .mbs floats."""
    inserted = reference.base_joint
    floats = bool(match.joints.get(inserted))
    is_robot = reference.conversion is not None and not reference.changed
    if is_robot and base == "auto" and floats and is_fixed_to_world(reference.robot, inserted):
        message = "the robot is fixed to the world, and the base of the .mbs floats"
        proof.add_differences([Difference("base", message, urdf="fixed", mbs="floating")])


def _compare_closures(proof: Proof, reference: Reference, model: Model, tolerance: float) -> None:
    """Compare where the loops of two models are closed, if all that moves is the same.

    The ends of a cut that a URDF states in ``<gazebo>`` are named as not compared.
    """
    if (reference.mbs is None and not reference.closures) or not proof.same:
        return
    from urdf2mbs.verification.loops import compare_closures, list_closures

    closures = reference.closures or list_closures(reference.robot, reference.mbs)
    differences = compare_closures(closures, model.mbs, max(tolerance, CLOSURE_TOLERANCE))
    proof.add_differences(differences)
    if not differences and len(closures) == len(model.mbs.cuts):
        for item in [item for item in proof.but_for if item.startswith("cut ")]:
            del proof.but_for[item]


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


def _make_verdict(
    proof: Proof, reference: Reference, model: Model, match: Match, *, frames: bool
) -> Verdict:
    """Return the verdict of a proof, with the joints of both sides.

    Args:
        proof: The proof.
        reference: The first robot.
        model: The second one.
        match: The joints and frames of the second robot that are those of the first.
        frames: Whether frames that are elsewhere are differences.
    """
    robot, inserted = reference.robot, reference.base_joint
    if frames:
        proof.not_compared |= _list_missing_frames(robot, model.mbs, match)
    joints = {name: names for name, names in match.joints.items() if name != inserted}
    verdict = Verdict(
        **msgspec.structs.asdict(proof),
        robot=robot.name,
        model=model.name,
        base="floating" if find_floating_joints(model.mbs) else "fixed",
        floating_base=match.joints.get(inserted, ()),
        joints=joints,
        by={name: match.by.get(name, "name") for name in joints},
        equal=match.equal,
        against=match.against,
        turned=match.turned,
        instead_of_names=match.instead_of_names,
        moving=sum(
            joint.moves and joint.name not in (inserted, *match.locked)
            for joint in robot.joints.values()
        ),
        changed=reference.changed,
        diagnostics=reference.diagnostics,
        made_of="" if model.conversion is None else model.name,
    )
    if frames:
        verdict.add_frames()
    else:  # of matched names: a model may have its frames anywhere
        verdict.largest.pop("frame", None)
    verdict.differences, verdict.findings = find_causes(verdict.differences, robot)
    return verdict


def _list_missing_frames(robot: Robot, mbs: Mbs, match: Match) -> dict[str, str]:
    """Return the links whose frames are not, or not wholly, in the .mbs, each with the reason."""
    points = {point.name for point in mbs.points().values()}
    root = robot.root()
    return {
        f"frame of link '{link}'": "its anchor point has no rotation"
        if not points.isdisjoint(list_spellings(link, "point"))
        else "the .mbs has no body and no point of its name"
        for link in robot.links
        if link not in match.frames and link != root
    }
