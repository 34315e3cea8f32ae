"""Robotran's equations of motion, as files of a project's ``symbolicR``, for any .mbs model.

See ``docs/how-equations-are-made.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Summary


def _are_there(conversion: Conversion, given: bool) -> bool:
    """True if equations are asked for, or those of an earlier model may be there."""
    settings = conversion.settings
    folder = settings.project or settings.output.parent
    return given or (folder / "symbolicR").is_dir()


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    return [PassEntry("equations", "urdf2mbs_equations", after=("check",), work=_are_there)]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "write Robotran's equations for an .mbs file"
    return [Command("equations", does, "urdf2mbs_equations.commands.equations")]


@hookimpl
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    if conversion.settings.project is None:
        return None
    from urdf2mbs_equations.summary import summarize

    return summarize(conversion)


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_equations.codes import CODES

    return CODES
