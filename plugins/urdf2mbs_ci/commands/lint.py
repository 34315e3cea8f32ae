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
from urdf2mbs_ci.findings import add_sarif, collect_findings

EXAMPLES = (
    "urdf2mbs lint robot.urdf",
    "urdf2mbs lint robot.urdf.xacro --arg name:=ur5e --strict",
    "urdf2mbs lint robot.yaml --sarif urdf2mbs.sarif",
)

#: The pass that warns of faults; no pass runs after it.
CHECKS = "find-faults"


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    command.add_argument(
        "config",
        type=path,
        metavar="ROBOT",
        help="a .urdf, .xacro or MJCF file, robot_descriptions:NAME, - for standard input, or a "
        "config",
    )
    add_json(command)
    add_verbose(command)
    add_no_plugins(command)
    add_fields(command, *READING, "packages", "xacro_args", "base")
    add_sarif(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Print the faults of a robot; return 1 if one of them is an error."""
    config, lines = robot_or_config(arguments)
    config = _add_checks(config)
    name = config.source
    try:
        with collect_findings(arguments.sarif, config.source) as findings:
            pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
            conversion = pipeline.run(stop_after=CHECKS)
            findings.diagnostics += conversion.diagnostics
            name = conversion.robot.name
    except ConversionError as error:
        if error.exit_code != ConversionError.exit_code:
            raise
    levels = [diagnostic.level for diagnostic in findings.diagnostics]
    counts = {level: levels.count(level) for level in ("error", "warning", "note")}
    if arguments.json:
        print_json({"robot": name, **counts, "diagnostics": findings.locate()})
    else:
        findings.print(verbose=arguments.verbose)
        print(f"{name}: {', '.join(counted(count, level) for level, count in counts.items())}")
    return ConversionError.exit_code if counts["error"] else 0


def _add_checks(config: Config) -> Config:
    """Return the config with the checks after all passes that change the robot.

    Those passes come before the pass ``insert-base``.  A sweep is checked as one robot without the
    values of the sweep: xacro arguments have their defaults.
    """
    before: dict[str, str | list[str]] = dict(config.before)
    after: dict[str, str | list[str]] = dict(config.after)
    names = config.pipeline
    if "insert-base" not in config.without and (isinstance(names, str) or "insert-base" in names):
        before["insert-base"] = _append_checks(before.get("insert-base", []))
    else:
        after["expand"] = _append_checks(after.get("expand", []))
    return msgspec.structs.replace(config, before=before, after=after, sweep=None)


def _append_checks(passes: str | list[str]) -> list[str]:
    """Return one or more passes, and the checks after them."""
    return [*([passes] if isinstance(passes, str) else passes), CHECKS]
