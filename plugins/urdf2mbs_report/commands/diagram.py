"""`diagram`: the 2D diagram of an .mbs, or of a robot, as a picture.

Draws bodies, joints and points as MBSysPad shows them.  A robot is converted
first, in memory.  Writes one .svg file.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import (
    ALONE,
    add_fields,
    add_printing,
    add_running,
    beside,
    check_ending,
    counted,
    find_model,
    is_stream,
    near,
    path,
    print_json,
    read_mbs_file,
    report,
    saving,
    tell,
)
from urdf2mbs_report.commands.report import convert_in_memory, refuse_fields

if TYPE_CHECKING:
    from urdf2mbs.plugin import Mbs

EXAMPLES = (
    "urdf2mbs diagram robot.mbs",
    "urdf2mbs diagram robot.urdf -o picture.svg",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config",
        type=path,
        metavar="MODEL.mbs",
        help="the file, the folder of its project, or - for standard input; or a .urdf, .xacro, "
        "MJCF or CONFIG.yaml, which is converted first, with the options below",
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="OUT.svg",
        help="default: beside the model; - for standard output",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    """Write the picture; return the exit code, 3 if a converted .mbs is another robot."""
    check_ending(arguments.output, ".svg")
    if is_stream(arguments.config):
        return _draw_model(arguments.config, arguments)
    model_file = find_model(arguments.config, arguments, "robot", "config")
    return _draw_model(model_file, arguments) if model_file else _draw_robot(arguments)


def _draw_model(model_file: Path, arguments: argparse.Namespace) -> int:
    """Draw an .mbs."""
    refuse_fields(arguments, model_file)
    model = read_mbs_file(model_file)
    output = model_file if is_stream(model_file) else beside(model_file, ".svg")
    output = _save(model, output, arguments)
    if is_stream(output) or arguments.json:
        return 0
    bodies = counted(len(model.bodies), "body")
    print(f"{model.name}: diagram of {bodies} written to {near(output)}")
    print(f"Next: open {near(output)} in a browser, and {model_file} in MBSysPad: they look alike")
    print(f"      is it the robot? urdf2mbs verify ROBOT {model_file}")
    return 0


def _draw_robot(arguments: argparse.Namespace) -> int:
    """Convert a robot in memory, and draw it."""
    conversion, command = convert_in_memory(arguments)
    output = _save(conversion.mbs, beside(conversion.settings.output, ".svg"), arguments)
    if not is_stream(output) and not arguments.json:
        tell(
            conversion, report(conversion), f"diagram written to {near(output)}", arguments.verbose
        )
        print(f"Next: open {near(output)} in a browser")
        print(f"      the .mbs itself is written by: {command}")
    return 0 if conversion.checked.rejected is None else 3


def _save(model: Mbs, default_output: Path, arguments: argparse.Namespace) -> Path:
    """Write the picture of a model, and return its file."""
    from urdf2mbs_report.draw import draw

    output: Path = arguments.output or default_output
    with saving(arguments, is_stream(output)) as save:
        save(output, draw(model).encode())
    if arguments.json:
        print_json({"model": model.name, "output": str(output)})
    return output
