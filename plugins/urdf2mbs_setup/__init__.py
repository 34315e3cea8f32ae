"""Help to set up urdf2mbs and to write plugins: versions, schema, new passes, dumps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, hookimpl

if TYPE_CHECKING:
    import argparse


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    """Add ``--dump`` to ``run`` and ``convert``."""
    if command in ("run", "convert"):
        from urdf2mbs.plugin import path

        summary = "write the state after every pass, as YAML"
        parser.add_argument("--dump", type=path, metavar="DIR", help=summary)


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> object | None:
    """Return the observer that ``--dump`` asks for."""
    if arguments.dump is None:
        return None
    from urdf2mbs_setup.dump import Dump

    return Dump(arguments.dump, force=arguments.force)


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Add the commands."""
    summaries = {
        "explain": "show the passes of a config, or every known pass, without running them",
        "new-pass": "write a plugin with one pass, and its test",
        "new-plugin": "write a package with a pass, a preset, tests and checks for GitHub",
        "schema": "print the JSON schema of a config, for editors",
        "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
    }
    return [
        Command(command_name, summary, f"urdf2mbs_setup.commands.{command_name.replace('-', '_')}")
        for command_name, summary in summaries.items()
    ]


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of messages and their meanings."""
    from urdf2mbs_setup.codes import CODES

    return CODES
