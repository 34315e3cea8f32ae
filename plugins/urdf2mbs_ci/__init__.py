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
    """Add the pass ``find-faults``."""
    # There is no preset "lint", so no preset gets the pass: `lint` and configs add it.
    after = ("expand", "snap", "estimate-inertia")
    return [PassEntry("find-faults", "urdf2mbs_ci", after, presets=("lint",))]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Add the command ``lint``."""
    summary = "list the faults of a robot, without converting it"
    return [Command("lint", summary, "urdf2mbs_ci.commands.lint")]


@hookimpl
def urdf2mbs_options(command: str, parser: argparse.ArgumentParser) -> None:
    """Add options to ``verify``."""
    if command == "verify":
        from urdf2mbs_ci.findings import add_options

        add_options(parser)


@hookimpl
def urdf2mbs_observe_verify(
    robot: str, arguments: argparse.Namespace
) -> AbstractContextManager[Callable[[Any], bool]]:
    """Collect the findings of ``verify``."""
    from urdf2mbs_ci.findings import observe_verify

    return observe_verify(robot, arguments)
