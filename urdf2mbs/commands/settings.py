"""What the words of a command line say of a conversion: a config, or what stands for one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.config import Config, Lines, load, typed
from urdf2mbs.files import is_folder
from urdf2mbs.urdf import descriptions, standard_input


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
