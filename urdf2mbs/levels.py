"""How much each thing that is said weighs: the user's choice, as in a linter.

An error stops the conversion, a warning is shown, a note is shown on demand, and what is ignored
is not said at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from urdf2mbs.diagnostics import ConversionError, Diagnostic

Level = Literal["error", "warning", "note", "ignore"]


class Levels(msgspec.Struct, frozen=True):
    """The levels that the user has set."""

    by_code: Mapping[str, Level] = {}
    strict: bool = False
    """Warnings are errors, except those whose level is set."""

    def applied(self, said: list[Diagnostic]) -> list[Diagnostic]:
        """The same diagnostics at the user's levels, without those that are ignored."""
        if not self.by_code and not self.strict:
            return said
        out = []
        for one in said:
            level: Any = self.by_code.get(one.code)
            if level is None:
                level = "error" if self.strict and one.level == "warning" else one.level
            if level == one.level:
                out.append(one)
            elif level != "ignore":
                # a hint never recommends what is already set
                hint = None if one.hint and "--level" in one.hint else one.hint
                out.append(msgspec.structs.replace(one, level=level, hint=hint))
        return out

    def judge(self, said: list[Diagnostic]) -> None:
        """Raise ConversionError if there is an error among diagnostics at the user's levels."""
        errors = [one for one in said if one.level == "error"]
        if errors:
            *before, last = errors
            error = ConversionError(
                last.code, last.message, file=last.file, line=last.line, hint=last.hint
            )
            error.said = before
            raise error
