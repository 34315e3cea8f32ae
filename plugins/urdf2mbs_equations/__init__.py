"""Robotran's equations of motion, as files of a project's ``symbolicR``, for any .mbs model.

See ``docs/how-equations-are-made.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf2mbs.plugin import Command, PassEntry, hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Summary


def _has_work(conversion: Conversion, given: bool) -> bool:
    """Return True if equations are asked for, or those of an earlier model may exist."""
    settings = conversion.settings
    folder = settings.project or settings.output.parent
    return given or (folder / "symbolicR").is_dir()


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the pass ``equations``."""
    return [PassEntry("equations", "urdf2mbs_equations", after=("check",), work=_has_work)]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Return the command ``equations``."""
    description = "write Robotran's equations for an .mbs file or a robot"
    return [Command("equations", description, "urdf2mbs_equations.commands.equations")]


@hookimpl
def urdf2mbs_summary(conversion: Conversion, for_page: bool) -> Summary | None:
    """Return the next steps of a project, and on a page the formulas of a small robot."""
    if conversion.settings.project is None and not for_page:
        return None
    from urdf2mbs_equations.summary import summarize

    return summarize(conversion, for_page=for_page)


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of the plugin's diagnostics."""
    from urdf2mbs_equations.codes import CODES

    return CODES
