"""The commands, a file each: its options, what it does, what it prints.

Help lists the commands from the table below.  Only the file of a command that is named is
imported, so that help comes at once.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import suppress
from errno import ENOSPC
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from urdf2mbs.commands.colours import screens
from urdf2mbs.disk.files import absolute
from urdf2mbs.engine.plugins import Plugins, load_plugins
from urdf2mbs.hookspecs import Command
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, memory_full_error, nearest

_HERE = "urdf2mbs.commands"
#: The commands of the core, in the order of the help.
CORE = [
    Command("run", "convert as a config file says, or as several do", f"{_HERE}.run"),
    Command(
        "convert", "convert one robot, or a folder of them, without a config file",
        f"{_HERE}.convert",
    ),
    Command(
        "verify", "compare a robot with an .mbs file: are they the same?", f"{_HERE}.verify"
    ),
]  # fmt: skip


def commands_of(plugins: Plugins | None = None) -> dict[str, Command]:
    """Every command by its name: the core's, and then those of each plugin."""
    plugins = plugins or load_plugins(installed=True)
    return {**{command.name: command for command in CORE}, **plugins.commands}


def carry_out(words: Sequence[str]) -> int:
    """Carry out a command line, and print what went wrong; returns the exit code."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # a service has closed the stream: nobody reads it
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # a robot's name may have letters that this terminal or pipe has not
            reconfigure(errors="backslashreplace")
    with screens():
        arguments = parse(words)
    with screens(arguments.color, quiet=getattr(arguments, "quiet", False)):
        try:
            absolute(Path())  # raises where the working folder is gone
            code: int = import_module(arguments.module).carry_out(arguments)
            sys.stdout.flush()
            return code
        except BrokenPipeError:  # the reader of our output has seen enough
            _leave_stdout()
            return 0
        except Exception as error:
            if arguments.debug:
                raise
            return _say(error, getattr(arguments, "json", False))


def _say(error: Exception, as_json: bool) -> int:
    """Print why a command has failed; returns the exit code."""
    if isinstance(error, MemoryError):
        error = memory_full_error("this command")
    elif not isinstance(error, ConversionError):
        _leave_stdout()
        if isinstance(error, OSError) and error.errno == ENOSPC:
            print(f"error[output-unwritable]: cannot print: {error.strerror}", file=sys.stderr)
            return ConfigError.exit_code
        error = ConversionError(
            "internal", f"{type(error).__name__}: {' '.join(str(error).split())}",
            hint="this is a mistake in urdf2mbs: please report it; --debug shows more",
        )  # fmt: skip
        as_json = False
    from urdf2mbs.commands.printing import print_json, with_near_paths

    print(with_near_paths(str(error)), file=sys.stderr)
    if as_json:
        fields = ("code", "message", "file", "line", "hint")
        said = {name: getattr(error, name) for name in fields}
        print_json({"error": said, "diagnostics": error.earlier})
    return error.exit_code


def _leave_stdout() -> None:
    """Let nothing more be written to standard output, not even when the process ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


#: Words that ask for help: ``-h``, also among other short options, ``--help`` or its beginning.
HELP = re.compile(r"-\w*h\w*|--h(e(lp?)?)?")
#: Options of the program, which may stand before the command, too.
_ANYWHERE = ("-v", "--verbose", "-q", "--quiet", "--no-plugins", "--debug", "--color")


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The words of a command line; what is wrong with them ends the program, as argparse does."""
    words = _command_first(words)
    name = words[0] if words else ""
    known = {command.name: command for command in CORE}
    if name not in known:
        known = commands_of(load_plugins(installed="--no-plugins" not in words))
    may_ask_for_help = any(HELP.fullmatch(word) for word in words)
    installed = "--no-plugins" not in words
    whole = parser(known, words[:1], texts=may_ask_for_help or not words, installed=installed)
    if not words:
        whole.print_help()
        whole.exit()
    if not name.startswith("-") and name not in known:
        whole.error(f"there is no command '{name}'{_nearest(name, known)}")
    arguments, unknown = whole.parse_known_args(words)
    if unknown:  # argparse would show the usage of all commands
        own: argparse.ArgumentParser = arguments.parser
        hint = _nearest(unknown[0].partition("=")[0], own._option_string_actions)
        own.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
    return arguments


def _command_first(words: Sequence[str]) -> list[str]:
    """The words with the program's options behind the command."""
    count = 0
    while count < len(words) and words[count].partition("=")[0] in _ANYWHERE:
        count += 2 if words[count] == "--color" else 1
    command, before, behind = words[count : count + 1], words[:count], words[count + 1 :]
    return [*command, *before, *behind]


def _nearest(word: str, known: Iterable[str]) -> str:
    hint = nearest(word, known) if word.startswith("--") or not word.startswith("-") else None
    return f"; {hint}" if hint else ""


def parser(
    known: Mapping[str, Command] | None = None,
    named: Iterable[str] | None = None,
    *,
    texts: bool = True,
    installed: bool = True,
) -> argparse.ArgumentParser:
    """The known commands in the order of the help, those that are ``named`` with their options.

    None: all.  Only the files of the named commands are imported.  Without ``texts`` there is no
    help, and no other command.
    """
    known = commands_of() if known is None else known
    named = known if named is None else named
    whole = _Parser(
        prog="urdf2mbs", description="Convert URDF and xacro robots to Robotran .mbs files.",
        epilog=_listed(known), formatter_class=_Help,
    )  # fmt: skip
    whole.color = False  # type: ignore[attr-defined]  # no escape code passes a screen
    whole.add_argument("--version", action=_Version, help="show the version and exit")
    commands = whole.add_subparsers(required=True, metavar="COMMAND", help="one of those below")
    for name, command in known.items():
        if not texts and name not in named:
            continue
        one = commands.add_parser(
            name, help=command.does,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )  # fmt: skip
        if name in named:
            _add_options(one, command, installed=installed)
            if texts:
                from urdf2mbs.commands.settings import add_texts

                add_texts(one)
    return whole


def _listed(known: Mapping[str, Command]) -> str:
    """The commands with a sentence each, those of a plugin below its name."""
    lines: list[str] = []
    title = ""
    for name, command in known.items():
        package = command.module.partition(".")[0]
        if package != title:
            title = package
            lines.append("commands:" if package == "urdf2mbs" else f"of {package}:")
        lines.append(f"  {name:11} {command.does}")
    return "\n".join(lines)


def _add_options(own: argparse.ArgumentParser, command: Command, *, installed: bool) -> None:
    """The options of a command, those that all commands have among them."""
    module = import_module(command.module)
    does = f"{command.does[0].upper()}{command.does[1:]}"
    told = (module.__doc__ or "").partition("\n\n")[2].rstrip()
    own.description = f"{does.rstrip('?')}{'?' if does[-1] == '?' else '.'}\n\n{told}"
    own.epilog = "examples:" + "".join(f"\n  {line}" for line in module.EXAMPLES)
    own.set_defaults(command=command.name, module=command.module, parser=own)
    own.add_argument("--debug", action="store_true", help="show the traceback of an error")
    own.add_argument(
        "--color", choices=("auto", "always", "never"), default="auto",
        help="colours; auto: on a terminal only",
    )  # fmt: skip
    module.add_options(own)
    if command in CORE:
        hook = load_plugins(installed=installed).hook
        hook.urdf2mbs_options(command=command.name, parser=own)


class _Help(argparse.RawDescriptionHelpFormatter):
    """Without argparse's own list of the commands: ours says whose they are."""

    def _iter_indented_subactions(
        self, action: argparse.Action
    ) -> Generator[argparse.Action, None, None]:
        yield from ()


class _Parser(argparse.ArgumentParser):
    """Offer the nearest word for a wrong choice."""

    def error(self, message: str) -> NoReturn:
        wrong = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        hint = _nearest(wrong[1], re.findall(r"[\w-]+", wrong[2])) if wrong else ""
        super().error(message + hint)


class _Version(argparse.Action):
    """Look for the version only where it is asked for."""

    def __init__(self, option_strings: list[str], dest: str, **more: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **more)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"urdf2mbs {version('urdf2mbs')}")
        parser.exit()
