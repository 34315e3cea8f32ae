"""What the words of a command line say of a conversion: a config, or what stands for one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.config import Config, Lines, load, typed, word
from urdf2mbs.files import is_folder
from urdf2mbs.urdf import descriptions, standard_input


class Parents(msgspec.Struct):
    """Options that several commands share."""

    common: argparse.ArgumentParser
    running: argparse.ArgumentParser
    levels: argparse.ArgumentParser


def shared_options() -> Parents:
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show the traceback of an error")
    common.add_argument("--no-plugins", action="store_true", help="leave out installed plugins")
    common.add_argument("--json", action="store_true", help="print the whole report as JSON")

    running = argparse.ArgumentParser(add_help=False)
    running.add_argument(
        "-v", "--verbose", action="store_true", help="show each pass and all notes"
    )
    running.add_argument("--stop-after", metavar="PASS", help="run the passes up to this one")
    running.add_argument(
        "--dump", type=Path, metavar="DIR", help="write the state after every pass, as YAML"
    )

    levels = argparse.ArgumentParser(add_help=False)
    levels.add_argument(
        "--level", action="append", default=[], metavar="CODE=LEVEL",
        help="how much a warning weighs: error, warning, note or ignore",
    )  # fmt: skip
    levels.add_argument("--strict", action="store_true", help="warnings are errors")
    levels.add_argument(
        "--no-cache", action="store_true", help="expand xacro anew, and do not keep it"
    )
    return Parents(common, running, levels)


def add_settings(command: argparse.ArgumentParser) -> None:
    """What a config says, for a robot without one."""
    command.add_argument("--base", choices=("auto", "floating", "fixed"))
    command.add_argument("--package", action="append", default=[], metavar="NAME=DIR")
    command.add_argument(
        "--arg", action="append", default=[], metavar="NAME:=VALUE", help="xacro argument"
    )
    command.add_argument("--pipeline", metavar="PRESET", help="default: faithful")
    command.add_argument("--plugin", action="append", default=[], metavar="FILE.py")
    command.add_argument(
        "--after", action="append", default=[], metavar="PASS=NEW", help="put NEW after PASS"
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="PASS.OPTION=VALUE", help="option of a pass"
    )


def configured(file: Path, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """A config file, with the levels of the command line."""
    return with_levels(*load(file), arguments)


def with_levels(
    config: Config, lines: Lines, arguments: argparse.Namespace
) -> tuple[Config, Lines]:
    given = typed(Config, {"source": config.source, **levels(arguments)}, Lines())
    config.diagnostics = {**config.diagnostics, **given.diagnostics}
    config.strict = config.strict or given.strict
    config.cache = config.cache and given.cache
    return config, lines


def levels(arguments: argparse.Namespace) -> dict[str, Any]:
    changed = pairs(arguments.level, "=", "--level", "CODE=LEVEL")
    return {
        "diagnostics": dict(changed), "strict": arguments.strict, "cache": not arguments.no_cache
    }  # fmt: skip


def without_config(robot: str, output: Any, arguments: argparse.Namespace) -> tuple[Config, Lines]:
    """The config that the command line stands for."""
    if robot == "-":
        robot = standard_input.take()
    options: dict[str, dict[str, Any]] = {}
    for key, value in pairs(arguments.set, "=", "--set", "PASS.OPTION=VALUE"):
        pass_, dot, option = key.rpartition(".")
        if not dot:
            raise ConfigError("usage", f"--set {key}={value}: it reads PASS.OPTION=VALUE")
        options.setdefault(pass_, {})[option] = word(value)
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
        "passes": options,
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
    for name in ("base", "package", "arg", "pipeline", "plugin", "after", "set"):
        if getattr(arguments, name):
            raise ConfigError(
                "usage", f"--{name} is for a robot without a config",
                hint=f"write it in '{file}', or name the .urdf or .xacro file instead",
            )  # fmt: skip
    return load(file)


def pairs(words: list[str], sign: str, flag: str, form: str) -> list[tuple[str, str]]:
    pairs = []
    for given in words:
        name, found, value = given.partition(sign)
        if not found or not name:
            raise ConfigError("usage", f"{flag} {given}: it reads {flag} {form}")
        pairs.append((name, value))
    return pairs
