"""`verify`: are two robots the same, whatever their parts are called?

Splits both descriptions into rigid groups, and compares motion, mass, centre
and inertia of each group.  Each may be a URDF or xacro file, an .mbs of any
origin, or a config, whose passes make the robot.  Joints are matched by name,
and those without a partner by place and mass.  Writes nothing, but for
--write-map.  Exit code 0: the same robot; 3: not.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.commands.kinds import Kind, check_kind
from urdf2mbs.commands.printing import near, print_diagnostics, print_json
from urdf2mbs.commands.settings import (
    READING,
    add_fields,
    add_no_plugins,
    add_printing,
    add_verbose,
    choose_fields,
    path,
    robot_or_config,
)
from urdf2mbs.commands.streams import STREAM
from urdf2mbs.disk import files
from urdf2mbs.engine.output import write_files
from urdf2mbs.engine.plugins import load_plugins
from urdf2mbs.messages.diagnostics import ConfigError, counted, printable

if TYPE_CHECKING:
    from urdf2mbs.verification import Verdict
    from urdf2mbs.verification.sides import Source

EXAMPLES = (
    "urdf2mbs verify robot.urdf robot.mbs",
    "urdf2mbs verify robot.urdf PROJECT",
    "urdf2mbs verify robot.xacro robot.urdf",
    "urdf2mbs verify drawn.mbs robot.mbs --write-map joints.yaml",
    "urdf2mbs verify drawn.mbs robot.mbs --map joints.yaml",
    "urdf2mbs verify robot.yaml robot.mbs",
    "urdf2mbs verify robot.yaml --ci --sarif urdf2mbs.sarif",
)

#: What may be compared.
KINDS: tuple[Kind, ...] = ("robot", "config", "model", "project")
#: The most findings that are printed, unless all are asked for.
MOST_FINDINGS = 15


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of ``verify``."""
    command.add_argument(
        "robot",
        metavar="ROBOT",
        help="a .urdf, .xacro or MJCF file, an .mbs, robot_descriptions:NAME, - for standard "
        "input; or a config, whose passes make the robot",
    )
    command.add_argument(
        "model",
        type=path,
        nargs="?",
        metavar="MODEL.mbs",
        help="of urdf2mbs, or drawn by hand; a project's folder; or another robot or config; "
        "without, of a config: its output",
    )
    command.add_argument(
        "--map",
        type=path,
        metavar="FILE.yaml",
        help="lines 'joint of ROBOT: joint of MODEL', which decide before names and places",
    )
    command.add_argument(
        "--write-map", type=path, metavar="FILE.yaml", help="write how the joints were matched"
    )
    add_printing(command)
    add_verbose(command)
    add_no_plugins(command)
    add_fields(command, *READING, "packages", "xacro_args", "base")
    command.add_argument(
        "--gravity",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="the gravity that the .mbs should have, in m/s^2 (0 0 -9.81; of a config: its own)",
    )
    command.add_argument(
        "--frames",
        action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )
    command.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")


def carry_out(arguments: argparse.Namespace) -> int:
    """Compare the two sides, print the verdict, and return the exit code."""
    robot, compare = _prepare(arguments)
    hook = load_plugins(installed=not arguments.no_plugins).hook
    observers = hook.urdf2mbs_observe_verify(robot=robot, arguments=arguments)
    with ExitStack() as stack:
        verdict_printers = [stack.enter_context(observer) for observer in observers]
        verdict = compare(frames=arguments.frames, tolerance=arguments.tolerance)
        are_printed = [print_verdict(verdict) for print_verdict in verdict_printers]
    if arguments.write_map is not None:
        _write_map(verdict, arguments)
    exit_code = 0 if verdict.same else 3
    if arguments.json:
        print_json(
            {"same": verdict.same, "verdict": verdict.verdict, **msgspec.to_builtins(verdict)}
        )
    elif not any(are_printed):
        _print_verdict(verdict, arguments)
    return exit_code


def _write_map(verdict: Verdict, arguments: argparse.Namespace) -> None:
    """Write how the joints were matched, for ``--map``."""
    from urdf2mbs.verification import write_joint_map

    write_files({arguments.write_map: write_joint_map(verdict.joints)}, force=arguments.force)


def _print_verdict(verdict: Verdict, arguments: argparse.Namespace) -> None:
    """Print the compared properties, the differences, the warnings, and the verdict."""
    first_line, *more_lines = verdict.describe_match()
    print(f"{verdict.robot}: {first_line}{_describe_base(verdict)}")
    for line in more_lines:
        print(printable(f"  {line}"))
    if verdict.made_of:
        print(f"  {verdict.made_of} was converted in memory")
    masses = f"{verdict.mbs_mass:.6g} kg move in {verdict.second}"
    print(f"  {masses}, {verdict.urdf_mass:.6g} kg in {verdict.first}")
    if _is_of_config(arguments):
        print(f"  the robot is that of {arguments.robot}; the model is {near(Path(verdict.model))}")
    print(f"  {verdict.compared}")
    if verdict.frames:
        frame_count = counted(len(verdict.frames), "frame")
        print(
            f"  {frame_count} of links and points elsewhere than by {verdict.first}, as a model "
            "may choose (--frames lists them, as differences)"
        )
    _print_findings(verdict, verbose=arguments.verbose)
    print_diagnostics(verdict.diagnostics, arguments.verbose)
    print(verdict.verdict)


def _is_of_config(arguments: argparse.Namespace) -> bool:
    """Return whether the robot is that of a config."""
    from urdf2mbs.verification import is_config

    return is_config(arguments.robot)


def _describe_base(verdict: Verdict) -> str:
    """Return whether the base floats, as the end of a sentence."""
    floating = [
        f"'{joint_name}'" for joint_name, joints in verdict.joints.items() if len(joints) == 6
    ]
    if floating:
        return f", {', '.join(floating)} floats"
    if verdict.floating_base:
        return ", and the floating base"
    return f", the base {'floats' if verdict.base == 'floating' else 'is fixed'}"


def _print_findings(verdict: Verdict, *, verbose: bool) -> None:
    """Print the differences by their causes; with their single numbers, if all are asked for."""
    if not verdict.findings:
        return
    print("not the same; what matters most for the motion first, with its relative size:")
    shown = verdict.findings if verbose else verdict.findings[:MOST_FINDINGS]
    for finding in shown:
        size = max(verdict.differences[number].size for number in finding.differences)
        print(printable(f"  {size:8.2e}  {finding.message}"))
    hidden = len(verdict.findings) - len(shown)
    if hidden:
        print(f"  and {hidden} more (-v lists all)")
    if verbose and len(verdict.differences) > len(verdict.findings):
        print("each difference alone, by relative size:")
        for difference in verdict.differences:
            print(printable(f"  {difference.size:8.2e}  {difference.message}"))


def _prepare(arguments: argparse.Namespace) -> tuple[str, Callable[..., Verdict]]:
    """Return the robot's file, and the function that makes the comparison."""
    from urdf2mbs.verification import read_joint_map, read_source, verify_sides

    fields = choose_fields(arguments)
    if arguments.gravity is not None:
        fields["gravity"] = tuple(arguments.gravity)
    joint_map = read_joint_map(arguments.map)
    second = None
    if arguments.robot not in ("", STREAM):
        check_kind(Path(arguments.robot), arguments, *KINDS)
    if arguments.model is not None:
        check_kind(arguments.model, arguments, *KINDS)
        second = read_source(arguments.model, {}, is_first=False)
        second.installed_plugins = not arguments.no_plugins
    if not _is_of_config(arguments):
        source = files.take_stdin() if arguments.robot == STREAM else arguments.robot
        first = read_source(source, {}, is_first=True)
        compare = partial(verify_sides, first, second, joint_map=joint_map, fields=fields)
        return source, compare
    if arguments.gravity is not None:
        message = "--gravity is for a robot without a config"
        raise ConfigError("usage", message, hint=f"write it in '{arguments.robot}'")
    first = _read_config(arguments)
    assert first.config is not None
    compare = partial(verify_sides, first, second, joint_map=joint_map)
    return str(first.lines.folder / first.config.source), compare


def _read_config(arguments: argparse.Namespace) -> Source:
    """Return the robot of a config, with the values that the command line overrides."""
    from urdf2mbs.verification.sides import Source

    arguments.config = Path(arguments.robot)
    config, lines = robot_or_config(arguments)
    installed_plugins = not arguments.no_plugins
    return Source(
        name=arguments.robot, config=config, lines=lines, installed_plugins=installed_plugins
    )
