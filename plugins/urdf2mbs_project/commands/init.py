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
from lxml import etree

from urdf2mbs.plugin import (
    STREAM,
    Config,
    ConfigError,
    Conversion,
    Lines,
    Mesh,
    Pipeline,
    Robot,
    add_fields,
    add_printing,
    choose_fields,
    counted,
    files,
    is_name,
    path,
    print_json,
    printable,
    read_text,
    report,
    safe_parser,
    some,
    stem,
    typed,
    write_files,
)
from urdf2mbs_meshes.files import get_mesh_files
from urdf2mbs_project.stance import find_stance, shapes

EXAMPLES = (
    "urdf2mbs init robot.urdf.xacro",
    "urdf2mbs init robot_descriptions:atlas_v4_description",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "robot", metavar="ROBOT", help="a .urdf or .xacro file, or robot_descriptions:NAME"
    )
    command.add_argument(
        "-o", "--output", type=path, metavar="CONFIG.yaml", help="default: the robot's name, here"
    )
    add_printing(command)
    add_fields(command, "base", "packages", "xacro_args", "trust_xacro")


def carry_out(arguments: argparse.Namespace) -> int:
    if arguments.robot == STREAM:
        raise ConfigError("usage", "a config names the robot's file, and standard input has none")
    fields = choose_fields(arguments)
    config, found = init(arguments.robot, arguments.output, force=arguments.force, **fields)
    if arguments.json:
        packages = {name: str(folder) for name, folder in found.packages.items()}
        whole = {**found._asdict(), "robot": found.robot.name, "packages": packages}
        print_json({"config": str(config), "links": len(found.robot.links), **whole})
    else:
        print(in_words(config, found))
    return 0


#: What a config says of equations: Robotran's own programs need them in the project.
EQUATIONS = {"language": "project"}
#: The controller that holds the start position (Hz).
HOLD = {"frequency": 10, "damping_ratio": 0.3}


class RobotFacts(NamedTuple):
    """What can be found out about a robot before it is converted."""

    robot: Robot
    packages: dict[str, Path]
    """The packages whose files the robot uses."""
    packages_missing: list[str]
    """The packages that meshes name, and that were not found."""
    arguments: dict[str, str]
    """The arguments that its xacro files declare, and their defaults as they are written."""
    meshes: int
    meshes_missing: list[str]
    meshes_remedy: str
    """What to do about the first missing mesh; empty if none is missing."""
    feet: list[str]
    why_no_feet: str
    """Empty where there are feet, or where the robot is bolted down."""
    passes: dict[str, Any]
    """What its config says of passes: a start position, and what lets a robot stand."""


def init(
    source: str, config: Path | None = None, *, force: bool = False, **fields: Any
) -> tuple[Path, RobotFacts]:
    """Write a config for a robot; gives its file, and what was found.

    ``fields`` are those of ``Config`` that say how to read the robot, such as ``packages``.
    ``force``: a config that is there is replaced, also one that was edited.

    The robot is converted before the config is written; the model is not kept.

    :raises ConfigError: ``output-not-ours``, ``output-unwritable``, ``config-name``
    :raises ConversionError: the robot cannot be converted
    """
    lines = Lines()
    asked = typed(Config, {"source": source, "pipeline": "compact", **fields}, lines)
    # what people changed in an .mbs that lies there is no fact of the robot
    conversion = Pipeline(asked, lines, installed_plugins=False, fresh=True).run()
    found = find(conversion)
    name = stem(conversion.settings.source)
    config = Path(f"{name}.yaml") if config is None else config
    if config.suffix.lower() not in (".yaml", ".yml"):
        raise ConfigError(
            "config-name", f"'{config}' is no name of a config", hint=f"such as {name}.yaml"
        )
    found = found._replace(passes={**found.passes, "equations": EQUATIONS})
    write_files({config: _text(config, found, asked, conversion).encode()}, force=force)
    return config, found


def find(conversion: Conversion) -> RobotFacts:
    """What there is to know of the robot of a conversion."""
    source, config = conversion.settings.source, conversion.settings.config
    packages, expansion = conversion.packages, conversion.input.expansion
    robot, _ = read_text(source, conversion.input.data, expansion, config.xacro_args)
    geometries = [shape for link in robot.links.values() for shape in shapes(link)]
    meshes = {shape.filename for shape in geometries if isinstance(shape, Mesh)}
    missing = sorted(name for name in meshes if get_mesh_files(conversion).find(name) is None)
    known = packages.list_found()
    named = {
        found[1] for name in missing if (found := re.match(r"(?:package|model)://([^/]+)", name))
    }
    stance = find_stance(conversion, conversion.report.get("posture-limit", {}).get("middle", {}))
    passes: dict[str, Any] = {"posture": {"joints": stance.joints}} if stance.joints else {}
    if (stance.feet or stance.rests) and any(body.mass for body in conversion.mbs.bodies):
        if any(joint.nature == "independent" for _, joint in conversion.single_coordinates()):
            passes["posture"] = {**passes.get("posture", {}), "hold": HOLD}
        passes["contacts"] = {"links": ["*"]}
        if stance.points:
            points = {link: [[*at] for at in places] for link, places in stance.points.items()}
            passes["contacts"]["points"] = points
    return RobotFacts(
        robot, known, sorted(named - known.keys()),
        _arguments(expansion.files if expansion else []),
        len(meshes), missing,
        get_mesh_files(conversion).suggest_remedy(missing[0]) if missing else "",
        stance.feet, stance.why_not, passes,
    )  # fmt: skip


def _arguments(names: list[str]) -> dict[str, str]:
    """The arguments that xacro files declare, and their defaults."""
    found: dict[str, str] = {}
    for file in names:
        try:
            root = etree.fromstring(files.read_bytes(Path(file)), safe_parser(recover=True))
        except (OSError, etree.XMLSyntaxError):
            continue
        for element in () if root is None else root.iter("{*}arg"):
            if "xacro" in str(etree.QName(element).namespace):
                found.setdefault(element.get("name") or "", element.get("default") or "")
    found.pop("", None)
    return found


def _text(config: Path, found: RobotFacts, asked: Config, conversion: Conversion) -> str:
    """The text of the config; ``asked`` is the config by which the robot was just converted."""
    robot, source = found.robot, asked.source
    moving = sum(joint.moves for joint in robot.joints.values())
    base = "floating" if conversion.base.floating else "fixed"
    own = conversion.base.inserted is None and conversion.base.reason == "own joint"
    holds_source = config.absolute().with_suffix("") in conversion.settings.source.parents
    named = is_name(source)
    folder = f"{config.stem}_robotran" if holds_source else config.stem
    file = _flow(f"{config.stem}.mbs")
    settings = [
        ("source", _flow(source if named else _relative(Path(source), config)), ""),
        ("output", _flow({"project": folder, "language": "both"}),
         f"a whole Robotran project; or only the file: {file}"),
        ("base", "auto" if own else base, _why(conversion)),
        ("pipeline", "compact", "the fewest joints; or faithful: a body for every link"),
    ]  # fmt: skip
    if conversion.settings.config.trust_xacro:
        settings.append(("trust_xacro", "true", "its xacro may do whatever Python can"))
    width = max(len(f"{key}: {value}") for key, value, _ in settings[1:])
    lines = [
        f"# {printable(robot.name)}: {counted(len(robot.links), 'link')}, "
        f"{counted(moving, 'moving joint')}, "
        f"{report(conversion).mass:.4g} kg. Paths are relative to this file.",
        f"#   urdf2mbs run {config.name}       convert it",
        f"#   urdf2mbs report {config.name}    look at it",
    ]
    for key, value, comment in settings:
        line = f"{key}: {value}"
        lines.append(f"{line:{width}}  # {comment}" if comment else line)
    lines += _packages(config, found)
    lines += _args(found, asked.xacro_args)
    lines += _passes(found, conversion)
    return "\n".join(lines) + "\n"


def _relative(path: Path, config: Path) -> str:
    """A path as a config in its folder states it; another drive's stays absolute."""
    try:
        return Path(os.path.relpath(path.absolute(), config.absolute().parent)).as_posix()
    except ValueError:
        return path.absolute().as_posix()


def _flow(value: object) -> str:
    """YAML in one line."""
    text = yaml.safe_dump(
        value, default_flow_style=True, sort_keys=False, width=10**9, allow_unicode=True
    )
    return text.removesuffix("\n").removesuffix("...").rstrip()


def _why(conversion: Conversion) -> str:
    return {
        "own joint": "the URDF has a floating joint of its own",
        "as asked": "as asked for",
        "fixed by another program": f"{conversion.robot.fixed_by} ties it to 'world'; or floating",
        "world": "the root is tied to 'world'; or floating",
        "one limb": "the root carries one limb, as an arm does; or floating",
        "two arms": "the root carries two limbs that rise above it; or floating",
        "massless root": "the root has no mass; or floating",
        "free root": "nothing ties the root to 'world'; or fixed",
    }.get(conversion.base.reason, conversion.base.reason)


def _packages(config: Path, found: RobotFacts) -> list[str]:
    if not found.packages and not found.packages_missing:
        return []
    lines = ["", "packages:" if found.packages else "# packages:"]
    lines += [f"  {_flow(n)}: {_flow(_relative(p, config))}" for n, p in found.packages.items()]
    lines += [
        f"#   {_flow(name)}: DIR   # meshes name it, and it was not found"
        for name in found.packages_missing
    ]
    return lines


def _args(found: RobotFacts, given: Mapping[str, str]) -> list[str]:
    if not found.arguments and not given:
        return []
    lines = ["", "xacro_args:" if given else "# xacro_args:   # and their defaults"]
    lines += [f"  {_flow(name)}: {_argument(value)}" for name, value in given.items()]
    return lines + [  # a default with $(...) has a value only in the file that declares it
        f"#   {_flow(name)}: {'VALUE' if '$(' in default else _argument(default)}"
        for name, default in found.arguments.items()
        if name not in given
    ]


def _argument(value: str) -> str:
    """An argument's value in YAML; a config takes numbers and yes or no as they are written."""
    return value if re.fullmatch(r"[\w.+-]*\w", value) else _flow(value)


def _passes(found: RobotFacts, conversion: Conversion) -> list[str]:
    """A start position within the limits, and what lets a robot with feet stand."""
    codes = {said.code for said in conversion.diagnostics}
    about = {
        "joints": "zero is beyond the limits of some"
        + "; its feet are below its hips" * bool(found.feet),
        "hold": "Hz; a controller holds the start position",
    }
    posture = found.passes.get("posture", {})
    lines = ["  posture:"] * bool(posture)
    lines += [f"    {key}: {_flow(value)}   # {about[key]}" for key, value in posture.items()]
    if "contacts" in found.passes:
        ground = _flow(found.passes["contacts"])
        lines.append(f"  contacts: {ground}   # the ground; all that is solid touches")
    equations = _flow(found.passes["equations"])
    lines.append(f"  equations: {equations}   # of motion, which Robotran's programs need")
    lines = ["", "passes:", *lines]
    offered: list[str] = []
    if "no-mass" in codes and any(shapes(link) for link in found.robot.links.values()):
        offered += [
            "# No link has a mass. Uncomment to estimate masses from the geometry:",
            "#   estimate-inertia: {total_mass: 10}   # kg",
        ]
    if "rotors-left-out" in codes:
        offered += [
            "# The URDF states motors. Uncomment to count their inertia, which joints feel, too:",
            "#   rotors: {from_urdf: true}   # a constraint for each joint with a motor",
        ]
    if offered:
        return [*lines, *offered]
    if "no-mass" in codes:
        return [*lines, "# NO DYNAMICS: no link has a mass, nor a shape to estimate one from."]
    return lines


def in_words(config: Path, found: RobotFacts) -> str:
    """What was found and written, and what to do next."""
    there = found.meshes - len(found.meshes_missing)
    text = f"wrote {config}: {counted(len(found.robot.links), 'link')}"
    text += f", {counted(len(found.packages), 'package')}" * bool(found.packages)
    text += f", {counted(len(found.arguments), 'xacro argument')}" * bool(found.arguments)
    text += f", {there} of {counted(found.meshes, 'mesh')} found" * bool(found.meshes)
    text += f"\n  feet: {', '.join(found.feet)}" * bool(found.feet)
    if bare := found.passes.get("contacts", {}).get("points"):
        text += f"\n  no shape was found of {some(bare, 3)}: a box of its inertia stands in"
    text += f"\n  no feet: {found.why_no_feet}" * bool(found.why_no_feet)
    if found.why_no_feet and "contacts" in found.passes:
        text += "; all that is solid touches the ground"
    if found.meshes_missing:
        text += f"\n  not found: {some(found.meshes_missing, 3)}\n    {found.meshes_remedy}"
    text += f"\n\nNext: urdf2mbs run {config}; "
    links = found.robot.links.values()
    if not any(link.inertial and link.inertial.mass for link in links):
        return text + f"no link has a mass, and nothing moves: see the end of {config}"
    return text + f"then: urdf2mbs simulate {config} -o moves.html"
