"""`completion`: a script that completes commands and options in a shell."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from urdf2mbs.commands.settings import Parents
from urdf2mbs.diagnostics import ConfigError

SHELLS = ("bash", "zsh", "fish")


def add(commands: Any, parents: Parents, parser: Callable[[], argparse.ArgumentParser]) -> None:
    """``parser`` makes the whole command line, whose words are completed."""
    completion = commands.add_parser(
        "completion", parents=[parents.common],
        help="print a script that completes commands and options in a shell",
    )  # fmt: skip
    completion.add_argument("shell", choices=SHELLS)
    completion.set_defaults(command=lambda arguments: _completion(arguments, parser()))


def _completion(arguments: argparse.Namespace, parser: argparse.ArgumentParser) -> int:
    try:
        import shtab
    except ImportError:
        raise ConfigError(
            "extra-missing",
            "completion needs the package 'shtab', which is not installed",
            hint="pip install 'urdf2mbs[completion]'",
        ) from None
    print(shtab.complete(parser, shell=arguments.shell))
    return 0
