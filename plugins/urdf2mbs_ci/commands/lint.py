"""`lint`: list the faults of a robot, without converting it.

Reads the robot, and prints each error and warning with its file and line.
Writes nothing but the file of --sarif.  Exit code 1: there is an error.
"""

from __future__ import annotations

import argparse

import msgspec

from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import (
    READING,
    add_fields,
    add_json,
    add_verbose,
    path,
    robot_or_config,
)
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConversionError, counted
from urdf2mbs_ci.findings import add_sarif, collecting

EXAMPLES = (
    "urdf2mbs lint robot.urdf",
    "urdf2mbs lint robot.urdf.xacro --arg name:=ur5e --strict",
    "urdf2mbs lint robot.yaml --sarif urdf2mbs.sarif",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, - for standard input, or a config",
    )  # fmt: skip
    add_json(command)
    add_verbose(command)
    add_fields(command, *READING, "packages", "xacro_args", "base")
    add_sarif(command)


def carry_out(arguments: argparse.Namespace) -> int:
    config, lines = robot_or_config(arguments)
    config = msgspec.structs.replace(
        config, pipeline=["expand"], after={}, before={}, without=[], swap={}, passes={},
        plugins=[], sweep=None,
    )  # fmt: skip
    name = config.source
    try:
        with collecting(arguments.sarif, config.source) as found:
            conversion = Pipeline(config, lines, installed_plugins=False).run()
            found.said += conversion.diagnostics
            name = conversion.robot.name
    except ConversionError as error:
        if error.exit_code != ConversionError.exit_code:
            raise
    levels = [one.level for one in found.said]
    counts = {level: levels.count(level) for level in ("error", "warning", "note")}
    if arguments.json:
        print_json({"robot": name, **counts, "diagnostics": found.placed()})
    else:
        found.tell(arguments.verbose)
        print(f"{name}: {', '.join(counted(count, level) for level, count in counts.items())}")
    return ConversionError.exit_code if counts["error"] else 0
