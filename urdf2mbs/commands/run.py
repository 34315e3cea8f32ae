"""`run`: a config in, an .mbs or a project out.

Reads the config, expands xacro, and converts the robot.  Writes the .mbs or
the Robotran project, where 'output' says.  Compares the .mbs with the URDF:
exit code 3 if they are not the same robot.  Files that you edited stay.
"""

from __future__ import annotations

import argparse

from urdf2mbs.commands.printing import near, next_steps, print_json, tell, tell_diagnostics
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import add_converting, path, read_config, refuse
from urdf2mbs.config.model import Config, Lines
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.output import plan, write
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import of_plugin
from urdf2mbs.messages.diagnostics import printable, some
from urdf2mbs.summary import Report, report

EXAMPLES = (
    "urdf2mbs run robot.yaml",
    "urdf2mbs run robot.yaml --plan",
    "urdf2mbs run robot.yaml -v --dump dump --stop-after emit",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml", nargs="+", help="'init' writes one"
    )
    add_converting(command)


def carry_out(arguments: argparse.Namespace) -> int:
    configs = [read_config(file, arguments) for file in arguments.config]
    if len(configs) > 1 or configs[0][0].sweep is not None:
        code: int = of_plugin("carry_out_many", "many")(configs, arguments)
        return code
    return carry_out_one(*configs[0], arguments)


def convert_one(config: Config, lines: Lines, arguments: argparse.Namespace) -> Conversion:
    """The conversion, run; nothing is written but the dump."""
    pipeline = Pipeline(
        config, lines, installed_plugins=not arguments.no_plugins,
        fresh=arguments.fresh or arguments.force,
    )  # fmt: skip
    with Progress(arguments) as progress:
        pipeline.watch(progress)
        if arguments.dump is None:
            return pipeline.run(stop_after=arguments.stop_after)
        dump = of_plugin("Dump", "setup")(arguments.dump, force=arguments.force)
        pipeline.watch(dump)
        try:
            return pipeline.run(stop_after=arguments.stop_after)
        finally:
            dump.finish()


def carry_out_one(config: Config, lines: Lines, arguments: argparse.Namespace) -> int:
    """Convert one robot, write its files, and say what became of it."""
    refuse(arguments, ("workers", "cluster", "report"), "many robots, and this is one")
    conversion = convert_one(config, lines, arguments)
    if arguments.plan:
        return _show_plan(conversion, arguments)
    write(conversion, force=arguments.force)
    found = report(conversion)
    if arguments.json:
        print_json(found)
    else:
        _summarise(conversion, found, arguments)
        if conversion.files:
            print(next_steps(conversion, found))
    return 0 if conversion.checked.rejected is None else 3


def _show_plan(conversion: Conversion, arguments: argparse.Namespace) -> int:
    """Say what would be written, and write nothing."""
    files = {
        does: list(map(near, paths))
        for does, paths in plan(conversion, force=arguments.force).items()
    }
    merge = conversion.report.get("merge")
    if arguments.json:
        print_json({"merge": merge, "files": files, "diagnostics": conversion.diagnostics})
    else:
        print(f"{conversion.robot.name}: the plan; nothing is written")
        for does, sentences in (merge["words"] if merge else {}).items():
            print(f"  {does}: {len(sentences) or 'nothing'}")
            for sentence in sentences:
                print(printable(f"    {sentence}"))
        if not merge and not any(files.values()):
            print("  nothing changes")
        for does, paths in files.items():
            if paths:
                print(f"  {does} files: {some(paths, 6)}")
        tell_diagnostics(conversion.diagnostics, arguments.verbose)
    return 0 if conversion.checked.rejected is None else 3


def _summarise(conversion: Conversion, found: Report, arguments: argparse.Namespace) -> None:
    output = conversion.written
    if output in conversion.files:
        tell(conversion, found, f"written to {near(output)}", arguments.verbose)
    else:
        print(f"stopped after '{arguments.stop_after}': nothing is written")
        tell_diagnostics(conversion.diagnostics, arguments.verbose)
