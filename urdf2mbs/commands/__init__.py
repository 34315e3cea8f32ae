"""The commands, a file each: its options, what it does, what it prints.

Help lists the commands from the table below.  Only the file of a command that is named is
imported, so that help comes at once.
"""

from __future__ import annotations

import argparse
import os
import sys

# typing is not imported: a type checker knows this name, too
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any

#: In the order of the help.
COMMANDS = {
    "init": "write a config for a robot, to start from",
    "run": "convert as a config file says, or as several do",
    "convert": "convert one robot, or a folder of them, without a config file",
    "report": "convert, and write one HTML page to look at instead",
    "verify": "compare a robot with an .mbs file: are they the same?",
    "diff": "say what differs between two .mbs files",
    "diagram": "draw the 2D diagram of an .mbs file as an SVG picture",
    "equations": "write Robotran's equations for an .mbs file",
    "explain": "show the passes of a config, without running them",
    "passes": "list every known pass",
    "new-pass": "write a plugin with one pass, and its test",
    "schema": "print the JSON schema of a config, for editors",
    "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
    "completion": "print a script that completes commands and options in a shell",
}


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The words of a command line; what is wrong with them ends the program, as argparse does."""
    may_ask_for_help = any(word.startswith("-") and "h" in word for word in words)
    whole = parser(words[:1], texts=may_ask_for_help)
    arguments, unknown = whole.parse_known_args(words)
    if unknown:  # argparse would show the usage of all commands
        arguments.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    return arguments


def parser(named: Iterable[str] = COMMANDS, *, texts: bool = True) -> argparse.ArgumentParser:
    """All commands in the order of the help, those that are ``named`` with their options.

    Only the files of the named commands are imported.  Without ``texts`` the help is not whole.
    """
    whole = _Parser(
        prog="urdf2mbs", description="Convert URDF and xacro robots to Robotran .mbs files."
    )
    whole.add_argument("--version", action=_Version, help="show the version and exit")
    commands = whole.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, does in COMMANDS.items():
        command = commands.add_parser(name, help=does)
        if name in named:
            _add_options(command, name)
            if texts:
                from urdf2mbs.commands.settings import add_texts

                add_texts(command)
    return whole


def _add_options(command: argparse.ArgumentParser, name: str) -> None:
    """The options of a command, those that all commands have among them."""
    module = module_of(name)
    command.epilog = "examples:" + "".join(f"\n  {line}" for line in module.EXAMPLES)
    command.set_defaults(command=name, parser=command)
    command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    command.add_argument(
        "--color", choices=("auto", "always", "never"), default="auto",
        help="auto: on a terminal only",
    )  # fmt: skip
    module.add_options(command)


def module_of(name: str) -> Any:
    """The file of a command."""
    from importlib import import_module

    return import_module(f"urdf2mbs.commands.{name.replace('-', '_')}")


class _Parser(argparse.ArgumentParser):
    """Its help is as wide as the terminal; it says what is wrong with a word without the control
    characters in it.

    argparse would ask shutil for the width, which imports four ways to compress files, and again
    for every option.
    """

    def __init__(self, **more: Any) -> None:
        width = _columns() - 2
        super().__init__(
            **more,
            formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(prog, width=width),
        )

    def _print_message(self, message: str, file: Any = None) -> None:
        super()._print_message("".join(map(_letter, message)), file)


def _letter(letter: str) -> str:
    return letter if letter.isprintable() or letter == "\n" else ascii(letter)[1:-1]


def _columns() -> int:
    given = os.environ.get("COLUMNS", "")
    if given.isdecimal() and int(given):
        return int(given)
    try:
        return os.get_terminal_size(sys.__stdout__.fileno()).columns or 80  # type: ignore[union-attr]
    except (AttributeError, OSError, ValueError):
        return 80


class _Version(argparse.Action):
    def __init__(self, option_strings: list[str], dest: str, **more: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **more)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"urdf2mbs {version('urdf2mbs')}")
        parser.exit()
