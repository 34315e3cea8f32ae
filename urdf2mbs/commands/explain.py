"""`explain`: the passes of a config, without running them."""

from __future__ import annotations

import argparse

import msgspec

from urdf2mbs.commands.printing import METHOD, describe, origin, print_json, warn_of
from urdf2mbs.commands.settings import (
    ALONE,
    add_fields,
    add_json,
    add_running,
    path,
    robot_or_config,
)
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs_many.sweep import in_words, members
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.urdf.reader import read_file

EXAMPLES = (
    "urdf2mbs explain robot.yaml",
    "urdf2mbs explain robot.urdf --pipeline compact",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below",
    )  # fmt: skip
    add_json(command)
    add_running(command)
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    config, lines = robot_or_config(arguments)
    first, *others = members(config, lines)
    pipeline = Pipeline(first.config, lines, installed_plugins=not arguments.no_plugins)
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
    if others:
        count = counted(len(others) + 1, "robot")
        print(f"sweep   {count}; this is the first: {in_words(first.values)}")
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
        print(f"   reads    {', '.join(pass_.reads) or '-'}")
        print(f"   writes   {', '.join(pass_.writes) or '-'}")
        options = msgspec.to_builtins(pass_)
        print(f"   options  {', '.join(f'{k}: {v!r}' for k, v in options.items()) or '-'}")
    print(f"\n{METHOD}")
    return 0
