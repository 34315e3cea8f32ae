"""`schema`: the JSON schema of a config."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from urdf2mbs.commands.printing import (
    print_json,
    warn_of,
)
from urdf2mbs.commands.settings import (
    Parents,
)
from urdf2mbs.engine.plugins import Plugins


def add(commands: Any, parents: Parents) -> None:
    schema = commands.add_parser(
        "schema",
        parents=[parents.common],
        help="print the JSON schema of a config, for editors",
    )
    schema.add_argument("--plugin", action="append", default=[], metavar="FILE.py")
    schema.set_defaults(command=_schema)


def _schema(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.schema import schema

    files = [Path(file) for file in arguments.plugin]
    plugins = Plugins(files, installed=not arguments.no_plugins)
    warn_of(plugins)
    print_json(schema(plugins))
    return 0
