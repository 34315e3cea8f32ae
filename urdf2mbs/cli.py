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

from urdf2mbs.commands import (
    completion,
    diagram,
    doctor,
    equations,
    explain,
    init,
    new_pass,
    passes,
    run,
    schema,
    verify,
)
from urdf2mbs.commands import report as report_page
from urdf2mbs.commands.colours import colours
from urdf2mbs.commands.printing import print_json
from urdf2mbs.commands.settings import shared_options
from urdf2mbs.diagnostics import ConfigError, ConversionError

#: In the order of the help.
COMMANDS = (
    init, run, report_page, verify, diagram, equations, explain, passes, new_pass, schema, doctor
)  # fmt: skip


#: The last lines of each command's help.
EXAMPLES = {
    "init": (
        "urdf2mbs init robot.urdf.xacro",
        "urdf2mbs init robot_descriptions:atlas_v4_description",
    ),
    "run": ("urdf2mbs run robot.yaml", "urdf2mbs run robot.yaml -v --dump dump --stop-after emit"),
    "convert": (
        "urdf2mbs convert robot.urdf -o robot.mbs",
        "urdf2mbs convert ur.urdf.xacro -o ur5e/ --arg ur_type:=ur5e --arg name:=ur5e",
        "xacro robot.urdf.xacro | urdf2mbs convert - -o - > robot.mbs",
    ),
    "report": ("urdf2mbs report robot.yaml", "urdf2mbs report robot.urdf -o look.html"),
    "verify": (
        "urdf2mbs verify robot.urdf robot.mbs",
        "urdf2mbs verify robot.urdf robot.mbs --engine pinocchio",
    ),
    "diagram": ("urdf2mbs diagram robot.mbs", "urdf2mbs diagram robot.mbs -o picture.svg"),
    "equations": (
        "urdf2mbs equations project/dataR/project.mbs",
        "urdf2mbs equations robot.mbs -o symbolicR --language c",
    ),
    "explain": ("urdf2mbs explain robot.yaml", "urdf2mbs explain robot.yaml --cost"),
    "passes": ("urdf2mbs passes", "urdf2mbs passes --plugin our_passes.py"),
    "new-pass": ("urdf2mbs new-pass actuate", "urdf2mbs new-pass actuate -o our_passes"),
    "schema": ("urdf2mbs schema > config.schema.json",),
    "doctor": ("urdf2mbs doctor", "urdf2mbs doctor --json"),
    "completion": (
        "urdf2mbs completion bash > ~/.local/share/bash-completion/completions/urdf2mbs",
        "urdf2mbs completion zsh > ~/.zfunc/_urdf2mbs     # with: fpath+=~/.zfunc; compinit",
        "urdf2mbs completion fish > ~/.config/fish/completions/urdf2mbs.fish",
    ),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code (0 done, 1 robot, 2 usage, 3 not the same)."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # a robot's name may have letters that this terminal or pipe has not
            stream.reconfigure(errors="backslashreplace")
    arguments = parser().parse_args(argv)
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, _stop)
    with colours():
        return _carry_out(arguments)


def _carry_out(arguments: argparse.Namespace) -> int:
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


def parser() -> argparse.ArgumentParser:
    """All commands with their options."""
    parser = argparse.ArgumentParser(
        prog="urdf2mbs", description="Convert URDF and xacro robots to Robotran .mbs files."
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    parents = shared_options()
    for command in COMMANDS:
        command.add(commands, parents)
    completion.add(commands, parents, lambda: parser)
    for name, one in commands.choices.items():
        if name in EXAMPLES:
            one.formatter_class = argparse.RawDescriptionHelpFormatter
            one.epilog = "examples:\n" + "\n".join(f"  {line}" for line in EXAMPLES[name])
    return parser


if __name__ == "__main__":
    sys.exit(main())
