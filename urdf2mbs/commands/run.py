"""`run` and `convert`: a robot in, an .mbs or a project out."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from urdf2mbs.commands.many import add_many, carry_out_many
from urdf2mbs.commands.presets import by_presets
from urdf2mbs.commands.printing import (
    near,
    next_steps,
    print_json,
    tell,
    tell_diagnostics,
)
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import (
    Parents,
    add_settings,
    configured,
    without_config,
)
from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, ConversionError, counted
from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.files import is_folder
from urdf2mbs.kit.dump import Dump
from urdf2mbs.many.folder import robots_in
from urdf2mbs.output import write
from urdf2mbs.summary import Report, report
from urdf2mbs.urdf.reader import stem


def add(commands: Any, parents: Parents) -> None:
    run = commands.add_parser(
        "run",
        parents=[parents.common, parents.running, parents.levels],
        help="convert as a config file says, or as several do",
    )
    run.add_argument("config", type=Path, metavar="CONFIG.yaml", nargs="+")
    add_many(run)
    run.set_defaults(command=_run)

    convert = commands.add_parser(
        "convert",
        parents=[parents.common, parents.running, parents.levels],
        help="convert one robot, or a folder of them, without a config file",
    )
    convert.add_argument(
        "robot",
        metavar="ROBOT",
        help="a .urdf or .xacro file, a folder, robot_descriptions:NAME, or - for standard input",
    )
    convert.add_argument(
        "-o", "--output", metavar="OUT.mbs",
        help="the file, - for standard output; an existing folder, or DIR/, gets a project "
        "(of a folder of robots: their .mbs files)",
    )  # fmt: skip
    add_settings(convert)
    add_many(convert)
    convert.set_defaults(command=_convert)


def _run(arguments: argparse.Namespace) -> int:
    configs = [configured(file, arguments) for file in arguments.config]
    if len(configs) > 1 or configs[0][0].sweep is not None:
        return carry_out_many(configs, arguments)
    _only_one(arguments)
    return _carry_out(*configs[0], arguments)


def _only_one(arguments: argparse.Namespace) -> None:
    for name in ("workers", "cluster", "report"):
        if getattr(arguments, name) is not None:
            raise ConfigError("usage", f"--{name} is for many robots, and this is one")


def _convert(arguments: argparse.Namespace) -> int:
    output: Any = arguments.output
    if output == "":
        raise ConfigError("usage", "--output: the name of the file is empty")
    if output == "-" or (output is None and arguments.robot == "-"):
        return _pass_on(arguments)
    if is_folder(Path(arguments.robot)):
        return _convert_folder(Path(arguments.robot), output, arguments)
    _only_one(arguments)
    if output is not None and (output.endswith(_SEPARATORS) or is_folder(Path(output))):
        output = {"project": output}
    config, lines = without_config(arguments.robot, output, arguments)
    return _carry_out(config, lines, arguments)


def _pass_on(arguments: argparse.Namespace) -> int:
    """Convert to standard output; all that is said goes to standard error."""
    if arguments.json:
        raise ConfigError("usage", "--json and the .mbs cannot both go to standard output")
    name = "robot" if arguments.robot == "-" else stem(Path(arguments.robot))
    output = sys.stdout
    with redirect_stdout(sys.stderr):
        config, lines = without_config(arguments.robot, f"{name}.mbs", arguments)
        conversion = _converted(config, lines, arguments)
        found = report(conversion)
        print(f"{found.robot}: written to standard output")
        tell(conversion, found, arguments.verbose)
        data = conversion.files.get(conversion.settings.output)
        if conversion.rejected is None and data is not None:
            output.flush()
            output.buffer.write(data)
            output.buffer.flush()
    return 0 if conversion.rejected is None else 3


def _convert_folder(folder: Path, output: str | None, arguments: argparse.Namespace) -> int:
    if output is None:
        raise ConfigError(
            "usage", f"'{folder}' is a folder: say where its robots go, such as '-o models/'"
        )
    if Path(output).exists() and not Path(output).is_dir():
        raise ConfigError("usage", f"--output: '{output}' is no folder, and '{folder}' is one")
    robots = robots_in(folder)
    return carry_out_many(
        [
            without_config(str(source), str(Path(output) / place), arguments)
            for source, place in robots.items()
        ],
        arguments,
    )


#: What ends the name of a folder.
_SEPARATORS = tuple(filter(None, (os.sep, os.altsep)))


def _converted(config: Config, lines: Lines, arguments: argparse.Namespace) -> Conversion:
    """The conversion, run; nothing is written but the dump."""
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    with Progress(arguments.verbose) as progress:
        pipeline.plugins.watch(progress)
        dump = None if arguments.dump is None else Dump(arguments.dump)
        if dump is not None:
            pipeline.plugins.watch(dump)
        try:
            return pipeline.run(stop_after=arguments.stop_after)
        finally:
            if dump is not None:
                dump.finish()


def _carry_out(config: Config, lines: Lines, arguments: argparse.Namespace) -> int:
    conversion = _converted(config, lines, arguments)
    write(conversion)
    found = report(conversion)
    if arguments.json:
        print_json(found)
    else:
        _summarise(conversion, found, arguments)
        fewer = _fewer(conversion, config, lines, arguments)
        if fewer:
            print(f"  {fewer}")
        if conversion.files and conversion.rejected is None:
            print(next_steps(conversion))
    return 0 if conversion.rejected is None else 3


def _summarise(conversion: Conversion, found: Report, arguments: argparse.Namespace) -> None:
    output = conversion.rejected or conversion.settings.output
    if output in conversion.files:
        print(f"{found.robot}: written to {near(output)}")
        tell(conversion, found, arguments.verbose)
    else:
        print(f"stopped after '{arguments.stop_after}': nothing is written")
        tell_diagnostics(conversion, arguments.verbose)


def _fewer(
    conversion: Conversion, config: Config, lines: Lines, arguments: argparse.Namespace
) -> str:
    """How many joints the other presets make, where Robotran's generator minds."""
    if all(one.code != "generator-limits" for one in conversion.diagnostics):
        return ""
    others = []
    for name, other in by_presets(config, lines, arguments).items():
        try:
            made = other.run(stop_after="decompose-joints").mbs.numbers()
        except ConversionError:
            continue  # this is not what was asked for
        others.append(f"the preset '{name}' makes {counted(len(made), 'joint')}")
    return "; ".join(others)
