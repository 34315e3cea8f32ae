"""Reads a command line, carries it out, and prints the error that ends it.

Each command is a file: its options, its function and its output; ``MEANT`` has words that people
type in place of an option, and the option, or what to do.  Help lists the commands from the
table below; only the file of the named command is imported, so that help is shown at once.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import suppress
from difflib import get_close_matches
from errno import ENOSPC
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from urdf2mbs.commands.colours import clean_streams
from urdf2mbs.disk.files import absolute
from urdf2mbs.disk.version import find_version
from urdf2mbs.engine.plugins import Plugins, load_plugins
from urdf2mbs.hookspecs import Command
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, memory_full_error

_PACKAGE = "urdf2mbs.commands"
#: The commands of the core, in the order of the help.
CORE = [
    Command("run", "convert as a config file says, or as several do", f"{_PACKAGE}.run"),
    Command(
        "convert",
        "convert one robot, or a folder of them, without a config file",
        f"{_PACKAGE}.convert",
    ),
    Command(
        "verify", "compare a robot with an .mbs file: are they the same?", f"{_PACKAGE}.verify"
    ),
]
#: Words that ask for help: ``-h``, also among other short options, ``--help`` or its beginning.
HELP = re.compile(r"-\w*h\w*|--h(e(lp?)?)?")
#: Options of the program, which may be placed before the command, too.
_GLOBAL_OPTIONS = ("-v", "--verbose", "-q", "--quiet", "--no-plugins", "--debug", "--color")


def list_commands(plugins: Plugins | None = None) -> dict[str, Command]:
    """Return every command by its name: the core's, and then those of each plugin."""
    plugins = plugins or load_plugins(installed=True)
    return {**{command.name: command for command in CORE}, **plugins.commands}


def carry_out(command_line: Sequence[str]) -> int:
    """Carry out a command line, print what went wrong, and return the exit code."""
    _repair_streams()
    with clean_streams("never"):  # help says "the same robot", and that is no verdict
        arguments = parse(command_line)
    with clean_streams(arguments.color, quiet=getattr(arguments, "quiet", False)):
        try:
            absolute(Path())  # raises if the working folder was removed
            exit_code: int = import_module(arguments.module).carry_out(arguments)
            sys.stdout.flush()
            return exit_code
        except BrokenPipeError:  # the reader of our output has stopped
            _close_stdout()
            return 0
        except Exception as error:
            if arguments.debug:
                raise
            return _print_error(error, as_json=getattr(arguments, "json", False))


def _repair_streams() -> None:
    """Replace a closed stream, and let a stream show letters that it cannot encode as codes."""
    for stream_name in ("stdout", "stderr"):
        if getattr(sys, stream_name) is None:  # a service has closed it: nobody reads it
            setattr(sys, stream_name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def _print_error(error: Exception, *, as_json: bool) -> int:
    """Print why a command has failed, and return the exit code."""
    if isinstance(error, MemoryError):
        error = memory_full_error("this command")
    elif not isinstance(error, ConversionError):
        _close_stdout()
        if isinstance(error, OSError) and error.errno == ENOSPC:
            print(f"error[output-unwritable]: cannot print: {error.strerror}", file=sys.stderr)
            return ConfigError.exit_code
        message = f"{type(error).__name__}: {' '.join(str(error).split())}"
        hint = "this is a mistake in urdf2mbs: please report it; --debug shows more"
        error = ConversionError("internal", message, hint=hint)
        as_json = False
    from urdf2mbs.commands.printing import print_json, with_near_paths

    print(with_near_paths(str(error)), file=sys.stderr)
    if as_json:
        field_names = ("code", "message", "file", "line", "hint")
        error_fields = {field_name: getattr(error, field_name) for field_name in field_names}
        print_json({"error": error_fields, "diagnostics": error.earlier})
    return error.exit_code


def _close_stdout() -> None:
    """Discard any further standard output, also when the process ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def parse(command_line: Sequence[str]) -> argparse.Namespace:
    """Parse the words of a command line; wrong words end the program, as with argparse."""
    command_line = _move_command_first(command_line)
    command_name = command_line[0] if command_line else ""
    installed = "--no-plugins" not in command_line
    commands = {command.name: command for command in CORE}
    if command_name not in commands:
        commands = list_commands(load_plugins(installed=installed))
    asks_for_help = any(HELP.fullmatch(argument) for argument in command_line)
    program = parser(
        commands, command_line[:1], texts=asks_for_help or not command_line, installed=installed
    )
    if not command_line:
        program.print_help()
        program.exit()
    if not command_name.startswith("-") and command_name not in commands:
        program.error(f"there is no command '{command_name}'{_suggest(command_name, commands)}")
    arguments, unknown = program.parse_known_args(command_line)
    if unknown:  # argparse would show the usage of all commands
        command_parser: argparse.ArgumentParser = arguments.parser
        hint = _suggest_option(unknown[0], arguments)
        command_parser.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
    return arguments


def _suggest_option(word: str, arguments: argparse.Namespace) -> str:
    """Return the end of a message that offers what a command has in place of an unknown word."""
    options: dict[str, argparse.Action] = arguments.parser._option_string_actions
    if ":=" in word and not word.startswith("-") and "--arg" in options:
        return f"; write '--arg {word}'"
    option, _, _ = word.partition("=")
    meant = arguments.meant.get(option)
    if meant is None:
        return _suggest(option, options)
    return f"; did you mean '{meant}'?" if meant in options else f"; {meant}"


def _move_command_first(command_line: Sequence[str]) -> list[str]:
    """Return the words with the options of the program after the command."""
    n_options = 0
    while (
        n_options < len(command_line)
        and command_line[n_options].partition("=")[0] in _GLOBAL_OPTIONS
    ):
        n_options += 2 if command_line[n_options] == "--color" else 1
    return [
        *command_line[n_options : n_options + 1],
        *command_line[:n_options],
        *command_line[n_options + 1 :],
    ]


def _suggest(wrong_word: str, choices: Iterable[str]) -> str:
    """Return the end of a message that offers the nearest choice; empty if none is near."""
    if wrong_word.startswith("-") and not wrong_word.startswith("--"):
        return ""
    # the hyphens that all options begin with make none alike
    choices_by_word = {choice.lstrip("-"): choice for choice in choices}
    near_words = get_close_matches(wrong_word.lstrip("-"), choices_by_word, n=1, cutoff=0.6)
    return f"; did you mean '{choices_by_word[near_words[0]]}'?" if near_words else ""


def parser(
    commands: Mapping[str, Command] | None = None,
    named: Iterable[str] | None = None,
    *,
    texts: bool = True,
    installed: bool = True,
) -> argparse.ArgumentParser:
    """Return the parser of the command line.

    Args:
        commands: The commands in the order of the help; None: all.
        named: The commands that get their options, and whose files are imported; None: all.
        texts: Whether there is help; without it, the parser has only the named commands.
        installed: Whether the plugins of other installed packages may add options.
    """
    commands = list_commands() if commands is None else commands
    named = commands if named is None else named
    program = _Parser(
        prog="urdf2mbs",
        description="Convert URDF, xacro and MJCF robots to Robotran .mbs files.",
        epilog=_list_by_plugin(commands),
        formatter_class=_HelpFormatter,
    )
    program.color = False  # type: ignore[attr-defined]  # our streams drop escape codes
    program.add_argument("--version", action=_Version, help="show the version and exit")
    subparsers = program.add_subparsers(required=True, metavar="COMMAND", help="one of those below")
    for command_name, command in commands.items():
        if not texts and command_name not in named:
            continue
        command_parser = subparsers.add_parser(
            command_name, help=command.does, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        if command_name in named:
            _add_options(command_parser, command, installed=installed)
            if texts:
                from urdf2mbs.commands.settings import add_texts

                add_texts(command_parser)
    return program


def _list_by_plugin(commands: Mapping[str, Command]) -> str:
    """Return the list of commands in the help, those of a plugin below its name."""
    help_lines: list[str] = []
    group_title = ""
    for command_name, command in commands.items():
        package = command.module.partition(".")[0]
        if package != group_title:
            group_title = package
            help_lines.append("commands:" if package == "urdf2mbs" else f"of {package}:")
        help_lines.append(f"  {command_name:11} {command.does}")
    return "\n".join(help_lines)


def _add_options(
    command_parser: argparse.ArgumentParser, command: Command, *, installed: bool
) -> None:
    """Add the options of a command, those that all commands have among them."""
    module = import_module(command.module)
    sentence = f"{command.does[0].upper()}{command.does[1:]}"
    if not sentence.endswith("?"):
        sentence += "."
    details = (module.__doc__ or "").partition("\n\n")[2].rstrip()
    command_parser.description = f"{sentence}\n\n{details}"
    command_parser.epilog = "examples:" + "".join(f"\n  {example}" for example in module.EXAMPLES)
    command_parser.set_defaults(
        command=command.name,
        module=command.module,
        parser=command_parser,
        meant=getattr(module, "MEANT", {}),
    )
    command_parser.add_argument(
        "--debug", action="store_true", help="show the traceback of an error"
    )
    command_parser.add_argument(
        "--color",
        choices=("auto", "always", "never"),
        default="auto",
        help="colours; auto: on a terminal only",
    )
    module.add_options(command_parser)
    if command in CORE:
        hook = load_plugins(installed=installed).hook
        hook.urdf2mbs_options(command=command.name, parser=command_parser)


class _HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Leaves out argparse's list of the commands: ours groups them by plugin."""

    def _iter_indented_subactions(
        self, action: argparse.Action
    ) -> Generator[argparse.Action, None, None]:
        yield from ()


class _Parser(argparse.ArgumentParser):
    """Offers the nearest word for a wrong choice; help, in place of a usage of many lines."""

    def error(self, message: str) -> NoReturn:
        invalid_choice = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        hint = (
            _suggest(invalid_choice[1], re.findall(r"[\w-]+", invalid_choice[2]))
            if invalid_choice
            else ""
        )
        help_hint = f"{self.prog} --help shows how it is used"
        self.exit(2, f"{self.prog}: error: {message}{hint}\n  {help_hint}\n")


class _Version(argparse.Action):
    """Looks up the version only if it is asked for, beside other options: ``cli`` answers first."""

    def __init__(self, option_strings: list[str], dest: str, **settings: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **settings)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print(f"urdf2mbs {find_version()}")
        parser.exit()
