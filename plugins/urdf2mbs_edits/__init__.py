"""Keep the edits of an .mbs: diff, merge, and the merge driver of git."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, PassEntry, always, hookimpl

if TYPE_CHECKING:
    import argparse

    from urdf2mbs.plugin import Conversion, Summary


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Add the pass ``merge``."""
    return [PassEntry("merge", "urdf2mbs_edits", after=("emit",), work=always)]


@hookimpl
def urdf2mbs_observe(arguments: argparse.Namespace) -> object | None:
    """Return the observer that lists the changes of a file for ``--plan``."""
    if not arguments.plan:
        return None
    from urdf2mbs_edits.passes.merge import PlannedChanges

    return PlannedChanges()


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Add the commands ``diff`` and ``merge``."""
    package = "urdf2mbs_edits.commands"
    return [
        Command("diff", "list the differences between two .mbs files", f"{package}.diff"),
        Command("merge", "merge three versions of an .mbs file, for git", f"{package}.merge"),
    ]


@hookimpl
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    """Return the line of the summary for a merge."""
    if "merge" not in conversion.report:
        return None
    from urdf2mbs.plugin import Summary

    counts = {
        heading: len(sentences)
        for heading, sentences in conversion.report["merge"]["words"].items()
    }
    text = ", ".join(f"{count} {heading}" for heading, count in counts.items() if count)
    return Summary([f"merged with your edits: {text or 'no change'}"])


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of messages and their meanings."""
    from urdf2mbs_edits.codes import CODES

    return CODES
