"""Turns the words of a command line into a ``Config``; options that several commands have."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import msgspec

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import config_of, load
from urdf2mbs.config.model import Config
from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.urdf.reader import is_name


class _Flag(NamedTuple):
    """The option of a command line that sets a field of ``Config``."""

    flag: str
    form: str
    """The form of its value; empty: the option has no value, or one of a few words."""
    kind: Any
    """The type of the field."""


def _flags() -> dict[str, _Flag]:
    """The fields of ``Config`` that have a flag."""
    flags = {}
    for name, hint in get_type_hints(Config, include_extras=True).items():
        kind, *metas = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        for words in [meta.extra["flag"] for meta in metas if meta.extra]:
            flag, _, form = words.partition(" ")
            flags[name] = _Flag(flag, form, kind)
    return flags


FLAGS = _flags()

#: The fields that say how a robot is read, and how much its warnings weigh.
READING = ("diagnostics", "strict", "trust_xacro")
#: The fields that a command line may change where there is a config, and those for a robot alone.
RUNNING = (*READING, "passes")
ALONE = ("base", "packages", "xacro_args", "pipeline", "plugins", "after")


def add_fields(command: argparse.ArgumentParser, *fields: str) -> None:
    """The options that set fields of ``Config``; ``add_texts`` gives them their help."""
    for field in fields:
        flag, form, kind = FLAGS[field]
        more: dict[str, Any] = {"help": field}
        if kind is bool:
            more["action"] = "store_true"
        elif get_origin(kind) is Literal:
            more["choices"] = get_args(kind)
        else:
            more["metavar"] = form
        if get_origin(kind) in (dict, list):
            more |= {"action": "append", "default": []}
        command.add_argument(flag, dest=field, **more)


def choose_fields(arguments: argparse.Namespace, fields: Iterable[str] = FLAGS) -> dict[str, Any]:
    """What a command line says of the fields of ``Config``, as a config says it."""
    given = {field: getattr(arguments, field, None) for field in fields}
    return {field: _value(FLAGS[field], value) for field, value in given.items() if value}


def _value(flag: _Flag, given: Any) -> Any:
    if get_origin(flag.kind) is not dict:
        return given
    from urdf2mbs.config.yaml_text import parse_value

    sign = ":=" if ":=" in flag.form else "="
    values: dict[str, Any] = {}
    for text in given:
        name, found, value = text.partition(sign)
        pass_, _, option = name.rpartition(".")
        if not found or not name or ("." in flag.form and not pass_):
            raise ConfigError("usage", f"{flag.flag} {text}: it reads {flag.flag} {flag.form}")
        if "." in flag.form:
            values.setdefault(pass_, {})[option] = parse_value(value)
        elif list[str] in get_args(get_args(flag.kind)[1]):
            values.setdefault(name, []).append(value)
        else:
            values[name] = value
    return values


def read_config(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Read a config file, with the values that the command line overrides."""
    config, lines = load(file, **choose_fields(arguments, RUNNING))
    if getattr(arguments, "no_plugins", False) and config.plugins:
        left_out = ", ".join(config.plugins)
        print(f"{file}: --no-plugins leaves out its plugins: {left_out}", file=sys.stderr)
        config = msgspec.structs.replace(config, plugins=[])
    return config, lines


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config that the command line stands for."""
    if robot == "-":
        robot = files.take_stdin()
    return config_of({"source": robot, "output": output, **choose_fields(arguments)})


def robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config of the file that is named: a config or a robot, by the file's ending."""
    file: Path = arguments.config
    robot = file.suffix.lower() not in (".yaml", ".yml", "") and not files.is_folder(file)
    if robot or str(file) == "-" or is_name(str(file)):
        return without_config(str(file), None, arguments)
    for field in choose_fields(arguments, ALONE):
        raise ConfigError(
            "usage", f"{FLAGS[field].flag} is for a robot without a config",
            hint=f"write it in '{file}', or name the .urdf or .xacro file instead",
        )  # fmt: skip
    return read_config(file, arguments)


def refuse(arguments: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Raise ConfigError if one of these options is given; ``why``: what it is for."""
    for name in names:
        if getattr(arguments, name) not in (None, False, []):
            raise ConfigError("usage", f"--{name.replace('_', '-')} is for {why}")


# --- options that several commands have ---


def path(text: str) -> Path:
    if not text:  # an empty path would be the working folder
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def add_json(command: argparse._ActionsContainer) -> None:
    command.add_argument("--json", action="store_true", help="print all that is known, as JSON")


def add_printing(command: argparse.ArgumentParser, *, writes: bool = True) -> None:
    """For a command that prints its result in words, as JSON, or not at all."""
    if writes:
        command.add_argument("--force", action="store_true", help="replace edited files, too")
    either = command.add_mutually_exclusive_group()
    add_json(either)
    either.add_argument("-q", "--quiet", action="store_true", help="print only warnings and errors")


def add_no_plugins(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--no-plugins",
        action="store_true",
        help="leave out installed plugins, and those of a config",
    )


@cache
def field_docs(kind: type) -> dict[str, str]:
    """The docstrings that stand below the fields of a class and its bases, by field."""
    import ast
    import inspect
    from itertools import pairwise
    from textwrap import dedent

    try:
        tree = ast.parse(dedent(inspect.getsource(kind)))
    except (OSError, TypeError, SyntaxError):
        return {}
    fields = getattr(kind, "__struct_fields__", ())
    docs = {name: text for base in kind.__bases__ for name, text in field_docs(base).items()}
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else []
    for field_and_text in pairwise(body):
        match field_and_text:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ) if name in fields:
                docs[name] = " ".join(text.split())
    return docs


def add_texts(command: argparse.ArgumentParser) -> None:
    """The texts of the fields of ``Config``, as help of the options that set the fields.

    Without these texts, a process that converts Cassie takes three quarters of the time.
    """
    docs = field_docs(Config)
    for action in command._actions:
        if action.help in docs:
            action.help = docs[action.help].replace("%", "%%")


def add_verbose(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )


def add_running(command: argparse.ArgumentParser) -> None:
    """For a command that runs passes, by a config or by options that stand for a config."""
    add_no_plugins(command)
    add_verbose(command)
    add_fields(command, *RUNNING)


def add_converting(command: argparse.ArgumentParser) -> None:
    """Add the options of ``run`` and ``convert``; plugins add theirs by ``urdf2mbs_options``."""
    add_printing(command)
    either = command.add_mutually_exclusive_group()
    either.add_argument("--plan", action="store_true", help="list the changes, and write nothing")
    either.add_argument(
        "--fresh", action="store_true", help="start over: keep no change that you made in the .mbs"
    )
    add_running(command)
    command.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
