"""How much each thing that is said weighs: the user's choice, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and what is ignored
is not said at all.
"""

from __future__ import annotations

from typing import Any

import msgspec

from urdf2mbs.config.model import Config
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic


def weigh(diagnostics: list[Diagnostic], config: Config) -> list[Diagnostic]:
    """The same diagnostics at the user's levels, without those that are ignored.

    Strict makes warnings errors, except those whose level is set.
    """
    weighed = []
    for diagnostic in diagnostics:
        strict = config.strict and diagnostic.level == "warning"
        level: Any = config.diagnostics.get(
            diagnostic.code, "error" if strict else diagnostic.level
        )
        if level == diagnostic.level:
            weighed.append(diagnostic)
        elif level != "ignore":
            # a hint never recommends what is already set
            hint = None if "--level" in (diagnostic.hint or "") else diagnostic.hint
            weighed.append(msgspec.structs.replace(diagnostic, level=level, hint=hint))
    return weighed


def judge(diagnostics: list[Diagnostic]) -> None:
    """Raise ConversionError if there is an error among diagnostics at the user's levels."""
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.level == "error"]
    if errors:
        *before, last = errors
        error = ConversionError(
            last.code, last.message, file=last.file, line=last.line, hint=last.hint
        )
        error.said = before
        raise error
