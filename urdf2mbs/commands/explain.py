"""`explain`: the passes of a config, without running them."""

from __future__ import annotations

import argparse

import msgspec

from urdf2mbs.commands.presets import by_presets
from urdf2mbs.commands.printing import (
    METHOD,
    describe,
    joints_in_words,
    origin,
    print_json,
    warn_of,
)
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import (
    ALONE,
    add_fields,
    add_json,
    add_running,
    path,
    robot_or_config,
)
from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import GROUP, Plugins
from urdf2mbs.engine.resolve import Configured
from urdf2mbs.many.sweep import in_words, members
from urdf2mbs.messages.diagnostics import ConversionError, counted
from urdf2mbs.report.summary import Report, report
from urdf2mbs.urdf.reader import read_file

EXAMPLES = (
    "urdf2mbs explain robot.yaml",
    "urdf2mbs explain robot.yaml --cost",
)


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "config", type=path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below",
    )  # fmt: skip
    command.add_argument(
        "--cost", action="store_true",
        help="convert after all, by each preset too, to count the joints; nothing is written",
    )  # fmt: skip
    add_json(command)
    add_running(command)
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    config, lines = robot_or_config(arguments)
    first, *others = members(config, lines)
    config = first.config
    pipeline = Pipeline(config, lines, installed_plugins=not arguments.no_plugins)
    warn_of(pipeline.plugins)
    if lines.file is None:
        read_file(pipeline.settings.source)  # a robot was named, and is to be there
    if arguments.json:
        passes = [
            {
                **describe(step.registered),
                "swapped": step.swapped,
                "options": step.pass_,
            }
            for step in pipeline.passes
        ]
        if not arguments.cost:
            print_json(passes)
            return 0
        costs = _cost(config, lines, pipeline, arguments)
        cost = {name: found.joints for name, found in costs.items()}
        print_json({"passes": passes, "cost": cost})
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
        print(f"   from     {origin(step.registered)}{_instead(step, pipeline.plugins)}")
        for rival in pipeline.plugins.passes.get(pass_.name, []):
            if rival.plugin not in (step.registered.plugin, GROUP):
                print(
                    f"   not      {origin(rival)}, which brings a '{pass_.name}' too; "
                    f"'swap: {{{pass_.name}: {rival.plugin}}}' takes it"
                )
        print(f"   reads    {', '.join(pass_.reads) or '-'}")
        print(f"   writes   {', '.join(pass_.writes) or '-'}")
        options = msgspec.to_builtins(pass_)
        print(f"   options  {', '.join(f'{k}: {v!r}' for k, v in options.items()) or '-'}")
    print(f"\n{METHOD}")
    if arguments.cost:
        print("\ncost")
        for name, found in _cost(config, lines, pipeline, arguments).items():
            print(f"   {name:13}  {joints_in_words(found.joints)}")
    return 0


def _cost(
    config: Config, lines: Lines, pipeline: Pipeline, arguments: argparse.Namespace
) -> dict[str, Report]:
    """What becomes of the joints by the config as it is, and of it by each other preset."""
    pipelines = {"this config": pipeline, **by_presets(config, lines, arguments)}
    with Progress(arguments) as progress:
        for each_pipeline in pipelines.values():
            each_pipeline.watch(progress)
        costs = {}
        for name, other in pipelines.items():
            try:
                costs[name] = report(other.run())
            except ConversionError:
                if other is pipeline:
                    raise
                # a preset for which this robot is not made
        return costs


def _instead(step: Configured, plugins: Plugins) -> str:
    """What a pass stands in for."""
    mine = step.registered
    offered = plugins.passes.get(mine.kind.name, [])
    others = [registered for registered in offered if registered != mine]
    if not step.swapped or not others:
        return ""
    built_in = any(registered.plugin == GROUP for registered in others)
    return ", in place of " + ("the built-in pass" if built_in else origin(others[0]))
