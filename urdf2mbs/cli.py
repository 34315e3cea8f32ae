"""The command line: the commands' options are put together here, and their errors end here."""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from errno import ENOSPC
from typing import Any

from urdf2mbs.commands import diagram, equations, explain, new_pass, passes, run, schema, verify
from urdf2mbs.commands import report as report_page
from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import shared_options
from urdf2mbs.diagnostics import ConfigError, ConversionError

#: In the order of the help.
COMMANDS = (run, explain, passes, new_pass, schema, report_page, verify, diagram, equations)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same)."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # a robot's name may have letters that this terminal or pipe has not
            stream.reconfigure(errors="backslashreplace")
    arguments = _parser().parse_args(argv)
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, _stop)
    try:
        code: int = arguments.command(arguments)
        sys.stdout.flush()
        return code
    except ConversionError as error:
        if arguments.debug:
            raise
        print(error, file=sys.stderr)
        if getattr(arguments, "json", False):
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


def _stop(*_: object) -> None:
    """A process that is asked to end takes away its unfinished files first."""
    raise SystemExit(128 + signal.SIGTERM)


def _leave_stdout() -> None:
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Version(argparse.Action):
    def __init__(self, option_strings: list[str], dest: str, **more: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **more)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version  # which takes time

        print(f"urdf2mbs {version('urdf2mbs')}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="urdf2mbs", description="Convert URDF and xacro robots to Robotran .mbs files."
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    parents = shared_options()
    for command in COMMANDS:
        command.add(commands, parents)
    return parser


if __name__ == "__main__":
    sys.exit(main())
