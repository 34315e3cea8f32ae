"""`explain`: the passes of a config, or every known pass, without running them.

Lists the passes in their order: what each reads and writes, where it comes
from, and its options.  Converts nothing.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    ALONE,
    Config,
    Lines,
    Pipeline,
    Plugins,
    Registered,
    add_fields,
    add_json,
    add_running,
    counted,
    near,
    of_plugin,
    path,
    print_json,
    robot_or_config,
)
from urdf2mbs.plugin import read_robot_file as read_file

#: What the summaries of the passes call "the method".
METHOD = (
    '"The method" is Appendix A, "URDF to MBS Converter", of the thesis on gait controllers in\n'
    "Robotran that urdf2mbs follows; the pages in docs/passes quote it, pass by pass."
)

EXAMPLES = (
    "urdf2mbs explain robot.yaml",
    "urdf2mbs explain robot.urdf --pipeline compact",
    "urdf2mbs explain --plugin our_passes.py",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml", nargs="?",
        help="or a .urdf or .xacro file, with the options below; without: every known pass",
    )  # fmt: skip
    add_json(command)
    add_running(command)
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    if arguments.config is None:
        return _list_all(arguments)
    config, lines = robot_or_config(arguments)
    config = _first_of_sweep(config, lines)
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    warn_of(pipeline.plugins)
    if lines.file is None:
        read_file(pipeline.settings.source)  # a robot was named, and is to be there
    if arguments.json:
        print_json([
            {**describe(step.registered), "swapped": step.swapped, "options": step.pass_}
            for step in pipeline.passes
        ])  # fmt: skip
        return 0
    settings = pipeline.settings
    print(f"source  {settings.source}\noutput  {settings.output}\nbase    {settings.config.base}")
    for name, folder in settings.packages.items():
        print(f"package {name} = {folder}")
    for name, value in settings.config.xacro_args.items():
        print(f"arg     {name} := {value}")
    for number, step in enumerate(pipeline.passes, start=1):
        pass_ = step.pass_
        print(f"\n{number}. {pass_.name}: {pass_.summary()}")
        swapped = ", by 'swap'" if step.swapped else ""
        print(f"   from     {origin(step.registered)}{swapped}")
        for rival in pipeline.plugins.passes.get(pass_.name, []):
            if rival.plugin != step.registered.plugin:
                print(f"   not      {origin(rival)}: 'swap: {{{pass_.name}: {rival.plugin}}}'")
        if step.registered.after:
            print(f"   after    {', '.join(step.registered.after)}")
        print(f"   reads    {', '.join(pass_.reads) or '-'}")
        print(f"   writes   {', '.join(pass_.writes) or '-'}")
        options = msgspec.to_builtins(pass_)
        print(f"   options  {', '.join(f'{k}: {v!r}' for k, v in options.items()) or '-'}")
    print(f"\n{METHOD}")
    return 0


def _first_of_sweep(config: Config, lines: Lines) -> Config:
    """The config of the first robot, where a config stands for many."""
    if config.sweep is None:
        return config
    sweep = of_plugin("sweep", "many")
    first, *others = sweep.members(config, lines)
    count = counted(len(others) + 1, "robot")
    print(f"sweep   {count}; this is the first: {sweep.in_words(first.values)}")
    found: Config = first.config
    return found


def _list_all(arguments: argparse.Namespace) -> int:
    """Print every known pass."""
    files = [Path(file) for file in arguments.plugins or ()]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    warn_of(plugins)
    passes = [registered for offered in plugins.passes.values() for registered in offered]
    if arguments.json:
        print_json([describe(registered) for registered in passes])
        return 0
    width = max(len(registered.name) for registered in passes)
    for registered in passes:
        kind = registered.kind
        trade = f"{', '.join(kind.reads) or '-'} -> {', '.join(kind.writes) or '-'}"
        print(f"{kind.name:{width}}  {kind.summary()}")
        print(f"{'':{width}}  {trade}; {origin(registered)}")
    print(f"\n{METHOD}")
    return 0


def warn_of(plugins: Plugins) -> None:
    """Print which plugins are left out, and why."""
    for broken in plugins.broken:
        print(broken, file=sys.stderr)


def origin(found: Registered) -> str:
    """The plugin that a pass is from, with its package, version and file."""
    of = f" of {found.package}" if found.package not in ("", found.plugin) else ""
    version = f" {found.version}" if found.version else ""
    return f"{found.plugin}{of}{version} ({near(Path(found.file))})"


def describe(found: Registered) -> dict[str, Any]:
    """A pass as JSON has it."""
    kind = found.kind
    return {
        "name": kind.name, "summary": kind.summary(), "plugin": found.plugin,
        "package": found.package, "version": found.version, "file": found.file,
        "reads": kind.reads, "writes": kind.writes,
    }  # fmt: skip
