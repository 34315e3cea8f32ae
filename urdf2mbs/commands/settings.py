"""Options that several commands have, and the ``Config`` that they form."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import msgspec

from urdf2mbs.commands.kinds import check_kind
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
    flags_by_field = {}
    for field_name, type_hint in get_type_hints(Config, include_extras=True).items():
        field_type, *metadata = (
            get_args(type_hint) if get_origin(type_hint) is Annotated else (type_hint,)
        )
        for flag_text in [annotation.extra["flag"] for annotation in metadata if annotation.extra]:
            option, _, value_form = flag_text.partition(" ")
            flags_by_field[field_name] = _Flag(option, value_form, field_type)
    return flags_by_field


FLAGS = _list_flags()

#: The fields that say how a robot is read, and the levels of messages.
READING = ("diagnostics", "strict", "trust_xacro")
#: The fields that a command line may override in a config.
RUNNING = (*READING, "passes")
#: The fields that a command line may set only for a robot without a config.
ALONE = ("base", "packages", "xacro_args", "pipeline", "plugins", "after")


def add_fields(command: argparse.ArgumentParser, *fields: str) -> None:
    """Add the options that set fields of ``Config``; ``add_texts`` adds their help."""
    for field_name in fields:
        option, value_form, field_type = FLAGS[field_name]
        settings: dict[str, Any] = {"help": field_name}
        if field_type is bool:
            settings["action"] = "store_true"
        elif get_origin(field_type) is Literal:
            settings["choices"] = get_args(field_type)
        else:
            settings["metavar"] = value_form
        if get_origin(field_type) in (dict, list):
            settings |= {"action": "append", "default": []}
        command.add_argument(option, dest=field_name, **settings)


def choose_fields(arguments: argparse.Namespace, fields: Iterable[str] = FLAGS) -> dict[str, Any]:
    """Return the fields of ``Config`` that a command line sets, as a config states them.

    Raises:
        ConfigError: ``usage``, an option has the wrong form.
    """
    given_values = {field_name: getattr(arguments, field_name, None) for field_name in fields}
    return {
        field_name: _parse_option(FLAGS[field_name], value)
        for field_name, value in given_values.items()
        if value
    }


def _parse_option(flag: _Flag, given_value: Any) -> Any:
    """Return the value of an option; the words NAME=VALUE become a dict."""
    if get_origin(flag.kind) is not dict:
        return given_value
    from urdf2mbs.config.yaml_text import parse_value

    separator = ":=" if ":=" in flag.form else "="
    is_pass_option = "." in flag.form
    is_list = list[str] in get_args(get_args(flag.kind)[1])
    option_values: dict[str, Any] = {}
    for assignment in given_value:
        key, found_separator, value = assignment.partition(separator)
        pass_name, _, option = key.rpartition(".")
        if not found_separator or not key or (is_pass_option and not pass_name):
            raise ConfigError(
                "usage", f"{flag.flag} {assignment}: expected {flag.flag} {flag.form}"
            )
        if is_pass_option:
            option_values.setdefault(pass_name, {})[option] = parse_value(value)
        elif is_list:
            option_values.setdefault(key, []).append(value)
        else:
            option_values[key] = value
    return option_values


def read_config(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Read a config file, with the values that the command line overrides."""
    config, lines = load(file, **choose_fields(arguments, RUNNING))
    if getattr(arguments, "no_plugins", False) and config.plugins:
        plugin_names = ", ".join(config.plugins)
        print(f"{file}: --no-plugins leaves out its plugins: {plugin_names}", file=sys.stderr)
        config = msgspec.structs.replace(config, plugins=[])
    return config, lines


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Return the config of a command line that names a robot."""
    if robot == "-":
        robot = files.take_stdin()
    return config_of({"source": robot, "output": output, **choose_fields(arguments)})


def robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """Return the config of the named file: a config or a robot, by the file's ending.

    Raises:
        ConfigError: ``usage``, the file is neither, or an option is only for a robot without a
            config; or the config is wrong.
    """
    file: Path = arguments.config
    check_kind(file, arguments, "robot", "config")
    is_robot = file.suffix.lower() not in (".yaml", ".yml", "") and not files.is_folder(file)
    if is_robot or str(file) == "-" or is_name(str(file)):
        return without_config(str(file), None, arguments)
    for field_name in choose_fields(arguments, ALONE):
        message = f"{FLAGS[field_name].flag} is for a robot without a config"
        hint = f"write it in '{file}', or name the robot's own file instead"
        raise ConfigError("usage", message, hint=hint)
    return read_config(file, arguments)


def refuse(arguments: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Raise ConfigError if one of some options is given; ``why`` says when it applies."""
    for option_name in names:
        if getattr(arguments, option_name) not in (None, False, []):
            raise ConfigError("usage", f"--{option_name.replace('_', '-')} is for {why}")


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
    exclusive_group = command.add_mutually_exclusive_group()
    add_json(exclusive_group)
    exclusive_group.add_argument(
        "-q", "--quiet", action="store_true", help="print only warnings and errors"
    )


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
        syntax_tree = ast.parse(dedent(inspect.getsource(kind)))
    except (OSError, TypeError, SyntaxError):
        return {}
    fields = getattr(kind, "__struct_fields__", ())
    docstrings = {
        field_name: docstring
        for base in kind.__bases__
        for field_name, docstring in field_docs(base).items()
    }
    class_body = syntax_tree.body[0].body if isinstance(syntax_tree.body[0], ast.ClassDef) else []
    for field_and_text in pairwise(class_body):
        match field_and_text:
            case (
                ast.AnnAssign(target=ast.Name(id=field_name)),
                ast.Expr(value=ast.Constant(value=str(docstring))),
            ) if field_name in fields:
                docstrings[field_name] = " ".join(docstring.split())
    return docstrings


def add_texts(command: argparse.ArgumentParser) -> None:
    """Add the docstrings of the fields of ``Config`` as help of the options that set them.

    A process that converts Cassie takes three quarters of the time without these texts.
    """
    docstrings = field_docs(Config)
    for action in command._actions:
        if action.help in docstrings:
            action.help = docstrings[action.help].replace("%", "%%")


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
    exclusive_group = command.add_mutually_exclusive_group()
    exclusive_group.add_argument(
        "--plan", action="store_true", help="list the changes, and write nothing"
    )
    exclusive_group.add_argument(
        "--fresh", action="store_true", help="start over: keep no change that you made in the .mbs"
    )
    add_running(command)
    command.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
