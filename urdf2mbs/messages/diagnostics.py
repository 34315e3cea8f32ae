"""What is said to the person at the keyboard: errors, warnings and notes.

Each has a stable code, says where (file and line, link or joint) and what to do.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Literal

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable


class ConversionError(Exception):
    """This robot cannot be converted (exit code 1)."""

    exit_code = 1

    def __init__(
        self, code: str, message: str, *, file: str | None = None, line: int | None = None,
        hint: str | None = None,
    ) -> None:  # fmt: skip
        self.code = code
        self.message = message
        self.file = file
        self.line = line
        self.hint = hint
        self.earlier: list[Diagnostic] = []
        """What was found before, in the same robot."""

    def diagnostic(self) -> Diagnostic:
        """The same as one of several errors, to stand in the ``said`` of another."""
        return Diagnostic(
            "error", self.code, self.message, file=self.file, line=self.line, hint=self.hint
        )

    def __str__(self) -> str:
        """All errors, in the order in which they were found."""
        before = [str(said) for said in self.earlier if said.level == "error"]
        own = format_message("error", self.code, self.message, self.file, self.line, self.hint)
        return "\n".join([*before, own])


class ConfigError(ConversionError):
    """The command line, the config or a plugin is wrong (exit code 2)."""

    exit_code = 2


def memory_full_error(what: str) -> ConversionError:
    """The error for a MemoryError."""
    return ConversionError(
        "memory-full", f"{what} takes more memory than there is",
        hint="is a file, or a number in one, far too large? Else give the process more memory",
    )  # fmt: skip


def not_installed(what: str, package: str) -> ConfigError:
    """The error for a package that is an extra."""
    text = f"{what} needs the package '{package}', which is not installed"
    return ConfigError("extra-missing", text, hint=f"pip install {package}")


class Diagnostic(msgspec.Struct, frozen=True, omit_defaults=True):
    """A warning (something of the robot is not in the .mbs as a user would expect) or a note
    (a decision that the program took).

    An error among them stops the conversion, unless the user lowers its level: what happens
    then is defined.
    """

    level: Literal["error", "warning", "note"]
    code: str
    message: str
    link: str | None = None
    joint: str | None = None
    file: str | None = None
    line: int | None = None
    hint: str | None = None

    def __str__(self) -> str:
        return format_message(self.level, self.code, self.message, self.file, self.line, self.hint)


def format_message(
    level: str, code: str, message: str, file: str | None, line: int | None, hint: str | None
) -> str:
    """``file:line: error[code]: message`` and, on a line of its own, what to do."""
    where = f"{file}:{line}: " if file and line else f"{file}: " if file else ""
    text = f"{where}{level}[{code}]: {message}"
    return _shorten(f"{text}\n  {hint}" if hint else text)


#: Letters that a terminal acts on: controls, and those that turn the direction of writing.
_CONTROLS = r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]"
#: Longer lines of a message are cut in the middle.
_LONGEST = 2000
#: A line break without two blanks behind it belongs to a name.
_OTHER_LINE = r"\n(?!  )"


def printable(text: str) -> str:
    r"""A text in which nothing acts on a terminal: such letters are written as ``\x1b``."""
    if text.replace("\n", "").isprintable():
        return text
    return re.sub(_CONTROLS, lambda match: match[0].encode("unicode_escape").decode(), text)


def _shorten(text: str) -> str:
    """A message, with long lines cut in the middle."""
    lines = re.sub(_OTHER_LINE, r"\\n", printable(text)).split("\n")
    return "\n".join(
        line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"
        for line in lines
    )


def quoted(text: str) -> str:
    r"""A name on one line: what cannot be printed is written as ``\n``, ``\x1b``, ``\u202e``.

    So a name in generated code, between quotes or in a comment, stays a name.  A backslash is
    doubled.
    """
    return "".join(
        letter
        if letter.isprintable() and letter != "\\"
        else letter.encode("unicode_escape").decode()
        for letter in text
    )


def counted(number: int, thing: str) -> str:
    """``1 joint``, ``2 joints``."""
    plural = {"body": "bodies", "mesh": "meshes", "inertia": "inertias"}.get(thing, f"{thing}s")
    return f"{number} {thing if number == 1 else plural}"


def some(names: Iterable[str], shown: int = 5) -> str:
    """The first few of some names, and how many more there are."""
    names = list(names)
    more = len(names) - shown
    return ", ".join(names[:shown]) + (f" and {more} more" if more > 0 else "")


def nearest(name: str, known: Iterable[str]) -> str | None:
    """A sentence that offers the known name most like a wrong one, if any is like it."""
    from difflib import get_close_matches

    close = get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f"did you mean '{close[0]}'?" if close else None
