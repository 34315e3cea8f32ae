"""The words of the command line: every command, its options and its help.

What a command does is in the file of its name in ``commands``.  That file is imported when the
command runs: here is nothing but argparse, so that help is there at once.
"""

from __future__ import annotations

import argparse
import os
import sys

# typing is not imported: a type checker knows this name, too
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path
    from typing import Any, TypeAlias

    Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser] | _Alone"

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

#: The name of the report of many robots.
REPORT = "urdf2mbs-report.json"

BASES = ("auto", "floating", "fixed")


def parser() -> argparse.ArgumentParser:
    """All commands with their options, in the order of the help."""
    parser: argparse.ArgumentParser = _Parser(
        prog="urdf2mbs",
        description="Convert URDF and xacro robots to Robotran .mbs files.",
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in _COMMANDS.values():
        add(commands)
    return parser


def parse(words: Sequence[str]) -> argparse.Namespace:
    """The words of a command line; what is wrong with them ends the program, as argparse does."""
    if not words or words[0] not in _COMMANDS:
        return parser().parse_args(words)
    # the options of one command are made in a tenth of the time of all
    alone = _Alone()
    _COMMANDS[words[0]](alone)
    return alone.parser.parse_args(words[1:])


class _Alone:
    """Stands for the commands of ``parser`` where only one is wanted."""

    parser: argparse.ArgumentParser

    def add_parser(self, name: str, *, help: str, **more: Any) -> argparse.ArgumentParser:  # noqa: A002
        self.parser = _Parser(prog=f"urdf2mbs {name}", **more)
        return self.parser


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


def _path(text: str) -> Path:
    from pathlib import Path

    if not text:  # which would be the working folder
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def _command(commands: Commands, name: str, does: str) -> argparse.ArgumentParser:
    """A new command with the options that all have."""
    examples = "".join(f"\n  {line}" for line in EXAMPLES[name])
    command = commands.add_parser(name, help=does, epilog=f"examples:{examples}")
    command.set_defaults(command=name)
    command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    command.add_argument(
        "--color", choices=("auto", "always", "never"), default="auto",
        help="auto: on a terminal only",
    )  # fmt: skip
    return command


def _add_json(command: argparse._ActionsContainer) -> None:
    command.add_argument("--json", action="store_true", help="print all that is known, as JSON")


def _add_telling(command: argparse.ArgumentParser, *, writes: bool = True) -> None:
    """For what does something, and tells of it: in words, as JSON, or not at all."""
    if writes:
        command.add_argument("--force", action="store_true", help="replace edited files, too")
    either = command.add_mutually_exclusive_group()
    _add_json(either)
    either.add_argument("-q", "--quiet", action="store_true", help="print only warnings and errors")


def _add_no_plugins(command: argparse.ArgumentParser) -> None:
    command.add_argument("--no-plugins", action="store_true", help="leave out installed plugins")


def _add_steps(command: argparse.ArgumentParser) -> None:
    """Where to stop, and what to show on the way."""
    command.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
    command.add_argument(
        "--dump", type=_path, metavar="DIR", help="write the state after every pass, as YAML"
    )


def _add_levels(command: argparse.ArgumentParser) -> None:
    """For what reads a robot, and may warn of it."""
    command.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )
    command.add_argument(
        "--level", action="append", default=[], metavar="CODE=LEVEL",
        help="how much a warning weighs: error, warning, note or ignore",
    )  # fmt: skip
    command.add_argument("--strict", action="store_true", help="warnings are errors")


def _add_running(command: argparse.ArgumentParser) -> None:
    """For what runs passes, by a config or by what stands for one."""
    _add_no_plugins(command)
    _add_levels(command)
    _add_trust(command)
    command.add_argument(
        "--set", action="append", default=[], metavar="PASS.OPTION=VALUE", help="option of a pass"
    )


def _add_trust(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--trust-xacro", action="store_true",
        help="let the robot's xacro do whatever Python can, and read any file",
    )  # fmt: skip


def _add_base(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--base", choices=BASES,
        help="whether the base floats (default: auto, as the URDF ties it)",
    )  # fmt: skip


def _add_robot(command: argparse.ArgumentParser) -> None:
    """What a robot needs to be read."""
    command.add_argument(
        "--package", action="append", default=[], metavar="NAME=DIR", help="where a package is"
    )
    command.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )


def _add_settings(command: argparse.ArgumentParser) -> None:
    """What a config says, for a robot without one."""
    _add_base(command)
    _add_robot(command)
    command.add_argument("--pipeline", metavar="PRESET", help="default: faithful")
    _add_plugin(command)
    command.add_argument(
        "--after", action="append", default=[], metavar="PASS=NEW", help="put NEW after PASS"
    )


def _add_plugin(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--plugin", action="append", default=[], metavar="FILE.py", help="a plugin to load"
    )


def _add_many(command: argparse.ArgumentParser) -> None:
    many = command.add_argument_group("many robots")
    many.add_argument("--workers", type=int, metavar="N", help="processes (default: every core)")
    many.add_argument("--cluster", metavar="ADDRESS", help="of a Dask scheduler to use instead")
    many.add_argument(
        "--report", type=_path, metavar="FILE.json",
        help=f"default: {REPORT} in the folder that all outputs are in",
    )  # fmt: skip


def _init(commands: Commands) -> None:
    command = _command(commands, "init", "write a config for a robot, to start from")
    command.add_argument(
        "robot", metavar="ROBOT", help="a .urdf or .xacro file, or robot_descriptions:NAME"
    )
    command.add_argument(
        "-o", "--output", type=_path, metavar="CONFIG.yaml", help="default: the robot's name, here"
    )
    _add_telling(command)
    _add_base(command)
    _add_robot(command)
    _add_trust(command)


def _run(commands: Commands) -> None:
    command = _command(commands, "run", "convert as a config file says, or as several do")
    command.add_argument(
        "config", type=_path, metavar="CONFIG.yaml", nargs="+", help="'init' writes one"
    )
    _add_telling(command)
    _add_running(command)
    _add_steps(command)
    _add_many(command)


def _convert(commands: Commands) -> None:
    command = _command(
        commands, "convert", "convert one robot, or a folder of them, without a config file"
    )
    _add_telling(command)
    _add_running(command)
    _add_steps(command)
    command.add_argument(
        "robot",
        metavar="ROBOT",
        help="a .urdf or .xacro file, a folder, robot_descriptions:NAME, or - for standard input",
    )
    command.add_argument(
        "-o", "--output", metavar="OUT.mbs",
        help="the file, - for standard output; an existing folder, or DIR/, gets a project "
        "(of a folder of robots: their .mbs files)",
    )  # fmt: skip
    _add_settings(command)
    _add_many(command)


def _report(commands: Commands) -> None:
    command = _command(commands, "report", "convert, and write one HTML page to look at instead")
    _add_telling(command)
    _add_running(command)
    command.add_argument(
        "config", type=_path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below",
    )  # fmt: skip
    command.add_argument(
        "-o", "--output", type=_path, metavar="OUT.html",
        help="default: beside the output; - for standard output",
    )  # fmt: skip
    _add_settings(command)


def _verify(commands: Commands) -> None:
    command = _command(commands, "verify", "compare a robot with an .mbs file: are they the same?")
    command.add_argument(
        "robot", metavar="ROBOT",
        help="a .urdf or .xacro file, robot_descriptions:NAME, or - for standard input",
    )  # fmt: skip
    _add_model(command)
    _add_telling(command, writes=False)
    _add_levels(command)
    _add_robot(command)
    _add_trust(command)
    command.add_argument(
        "--engine", choices=("own", "pinocchio"), default="own",
        help="own (the default), or pinocchio, which compares mass matrix and forces, too",
    )  # fmt: skip
    _add_base(command)
    command.add_argument(
        "--gravity", type=float, nargs=3, default=(0.0, 0.0, -9.81), metavar=("X", "Y", "Z"),
        help="what the .mbs should have, in m/s^2 (0 0 -9.81): a URDF has none",
    )  # fmt: skip
    command.add_argument(
        "--frames", action="store_true",
        help="a link's frame that is elsewhere in the .mbs is a difference, too",
    )  # fmt: skip
    command.add_argument("--tolerance", type=float, default=1e-9, help="relative (%(default)s)")


def _add_model(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=_path, metavar="MODEL.mbs", help="of urdf2mbs, or drawn by hand"
    )


def _diagram(commands: Commands) -> None:
    command = _command(commands, "diagram", "draw the 2D diagram of an .mbs file as an SVG picture")
    command.add_argument(
        "model", type=_path, metavar="MODEL.mbs", help="the file, or - for standard input"
    )
    command.add_argument(
        "-o", "--output", type=_path, metavar="OUT.svg",
        help="default: beside the model; - for standard output",
    )  # fmt: skip
    _add_telling(command)


def _equations(commands: Commands) -> None:
    command = _command(commands, "equations", "write Robotran's equations for an .mbs file")
    _add_model(command)
    _add_telling(command)
    command.add_argument(
        "-o", "--output", type=_path, metavar="DIR", help="default: symbolicR of the project"
    )
    command.add_argument(
        "--language", choices=("python", "c"), default="python", help="default: python"
    )
    command.add_argument(
        "--fold", action="store_true", help="write masses, points and the like as numbers"
    )
    command.add_argument(
        "--keep-turns", action="store_true",
        help="read the positions of joints that never move, too",
    )  # fmt: skip
    command.add_argument(
        "--numba", action="store_true", help="let numba compile dirdyna and invdyna (python)"
    )
    command.add_argument(
        "--no-pairs", action="store_true",
        help="compute mirrored limbs one after the other, for compilers other than gcc and "
        "clang (c)",
    )  # fmt: skip


def _explain(commands: Commands) -> None:
    command = _command(commands, "explain", "show the passes of a config, without running them")
    command.add_argument(
        "config", type=_path, metavar="CONFIG.yaml",
        help="or a .urdf or .xacro file, with the options below",
    )  # fmt: skip
    command.add_argument(
        "--cost", action="store_true",
        help="convert after all, by each preset too, to count the joints; nothing is written",
    )  # fmt: skip
    _add_json(command)
    _add_running(command)
    _add_settings(command)


def _passes(commands: Commands) -> None:
    command = _command(commands, "passes", "list every known pass")
    _add_json(command)
    _add_no_plugins(command)
    _add_plugin(command)


def _new_pass(commands: Commands) -> None:
    command = _command(commands, "new-pass", "write a plugin with one pass, and its test")
    command.add_argument("name", metavar="NAME", help="of the pass: small letters, digits, hyphens")
    command.add_argument(
        "-o", "--output", type=_path, metavar="DIR", default=".", help="default: here"
    )
    _add_telling(command)


def _schema(commands: Commands) -> None:
    command = _command(commands, "schema", "print the JSON schema of a config, for editors")
    _add_no_plugins(command)
    _add_plugin(command)


def _doctor(commands: Commands) -> None:
    command = _command(
        commands, "doctor",
        "show versions, extras, plugins, ROS packages and Robotran as they are here",
    )  # fmt: skip
    _add_json(command)
    _add_no_plugins(command)


def _completion(commands: Commands) -> None:
    command = _command(
        commands, "completion", "print a script that completes commands and options in a shell"
    )
    command.add_argument("shell", choices=("bash", "zsh", "fish"), help="the shell that you use")


#: In the order of the help.
_COMMANDS = {
    "init": _init, "run": _run, "convert": _convert, "report": _report, "verify": _verify,
    "diagram": _diagram, "equations": _equations, "explain": _explain, "passes": _passes,
    "new-pass": _new_pass, "schema": _schema, "doctor": _doctor, "completion": _completion,
}  # fmt: skip
