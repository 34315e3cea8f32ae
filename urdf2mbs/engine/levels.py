"""How much each thing that is said weighs: the user's choice, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and what is ignored
is not said at all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic

if TYPE_CHECKING:
    from urdf2mbs.engine.plugins import Plugins


def weigh(diagnostics: list[Diagnostic], config: Config, plugins: Plugins) -> list[Diagnostic]:
    """The same diagnostics at the user's levels, without those that are ignored.

    Strict makes warnings errors, except those whose level is set.  A warning without a hint gets
    what the meaning of its code says to do.
    """
    weighed = []
    for said in diagnostics:
        strict = config.strict and said.level == "warning"
        level: Any = config.diagnostics.get(said.code, "error" if strict else said.level)
        hint = said.hint
        if said.level == "warning" and hint is None:
            _, _, does = plugins.codes.get(said.code, "").partition(". ")
            hint = (does[:1].lower() + does[1:].rstrip(".")).replace("`", "'") or None
        if level != said.level and "--level" in (hint or ""):
            hint = None  # a hint never recommends what is already set
        if level != "ignore":
            weighed.append(msgspec.structs.replace(said, level=level, hint=hint))
    return weighed


def judge(diagnostics: list[Diagnostic]) -> None:
    """Raise ConversionError if there is an error among diagnostics at the user's levels."""
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.level == "error"]
    if errors:
        *before, last = errors
        error = ConversionError(
            last.code, last.message, file=last.file, line=last.line, hint=last.hint
        )
        error.earlier = before
        raise error
