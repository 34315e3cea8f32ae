"""For the pages of a CI: ``lint``, and findings as SARIF."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import Command, PassEntry, hookimpl

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable
    from contextlib import AbstractContextManager


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    # no preset is called so, and none gets the pass: 'lint' and configs put it in
    after = ("expand", "snap", "estimate-inertia")
    return [PassEntry("find-faults", "urdf2mbs_ci", after, presets=("lint",))]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "list the faults of a robot, without converting it"
    return [Command("lint", does, "urdf2mbs_ci.commands.lint")]


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    if command == "verify":
        from urdf2mbs_ci.findings import add_options

        add_options(parser)


@hookimpl
def urdf2mbs_observe_verify(
    robot: str, arguments: argparse.Namespace
) -> AbstractContextManager[Callable[[Any], bool]]:
    from urdf2mbs_ci.findings import observe_verify

    return observe_verify(robot, arguments)
