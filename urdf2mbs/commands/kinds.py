"""What a file on the command line is; for one of another kind, the command that takes it."""

from __future__ import annotations

import argparse
import os
import re
from pathlib import Path
from typing import Literal

from urdf2mbs.commands.printing import near
from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, counted
from urdf2mbs.urdf import macros
from urdf2mbs.urdf.reader import is_name

Kind = Literal["robot", "config", "model", "project", "folder"]

_CALLED: dict[Kind, str] = {
    "robot": "a robot",
    "config": "a config",
    "model": "a model (.mbs)",
    "project": "the folder of a Robotran project",
    "folder": "a folder",
}
#: The commands that take a kind, the best one first, and what they do with it.
_COMMANDS: dict[Kind, dict[str, str]] = {
    "robot": {"convert": "converts it", "init": "writes a config for it"},
    "config": {"run": "converts its robot", "report": "shows it"},
    "model": {"report": "shows it", "simulate": "simulates it"},
    "project": {"report": "shows its model", "simulate": "simulates it"},
}
#: Endings of files that are no .mbs, no page and no picture, whatever a command writes.
_ENDINGS = (".csv", ".html", ".json", ".mbs", ".svg", ".txt", ".urdf", ".xacro", ".yaml", ".yml")
#: The beginning of a file in which its kind is searched (bytes).
_N_BYTES = 4096


def find_kind(file: Path) -> Kind | None:
    """Return the kind of a file or folder, by what it contains and by its ending.

    None: it can be anything, such as a file without an ending that does not exist.
    """
    if files.is_folder(file):
        return "project" if files.list_models(file) else "folder"
    ending = file.suffix.lower()
    beginning = files.read_beginning(file, _N_BYTES) if files.is_file(file) else b""
    if ending == ".mbs" or b"<mbsDescR7" in beginning:
        return "model"
    if ending in (".urdf", ".xacro") or beginning.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return "robot"
    return "config" if ending in (".yaml", ".yml") else None


def check_kind(file: Path, arguments: argparse.Namespace, *expected: Kind) -> Kind | None:
    """Return the kind of a file that a command line names; None if it is not known.

    Args:
        file: The file; a robot may be a name, or - for standard input.
        arguments: The options of the command.
        expected: The kinds that the command takes.

    Raises:
        ConfigError: ``usage``, the command takes no file of this kind.  The hint is a command that
            does.
    """
    if str(file) == "-" or is_name(str(file)):
        return "robot"
    kind = find_kind(file)
    is_there = files.is_file(file) or files.is_folder(file)  # a file that is not is read in vain
    if kind is None or kind in expected or not is_there:
        return kind
    *called, last = [_CALLED[each] for each in expected if each != "folder"]
    choices = f"{', '.join(called)} or {last}" if called else last
    message = f"'{arguments.command}' expects {choices}, got {_CALLED[kind]}"
    hint = _propose_command(file, kind, arguments.command, expected)
    raise ConfigError("usage", message, file=str(file), hint=hint)


def find_model(file: Path, arguments: argparse.Namespace, *others: Kind) -> Path | None:
    """Return the model that a command line names; None: it names something else.

    Args:
        file: An .mbs, the folder of a project, or something else.
        arguments: The options of the command.
        others: The kinds, beside these two, that the command takes.

    Raises:
        ConfigError: ``usage``, the command takes no file of this kind; ``project-unknown``, the
            project has several models.
    """
    kind = check_kind(file, arguments, *others, "model", "project")
    if kind != "project":
        return None if kind in others or kind is None else file
    model, *more = files.list_models(file)
    if more:
        message = f"the project '{file}' has {1 + len(more)} models; expected 1"
        hint = f"name one: {_write_command(arguments.command, model)}"
        raise ConfigError("project-unknown", message, hint=hint)
    return model


def propose_in_folder(folder: Path, command: str, *expected: Kind) -> str:
    """Return what to do with a folder: a command that takes a file in it.

    Args:
        folder: The folder.
        command: The command that was given the folder.
        expected: The kinds that it takes; others are proposed only if it has none of these.
    """
    contents = _list_contents(folder)
    preferred: tuple[Kind, ...] = (*expected, "config", "robot", "model")
    kinds = [kind for kind in preferred if kind in contents]
    if not kinds:
        return "it has nothing to convert and nothing to show: name another folder, or a file"
    kind = kinds[0]
    count = counted(len(contents[kind]), kind)
    if kind not in expected:
        command = next(iter(_list_commands(kind)), command)
    such = "" if len(contents[kind]) == 1 else ", such as"
    return f"it contains {count}{such}: {_write_command(command, contents[kind][0])}"


def check_ending(output: Path | None, ending: str) -> None:
    """Raise an error if an output has the ending of another kind of file.

    Args:
        output: The output; None: the default.
        ending: The ending that is expected, such as ``.svg``.
    """
    given_ending = output.suffix.lower() if output is not None else ending
    if output is not None and given_ending in _ENDINGS and given_ending != ending:
        message = f"--output: '{output}' ends in {given_ending}; expected {ending}"
        raise ConfigError("usage", message, hint=f"-o {_quote(output.with_suffix(ending))}")


def _propose_command(file: Path, kind: Kind, command: str, expected: tuple[Kind, ...]) -> str:
    """Return a command that takes a file which another command does not take."""
    if kind in ("project", "folder") and "config" in expected:
        configs = [file.with_name(f"{file.name}{ending}") for ending in (".yaml", ".yml")]
        for config in filter(files.is_file, configs if file.name else ()):
            return f"did you mean its config? {_write_command(command, config)}"
    if kind == "folder":
        return propose_in_folder(file, command, *expected)
    if kind == "robot" and (advice := _propose_caller(file)):
        return advice
    return "; ".join(
        f"{_write_command(name, file)} {does}" for name, does in _list_commands(kind).items()
    )


def _list_commands(kind: Kind) -> dict[str, str]:
    """Return the installed commands that take a kind of file, and what they do with it."""
    from urdf2mbs.commands import list_commands

    installed = list_commands()
    return {name: does for name, does in _COMMANDS[kind].items() if name in installed}


def _propose_caller(robot: Path) -> str | None:
    """Return what to do with a file that only defines macros of xacro; None for a robot."""
    if robot.suffix.lower() != ".xacro" or macros.is_robot_file(robot):
        return None
    from urdf2mbs.urdf import xml

    try:
        xml_root, _ = xml.parse(files.read_bytes(robot), str(robot))
    except (OSError, ConversionError):
        return None
    if not macros.list_uncalled_macros(xml_root):
        return None
    return f"it only defines macros: {macros.propose_caller(robot.absolute(), xml_root)}"


def _list_contents(folder: Path) -> dict[Kind, list[Path]]:
    """Return the robots, configs and models in a folder and below it, by their kinds."""
    contents: dict[Kind, list[Path]] = {}
    for file in files.list_files(folder, macros.MAX_FILES):
        ending = file.suffix.lower()
        kind: Kind
        if macros.is_robot_file(file):
            kind = "robot"
        elif ending == ".mbs" and files.is_model_name(file.name):
            kind = "model"
        elif ending in (".yaml", ".yml") and _names_source(file):
            kind = "config"
        else:
            continue
        contents.setdefault(kind, []).append(file)
    return contents


def _names_source(file: Path) -> bool:
    """Return whether a YAML file is a config: one of its lines begins with ``source:``."""
    return re.search(rb"(?m)^source\s*:", files.read_beginning(file, _N_BYTES)) is not None


def _write_command(command: str, file: Path) -> str:
    return f"urdf2mbs {command} {_quote(file)}"


def _quote(file: Path) -> str:
    """Return the name of a file as the user's shell reads it."""
    name = near(file)
    if os.name == "nt":
        from subprocess import list2cmdline

        return list2cmdline([name])
    from shlex import quote

    return quote(name)
