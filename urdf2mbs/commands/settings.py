"""What the words of a command line say of a conversion: a config, or what stands for one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.config import Config, Lines, load, typed
from urdf2mbs.files import is_folder
from urdf2mbs.urdf import descriptions, standard_input

BASES = ("auto", "floating", "fixed")

#: The name of the report of many robots.
REPORT = "urdf2mbs-report.json"


def configured(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config file, with what the command line changes of it."""
    config, lines = load(file)
    given = typed(Config, {"source": config.source, **levels(arguments)}, Lines())
    config.diagnostics = {**config.diagnostics, **given.diagnostics}
    config.strict = config.strict or given.strict
    config.trust_xacro = config.trust_xacro or arguments.trust_xacro
    passes = dict(config.passes)
    for name, options in _options(arguments).items():
        passes[name] = {**(passes.get(name) or {}), **options}
    config.passes = passes
    return config, lines


def levels(arguments: argparse.Namespace) -> dict[str, Any]:
    """How much warnings weigh, as a config says it."""
    weighed = pairs(arguments.level, "=", "--level", "CODE=LEVEL")
    return {"diagnostics": dict(weighed), "strict": arguments.strict}


def _options(arguments: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """What ``--set`` says, by passes."""
    options: dict[str, dict[str, Any]] = {}
    for key, value in pairs(arguments.set, "=", "--set", "PASS.OPTION=VALUE"):
        pass_, dot, option = key.rpartition(".")
        if not dot:
            raise ConfigError("usage", f"--set {key}={value}: it reads PASS.OPTION=VALUE")
        from urdf2mbs.engine.yaml_text import word

        options.setdefault(pass_, {})[option] = word(value)
    return options


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config that the command line stands for."""
    if robot == "-":
        robot = standard_input.take()
    after: dict[str, list[str]] = {}
    for pass_, new in pairs(arguments.after, "=", "--after", "PASS=NEW"):
        after.setdefault(pass_, []).append(new)
    given = {
        "source": robot,
        "output": output,
        "base": arguments.base or "auto",
        "packages": dict(pairs(arguments.package, "=", "--package", "NAME=DIR")),
        "xacro_args": dict(pairs(arguments.arg, ":=", "--arg", "NAME:=VALUE")),
        "pipeline": arguments.pipeline or "faithful",
        "plugins": arguments.plugin,
        "after": after,
        "passes": _options(arguments),
        "trust_xacro": arguments.trust_xacro,
        **levels(arguments),
    }
    lines = Lines()
    return typed(Config, given, lines), lines


def robot_or_config(arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config is told from a robot by the file's ending."""
    file: Path = arguments.config
    if str(file) == "-" or str(file).startswith(descriptions.PREFIX):
        return without_config(str(file), None, arguments)
    if file.suffix.lower() not in (".yaml", ".yml", "") and not is_folder(file):
        return without_config(str(file), None, arguments)
    for name in ("base", "package", "arg", "pipeline", "plugin", "after"):
        if getattr(arguments, name):
            raise ConfigError(
                "usage", f"--{name} is for a robot without a config",
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


def add_levels(command: argparse.ArgumentParser) -> None:
    """For what reads a robot, and may warn of it."""
    command.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )
    command.add_argument(
        "--level", action="append", default=[], metavar="CODE=LEVEL",
        help="how much a warning weighs: error, warning, note or ignore",
    )  # fmt: skip
    command.add_argument("--strict", action="store_true", help="warnings are errors")


def add_running(command: argparse.ArgumentParser) -> None:
    """For what runs passes, by a config or by what stands for one."""
    add_no_plugins(command)
    add_levels(command)
    add_trust(command)
    command.add_argument(
        "--set", action="append", default=[], metavar="PASS.OPTION=VALUE", help="option of a pass"
    )


def add_trust(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--trust-xacro", action="store_true",
        help="let the robot's xacro do whatever Python can, and read any file",
    )  # fmt: skip


def add_base(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--base", choices=BASES,
        help="whether the base floats (default: auto, as the URDF ties it)",
    )  # fmt: skip


def add_robot(command: argparse.ArgumentParser) -> None:
    """What a robot needs to be read."""
    command.add_argument(
        "--package", action="append", default=[], metavar="NAME=DIR", help="where a package is"
    )
    command.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )


def add_settings(command: argparse.ArgumentParser) -> None:
    """What a config says, for a robot without one."""
    add_base(command)
    add_robot(command)
    command.add_argument("--pipeline", metavar="PRESET", help="default: faithful")
    add_plugin(command)
    command.add_argument(
        "--after", action="append", default=[], metavar="PASS=NEW", help="put NEW after PASS"
    )


def add_plugin(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--plugin", action="append", default=[], metavar="FILE.py", help="a plugin to load"
    )


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
