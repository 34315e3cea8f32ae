"""`convert`: a robot in, an .mbs or a project out, without a config.

Reads a robot's file, and converts it with the defaults of a config.  Writes an
.mbs with the name of the robot's file; '-o DIR/' writes a Robotran project.
Compares the .mbs with the URDF: exit code 3 if they are not the same robot.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from urdf2mbs.commands.kinds import check_ending, check_kind
from urdf2mbs.commands.printing import print_summary
from urdf2mbs.commands.run import carry_out_many, carry_out_one, convert_one
from urdf2mbs.commands.settings import ALONE, add_converting, add_fields, without_config
from urdf2mbs.commands.streams import STREAM, is_stream, saving
from urdf2mbs.disk.files import is_folder
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.summary import report
from urdf2mbs.urdf.reader import stem

EXAMPLES = (
    "urdf2mbs convert robot.urdf -o robot.mbs",
    "urdf2mbs convert robot.urdf -o robot/ --language c",
    "urdf2mbs convert ur.urdf.xacro -o ur5e/ --arg ur_type:=ur5e --arg name:=ur5e",
    "xacro robot.urdf.xacro | urdf2mbs convert - -o - > robot.mbs",
)


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of ``convert``."""
    add_converting(command)
    command.add_argument(
        "robot",
        metavar="ROBOT",
        help="a .urdf, .xacro or MJCF file, a folder, robot_descriptions:NAME, or - for standard "
        "input",
    )
    command.add_argument(
        "-o",
        "--output",
        metavar="OUT.mbs",
        help="the file, - for standard output; an existing folder, or DIR/, gets a project "
        "(of a folder of robots: their .mbs files)",
    )
    command.add_argument(
        "--language", choices=("python", "c", "both"), help="the code of a project; default: python"
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    """Convert the robot that the command line names, and return the exit code."""
    output: Any = arguments.output
    is_project = output is not None and (output.endswith(("/", os.sep)) or is_folder(Path(output)))
    if arguments.language and not is_project:
        raise ConfigError("usage", "--language is for a project: '-o DIR/' makes one")
    if output == "":
        raise ConfigError("usage", "--output: the name of the file is empty")
    if not arguments.robot:
        raise ConfigError("usage", "the name of the robot is empty")
    check_kind(Path(arguments.robot), arguments, "robot", "folder")
    if is_stream(output) or (output is None and is_stream(arguments.robot)):
        return _convert_to_stdout(arguments)
    if is_folder(Path(arguments.robot)):
        return carry_out_many("convert", [], arguments)
    if is_project:
        output = {"project": output, "language": arguments.language or "python"}
    else:
        check_ending(output and Path(output), ".mbs")
    config, lines = without_config(arguments.robot, output, arguments)
    return carry_out_one(config, lines, arguments)


def _convert_to_stdout(arguments: argparse.Namespace) -> int:
    """Convert to standard output; all messages go to standard error."""
    robot_name = "robot" if is_stream(arguments.robot) else stem(Path(arguments.robot))
    with saving(arguments, True) as save_file:
        config, lines = without_config(arguments.robot, f"{robot_name}.mbs", arguments)
        arguments.fresh = True  # there is no file to merge with
        conversion = convert_one(config, lines, arguments)
        mbs_bytes = conversion.files.get(conversion.settings.output)
        outcome = "nothing is written" if mbs_bytes is None else "written to standard output"
        print_summary(conversion, report(conversion), outcome, arguments.verbose)
        if mbs_bytes is not None:
            save_file(Path(STREAM), mbs_bytes)
    return 0 if conversion.checked.rejected is None else 3
