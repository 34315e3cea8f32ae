"""`lint`: list the faults of a robot, without converting it.

Reads the robot, runs the passes of a config that change it, and prints each
error and warning with its file and line.  Writes nothing but the file of
--sarif.  Exit code 1: there is an error.
"""

from __future__ import annotations

import argparse

import msgspec

from urdf2mbs.plugin import (
    READING,
    Config,
    ConversionError,
    Pipeline,
    add_fields,
    add_json,
    add_no_plugins,
    add_verbose,
    counted,
    path,
    print_json,
    robot_or_config,
)
from urdf2mbs_ci.findings import add_sarif, collecting

EXAMPLES = (
    "urdf2mbs lint robot.urdf",
    "urdf2mbs lint robot.urdf.xacro --arg name:=ur5e --strict",
    "urdf2mbs lint robot.yaml --sarif urdf2mbs.sarif",
)


#: The pass that warns of the robot's faults: the last one that runs.
CHECKS = "find-faults"


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, - for standard input, or a config",
    )  # fmt: skip
    add_json(command)
    add_verbose(command)
    add_no_plugins(command)
    add_fields(command, *READING, "packages", "xacro_args", "base")
    add_sarif(command)


def carry_out(arguments: argparse.Namespace) -> int:
    config, lines = robot_or_config(arguments)
    config = _with_checks(config)
    name = config.source
    try:
        with collecting(arguments.sarif, config.source) as found:
            pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
            conversion = pipeline.run(stop_after=CHECKS)
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


def _with_checks(config: Config) -> Config:
    """Return the config with the checks behind all passes that change the robot.

    Those passes come before a base is put under the robot.  A sweep is one robot: its values are
    left out, and so the defaults of xacro arguments count.
    """
    before: dict[str, str | list[str]] = dict(config.before)
    after: dict[str, str | list[str]] = dict(config.after)
    names = config.pipeline
    if "insert-base" not in config.without and (isinstance(names, str) or "insert-base" in names):
        given = before.get("insert-base", [])
        before["insert-base"] = [*([given] if isinstance(given, str) else given), CHECKS]
    else:
        given = after.get("expand", [])
        after["expand"] = [*([given] if isinstance(given, str) else given), CHECKS]
    return msgspec.structs.replace(config, before=before, after=after, sweep=None)
