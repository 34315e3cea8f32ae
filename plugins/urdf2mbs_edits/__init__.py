"""What people change in an .mbs is kept: diff, merge, and the merge driver of git."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, PassEntry, always, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Summary


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry("merge", "urdf2mbs_edits", after=("emit",), work=always)]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    package = "urdf2mbs_edits.commands"
    return [
        Command("diff", "list the differences between two .mbs files", f"{package}.diff"),
        Command("merge", "merge three versions of an .mbs file, for git", f"{package}.merge"),
    ]


@hookimpl
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    if "merge" not in conversion.report:
        return None
    from urdf2mbs.plugin import Summary

    counts = {does: len(said) for does, said in conversion.report["merge"]["words"].items()}
    words = ", ".join(f"{count} {does}" for does, count in counts.items() if count)
    return Summary([f"merged with your edits: {words or 'nothing is another'}"])


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_edits.codes import CODES

    return CODES
