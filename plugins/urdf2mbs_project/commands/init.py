"""``urdf2mbs init``: a short commented config for a robot, from what can be found out about it.

Reads the robot, and finds its packages, xacro arguments, base, feet, meshes.
Writes a short config with comments, which 'urdf2mbs run' converts.
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from urdf2mbs.plugin import (
    STREAM,
    Config,
    ConfigError,
    Conversion,
    Lines,
    Pipeline,
    absolute,
    add_fields,
    add_printing,
    check_kind,
    choose_fields,
    choose_file_name,
    counted,
    is_name,
    path,
    print_json,
    printable,
    report,
    some,
    stem,
    typed,
    write_files,
)
from urdf2mbs_project.facts import RobotFacts, find_robot_facts
from urdf2mbs_project.feet import list_geometries

EXAMPLES = (
    "urdf2mbs init robot.urdf.xacro",
    "urdf2mbs init robot_descriptions:atlas_v4_description",
)

#: The options of the pass ``equations``: Robotran's own programs need equations in the project.
EQUATIONS_OPTIONS = {"language": "project"}
#: The comments beside ``base``, by the reason of the base; others are written as they are.
BASE_COMMENTS = {
    "own joint": "the URDF has a floating joint of its own",
    "as asked": "as asked for",
    "world": "the root is tied to 'world'; or floating",
    "one limb": "the root carries one limb, as an arm does; or floating",
    "two arms": "the root carries two limbs that rise above it; or floating",
    "massless root": "the root has no mass; or floating",
    "free root": "nothing ties the root to 'world'; or fixed",
}


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    command.add_argument(
        "robot", metavar="ROBOT", help="a .urdf, .xacro or MJCF file, or robot_descriptions:NAME"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="CONFIG.yaml", help="default: the robot's name, here"
    )
    add_printing(command)
    add_fields(command, "base", "packages", "xacro_args", "trust_xacro")


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the config, and print the facts of the robot."""
    if arguments.robot == STREAM:
        raise ConfigError("usage", "a config names the robot's file, and standard input has none")
    check_kind(Path(arguments.robot), arguments, "robot")
    fields = choose_fields(arguments)
    config, facts = init(arguments.robot, arguments.output, force=arguments.force, **fields)
    if arguments.json:
        packages = {name: str(folder) for name, folder in facts.packages.items()}
        data = {**facts._asdict(), "robot": facts.robot.name, "packages": packages}
        print_json({"config": str(config), "links": len(facts.robot.links), **data})
    else:
        print(describe_facts(config, facts))
    return 0


def init(
    source: str, config: Path | None = None, *, force: bool = False, **fields: Any
) -> tuple[Path, RobotFacts]:
    """Write a config for a robot.

    The robot is converted before the config is written; the model is not kept.

    Args:
        source: The file or name of the robot.
        config: The file to write; None for the robot's name.
        force: True to replace an existing config, even if it was edited.
        fields: The fields of ``Config`` that say how to read the robot, such as ``packages``.

    Returns:
        The file, and the facts of the robot.

    Raises:
        ConfigError: ``output-not-ours``, ``output-unwritable``, ``config-name``.
        ConversionError: The robot cannot be converted.
    """
    lines = Lines()
    given = typed(Config, {"source": source, "pipeline": "compact", **fields}, lines)
    # Fresh, since edits of an existing .mbs are no facts of the robot.
    conversion = Pipeline(given, lines, installed_plugins=False, fresh=True).run()
    facts = find_robot_facts(conversion)
    facts = facts._replace(passes={**facts.passes, "equations": EQUATIONS_OPTIONS})
    config = _choose_config(conversion) if config is None else config
    if config.suffix.lower() not in (".yaml", ".yml"):
        message = f"'{config}' is no name of a config"
        raise ConfigError("config-name", message, hint=f"such as {_choose_config(conversion)}")
    write_files({config: _format_config(config, facts, given, conversion).encode()}, force=force)
    return config, facts


def _choose_config(conversion: Conversion) -> Path:
    """Return the config of a robot: its name, or that of its file if another robot has its name."""
    source = conversion.settings.source
    config = Path(f"{choose_file_name(conversion.robot.name, source)}.yaml")
    try:
        values = yaml.safe_load(config.read_bytes())
        stated = Path(values["source"])
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError):
        return config  # it is free, or it has no source: then it is not replaced without --force
    is_of_source = absolute(stated) == source or is_name(str(stated))
    return config if is_of_source else Path(f"{stem(source)}.yaml")


# --- the config ---


class _Setting(NamedTuple):
    """A line of the config."""

    key: str
    value: str
    """In YAML."""
    comment: str


def _format_config(config: Path, facts: RobotFacts, given: Config, conversion: Conversion) -> str:
    """Return the text of the config.

    Args:
        config: Its file.
        facts: The facts of the robot.
        given: The config by which the robot was just converted.
        conversion: That conversion.
    """
    robot = facts.robot
    n_moving = sum(joint.moves for joint in robot.joints.values())
    settings = _choose_settings(config, given, conversion)
    width = max(len(f"{setting.key}: {setting.value}") for setting in settings[1:])
    lines = [
        f"# {printable(robot.name)}: {counted(len(robot.links), 'link')}, "
        f"{counted(n_moving, 'moving joint')}, "
        f"{report(conversion).mass:.4g} kg. Paths are relative to this file.",
        f"#   urdf2mbs run {config.name}       convert it",
        f"#   urdf2mbs report {config.name}    look at it",
    ]
    for setting in settings:
        line = f"{setting.key}: {setting.value}"
        lines.append(f"{line:{width}}  # {setting.comment}" if setting.comment else line)
    lines += _format_packages(config, facts)
    lines += _format_xacro_arguments(facts, given.xacro_args)
    lines += _format_passes(facts, conversion)
    return "\n".join(lines) + "\n"


def _choose_settings(config: Path, given: Config, conversion: Conversion) -> list[_Setting]:
    """Choose the fields of the config, with a comment for each."""
    source = given.source
    # The folder of the project must not be that of the robot's file.
    has_source = config.absolute().with_suffix("") in conversion.settings.source.parents
    folder = f"{config.stem}_robotran" if has_source else config.stem
    base = "floating" if conversion.base.floating else "fixed"
    if conversion.base.inserted is None and conversion.base.reason == "own joint":
        base = "auto"
    output = _format_yaml({"project": folder, "language": "both"})
    file = _format_yaml(f"{config.stem}.mbs")
    settings = [
        _Setting(
            "source",
            _format_yaml(source if is_name(source) else _relative_path(Path(source), config)),
            "",
        ),
        _Setting("output", output, f"a whole Robotran project; or only the file: {file}"),
        _Setting("base", base, _explain_base(conversion)),
        _Setting("pipeline", "compact", "the fewest joints; or faithful: a body for every link"),
    ]
    if conversion.settings.config.trust_xacro:
        settings.append(_Setting("trust_xacro", "true", "its xacro may do whatever Python can"))
    return settings


def _explain_base(conversion: Conversion) -> str:
    """Return why the base is fixed or floating."""
    reason = conversion.base.reason
    if reason == "fixed by another program":
        return f"{conversion.robot.fixed_by} ties it to 'world'; or floating"
    return BASE_COMMENTS.get(reason, reason)


def _format_packages(config: Path, facts: RobotFacts) -> list[str]:
    """Return the lines of ``packages``, with comments for those that were not found."""
    if not facts.packages and not facts.packages_missing:
        return []
    lines = ["", "packages:" if facts.packages else "# packages:"]
    for name, folder in facts.packages.items():
        lines.append(f"  {_format_yaml(name)}: {_format_yaml(_relative_path(folder, config))}")
    lines += [
        f"#   {_format_yaml(name)}: DIR   # meshes name it, and it was not found"
        for name in facts.packages_missing
    ]
    return lines


def _format_xacro_arguments(facts: RobotFacts, given: Mapping[str, str]) -> list[str]:
    """Return the lines of ``xacro_args``, with comments for the defaults of the others."""
    if not facts.arguments and not given:
        return []
    lines = ["", "xacro_args:" if given else "# xacro_args:   # and their defaults"]
    for name, value in given.items():
        lines.append(f"  {_format_yaml(name)}: {_format_argument(value)}")
    for name, default in facts.arguments.items():
        if name not in given:
            # A default with $(...) has a value only in the file that declares it.
            value = "VALUE" if "$(" in default else _format_argument(default)
            lines.append(f"#   {_format_yaml(name)}: {value}")
    return lines


def _format_passes(facts: RobotFacts, conversion: Conversion) -> list[str]:
    """Return the lines of ``passes``, with comments that offer further options."""
    comments = {
        "joints": "zero is beyond the limits of some"
        + "; its feet are below its hips" * bool(facts.feet),
        "hold": "Hz; a controller holds the start position",
    }
    lines = ["", "passes:"]
    posture = facts.passes.get("posture", {})
    if posture:
        lines.append("  posture:")
    for key, value in posture.items():
        lines.append(f"    {key}: {_format_yaml(value)}   # {comments[key]}")
    if "contacts" in facts.passes:
        contacts = _format_yaml(facts.passes["contacts"])
        lines.append(f"  contacts: {contacts}   # the ground; all that is solid touches")
    equations = _format_yaml(facts.passes["equations"])
    lines.append(f"  equations: {equations}   # of motion, which Robotran's programs need")

    codes = {diagnostic.code for diagnostic in conversion.diagnostics}
    has_shapes = any(list_geometries(link) for link in facts.robot.links.values())
    if "no-mass" in codes and has_shapes:
        lines += [
            "# No link has a mass. Uncomment to estimate masses from the geometry:",
            "#   estimate-inertia: {total_mass: 10}   # kg",
        ]
    has_rotors = "rotors" in conversion.input.settings.get("passes", {})  # a project adds them
    if "rotors-left-out" in codes and not has_rotors:
        lines += [
            "# The URDF states motors. Uncomment to count their inertia, which joints feel, too:",
            "#   rotors: {from_urdf: true}   # a constraint for each joint with a motor",
        ]
    elif "no-mass" in codes and not has_shapes:
        lines.append("# NO DYNAMICS: no link has a mass, nor a shape to estimate one from.")
    return lines


def _relative_path(path: Path, config: Path) -> str:
    """Return a path relative to the folder of a config; absolute if it is on another drive."""
    try:
        return Path(os.path.relpath(path.absolute(), config.absolute().parent)).as_posix()
    except ValueError:
        return path.absolute().as_posix()


def _format_yaml(value: object) -> str:
    """Return a value as YAML in one line."""
    text = yaml.safe_dump(
        value, default_flow_style=True, sort_keys=False, width=10**9, allow_unicode=True
    )
    return text.removesuffix("\n").removesuffix("...").rstrip()


def _format_argument(value: str) -> str:
    """Return the value of an argument in YAML; numbers, yes and no need no quotes here."""
    return value if re.fullmatch(r"[\w.+-]*\w", value) else _format_yaml(value)


# --- messages ---


def describe_facts(config: Path, facts: RobotFacts) -> str:
    """Return the message about the written config, and the commands to use next."""
    return "\n".join([*_describe_files(config, facts), "", _propose_next(config, facts)])


def _describe_files(config: Path, facts: RobotFacts) -> list[str]:
    """Return lines about the config, the feet, and the files that were not found."""
    parts = [f"wrote {config}: {counted(len(facts.robot.links), 'link')}"]
    if facts.packages:
        parts.append(counted(len(facts.packages), "package"))
    if facts.arguments:
        parts.append(counted(len(facts.arguments), "xacro argument"))
    if facts.meshes:
        n_found = facts.meshes - len(facts.meshes_missing)
        parts.append(f"{n_found} of {counted(facts.meshes, 'mesh')} found")
    lines = [", ".join(parts)]
    if facts.feet:
        lines.append(f"  feet: {', '.join(facts.feet)}")
    shapeless = facts.passes.get("contacts", {}).get("points")
    if shapeless:
        lines.append(
            f"  no shape was found of {some(shapeless, 3)}: a box with its inertia is used"
        )
    if facts.why_no_feet:
        ground = "; all that is solid touches the ground" * ("contacts" in facts.passes)
        lines.append(f"  no feet: {facts.why_no_feet}{ground}")
    if facts.meshes_missing:
        lines.append(f"  not found: {some(facts.meshes_missing, 3)}")
        lines.append(f"    {facts.meshes_remedy}")
    return lines


def _propose_next(config: Path, facts: RobotFacts) -> str:
    """Return the commands to use next."""
    text = f"Next: urdf2mbs run {config}; "
    if not any(link.inertial and link.inertial.mass for link in facts.robot.links.values()):
        return text + f"no link has a mass, and nothing moves: see the end of {config}"
    return text + f"then: urdf2mbs simulate {config} -o moves.html"
