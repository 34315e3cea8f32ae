"""The levels of messages: the user's choice for each code, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and an ignored message
is dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic

if TYPE_CHECKING:
    from urdf2mbs.engine.plugins import Plugins


def apply_levels(
    diagnostics: list[Diagnostic], config: Config, plugins: Plugins
) -> list[Diagnostic]:
    """Return the diagnostics at the user's levels, without those that are ignored.

    Strict makes warnings errors, except those whose level is set.  A warning without a hint gets
    the second sentence of the meaning of its code.
    """
    leveled_diagnostics: list[Diagnostic] = []
    for diagnostic in diagnostics:
        strict = config.strict and diagnostic.level == "warning"
        default_level = "error" if strict else diagnostic.level
        user_level: Any = config.diagnostics.get(diagnostic.code, default_level)
        hint = diagnostic.hint
        if diagnostic.level == "warning" and hint is None:
            _, _, remedy = plugins.codes.get(diagnostic.code, "").partition(". ")
            hint = (remedy[:1].lower() + remedy[1:].rstrip(".")).replace("`", "'") or None
        if user_level != diagnostic.level and "--level" in (hint or ""):
            hint = None  # a hint never recommends a level that is set already
        if user_level != "ignore":
            leveled_diagnostics.append(
                msgspec.structs.replace(diagnostic, level=user_level, hint=hint)
            )
    return leveled_diagnostics


def raise_errors(diagnostics: list[Diagnostic]) -> None:
    """Raise ConversionError if there is an error among diagnostics at the user's levels."""
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.level == "error"]
    if errors:
        *earlier, last = errors
        error = ConversionError(
            last.code, last.message, file=last.file, line=last.line, hint=last.hint
        )
        error.earlier = earlier
        raise error
