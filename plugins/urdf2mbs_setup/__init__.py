"""What helps to set up and to write plugins: versions, schema, completion, new passes, dumps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, hookimpl

if TYPE_CHECKING:
    import argparse


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    if command in ("run", "convert"):
        from urdf2mbs.plugin import path

        does = "write the state after every pass, as YAML"
        parser.add_argument("--dump", type=path, metavar="DIR", help=does)


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> object | None:
    if arguments.dump is None:
        return None
    from urdf2mbs_setup.dump import Dump

    return Dump(arguments.dump, force=arguments.force)


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    sentences = {
        "explain": "show the passes of a config, or every known pass, without running them",
        "new-pass": "write a plugin with one pass, and its test",
        "new-plugin": "write a package with a pass, a preset, tests and checks for GitHub",
        "schema": "print the JSON schema of a config, for editors",
        "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
        "completion": "print a script that completes commands and options in a shell",
    }
    return [
        Command(name, does, f"urdf2mbs_setup.commands.{name.replace('-', '_')}")
        for name, does in sentences.items()
    ]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_setup.codes import CODES

    return CODES
