"""Options that several commands have, and the ``Config`` that a command line stands for."""

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


def _list_flags() -> dict[str, _Flag]:
    """Return the fields of ``Config`` that an option sets."""
    flags = {}
    for name, hint in get_type_hints(Config, include_extras=True).items():
        kind, *metas = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        for words in [meta.extra["flag"] for meta in metas if meta.extra]:
            flag, _, form = words.partition(" ")
            flags[name] = _Flag(flag, form, kind)
    return flags


FLAGS = _list_flags()

#: The fields that say how a robot is read, and the levels of messages.
READING = ("diagnostics", "strict", "trust_xacro")
#: The fields that a command line may override in a config.
RUNNING = (*READING, "passes")
#: The fields that a command line may set only for a robot without a config.
ALONE = ("base", "packages", "xacro_args", "pipeline", "plugins", "after")


def add_fields(command: argparse.ArgumentParser, *fields: str) -> None:
    """Add the options that set fields of ``Config``; ``add_texts`` adds their help."""
    for field in fields:
        flag, form, kind = FLAGS[field]
        settings: dict[str, Any] = {"help": field}
        if kind is bool:
            settings["action"] = "store_true"
        elif get_origin(kind) is Literal:
            settings["choices"] = get_args(kind)
        else:
            settings["metavar"] = form
        if get_origin(kind) in (dict, list):
            settings |= {"action": "append", "default": []}
        command.add_argument(flag, dest=field, **settings)


def choose_fields(arguments: argparse.Namespace, fields: Iterable[str] = FLAGS) -> dict[str, Any]:
    """Return the fields of ``Config`` that a command line sets, as a config states them.

    Raises:
        ConfigError: ``usage``, an option has the wrong form.
    """
    given = {field: getattr(arguments, field, None) for field in fields}
    return {field: _parse_option(FLAGS[field], value) for field, value in given.items() if value}


def _parse_option(flag: _Flag, given: Any) -> Any:
    """Return the value of an option; the words NAME=VALUE become a dict."""
    if get_origin(flag.kind) is not dict:
        return given
    from urdf2mbs.config.yaml_text import parse_value

    sign = ":=" if ":=" in flag.form else "="
    is_pass_option = "." in flag.form
    is_list = list[str] in get_args(get_args(flag.kind)[1])
    values: dict[str, Any] = {}
    for text in given:
        name, found_sign, value = text.partition(sign)
        pass_name, _, option = name.rpartition(".")
        if not found_sign or not name or (is_pass_option and not pass_name):
            raise ConfigError("usage", f"{flag.flag} {text}: expected {flag.flag} {flag.form}")
        if is_pass_option:
            values.setdefault(pass_name, {})[option] = parse_value(value)
        elif is_list:
            values.setdefault(name, []).append(value)
        else:
            values[name] = value
    return values


def read_config(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Read a config file, with the values that the command line overrides."""
    config, lines = load(file, **choose_fields(arguments, RUNNING))
    if getattr(arguments, "no_plugins", False) and config.plugins:
        names = ", ".join(config.plugins)
        print(f"{file}: --no-plugins leaves out its plugins: {names}", file=sys.stderr)
        config = msgspec.structs.replace(config, plugins=[])
    return config, lines


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Return the config that a command line stands for, which names a robot."""
    if robot == "-":
        robot = files.take_stdin()
    return config_of({"source": robot, "output": output, **choose_fields(arguments)})


def robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Return the config of the named file: a config or a robot, by the file's ending.

    Raises:
        ConfigError: ``usage``, an option is only for a robot without a config; or the config is
            wrong.
    """
    file: Path = arguments.config
    is_robot = file.suffix.lower() not in (".yaml", ".yml", "") and not files.is_folder(file)
    if is_robot or str(file) == "-" or is_name(str(file)):
        return without_config(str(file), None, arguments)
    for field in choose_fields(arguments, ALONE):
        message = f"{FLAGS[field].flag} is for a robot without a config"
        hint = f"write it in '{file}', or name the .urdf or .xacro file instead"
        raise ConfigError("usage", message, hint=hint)
    return read_config(file, arguments)


def refuse(arguments: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Raise ConfigError if one of some options is given; ``why`` says what it is for."""
    for name in names:
        if getattr(arguments, name) not in (None, False, []):
            raise ConfigError("usage", f"--{name.replace('_', '-')} is for {why}")


# --- options that several commands have ---


def path(text: str) -> Path:
    """Return the path of an option; the empty one would be the working folder."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def add_json(command: argparse._ActionsContainer) -> None:
    """Add ``--json``."""
    command.add_argument("--json", action="store_true", help="print all that is known, as JSON")


def add_printing(command: argparse.ArgumentParser, *, writes: bool = True) -> None:
    """Add ``--json`` and ``--quiet``, and ``--force`` for a command that writes files."""
    if writes:
        command.add_argument("--force", action="store_true", help="replace edited files, too")
    either = command.add_mutually_exclusive_group()
    add_json(either)
    either.add_argument("-q", "--quiet", action="store_true", help="print only warnings and errors")


def add_no_plugins(command: argparse.ArgumentParser) -> None:
    """Add ``--no-plugins``."""
    command.add_argument(
        "--no-plugins",
        action="store_true",
        help="leave out installed plugins, and those of a config",
    )


@cache
def field_docs(kind: type) -> dict[str, str]:
    """Return the docstrings below the fields of a class and its bases, by field."""
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
    """Add the docstrings of the fields of ``Config`` as help of the options that set them.

    A process that converts Cassie takes three quarters of the time without these texts.
    """
    docs = field_docs(Config)
    for action in command._actions:
        if action.help in docs:
            action.help = docs[action.help].replace("%", "%%")


def add_verbose(command: argparse.ArgumentParser) -> None:
    """Add ``--verbose``."""
    command.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )


def add_running(command: argparse.ArgumentParser) -> None:
    """Add the options of a command that runs passes, with a config or without."""
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
