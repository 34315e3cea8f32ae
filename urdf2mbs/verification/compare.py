"""Compares two robots of any origin: a URDF, an .mbs, or what a config makes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.proof.findings import OF_MECHANISM, OF_MOTION, find_causes
from urdf2mbs.proof.match import (
    Match,
    find_floating_joints,
    is_fixed_to_world,
    list_spellings,
)
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.urdf.model import Robot
from urdf2mbs.verification.explanation import match_and_compare
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

    Joints are matched by name; those that have no partner of their name, by their place and
    the masses of their subtrees.

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
        joint_map = None if joint_map is None else joint_map.invert()
    model = read_second(second, fields)
    reference = read_first(first, model, fields)
    if joint_map is not None:
        if model.conversion is not None:
            joint_map.expand(model.conversion.names.coordinates)
        joint_map.check(reference.robot, model.mbs)
    reference, match, proof = match_and_compare(reference, model, joint_map, tolerance)
    _compare_closures(proof, reference, model, tolerance)
    _compare_base(proof, reference, match, fields.get("base", "auto"))
    verdict = _make_verdict(proof, reference, model, match, frames=frames)
    if first.is_model or not second.is_model:
        verdict.name_sides(*_name_sides(first, second))
    return verdict


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
    """Compare where the loops of two models are closed, if all joints are the same.

    The ends of a cut that a URDF states in ``<gazebo>`` are named as not compared.
    """
    if reference.mbs is None and not reference.closures:
        return
    if any(each.kind in (*OF_MECHANISM, *OF_MOTION) for each in proof.differences):
        return  # then the ends are elsewhere, too
    from urdf2mbs.verification.loops import compare_closures, list_closures

    closures = reference.closures or list_closures(reference.robot, reference.mbs)
    comparison = compare_closures(closures, model.mbs, max(tolerance, CLOSURE_TOLERANCE))
    proof.add_differences(comparison.differences)
    for name in comparison.same:
        for item in [item for item in proof.but_for if item.startswith(f"cut '{name}' (")]:
            del proof.but_for[item]


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
