"""`new-pass`: a plugin with one pass, and its test."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from urdf2mbs.commands.settings import (
    Parents,
)


def add(commands: Any, parents: Parents) -> None:
    new = commands.add_parser(
        "new-pass",
        parents=[parents.common],
        help="write a plugin with one pass, and its test",
    )
    new.add_argument("name", metavar="NAME")
    new.add_argument("-o", "--output", type=Path, metavar="DIR", default=Path())
    new.set_defaults(command=_new_pass)


def _new_pass(arguments: argparse.Namespace) -> int:
    from urdf2mbs.kit.new_pass import new_pass

    print(new_pass(arguments.name, arguments.output))
    return 0
