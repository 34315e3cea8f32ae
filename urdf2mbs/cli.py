"""The command line: reads its words, carries the command out, and says what went wrong."""

from __future__ import annotations

import argparse
import atexit
import gc
import os
import sys

from urdf2mbs.commands import COMMANDS

# What more a command needs is imported when it runs, so that help comes at once.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same)."""
    if argv is None:
        # This process is ours: at its end the collector would look through all that there is, and
        # find nothing worth the time.
        atexit.register(gc.freeze)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed, as for a service: nobody reads it
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # a robot's name may have letters that this terminal or pipe has not
            reconfigure(errors="backslashreplace")
    arguments = parse(sys.argv[1:] if argv is None else argv)
    from urdf2mbs.collector import seldom_collected

    with seldom_collected():  # it would look through all that is imported, too
        return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    import signal
    from contextlib import suppress

    from urdf2mbs.commands.colours import shown
    from urdf2mbs.commands.streams import quiet

    with suppress(ValueError):  # only the main thread is asked to end
        signal.signal(signal.SIGTERM, _stop)
    with shown(arguments.color), quiet(getattr(arguments, "quiet", False)):
        return _carry_out(arguments)


def _carry_out(arguments: argparse.Namespace) -> int:
    from errno import ENOSPC
    from pathlib import Path

    from urdf2mbs.diagnostics import ConfigError, ConversionError, memory_full
    from urdf2mbs.files import absolute

    try:
        absolute(Path())  # a working folder that is not there any more is told at once
        code: int = _module(arguments.command).carry_out(arguments)
        sys.stdout.flush()
        return code
    except ConversionError as error:
        if arguments.debug:
            raise
        print(error, file=sys.stderr)
        if getattr(arguments, "json", False):
            from urdf2mbs.commands.printing import print_json

            print_json(
                {
                    "error": {
                        k: getattr(error, k) for k in ("code", "message", "file", "line", "hint")
                    },
                    "diagnostics": error.said,
                }
            )
        return error.exit_code
    except BrokenPipeError:
        # whoever read our output has seen enough
        _leave_stdout()
        return 0
    except KeyboardInterrupt:
        return 130
    except MemoryError:
        if arguments.debug:
            raise
        print(memory_full("this command"), file=sys.stderr)
        return ConversionError.exit_code
    except Exception as error:
        if arguments.debug:
            raise
        _leave_stdout()
        if isinstance(error, OSError) and error.errno == ENOSPC:
            print(f"error[output-unwritable]: cannot print: {error.strerror}", file=sys.stderr)
            return ConfigError.exit_code
        said = ConversionError(
            "internal", f"{type(error).__name__}: {' '.join(str(error).split())}",
            hint="this is a mistake in urdf2mbs: please report it; --debug shows more",
        )  # fmt: skip
        print(said, file=sys.stderr)
        return said.exit_code


def _stop(signal: int, *_: object) -> None:
    """A process that is asked to end takes away its unfinished files first."""
    raise SystemExit(128 + signal)


def _leave_stdout() -> None:
    from contextlib import suppress

    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The words of a command line; what is wrong with them ends the program, as argparse does."""
    return parser(words[:1]).parse_args(words)


def parser(named: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """All commands in the order of the help, those that are ``named`` with their options.

    Only the files of the named commands are imported.
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
    return whole


def _add_options(command: argparse.ArgumentParser, name: str) -> None:
    """The options of a command, those that all commands have among them."""
    module = _module(name)
    command.epilog = "examples:" + "".join(f"\n  {line}" for line in module.EXAMPLES)
    command.set_defaults(command=name)
    command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    command.add_argument(
        "--color", choices=("auto", "always", "never"), default="auto",
        help="auto: on a terminal only",
    )  # fmt: skip
    module.add_options(command)


def _module(name: str) -> Any:
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


if __name__ == "__main__":
    sys.exit(main())
