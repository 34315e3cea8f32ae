"""What the words of a command line say of a conversion: a config, or what stands for one."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import msgspec

from urdf2mbs.disk import standard_input
from urdf2mbs.disk.files import is_folder
from urdf2mbs.engine.config import Config, Lines, field_docs, load, typed
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.urdf import descriptions

#: The name of the report of many robots.
REPORT = "urdf2mbs-report.json"


class _Flag(NamedTuple):
    """The option of a command line that sets a field of ``Config``."""

    flag: str
    form: str | None
    """Of its value; None: it has none, or one of a few words."""
    kind: Any
    """The type of the field."""

    @property
    def name(self) -> str:
        """What the parsed arguments call it."""
        return self.flag.removeprefix("--").replace("-", "_")


def _flags() -> dict[str, _Flag]:
    """The fields of ``Config`` that have a flag."""
    flags = {}
    for name, hint in get_type_hints(Config, include_extras=True).items():
        kind, *metas = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        for words in [meta.extra["flag"] for meta in metas if meta.extra]:
            flag, _, form = words.partition(" ")
            flags[name] = _Flag(flag, form or None, kind)
    return flags


FLAGS = _flags()

#: The fields that a command line may change where there is a config, and those for a robot alone.
RUNNING = ("diagnostics", "strict", "trust_xacro", "passes")
ALONE = ("base", "packages", "xacro_args", "pipeline", "plugins", "after")


def chosen(arguments: argparse.Namespace, fields: Iterable[str] = FLAGS) -> dict[str, Any]:
    """What a command line says of the fields of ``Config``, as a config says it."""
    fields_given = {}
    for field in fields:
        given = getattr(arguments, FLAGS[field].name, None)
        if given:
            fields_given[field] = _value(FLAGS[field], given)
    return fields_given


def _value(flag: _Flag, given: Any) -> Any:
    if get_origin(flag.kind) is not dict:
        return given
    form = flag.form or ""
    words = pairs(given, ":=" if ":=" in form else "=", flag.flag, form)
    if "." in form:
        return _options(words)
    if list[str] not in get_args(get_args(flag.kind)[1]):
        return dict(words)
    lists: dict[str, list[str]] = {}
    for key, value in words:
        lists.setdefault(key, []).append(value)
    return lists


def configured(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config file, with what the command line changes of it."""
    config, lines = load(file)
    given = chosen(arguments, RUNNING)
    for name, options in given.get("passes", {}).items():
        given["passes"][name] = {**config.passes.get(name, {}), **options}
    values = typed(Config, {"source": config.source, **given}, Lines())
    for field in given:
        value = getattr(values, field)
        given[field] = {**getattr(config, field), **value} if isinstance(value, dict) else value
    return msgspec.structs.replace(config, **given), lines


def levels(arguments: argparse.Namespace) -> dict[str, Any]:
    """How much warnings weigh, as a config says it."""
    return chosen(arguments, ("diagnostics", "strict"))


def _options(words: list[tuple[str, str]]) -> dict[str, dict[str, Any]]:
    """What ``--set`` says, by passes."""
    from urdf2mbs.engine.yaml_text import word

    options: dict[str, dict[str, Any]] = {}
    for key, value in words:
        pass_, dot, option = key.rpartition(".")
        if not dot:
            raise ConfigError("usage", f"--set {key}={value}: it reads PASS.OPTION=VALUE")
        options.setdefault(pass_, {})[option] = word(value)
    return options


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config that the command line stands for."""
    if robot == "-":
        robot = standard_input.take()
    lines = Lines()
    given = {"source": robot, "output": output, **chosen(arguments)}
    return typed(Config, given, lines), lines


def robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config is told from a robot by the file's ending."""
    file: Path = arguments.config
    if str(file) == "-" or str(file).startswith(descriptions.PREFIX):
        return without_config(str(file), None, arguments)
    if file.suffix.lower() not in (".yaml", ".yml", "") and not is_folder(file):
        return without_config(str(file), None, arguments)
    for field in chosen(arguments, ALONE):
        raise ConfigError(
            "usage", f"{FLAGS[field].flag} is for a robot without a config",
            hint=f"write it in '{file}', or name the .urdf or .xacro file instead",
        )  # fmt: skip
    return configured(file, arguments)


def pairs(words: list[str], sign: str, flag: str, form: str) -> list[tuple[str, str]]:
    """Split words such as ``NAME=VALUE``; raises ConfigError for one that cannot be."""
    pairs = []
    for given in words:
        name, found, value = given.partition(sign)
        if not found or not name:
            raise ConfigError("usage", f"{flag} {given}: it reads {flag} {form}")
        pairs.append((name, value))
    return pairs


# --- options that several commands have ---


def path(text: str) -> Path:
    if not text:  # which would be the working folder
        raise argparse.ArgumentTypeError("the name is empty")
    return Path(text)


def add_json(command: argparse._ActionsContainer) -> None:
    command.add_argument("--json", action="store_true", help="print all that is known, as JSON")


def add_telling(command: argparse.ArgumentParser, *, writes: bool = True) -> None:
    """For what does something, and tells of it: in words, as JSON, or not at all."""
    if writes:
        command.add_argument("--force", action="store_true", help="replace edited files, too")
    either = command.add_mutually_exclusive_group()
    add_json(either)
    either.add_argument("-q", "--quiet", action="store_true", help="print only warnings and errors")


def add_no_plugins(command: argparse.ArgumentParser) -> None:
    command.add_argument("--no-plugins", action="store_true", help="leave out installed plugins")


def add_steps(command: argparse.ArgumentParser) -> None:
    """Where to stop, and what to show on the way."""
    command.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
    command.add_argument(
        "--dump", type=path, metavar="DIR", help="write the state after every pass, as YAML"
    )


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
        command.add_argument(flag, **more)


def add_texts(command: argparse.ArgumentParser) -> None:
    """The texts of the fields of ``Config``, as help of the options that set the fields.

    Without these texts, a process that converts Cassie takes three quarters of the time.
    """
    docs = field_docs(Config)
    for action in command._actions:
        if action.help in docs:
            action.help = docs[action.help].replace("%", "%%")


def add_levels(command: argparse.ArgumentParser) -> None:
    """For what reads a robot, and may warn of it."""
    command.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )
    add_fields(command, "diagnostics", "strict")


def add_running(command: argparse.ArgumentParser) -> None:
    """For what runs passes, by a config or by what stands for one."""
    add_no_plugins(command)
    add_levels(command)
    add_fields(command, "trust_xacro", "passes")


def add_trust(command: argparse.ArgumentParser) -> None:
    add_fields(command, "trust_xacro")


def add_base(command: argparse.ArgumentParser) -> None:
    add_fields(command, "base")


def add_robot(command: argparse.ArgumentParser) -> None:
    """What a robot needs to be read."""
    add_fields(command, "packages", "xacro_args")


def add_settings(command: argparse.ArgumentParser) -> None:
    """What a config says, for a robot without one."""
    add_fields(command, *ALONE)


def add_many(command: argparse.ArgumentParser) -> None:
    many = command.add_argument_group("many robots")
    many.add_argument("--workers", type=int, metavar="N", help="processes (default: every core)")
    many.add_argument("--cluster", metavar="ADDRESS", help="of a Dask scheduler to use instead")
    many.add_argument(
        "--report", type=path, metavar="FILE.json",
        help=f"default: {REPORT} in the folder that all outputs are in",
    )  # fmt: skip


def add_model(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "model", type=path, metavar="MODEL.mbs", help="of urdf2mbs, or drawn by hand"
    )
