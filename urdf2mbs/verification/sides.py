"""The two robots of a comparison: the first as a URDF's robot, the second as a model.

Each of them may be a URDF or xacro file, an .mbs, or a config, whose passes make the robot.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
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
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConfigError, Diagnostic
from urdf2mbs.proof.compare import Expectation, compare
from urdf2mbs.proof.match import Match, find_floating_joints, match_by_name
from urdf2mbs.proof.mbs_as_robot import convert_to_robot
from urdf2mbs.proof.parameters import PARAMETERS
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.states import OnPurpose
from urdf2mbs.urdf.model import Robot
from urdf2mbs.urdf.reader import ROBOT_ENDINGS, is_name
from urdf2mbs.verification.joint_map import JointMap
from urdf2mbs.verification.loops import Closure

#: The passes that read the robot.  Passes of plugins that change the robot join them.
_ROBOT_PASSES = ("expand", "insert-base")
#: The kinds of differences that are faults of one file alone.
_FAULTS_OF_ONE_FILE = ("nature", "cut", "symbols")


class Source(msgspec.Struct, kw_only=True):
    """One of the two robots, as a user names it."""

    name: str
    """The name of the file."""
    is_model: bool = False
    """Whether it is an .mbs, or the folder of a project."""
    config: Config | None = None
    """The config, if its passes make the robot."""
    lines: Lines = msgspec.field(default_factory=Lines)
    installed_plugins: bool = True
    pipeline: Pipeline | None = None
    """The passes of the config, once they are resolved."""

    def resolve(self) -> Pipeline:
        """Return the passes of the config, which start over."""
        assert self.config is not None
        if self.pipeline is None:
            self.pipeline = Pipeline(
                self.config, self.lines, installed_plugins=self.installed_plugins, fresh=True
            )
        return self.pipeline


class Model(msgspec.Struct, kw_only=True):
    """The second robot, as a model."""

    name: str
    mbs: Mbs
    conversion: Conversion | None = None
    """The conversion that made it in memory; None if the model was read from a file."""


class Reference(msgspec.Struct, kw_only=True):
    """The first robot, with which a model is compared."""

    robot: Robot
    match: Callable[[Robot, Mbs, JointMap | None], Match]
    """Finds the joints of a model by a map and by name."""
    expect: Callable[[Match, Model], Expectation]
    """Returns what the robot's file does not state, and the model should have."""
    base_joint: str = ""
    """The joint of a base that was inserted; empty if there is none."""
    diagnostics: list[Diagnostic] = []
    accepted: dict[str, str] = {}
    """Changes of the robot that a certificate names, each with the reason."""
    changed: list[str] = []
    """The changes of the robot by the passes of a config, a sentence for each pass."""
    undeclared: list[Difference] = []
    """The changes that no pass of the config declared."""
    conversion: Conversion | None = None
    mbs: Mbs | None = None
    """The model, if the first robot is an .mbs."""
    own_faults: list[Difference] = []
    """Its differences from itself, such as dependent joints that nothing moves."""
    closures: list[Closure] = []
    """What closes its loops, if they are cut elsewhere than in its file."""


def is_robot(name: str) -> bool:
    """Return whether a name is that of a robot's file; an .mbs may have any other ending."""
    return is_name(name) or Path(name).suffix.lower() in ROBOT_ENDINGS


def is_config(name: str | os.PathLike[str]) -> bool:
    """Return whether a name is that of a config file."""
    return os.fspath(name).lower().endswith((".yaml", ".yml"))


def read_source(
    source: Config | str | os.PathLike[str], fields: dict[str, Any], *, is_first: bool
) -> Source:
    """Return a robot as a user names it; of a config, its passes are not run yet.

    Args:
        source: A config, or the name of a file.
        fields: Fields of ``Config``, which change those of a config.
        is_first: Whether it is the first of two; a file of unknown ending is then a robot, and as
            the second a model.
    """
    if isinstance(source, Config) or is_config(source):
        config, lines = config_of(source, **fields)
        name = "the config" if isinstance(source, Config) else os.fspath(source)
        return Source(name=name, config=config, lines=lines)
    name = os.fspath(source)
    if files.is_folder(Path(name, "dataR")):
        return Source(name=os.fspath(files.model_of(Path(name)) or name), is_model=True)
    is_model = name.lower().endswith(".mbs") if is_first else not is_robot(name)
    return Source(name=name, is_model=is_model)


def find_output(source: Source) -> Source:
    """Return the .mbs that a config writes.

    Raises:
        ConfigError: ``usage``, there is none.
    """
    output = source.resolve().settings.output
    if not files.is_file(output):
        message = f"no model to compare: '{output}' does not exist"
        name = source.lines.file or "CONFIG.yaml"
        hint = f"make it: urdf2mbs run {name}; or name one: urdf2mbs verify {name} MODEL.mbs"
        raise ConfigError("usage", message, hint=hint)
    return Source(name=os.fspath(output), is_model=True)


# --- the second robot ---


def read_second(source: Source, fields: dict[str, Any]) -> Model:
    """Read a model, or convert a robot to one in memory.

    Args:
        source: The second robot.
        fields: Fields of ``Config`` for the reading of a robot.
    """
    if source.is_model:
        return Model(name=source.name, mbs=read_mbs(files.read_model(source.name), source.name))
    conversion = _convert(source, fields)
    return Model(name=source.name, mbs=conversion.mbs, conversion=conversion)


def _convert(source: Source, fields: dict[str, Any]) -> Conversion:
    """Convert a robot.

    The passes after emit do not take part: they write files, and merge people's edits of an .mbs.
    """
    if source.config is None:
        pipeline = Pipeline(*config_of(source.name, **fields))
    else:
        pipeline = source.resolve()
    names = [step.name for step in pipeline.passes]
    return pipeline.run(stop_after="emit" if "emit" in names else None)


# --- the first robot ---


def read_first(source: Source, model: Model, fields: dict[str, Any]) -> Reference:
    """Read the robot with which a model is compared.

    Args:
        source: The first robot.
        model: The second one.
        fields: Fields of ``Config`` for the reading of a robot.
    """
    if source.config is not None:
        return _refer_to_config(source)
    if source.is_model:
        return _refer_to_model(source, fields)
    return _refer_to_robot(source, model, fields)


def _refer_to_model(source: Source, fields: dict[str, Any]) -> Reference:
    """Refer to an .mbs, as a robot of links and joints."""
    mbs = read_mbs(files.read_model(source.name), source.name)
    robot = convert_to_robot(mbs, source.name)
    compared_models = [model for model in mbs.user_models if model.name not in PARAMETERS]

    def expect(match: Match, model: Model) -> Expectation:
        return Expectation(
            gravity=fields.get("gravity", mbs.base.gravity),
            massless=[*match.locked],
            user_models=compared_models,
        )

    faults = compare(robot, mbs, match_by_name(robot, mbs)).differences
    return Reference(
        robot=robot,
        match=_match_by_name,
        expect=expect,
        mbs=mbs,
        own_faults=[each for each in faults if each.kind in _FAULTS_OF_ONE_FILE],
    )


def _match_by_name(robot: Robot, mbs: Mbs, joint_map: JointMap | None) -> Match:
    """Match the joints of a map, and the others by name."""
    return match_by_name(robot, mbs, None if joint_map is None else joint_map.joints)


def _refer_to_robot(source: Source, model: Model, fields: dict[str, Any]) -> Reference:
    """Refer to the robot of a URDF, with the base of a model and the intended changes."""
    intent = Intent()
    if model.conversion is None:
        intent = load_plugins().hook.urdf2mbs_intent(model=Path(model.name)) or Intent()
    names = join(_ROBOT_PASSES, load_plugins(installed=False))
    options = {name: values for name, values in intent.passes.items() if name in names}
    given = {"source": source.name, "pipeline": names, "passes": options}
    made = model.conversion
    # rotors are for projects only; a robot's own file may ask for them, where the model has none
    if options or (made is not None and made.settings.project is not None):
        fields = {**fields, "output": {"project": files.project_of(Path(model.name))}}
    conversion = _read_robot(given, fields, model.mbs)

    def expect(match: Match, model: Model) -> Expectation:
        return Expectation(
            gravity=conversion.settings.config.gravity,
            massless=[*match.locked],
            driven=intent.driven,
            user_models=None if model.conversion is None else model.mbs.user_models,
            shapes=model.mbs,
        )

    return Reference(
        robot=conversion.robot,
        match=_match_by_name,
        expect=expect,
        base_joint=conversion.base.inserted or "",
        diagnostics=conversion.diagnostics,
        accepted={
            change.describe(): "on purpose, as the certificate says"
            for change in conversion.checked.changed
        },
        conversion=conversion,
        closures=_list_stated_closures(conversion, fields),
    )


def _list_stated_closures(conversion: Conversion, fields: dict[str, Any]) -> list[Closure]:
    """Return what closes the loops of a robot whose file states cuts, as an MJCF does.

    A pass makes them, which the reading of the robot does not run.
    """
    expansion = conversion.input.expansion
    if expansion is None or not expansion.settings.get("passes"):
        return []
    from urdf2mbs.verification.loops import list_closures

    source = {"source": str(conversion.settings.source)}
    fields = {name: value for name, value in fields.items() if name not in ("source", "output")}
    pipeline = Pipeline(*config_of({**source, "pipeline": "faithful"}, **fields))
    mbs = pipeline.run(stop_after="emit").mbs
    return list_closures(convert_to_robot(mbs, ""), mbs)


def _read_robot(given: dict[str, Any], fields: dict[str, Any], mbs: Mbs) -> Conversion:
    """Read a robot, with the base of a model unless the fields state one.

    Six joints of the model that are joints of the URDF are no floating base.
    """
    bases = [fields.get("base", "auto")]
    if bases == ["auto"]:
        bases = ["floating", "fixed"] if find_floating_joints(mbs) else ["fixed"]
    for base in bases:
        config, lines = config_of(given, **{**fields, "base": base})
        conversion = Pipeline(config, lines, installed_plugins=False).run()
        inserted = conversion.base.inserted
        if not inserted or inserted in match_by_name(conversion.robot, mbs).joints:
            break
    return conversion


def _refer_to_config(source: Source) -> Reference:
    """Refer to the robot that the passes of a config make.

    A model should have the changes that the passes make on purpose, the joints that they lock and
    drive, and the names that they give.
    """
    conversion = _convert(source, {})
    on_purpose = conversion.state(OnPurpose)

    def expect(match: Match, model: Model) -> Expectation:
        massless = [
            name
            for name in match.locked
            if name in on_purpose.massless or name not in conversion.frozen
        ]
        return Expectation(
            gravity=conversion.settings.config.gravity,
            massless=massless,
            driven=[joint.name for joint in on_purpose.driven],
            user_models=conversion.mbs.user_models,
            shapes=model.mbs,
        )

    return Reference(
        robot=conversion.robot,
        match=partial(_match_conversion, conversion),
        expect=expect,
        base_joint=conversion.base.inserted or "",
        diagnostics=conversion.diagnostics,
        changed=[change.describe() for change in conversion.checked.changed if change.declared],
        undeclared=[
            Difference("changed", f"{change}, and does not say so by writes = ('robot',)")
            for change in conversion.checked.changed
            if not change.declared
        ],
        conversion=conversion,
    )


def _match_conversion(
    conversion: Conversion, robot: Robot, mbs: Mbs, joint_map: JointMap | None
) -> Match:
    """Return the joints and frames of an .mbs that are those of a conversion.

    If the .mbs has all the names that the conversion gave, these decide.  Otherwise joints and
    frames are matched by the names of the URDF, as for a model that was drawn by hand.
    """
    joints, bodies = mbs.joints(), {body.name for body in mbs.bodies}
    names = conversion.names.coordinates
    needed = {name for coordinates in names.values() for name in coordinates}
    needed |= {frame.joint for frame in conversion.frames.values() if frame.joint is not None}
    framed = {frame.body for frame in conversion.frames.values() if frame.body is not None}
    if needed <= joints.keys() and framed <= bodies and joint_map is None:
        return Match(
            joints={name: tuple(coordinates) for name, coordinates in names.items()},
            frames=conversion.frames,
            locked=conversion.frozen,
        )
    matched = _match_by_name(robot, mbs, joint_map)
    for name in conversion.frozen:
        matched.joints.pop(name, None)
    matched.locked |= conversion.frozen
    return matched
