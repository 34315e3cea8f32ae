"""`schema`: the JSON schema of a config."""

from __future__ import annotations

import argparse
from pathlib import Path

from urdf2mbs.commands.printing import print_json, warn_of
from urdf2mbs.commands.settings import add_no_plugins, add_plugin
from urdf2mbs.engine.plugins import Plugins

EXAMPLES = ("urdf2mbs schema > config.schema.json",)


def add_options(command: argparse.ArgumentParser) -> None:
    add_no_plugins(command)
    add_plugin(command)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.schema import schema

    files = [Path(file) for file in arguments.plugin]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    warn_of(plugins)
    print_json(schema(plugins))
    return 0
