"""urdf2mbs from Python: convert a robot, and compare one with an .mbs file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.model import Config, config_of
from urdf2mbs.conversion import Conversion, Names
from urdf2mbs.disk import files
from urdf2mbs.engine.output import write
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import of_ours, plugins_of
from urdf2mbs.mbs.model import LinkFrame, Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic
from urdf2mbs.proof.compare import compare
from urdf2mbs.proof.match import Match, fixed_to_world, floating_joints, match, spellings
from urdf2mbs.proof.pair import TOLERANCE
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.ranges import LARGEST_TOLERANCE
from urdf2mbs.summary import Report, report
from urdf2mbs.urdf.changes import describe
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
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...] = ()
    """The six .mbs joints of a base that the URDF does not have itself."""
    joints: dict[str, tuple[str, ...]] = {}
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    moving: int
    """The number of moving joints of the URDF."""
    diagnostics: list[Diagnostic] = []
    """Warnings and notes of reading the URDF."""
    made_of: str = ""
    """The URDF that the .mbs was made of in memory."""

    @property
    def verdict(self) -> str:
        """In words, the same as those of a conversion."""
        return self.in_words()


def verify(
    source: str | os.PathLike[str], model: str | os.PathLike[str], *, frames: bool = False,
    tolerance: float = TOLERANCE, **fields: Any,
) -> Verdict:  # fmt: skip
    """Compare a URDF or xacro file with an .mbs, which may have been edited by hand.

    The .mbs may be given as its project's folder.  A second URDF in its place is converted in
    memory, and the result is compared with the first.

    Joints are matched by name.  ``frames``: a link's frame that is elsewhere in the .mbs is a
    difference, too.  ``fields`` are those of ``Config``, for reading the robot.  Its ``base`` is
    what the .mbs should have; ``auto`` takes it from the .mbs, unless the URDF is tied to
    ``world``.  Its ``gravity`` is what the .mbs should have, since a URDF has none.
    Raises ConversionError.
    """
    if not 0.0 < tolerance <= LARGEST_TOLERANCE:
        raise ConfigError(
            "tolerance-invalid",
            f"the tolerance is {tolerance}: above 0, at most {LARGEST_TOLERANCE} is wanted",
            hint=f"such as {TOLERANCE}",
        )
    robot, other = os.fspath(source), os.fspath(model)
    if files.is_folder(Path(other, "dataR")):
        other = os.fspath(files.model_of(Path(other)) or "")
    if robot.lower().endswith(".mbs"):
        if not _is_robot(other):
            raise ConfigError(
                "usage", "verify compares a URDF with an .mbs, and neither file is a URDF",
                hint=f"urdf2mbs diff {robot} {other}",
            )  # fmt: skip
        robot, other = other, robot
    # what people changed in an .mbs that is there is no part of a model that is made of a URDF
    made = (
        Pipeline(*config_of(other, **fields)).run(stop_after="emit") if _is_robot(other) else None
    )
    # the project of the .mbs: rotors are for projects alone
    fields["output"] = {"project": files.project_of(Path(other))}
    if made is None:
        mbs = read(files.read_model(other), other)
        certified = of_ours("certified")
        known = certified(other) if certified else ({}, [])
        verdict = _verify(robot, mbs, known, None, frames, tolerance, fields)
    else:
        verdict = _verify(robot, made.mbs, ({}, []), made.robot, frames, tolerance, fields)
        verdict.made_of = other
    if frames:
        verdict.count_frames()
    else:  # of matched names: where a model has its frames is its own choice
        verdict.largest.pop("frame", None)
    return verdict


def _verify(
    source: str, mbs: Mbs, certified: tuple[dict[str, Any], list[str]], other: Robot | None,
    frames: bool, tolerance: float, fields: dict[str, Any],
) -> Verdict:  # fmt: skip
    """Compare a URDF with an .mbs; ``other`` is the robot that the .mbs was just made of.

    ``certified``: the options of the passes that changed the robot on purpose, and the joints that
    are driven on purpose, though the URDF has them follow others.
    """
    changing, driven = certified
    base = fields.get("base", "auto")
    floats = "floating" if floating_joints(mbs) else "fixed"
    passes = plugins_of((), installed=False).join(_ROBOT)
    asked = {name: options for name, options in changing.items() if name in passes}
    given = {"source": source, "pipeline": passes, "passes": asked}
    fields = {**fields, "base": floats if base == "auto" else base}
    conversion = Pipeline(*config_of(given, **fields), installed_plugins=False).run()
    robot, gravity = conversion.robot, conversion.settings.config.gravity
    found = match(robot, mbs)
    proof = compare(
        robot, mbs, found.joints,
        frames=found.frames, frozen=found.frozen, weightless=[*found.frozen], orders=found.orders,
        driven=driven,
        models=None if other is None else mbs.user_models,
        gravity=gravity, tolerance=tolerance, drawn=mbs,
    )  # fmt: skip
    for change in conversion.checked.changed:
        changed = f"what {change.by} changed: {describe(change.changes)}"
        proof.but_for[changed] = "on purpose, as the certificate says"
    if other is not None:
        _compare_followers(robot, other, found, proof)
    inserted = conversion.base.inserted or ""
    floating_base = found.joints.get(inserted, ())
    if base == "auto" and floating_base and fixed_to_world(robot, inserted):
        said = "the robot is fixed to the world, and the base of the .mbs floats"
        proof.differ([Difference("base", said, urdf="fixed", mbs="floating")])
    if frames:
        proof.not_compared |= _unseen(robot, mbs, found)
    return Verdict(
        **msgspec.structs.asdict(proof),
        robot=robot.name,
        base=floats,
        floating_base=floating_base,
        joints={name: names for name, names in found.joints.items() if name != inserted},
        moving=sum(
            joint.moves and joint.name not in (inserted, *found.frozen)
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
            proof.differ([Difference("mimic", said, link=joint.child, joint=joint.name)])


def _is_robot(file: str) -> bool:
    """True for the name of a URDF or xacro file; an .mbs may have any ending."""
    return is_name(file) or Path(file).suffix.lower() in (".urdf", ".xacro", ".xml")


def _unseen(robot: Robot, mbs: Mbs, found: Match) -> dict[str, str]:
    """The links whose frames are not, or not wholly, in the .mbs, each with the reason."""
    points = {point.name for point in mbs.points().values()}
    root = robot.root()
    return {
        f"frame of link '{link}'": "its anchor point has no rotation"
        if not points.isdisjoint(spellings(link, "point"))
        else "the .mbs has no body and no point of its name"
        for link in robot.links
        if link not in found.frames and link != root
    }
