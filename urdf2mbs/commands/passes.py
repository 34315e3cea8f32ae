"""`passes`: every known pass."""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.commands.printing import METHOD, describe, origin, print_json, warn_of
from urdf2mbs.commands.settings import add_fields, add_json, add_no_plugins
from urdf2mbs.engine.plugins import Plugins

EXAMPLES = (
    "urdf2mbs passes",
    "urdf2mbs passes --plugin our_passes.py",
)


def add_options(command: argparse.ArgumentParser) -> None:
    add_json(command)
    add_no_plugins(command)
    add_fields(command, "plugins")


def carry_out(arguments: argparse.Namespace) -> int:
    files = [Path(file) for file in arguments.plugins]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    warn_of(plugins)
    passes = [registered for offered in plugins.passes.values() for registered in offered]
    if arguments.json:
        print_json([describe(registered) for registered in passes])
        return 0
    width = max(len(registered.kind.name) for registered in passes)
    for registered in passes:
        kind = registered.kind
        trade = f"{', '.join(kind.reads) or '-'} -> {', '.join(kind.writes) or '-'}"
        print(f"{kind.name:{width}}  {kind.summary()}")
        print(f"{'':{width}}  {trade}; {origin(registered)}")
    print(f"\n{METHOD}")
    return 0
