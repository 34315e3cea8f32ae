"""`run`: a config in, an .mbs or a project out.

Reads the config, expands xacro, and converts the robot.  Writes the .mbs or
the Robotran project, where 'output' says.  Compares the .mbs with the URDF:
exit code 3 if they are not the same robot.  Files that you edited stay.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import Any

from urdf2mbs.commands.kinds import check_kind
from urdf2mbs.commands.printing import (
    list_next_steps,
    near,
    print_diagnostics,
    print_json,
    print_robot_settings,
    print_summary,
)
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import add_converting, path, read_config
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.output import plan, write
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import load_plugins
from urdf2mbs.messages.diagnostics import ConfigError, printable, some
from urdf2mbs.summary import Report, report

EXAMPLES = (
    "urdf2mbs run robot.yaml",
    "urdf2mbs run robot.yaml --plan",
    "urdf2mbs run robot.yaml -v --dump dump --stop-after emit",
)


#: What is typed in place of a key of the config.
MEANT = {
    "-o": "write 'output:' in the config",
    "--output": "write 'output:' in the config",
    "--arg": "write 'xacro_args: {NAME: VALUE}' in the config",
    "--base": "write 'base:' in the config",
    "--package": "write 'packages: {NAME: DIR}' in the config",
    "--pipeline": "write 'pipeline:' in the config",
    "--plugin": "write 'plugins: [FILE.py]' in the config",
}


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of ``run``."""
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml", nargs="+", help="'init' writes one"
    )
    add_converting(command)


def carry_out(arguments: argparse.Namespace) -> int:
    """Convert the robots of the configs, and return the exit code."""
    for file in arguments.config:
        check_kind(file, arguments, "config")
    configs = [read_config(config_file, arguments) for config_file in arguments.config]
    if len(configs) > 1 or configs[0][0].sweep is not None:
        return carry_out_many("run", configs, arguments)
    return carry_out_one(*configs[0], arguments)


def carry_out_many(
    command: str, configs: list[tuple[Config, Lines]], arguments: argparse.Namespace
) -> int:
    """Let a plugin convert many robots, and return the exit code.

    Raises:
        ConfigError: ``plugin-missing``, no plugin does.
    """
    hook = load_plugins(installed=not arguments.no_plugins).hook
    exit_code: int | None = hook.urdf2mbs_carry_out(
        command=command, configs=configs, arguments=arguments
    )
    if exit_code is None:
        message = "these are many robots, and no plugin converts many"
        hint = "convert them one by one, or install urdf2mbs whole"
        raise ConfigError("plugin-missing", message, hint=hint)
    return exit_code


def convert_one(config: Config, lines: Lines, arguments: argparse.Namespace) -> Conversion:
    """Run the passes of a config; only observers may write files."""
    pipeline = Pipeline(
        config,
        lines,
        installed_plugins=not arguments.no_plugins,
        fresh=arguments.fresh or arguments.force,
    )
    hook = load_plugins(installed=not arguments.no_plugins).hook
    observers: list[object] = hook.urdf2mbs_observe(arguments=arguments)
    with Progress(arguments) as progress, ExitStack() as ends:
        pipeline.watch(progress)
        for observer in observers:
            pipeline.watch(observer)
            ends.callback(getattr(observer, "finish", lambda: None))
        return pipeline.run(stop_after=arguments.stop_after)


def carry_out_one(config: Config, lines: Lines, arguments: argparse.Namespace) -> int:
    """Convert one robot, write its files, print a summary, and return the exit code."""
    conversion = convert_one(config, lines, arguments)
    if arguments.plan:
        return _show_plan(conversion, arguments)
    write(conversion, force=arguments.force)
    conversion_report = report(conversion)
    if arguments.json:
        print_json(conversion_report)
    else:
        _print_result(conversion, conversion_report, arguments)
        if conversion.files:
            print(list_next_steps(conversion, conversion_report))
    return 0 if conversion.checked.rejected is None else 3


def _show_plan(conversion: Conversion, arguments: argparse.Namespace) -> int:
    """Print what would be written, and return the exit code; nothing is written."""
    changes = plan(conversion, force=arguments.force)
    changed_files = {change_kind: list(map(near, paths)) for change_kind, paths in changes.items()}
    merge = conversion.report.get("merge")
    if arguments.json:
        print_json(
            {
                "merge": merge,
                "files": changed_files,
                "robot_settings": conversion.input.settings,
                "diagnostics": conversion.diagnostics,
            }
        )
    else:
        print(f"{conversion.robot.name}: the plan; nothing is written")
        # without edits, the file is replaced by the new one
        _print_merge(merge or conversion.report.get("replaced", {"words": {}}), arguments.verbose)
        if not merge and not any(changed_files.values()):
            print("  nothing changes")
        for change_kind, paths in changed_files.items():
            if paths:
                print(f"  {change_kind} files: {some(paths, 6)}")
        print_robot_settings(conversion)
        print_diagnostics(conversion.diagnostics, arguments.verbose)
    return 0 if conversion.checked.rejected is None else 3


def _print_merge(merge: dict[str, Any], verbose: bool) -> None:
    """Print the changes of a merge by heading; one line for a heading that has a brief text."""
    for heading, sentences in merge["words"].items():
        brief = merge.get("brief", {}).get(heading)
        if brief and not verbose:
            print(printable(f"  {heading}: {brief} (-v lists them)"))
            continue
        print(f"  {heading}: {len(sentences) or 'nothing'}")
        for sentence in sentences:
            print(printable(f"    {sentence}"))


def _print_result(
    conversion: Conversion, conversion_report: Report, arguments: argparse.Namespace
) -> None:
    """Print what became of the robot, or why there is no .mbs."""
    output = conversion.written
    if output in conversion.files:
        outcome = f"written to {near(output)}"
        print_summary(conversion, conversion_report, outcome, arguments.verbose)
    else:
        reason = "the pipeline writes no .mbs"
        if arguments.stop_after is not None:
            reason = f"stopped after '{arguments.stop_after}': nothing is written"
        print(reason)
        print_diagnostics(conversion.diagnostics, arguments.verbose)
