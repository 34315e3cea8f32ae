"""`verify`: is an .mbs, or another URDF, the same robot?

Splits both descriptions into rigid groups, and compares motion, mass, centre
and inertia of each group.  The .mbs may be of any origin; a second URDF is
compared as well.  Of a config, the robot is the one that its passes make.
Writes nothing.  Exit code 0: the same robot; 3: not.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

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
from urdf2mbs.engine.plugins import load_plugins
from urdf2mbs.messages.diagnostics import ConfigError, counted, printable

if TYPE_CHECKING:
    from urdf2mbs.verification import Verdict

EXAMPLES = (
    "urdf2mbs verify robot.urdf robot.mbs",
    "urdf2mbs verify robot.urdf PROJECT",
    "urdf2mbs verify robot.xacro robot.urdf",
    "urdf2mbs verify robot.yaml robot.mbs",
    "urdf2mbs verify robot.yaml --ci --sarif urdf2mbs.sarif",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of ``verify``."""
    command.add_argument(
        "robot",
        metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, - for standard input; or a config, "
        "whose passes make the robot",
    )
    command.add_argument(
        "model",
        type=path,
        nargs="?",
        metavar="MODEL.mbs",
        help="of urdf2mbs, or drawn by hand; a project's folder; or another .urdf or .xacro; "
        "without, of a config: its output",
    )
    add_printing(command, writes=False)
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
    exit_code = 0 if verdict.same else 3
    if arguments.json:
        print_json(
            {"same": verdict.same, "verdict": verdict.verdict, **msgspec.to_builtins(verdict)}
        )
    elif not any(are_printed):
        _print_verdict(verdict, arguments)
    return exit_code


def _print_verdict(verdict: Verdict, arguments: argparse.Namespace) -> None:
    """Print the compared properties, the differences, the warnings, and the verdict."""
    _print_match(verdict)
    if _is_of_config(arguments):
        print(f"  the robot is that of {arguments.robot}; the model is {near(Path(verdict.model))}")
    print(f"  {verdict.compared}")
    if verdict.frames:
        frame_count = counted(len(verdict.frames), "frame")
        print(
            f"  {frame_count} of links and points elsewhere than by the URDF, as a model may "
            "choose (--frames lists them, as differences)"
        )
    if verdict.differences:
        print("not the same, by relative size:")
    for difference in verdict.differences:
        print(printable(f"  {difference.size:8.2e}  {difference.message}"))
    print_diagnostics(verdict.diagnostics, arguments.verbose)
    print(verdict.verdict)


def _is_of_config(arguments: argparse.Namespace) -> bool:
    """Return whether the robot is that of a config."""
    from urdf2mbs.verification import is_config

    return is_config(arguments.robot)


def _prepare(arguments: argparse.Namespace) -> tuple[str, Callable[..., Verdict]]:
    """Return the robot's file, and the function that makes the comparison."""
    from urdf2mbs.verification import is_config, verify, verify_config

    model = arguments.model
    if model is not None and is_config(model) and arguments.robot.lower().endswith(".mbs"):
        arguments.robot, model = str(model), Path(arguments.robot)
    if not _is_of_config(arguments):
        source = files.take_stdin() if arguments.robot == STREAM else arguments.robot
        config_fields = choose_fields(arguments)
        if arguments.gravity is not None:
            config_fields["gravity"] = tuple(arguments.gravity)
        return source, partial(verify, source, model, **config_fields)
    if arguments.gravity is not None:
        message = "--gravity is for a robot without a config"
        raise ConfigError("usage", message, hint=f"write it in '{arguments.robot}'")
    arguments.config = Path(arguments.robot)
    config, lines = robot_or_config(arguments)
    compare = partial(
        verify_config, config, lines, model, installed_plugins=not arguments.no_plugins
    )
    return str(lines.folder / config.source), compare


def _print_match(verdict: Verdict) -> None:
    """Print how many joints of the URDF match joints of the .mbs, and the masses."""
    floating = [
        f"'{joint_name}'" for joint_name, joints in verdict.joints.items() if len(joints) == 6
    ]
    base_text = ", and the floating base" if verdict.floating_base else ", the base is fixed"
    if floating:
        base_text = f", {', '.join(floating)} floats"
    matches = f"{len(verdict.joints)} of {verdict.moving} joints match by name"
    print(f"{verdict.robot}: {matches}{base_text}")
    if verdict.made_of:
        print(f"  the .mbs is {verdict.made_of}, converted in memory")
    print(f"  {verdict.mbs_mass:.6g} kg move in the .mbs, {verdict.urdf_mass:.6g} kg in the URDF")
