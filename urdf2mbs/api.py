"""urdf2mbs from Python: convert a robot, and compare one with an .mbs file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import config_of
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion, Intent, Names
from urdf2mbs.disk import files
from urdf2mbs.engine.order import join
from urdf2mbs.engine.output import write
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import load_plugins
from urdf2mbs.mbs.model import LinkFrame, Mbs
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
from urdf2mbs.states import OnPurpose
from urdf2mbs.summary import Report, report
from urdf2mbs.urdf.changes import describe_changes
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.reader import is_name

#: The passes that make the robot which the others convert.  Passes of plugins that change the
#: robot join them, and do so when asked.
_ROBOT = ("expand", "insert-base")


class Result:
    """The result of a conversion: the model, the file's bytes, and the report."""

    def __init__(self, conversion: Conversion) -> None:
        self.conversion = conversion

    def write(self, *, force: bool = False) -> Path:
        """Write the file, or the project; gives the path of the .mbs.

        One that is not the same robot is written as ``NAME.rejected.mbs``.  Raises ConfigError
        where a file cannot be written, and where a file that is there was edited or was not
        written by urdf2mbs: ``force`` replaces these, too.
        """
        write(self.conversion, force=force)
        return self.conversion.written

    @property
    def mbs(self) -> Mbs:
        return self.conversion.mbs

    @property
    def data(self) -> bytes:
        """The .mbs file."""
        conversion = self.conversion
        return conversion.files[conversion.written]

    @property
    def robot(self) -> Robot:
        """The URDF's robot, with the base that was inserted."""
        return self.conversion.robot

    @property
    def names(self) -> Names:
        return self.conversion.names

    @property
    def frames(self) -> dict[str, LinkFrame]:
        """Where each URDF link's frame is in the .mbs."""
        return self.conversion.frames

    @property
    def frozen(self) -> dict[str, str]:
        """Moving URDF joints that are not in the .mbs, and why."""
        return self.conversion.frozen

    @property
    def diagnostics(self) -> list[Diagnostic]:
        return self.conversion.diagnostics

    @property
    def report(self) -> Report:
        return report(self.conversion)


def convert(source: Config | str | os.PathLike[str], **fields: Any) -> Result:
    """Convert a URDF or xacro file; nothing is written until ``Result.write()``.

    ``source`` may also be a config file, or a ``Config``.  ``fields`` are those of ``Config``, the
    keys of a config file: ``pipeline="compact"``, ``output={"project": "robot"}``,
    ``passes={"contacts": {"links": ["foot"]}}``.  Paths are relative to the working folder.
    Raises ConversionError.
    """
    return Result(Pipeline(*config_of(source, **fields)).run())


class Verdict(Proof, kw_only=True):
    """The result of ``verify``: a proof, and how the two sides match."""

    robot: str
    model: str = ""
    """The file that was compared with the robot."""
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...] = ()
    """The six .mbs joints of a base that the URDF does not have itself."""
    joints: dict[str, tuple[str, ...]] = {}
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    moving: int
    """The number of moving joints of the URDF."""
    changed: list[str] = []
    """What the passes of a config changed of the URDF's robot, a sentence for each pass."""
    diagnostics: list[Diagnostic] = []
    """Warnings and notes of reading the URDF."""
    made_of: str = ""
    """The URDF that the .mbs was made of in memory."""

    @property
    def verdict(self) -> str:
        """In words, the same as those of a conversion."""
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
    robot, other = os.fspath(source), os.fspath(model)
    if files.is_folder(Path(other, "dataR")):
        other = os.fspath(files.model_of(Path(other)) or "")
    if robot.lower().endswith(".mbs"):
        if not _is_robot(other):
            message = "verify compares a URDF with an .mbs, and neither file is a URDF"
            raise ConfigError("usage", message, hint=f"urdf2mbs diff {robot} {other}")
        robot, other = other, robot
    # what people changed in an .mbs that is there is no part of a model that is made of a URDF
    made = (
        Pipeline(*config_of(other, **fields)).run(stop_after="emit") if _is_robot(other) else None
    )
    # the project of the .mbs: rotors are for projects alone
    fields["output"] = {"project": files.project_of(Path(other))}
    if made is None:
        mbs = read_mbs(files.read_model(other), other)
        intent = load_plugins().hook.urdf2mbs_intent(model=Path(other)) or Intent()
        verdict = _verify_robot(robot, mbs, intent, None, frames, tolerance, fields)
    else:
        verdict = _verify_robot(robot, made.mbs, Intent(), made.robot, frames, tolerance, fields)
        verdict.made_of = other
    verdict.model = other
    return _count_frames(verdict, frames)


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

    The passes run as in a conversion that starts over, and nothing is written.  What they change
    of the robot on purpose, hold, drive and name is what the .mbs should have.

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
    place = _find_model(pipeline.settings.output, lines.file, model)
    mbs = read_mbs(files.read_model(place), os.fspath(place))
    names = [configured.name for configured in pipeline.passes]
    # the passes after emit change no robot: they write files, and keep people's edits
    conversion = pipeline.run(stop_after="emit" if "emit" in names else None)
    expected = _match_conversion(conversion, mbs)
    meant = conversion.state(OnPurpose)
    expectation = Expectation(
        gravity=config.gravity,
        massless=[
            name
            for name in expected.locked
            if name in meant.massless or name not in conversion.frozen
        ],
        driven=[joint.name for joint in meant.driven],
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
    verdict = _verdict_of(proof, conversion, mbs, expected, frames)
    verdict.model = os.fspath(place)
    verdict.changed = [
        f"what {change.by} changed: {describe_changes(change.changes)}" for change in declared
    ]
    return _count_frames(verdict, frames)


def _find_model(
    output: Path, config: Path | None, model: str | os.PathLike[str] | None
) -> str | os.PathLike[str]:
    """Return the .mbs to compare: the one that is named, or the output of a config."""
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
        message = f"the tolerance is {tolerance}: above 0, at most {LARGEST_TOLERANCE} is wanted"
        raise ConfigError("tolerance-invalid", message, hint=f"such as {TOLERANCE}")


def _count_frames(verdict: Verdict, frames: bool) -> Verdict:
    """Make frames that are elsewhere differences, if asked for."""
    if frames:
        verdict.add_frames()
    else:  # of matched names: where a model has its frames is its own choice
        verdict.largest.pop("frame", None)
    return verdict


def _verify_robot(
    source: str,
    mbs: Mbs,
    intent: Intent,
    other: Robot | None,
    frames: bool,
    tolerance: float,
    fields: dict[str, Any],
) -> Verdict:
    """Compare a URDF with an .mbs; ``other`` is the robot that the .mbs was just made of."""
    base = fields.get("base", "auto")
    floats = "floating" if find_floating_joints(mbs) else "fixed"
    passes = join(_ROBOT, load_plugins(installed=False))
    asked = {name: options for name, options in intent.passes.items() if name in passes}
    given = {"source": source, "pipeline": passes, "passes": asked}
    fields = {**fields, "base": floats if base == "auto" else base}
    conversion = Pipeline(*config_of(given, **fields), installed_plugins=False).run()
    robot, gravity = conversion.robot, conversion.settings.config.gravity
    found = match_by_name(robot, mbs)
    expectation = Expectation(
        gravity=gravity,
        massless=[*found.locked],
        driven=intent.driven,
        user_models=None if other is None else mbs.user_models,
        shapes=mbs,
    )
    proof = compare(robot, mbs, found, expectation, tolerance)
    for change in conversion.checked.changed:
        changed = f"what {change.by} changed: {describe_changes(change.changes)}"
        proof.but_for[changed] = "on purpose, as the certificate says"
    if other is not None:
        _compare_followers(robot, other, found, proof)
    inserted = conversion.base.inserted or ""
    if base == "auto" and found.joints.get(inserted) and is_fixed_to_world(robot, inserted):
        message = "the robot is fixed to the world, and the base of the .mbs floats"
        proof.add_differences([Difference("base", message, urdf="fixed", mbs="floating")])
    return _verdict_of(proof, conversion, mbs, found, frames)


def _verdict_of(
    proof: Proof, conversion: Conversion, mbs: Mbs, found: Match, frames: bool
) -> Verdict:
    """Return the verdict of a proof, with the joints of both sides."""
    robot, inserted = conversion.robot, conversion.base.inserted or ""
    if frames:
        proof.not_compared |= _unseen(robot, mbs, found)
    return Verdict(
        **msgspec.structs.asdict(proof),
        robot=robot.name,
        base="floating" if find_floating_joints(mbs) else "fixed",
        floating_base=found.joints.get(inserted, ()),
        joints={name: names for name, names in found.joints.items() if name != inserted},
        moving=sum(
            joint.moves and joint.name not in (inserted, *found.locked)
            for joint in robot.joints.values()
        ),
        diagnostics=conversion.diagnostics,
    )


def _compare_followers(robot: Robot, other: Robot, found: Match, proof: Proof) -> None:
    """Compare the rules of ``<mimic>`` of two URDFs: a plain .mbs cannot hold them."""
    for joint in robot.joints.values():
        twin = other.joints.get(joint.name)
        if joint.mimic is not None and joint.name in found.joints:
            proof.but_for.pop(f"joint '{joint.name}'", None)
        if twin is not None and joint.mimic != twin.mimic:
            said = f"joint '{joint.name}' has another <mimic>"
            proof.add_differences([Difference("mimic", said, link=joint.child, joint=joint.name)])


def _is_robot(file: str) -> bool:
    """True for the name of a URDF or xacro file; an .mbs may have any ending."""
    return is_name(file) or Path(file).suffix.lower() in (".urdf", ".xacro", ".xml")


def _unseen(robot: Robot, mbs: Mbs, found: Match) -> dict[str, str]:
    """The links whose frames are not, or not wholly, in the .mbs, each with the reason."""
    points = {point.name for point in mbs.points().values()}
    root = robot.root()
    return {
        f"frame of link '{link}'": "its anchor point has no rotation"
        if not points.isdisjoint(list_spellings(link, "point"))
        else "the .mbs has no body and no point of its name"
        for link in robot.links
        if link not in found.frames and link != root
    }
