"""Compares a robot with an .mbs, which may have been edited or drawn by hand."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import config_of
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion, Intent
from urdf2mbs.disk import files
from urdf2mbs.engine.order import join
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import load_plugins
from urdf2mbs.mbs.model import Mbs, UserModel
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic
from urdf2mbs.proof.compare import Expectation, compare
from urdf2mbs.proof.match import (
    Match,
    find_floating_joints,
    is_fixed_to_world,
    list_spellings,
    match_by_name,
)
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.states import OnPurpose, SecondOpinions
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.reader import is_name

#: The passes that read the robot.  Passes of plugins that change the robot join them.
_ROBOT_PASSES = ("expand", "insert-base")


class Verdict(Proof, kw_only=True):
    """The result of ``verify``: a proof, and how the two sides match."""

    robot: str
    model: str = ""
    """The file that was compared with the robot."""
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...] = ()
    """The six .mbs joints of a floating base that is not in the URDF."""
    joints: dict[str, tuple[str, ...]] = {}
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    moving: int
    """The number of moving joints of the URDF."""
    changed: list[str] = []
    """The changes of the URDF's robot by the passes of a config, a sentence for each pass."""
    diagnostics: list[Diagnostic] = []
    """Warnings and notes of reading the URDF."""
    made_of: str = ""
    """Path of the second URDF, if two were compared."""

    @property
    def verdict(self) -> str:
        """The verdict in words, the same as those of a conversion."""
        return self.describe(self.changed)


def verify(
    source: Config | str | os.PathLike[str],
    model: str | os.PathLike[str] | None = None,
    *,
    frames: bool = False,
    tolerance: float = TOLERANCE,
    **fields: Any,
) -> Verdict:
    """Compare a robot with an .mbs, which may have been edited by hand.

    Joints are matched by name.

    Args:
        source: A URDF or xacro file; or a config, whose passes make the robot to compare with.
        model: The .mbs, or its project's folder.  Without it, that which the config writes.  A
            second URDF in its place is converted in memory, and the result is compared with the
            first.
        frames: Whether a link's frame that is elsewhere in the .mbs is a difference, too.
        tolerance: The largest relative deviation that is no difference.
        fields: Those of ``Config``.  Of a URDF: how to read the robot.  Its ``base`` is what the
            .mbs should have; ``auto`` takes it from the .mbs, unless the URDF is tied to
            ``world``.  Its ``gravity`` is what the .mbs should have, since a URDF has none.

    Raises:
        ConversionError: A file or an option is wrong.
    """
    if isinstance(source, Config) or is_config(source):
        config, lines = config_of(source, **fields)
        return verify_config(config, lines, model, frames=frames, tolerance=tolerance)
    if model is None:
        raise _missing_side(os.fspath(source))
    if is_config(model) and os.fspath(source).lower().endswith(".mbs"):
        return verify(model, source, frames=frames, tolerance=tolerance, **fields)
    if is_config(model):
        raise _misplaced_config(model)
    _check_tolerance(tolerance)
    robot, model = _order_sides(os.fspath(source), os.fspath(model))
    converted: Conversion | None = None
    if _is_robot(model):
        # the passes after emit merge people's edits of an .mbs, which are not of the second robot
        converted = Pipeline(*config_of(model, **fields)).run(stop_after="emit")
        mbs, intent = converted.mbs, Intent()
    else:
        mbs = read_mbs(files.read_model(model), model)
        intent = load_plugins().hook.urdf2mbs_intent(model=Path(model)) or Intent()
    fields["output"] = {"project": files.project_of(Path(model))}  # rotors are for projects only
    conversion = _read_robot(robot, mbs, intent, fields)
    expected = match_by_name(conversion.robot, mbs)
    user_models = None if converted is None else mbs.user_models
    proof = _compare_with_robot(
        conversion, mbs, expected, intent, tolerance, user_models=user_models
    )
    if converted is not None:
        _compare_followers(conversion.robot, converted.robot, expected, proof)
        converted.state(SecondOpinions).add_to(proof)
    _compare_base(proof, conversion, expected, fields.get("base", "auto"))
    verdict = _make_verdict(proof, conversion, mbs, expected, model=model, frames=frames)
    verdict.made_of = "" if converted is None else model
    return verdict


def _order_sides(source: str, model: str) -> tuple[str, str]:
    """Return the robot and the model, which may be given in the other order.

    Raises:
        ConfigError: ``usage``, neither is a robot.
    """
    if files.is_folder(Path(model, "dataR")):
        model = os.fspath(files.model_of(Path(model)) or "")
    if not source.lower().endswith(".mbs"):
        return source, model
    if not _is_robot(model):
        message = "verify compares a URDF with an .mbs, and neither file is a URDF"
        raise ConfigError("usage", message, hint=f"urdf2mbs diff {source} {model}")
    return model, source


def is_config(source: str | os.PathLike[str]) -> bool:
    """Return whether a name is that of a config file."""
    return os.fspath(source).lower().endswith((".yaml", ".yml"))


def verify_config(
    config: Config,
    lines: Lines,
    model: str | os.PathLike[str] | None = None,
    *,
    installed_plugins: bool = True,
    frames: bool = False,
    tolerance: float = TOLERANCE,
) -> Verdict:
    """Compare the robot that the passes of a config make with an .mbs.

    The passes run as in a conversion that starts over, and nothing is written.  The .mbs should
    have the changes that the passes make on purpose, the joints that they lock and drive, and the
    names that they give.

    Args:
        config: The config.
        lines: Where each value of the config stands.
        model: The .mbs, or its project's folder; None: the config's output.
        installed_plugins: Whether installed plugins take part.
        frames: As in ``verify``.
        tolerance: As in ``verify``.

    Raises:
        ConversionError: A file or an option is wrong, or a pass failed.
    """
    _check_tolerance(tolerance)
    if model is not None and is_config(model):
        raise _misplaced_config(model)
    if model is not None and _is_robot(os.fspath(model)):
        message = f"a config is compared with an .mbs, and '{model}' is a robot"
        hint = f"to compare two robots: urdf2mbs verify ROBOT {model}"
        raise ConfigError("usage", message, hint=hint)
    pipeline = Pipeline(config, lines, installed_plugins=installed_plugins, fresh=True)
    path = _find_model(pipeline.settings.output, lines.file, model)
    mbs = read_mbs(files.read_model(path), os.fspath(path))
    names = [step.name for step in pipeline.passes]
    # the passes after emit change no robot: they write files, and keep people's edits
    conversion = pipeline.run(stop_after="emit" if "emit" in names else None)
    expected = _match_conversion(conversion, mbs)
    on_purpose = conversion.state(OnPurpose)
    expectation = Expectation(
        gravity=conversion.settings.config.gravity,
        massless=[
            name
            for name in expected.locked
            if name in on_purpose.massless or name not in conversion.frozen
        ],
        driven=[joint.name for joint in on_purpose.driven],
        user_models=conversion.mbs.user_models,
        shapes=mbs,
    )
    proof = compare(conversion.robot, mbs, expected, expectation, tolerance)
    declared = [change for change in conversion.checked.changed if change.declared]
    proof.add_differences(
        Difference("changed", f"{change}, and does not say so by writes = ('robot',)")
        for change in conversion.checked.changed
        if not change.declared
    )
    verdict = _make_verdict(proof, conversion, mbs, expected, model=os.fspath(path), frames=frames)
    verdict.changed = [change.describe() for change in declared]
    return verdict


def _find_model(
    output: Path, config: Path | None, model: str | os.PathLike[str] | None
) -> str | os.PathLike[str]:
    """Return the .mbs to compare: the named one, or the output of a config."""
    if model is not None:
        is_project = files.is_folder(Path(model, "dataR"))
        return (files.model_of(Path(model)) or model) if is_project else model
    if not files.is_file(output):
        message = f"no model to compare: '{output}' does not exist"
        name = config or "CONFIG.yaml"
        hint = f"make it: urdf2mbs run {name}; or name one: urdf2mbs verify {name} MODEL.mbs"
        raise ConfigError("usage", message, hint=hint)
    return output


def _match_conversion(conversion: Conversion, mbs: Mbs) -> Match:
    """Return the joints and frames of an .mbs that are those of a conversion.

    If the .mbs has all the names that the conversion gave, these decide.  Otherwise joints and
    frames are matched by the names of the URDF, as for a model that was drawn by hand.
    """
    joints, bodies = mbs.joints(), {body.name for body in mbs.bodies}
    names = conversion.names.coordinates
    given = {name for coordinates in names.values() for name in coordinates}
    given |= {frame.joint for frame in conversion.frames.values() if frame.joint is not None}
    framed = {frame.body for frame in conversion.frames.values() if frame.body is not None}
    if given <= joints.keys() and framed <= bodies:
        return Match(
            joints={name: tuple(coordinates) for name, coordinates in names.items()},
            frames=conversion.frames,
            locked=conversion.frozen,
        )
    matched = match_by_name(conversion.robot, mbs)
    for name in conversion.frozen:
        matched.joints.pop(name, None)
    matched.locked |= conversion.frozen
    return matched


def _missing_side(given: str) -> ConfigError:
    """Return the error for a command that names only one file, which is no config."""
    if given.lower().endswith(".mbs"):
        message = f"no robot to compare with '{given}'"
        hint = f"name it first: urdf2mbs verify ROBOT {given}"
    else:
        message = f"no model to compare with '{given}'"
        hint = f"name it: urdf2mbs verify {given} MODEL.mbs; only a config names its own"
    return ConfigError("usage", message, hint=hint)


def _misplaced_config(model: str | os.PathLike[str]) -> ConfigError:
    """Return the error for a config in place of the .mbs."""
    message = f"'{model}' is a config, which stands for the robot, not for the model"
    return ConfigError("usage", message, hint=f"urdf2mbs verify {model} MODEL.mbs")


def _check_tolerance(tolerance: float) -> None:
    if not 0.0 < tolerance <= LARGEST_TOLERANCE:
        message = f"the tolerance is {tolerance}; expected above 0, at most {LARGEST_TOLERANCE}"
        raise ConfigError("tolerance-invalid", message, hint=f"such as {TOLERANCE}")


def _read_robot(source: str, mbs: Mbs, intent: Intent, fields: dict[str, Any]) -> Conversion:
    """Read a robot, with the base of an .mbs and the intended changes.

    Args:
        source: The robot's file.
        mbs: The model that it is compared with.
        intent: What an earlier conversion changed of the robot on purpose.
        fields: Fields of ``Config``.
    """
    names = join(_ROBOT_PASSES, load_plugins(installed=False))
    options = {name: values for name, values in intent.passes.items() if name in names}
    if fields.get("base", "auto") == "auto":
        fields = {**fields, "base": "floating" if find_floating_joints(mbs) else "fixed"}
    config, lines = config_of({"source": source, "pipeline": names, "passes": options}, **fields)
    return Pipeline(config, lines, installed_plugins=False).run()


def _compare_with_robot(
    conversion: Conversion,
    mbs: Mbs,
    expected: Match,
    intent: Intent,
    tolerance: float,
    *,
    user_models: list[UserModel] | None = None,
) -> Proof:
    """Compare a robot that was read with an .mbs.

    Args:
        conversion: The robot.
        mbs: The .mbs.
        expected: The joints and frames of the .mbs that are those of the robot.
        intent: What an earlier conversion changed on purpose.
        tolerance: The largest relative deviation that is no difference.
        user_models: The user models to compare; None: they are not compared.
    """
    expectation = Expectation(
        gravity=conversion.settings.config.gravity,
        massless=[*expected.locked],
        driven=intent.driven,
        user_models=user_models,
        shapes=mbs,
    )
    proof = compare(conversion.robot, mbs, expected, expectation, tolerance)
    for change in conversion.checked.changed:
        proof.but_for[change.describe()] = "on purpose, as the certificate says"
    return proof


def _compare_base(proof: Proof, conversion: Conversion, expected: Match, base: str) -> None:
    """Add a difference if the robot is fixed to the world, and the base of the .mbs floats."""
    inserted = conversion.base.inserted or ""
    floats = bool(expected.joints.get(inserted))
    if base == "auto" and floats and is_fixed_to_world(conversion.robot, inserted):
        message = "the robot is fixed to the world, and the base of the .mbs floats"
        proof.add_differences([Difference("base", message, urdf="fixed", mbs="floating")])


def _make_verdict(
    proof: Proof,
    conversion: Conversion,
    mbs: Mbs,
    expected: Match,
    *,
    model: str,
    frames: bool,
) -> Verdict:
    """Return the verdict of a proof, with the joints of both sides.

    Args:
        proof: The proof.
        conversion: The robot.
        mbs: The .mbs.
        expected: The joints and frames of the .mbs that are those of the robot.
        model: The file of the .mbs.
        frames: Whether frames that are elsewhere are differences.
    """
    robot, inserted = conversion.robot, conversion.base.inserted or ""
    conversion.state(SecondOpinions).add_to(proof)
    if frames:
        proof.not_compared |= _list_missing_frames(robot, mbs, expected)
    verdict = Verdict(
        **msgspec.structs.asdict(proof),
        robot=robot.name,
        model=model,
        base="floating" if find_floating_joints(mbs) else "fixed",
        floating_base=expected.joints.get(inserted, ()),
        joints={name: names for name, names in expected.joints.items() if name != inserted},
        moving=sum(
            joint.moves and joint.name not in (inserted, *expected.locked)
            for joint in robot.joints.values()
        ),
        diagnostics=conversion.diagnostics,
    )
    if frames:
        verdict.add_frames()
    else:  # of matched names: a model may have its frames anywhere
        verdict.largest.pop("frame", None)
    return verdict


def _compare_followers(robot: Robot, second: Robot, expected: Match, proof: Proof) -> None:
    """Compare the ``<mimic>`` of two URDFs, which a plain .mbs cannot hold."""
    for joint in robot.joints.values():
        counterpart = second.joints.get(joint.name)
        if joint.mimic is not None and joint.name in expected.joints:
            proof.but_for.pop(f"joint '{joint.name}'", None)
        if counterpart is not None and joint.mimic != counterpart.mimic:
            message = f"joint '{joint.name}' has another <mimic>"
            difference = Difference("mimic", message, link=joint.child, joint=joint.name)
            proof.add_differences([difference])


def _is_robot(file: str) -> bool:
    """Return whether a name is that of a URDF or xacro file; an .mbs may have any ending."""
    return is_name(file) or Path(file).suffix.lower() in (".urdf", ".xacro", ".xml", ".mjcf")


def _list_missing_frames(robot: Robot, mbs: Mbs, expected: Match) -> dict[str, str]:
    """Return the links whose frames are not, or not wholly, in the .mbs, each with the reason."""
    points = {point.name for point in mbs.points().values()}
    root = robot.root()
    return {
        f"frame of link '{link}'": "its anchor point has no rotation"
        if not points.isdisjoint(list_spellings(link, "point"))
        else "the .mbs has no body and no point of its name"
        for link in robot.links
        if link not in expected.frames and link != root
    }
