"""urdf2mbs from Python: convert a robot, and compare one with an .mbs file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion, LinkFrame, Names
from urdf2mbs.disk import files
from urdf2mbs.disk.output import write
from urdf2mbs.engine.config import Config, Lines, from_values, typed
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read, validate
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic, Difference
from urdf2mbs.proof.compare import TOLERANCE, Comparison, compare
from urdf2mbs.proof.match import Match, fixed_to_world, floating_joints, match, spellings
from urdf2mbs.proof.verdict import in_words
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.report.summary import Report, report
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.descriptions import PREFIX
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.reader import read_file
from urdf2mbs.urdf.xml import mend


class Result:
    """What a conversion gives: the model, the file's bytes, and the report."""

    def __init__(self, conversion: Conversion) -> None:
        self.conversion = conversion

    def write(self, *, force: bool = False) -> Path:
        """Write the file, or the project; gives the path of the .mbs.

        One that is not the same robot is written as ``NAME.rejected.mbs``.  Raises ConfigError
        where a file cannot be written, and where a file that is there was edited or was not
        written by urdf2mbs: ``force`` replaces these, too.
        """
        write(self.conversion, force=force)
        return self.conversion.rejected or self.conversion.settings.output

    @property
    def mbs(self) -> Mbs:
        return self.conversion.mbs

    @property
    def data(self) -> bytes:
        """The .mbs file."""
        conversion = self.conversion
        return conversion.files[conversion.rejected or conversion.settings.output]

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


def convert(
    source: Config | str | os.PathLike[str],
    *,
    project: str | os.PathLike[str] | None = None,
    language: str | Sequence[str] | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    **fields: Any,
) -> Result:
    """Convert a URDF or xacro file; nothing is written until ``Result.write()``.

    ``fields`` are those of ``Config``, the keys of a config file: ``pipeline="compact"``.  A whole
    ``Config`` in place of the file says the same with types.  ``options`` are the ``passes`` of a
    config; ``project`` and ``language`` are its ``output`` where that is a Robotran project.
    Paths are relative to the working folder.  Raises ConversionError.
    """
    if options is not None:
        fields["passes"] = options
    if project is not None:
        if fields.get("output") is not None:
            raise ConfigError("usage", "give either an output or a project, not both")
        fields["output"] = {"project": project}
        if language is not None:
            fields["output"]["language"] = language
    given = source if isinstance(source, Config) else {"source": source}
    return Result(Pipeline(*from_values(given, **fields)).run())


class Verdict(msgspec.Struct):
    """What was compared and what differs."""

    robot: str
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...]
    """The six .mbs joints of a base that the URDF does not have itself."""
    joints: dict[str, tuple[str, ...]]
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    moving: int
    """How many moving joints the URDF has."""
    urdf_mass: float
    """kg, of all that can move."""
    mbs_mass: float
    """kg, of all that can move."""
    groups: int
    positions: int
    largest: dict[str, float]
    """The largest relative deviation of each kind."""
    differences: list[Difference]
    """Where the two are not the same robot, the largest first."""
    frames: list[Difference]
    """Frames that are elsewhere in the .mbs: by itself a matter of convention."""
    but_for: dict[str, str]
    """What is not as in the URDF, known, and no difference by itself: each thing, and why."""
    not_compared: dict[str, str]
    """What Robotran reads and nothing here compares: each thing, and why."""
    schema: list[str]
    """Where the file departs from the format."""
    flipped: list[str] = []
    """The URDF's joints that count the other way round, as their names in the .mbs say."""
    diagnostics: list[Diagnostic] = []
    """Warnings and notes of reading the URDF."""
    called: tuple[str, str] = ("the URDF", "the .mbs")
    """The two sides: of two .mbs files, or of two URDFs, their names."""

    @property
    def same(self) -> bool:
        return not self.differences

    @property
    def verdict(self) -> str:
        """In words, the same as those of a conversion."""
        return in_words(not self.same, self.but_for, self.not_compared)


def verify(
    source: str | os.PathLike[str],
    model: str | os.PathLike[str],
    *,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    xacro_args: Mapping[str, str] | None = None,
    base: str = "auto",
    engine: str = "own",
    frames: bool = False,
    gravity: Vec = (0.0, 0.0, -9.81),
    tolerance: float = TOLERANCE,
    diagnostics: Mapping[str, str] | None = None,
    strict: bool = False,
    trust_xacro: bool = False,
) -> Verdict:
    """Compare a URDF or xacro file with an .mbs, which may have been edited by hand.

    Whether the ``base`` should float is read off the .mbs (``auto``), since a URDF leaves it open,
    unless it is tied to ``world``; or it is given, ``floating`` or ``fixed``. Joints are matched by
    name; ``gravity`` (m/s^2) is what the .mbs should have, since a URDF has none.  ``engine`` is
    ``own`` or ``pinocchio``, which compares the equations of motion too.  ``frames``: a link's
    frame that is elsewhere in the .mbs is a difference, too.  ``diagnostics`` and ``strict`` weigh
    the warnings of reading the URDF, and ``trust_xacro`` is as in ``convert``.
    Both may also be .mbs files, or both URDFs: then ``base`` is for both URDFs, and ``gravity`` and
    ``engine`` are for neither.
    Raises ConversionError.
    """
    if not 0.0 < tolerance <= LARGEST_TOLERANCE:
        raise ConfigError(
            "tolerance-invalid",
            f"the tolerance is {tolerance}: above 0, at most {LARGEST_TOLERANCE} is wanted",
            hint=f"such as {TOLERANCE}",
        )
    source, model = os.fspath(source), os.fspath(model)
    kinds = not source.lower().endswith(".mbs"), _is_robot(model)
    if kinds == (False, True):
        source, model, kinds = model, source, (True, False)
    given = {
        "packages": {name: os.fspath(path) for name, path in (packages or {}).items()},
        "xacro_args": dict(xacro_args or {}),
        "base": base,
        "gravity": tuple(gravity),
        "pipeline": ["expand", "insert-base"],
        "trust_xacro": trust_xacro,
        "diagnostics": dict(diagnostics or {}),
        "strict": strict,
    }
    if kinds[0] == kinds[1]:
        if engine != "own":
            raise ConfigError(
                "usage", f"the engine {engine} compares a URDF with an .mbs", hint="leave it out"
            )
        if kinds[0]:
            return _verify_robots(source, model, given, frames, tolerance)
        return _verify_models(source, model, tolerance)
    data = _read_model(model)
    mbs = read(data, model)
    floats = _base(mbs)
    given["base"] = floats if base == "auto" else base
    conversion = _read_robot(source, given)
    robot = conversion.robot
    found = match(robot, mbs)
    comparison = compare(
        robot.with_flipped(found.flipped), mbs, found.joints,
        frames=found.frames, frozen=found.frozen, weightless=[*found.frozen], orders=found.orders,
        gravity=gravity, tolerance=tolerance,
    )  # fmt: skip
    inserted = next(iter(robot.joints)) if conversion.floating else ""
    floating_base = found.joints.get(inserted, ())
    differences, largest = comparison.differences, comparison.largest
    if base == "auto" and floating_base and fixed_to_world(robot, inserted):
        said = "the robot is fixed to the world, and the base of the .mbs floats"
        differences.append(Difference("base", said, urdf="fixed", mbs="floating"))
    if not frames:
        del largest["frame"]  # of matched names: where a model has its frames is its own choice
    if engine == "pinocchio":
        from urdf2mbs.proof.dynamics import compare_dynamics

        more, deviations = compare_dynamics(
            _text(conversion), mbs, found.joints,
            orders=found.orders, floating_base=floating_base, flipped=found.flipped,
            gravity=gravity, tolerance=tolerance,
        )  # fmt: skip
        differences = differences + more
        largest = {**largest, **deviations}
    elsewhere = comparison.frames
    if frames:
        differences, elsewhere = differences + elsewhere, []
    differences.sort(key=lambda difference: -difference.size)
    moving = [joint.name for joint in robot.joints.values() if joint.moves]
    return Verdict(
        robot.name,
        floats,
        floating_base,
        {name: names for name, names in found.joints.items() if name != inserted},
        sum(name not in (inserted, *found.frozen) for name in moving),
        comparison.urdf_mass,
        comparison.mbs_mass,
        comparison.groups,
        comparison.positions,
        largest,
        differences,
        elsewhere,
        comparison.but_for,
        comparison.not_compared | (_unseen(robot, mbs, found) if frames else {}),
        [str(problem) for problem in validate(data, model)],
        found.flipped,
        conversion.diagnostics,
    )


def _is_robot(file: str) -> bool:
    """True for the name of a URDF or xacro file; an .mbs may have any ending."""
    return file.startswith(PREFIX) or Path(file).suffix.lower() in (".urdf", ".xacro", ".xml")


def _read_model(model: str) -> bytes:
    try:
        return files.read(Path(model))
    except OSError as error:
        raise ConfigError("model-unreadable", f"cannot read '{model}': {error.strerror}") from None


def _read_robot(source: str, given: Mapping[str, Any]) -> Conversion:
    lines = Lines()
    whole = {"source": source, "output": f"{source}.mbs", **given}  # never written
    return Pipeline(typed(Config, whole, lines), lines, installed_plugins=False).run()


def _base(mbs: Mbs) -> str:
    return "floating" if floating_joints(mbs) else "fixed"


def _verify_models(first: str, second: str, tolerance: float) -> Verdict:
    """Compare two .mbs files."""
    from urdf2mbs.proof.alike import compare_models

    data = _read_model(first), _read_model(second)
    one, two = read(data[0], first), read(data[1], second)
    called = _called(first, second)
    comparison = compare_models(one, two, tolerance, called)
    moving = [j.name for body in one.bodies for j in body.joints if j.nature != "driven"]
    return _alike(
        one.name, _base(two), comparison, len(moving), called,
        [str(problem) for k in (0, 1) for problem in validate(data[k], (first, second)[k])],
    )  # fmt: skip


def _verify_robots(
    first: str, second: str, given: Mapping[str, Any], frames: bool, tolerance: float
) -> Verdict:
    """Compare two URDFs."""
    from urdf2mbs.proof.alike import compare_robots

    one, two = _read_robot(first, given), _read_robot(second, given)
    called = _called(first, second)
    names = {one.inserted: two.inserted} if one.inserted and two.inserted else {}
    comparison = compare_robots(one.robot, two.robot, names, tolerance, called)
    if frames:
        comparison.differences += comparison.frames
        comparison.frames = []
    moving = [j.name for j in one.robot.joints.values() if j.moves and j.name != one.inserted]
    return _alike(
        one.robot.name, "floating" if one.floating else "fixed", comparison, len(moving), called,
        [], [*one.diagnostics, *two.diagnostics],
    )  # fmt: skip


def _called(first: str, second: str) -> tuple[str, str]:
    """How messages call two files: by their names, with the folders where these are alike."""
    names = Path(first).name, Path(second).name
    return names if names[0] != names[1] else (first, second)


def _alike(
    robot: str, base: str, comparison: Comparison, moving: int, called: tuple[str, str],
    schema: list[str], diagnostics: Sequence[Diagnostic] = (),
) -> Verdict:  # fmt: skip
    """The verdict on two descriptions of one kind."""
    return Verdict(
        robot, base, (), {}, moving, comparison.urdf_mass, comparison.mbs_mass, comparison.groups,
        comparison.positions, comparison.largest, comparison.differences, comparison.frames,
        comparison.but_for, comparison.not_compared, schema, [], list(diagnostics), called,
    )  # fmt: skip


def _unseen(robot: Robot, mbs: Mbs, found: Match) -> dict[str, str]:
    """The links' frames of which the .mbs says less than the URDF, or nothing."""
    points = {point.name for point in mbs.base.points}
    points |= {point.name for body in mbs.bodies for point in body.points}
    root = robot.root()
    return {
        f"frame of link '{link}'": "its anchor point has no rotation"
        if not points.isdisjoint(spellings(link, "point"))
        else "the .mbs has no body and no point of its name"
        for link in robot.links
        if link not in found.frames and link != root
    }


def _text(conversion: Conversion) -> bytes:
    """The URDF's text as the reader takes it: expanded, and harmless slips mended."""
    if conversion.expanded is not None:
        return conversion.expanded
    settings = conversion.settings
    return mend(read_file(settings.source))[0]
