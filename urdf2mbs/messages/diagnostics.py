"""Messages for the user: errors, warnings and notes.

Each has a stable code, says where it is about (file and line, link or joint) and what to do::

    robot.urdf:7: error[code]: joint 'knee': what is wrong
      what to do
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
        self,
        code: str,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        hint: str | None = None,
    ) -> None:
        self.code = code
        self.message = message
        self.file = file
        self.line = line
        self.hint = hint
        self.earlier: list[Diagnostic] = []
        """The messages about the same robot before this error."""

    def diagnostic(self) -> Diagnostic:
        """Return the error as a diagnostic, such as one of the ``earlier`` of another error."""
        return Diagnostic(
            "error", self.code, self.message, file=self.file, line=self.line, hint=self.hint
        )

    def __str__(self) -> str:
        """Format all errors, in the order in which they were found."""
        errors = [diagnostic for diagnostic in self.earlier if diagnostic.level == "error"]
        return "\n".join(map(str, [*errors, self.diagnostic()]))


class ConfigError(ConversionError):
    """The command line, the config or a plugin is wrong (exit code 2)."""

    exit_code = 2


def memory_full_error(subject: str) -> ConversionError:
    """Return the error to raise in place of a MemoryError.

    Args:
        subject: The subject of the message, such as "this command".
    """
    message = f"{subject} takes more memory than there is"
    hint = "is a file, or a number in one, far too large? Else give the process more memory"
    return ConversionError("memory-full", message, hint=hint)


def not_installed(who: str, package: str) -> ConfigError:
    """Return the error for a package that is not installed.

    Args:
        who: The subject of the message, which needs the package.
        package: Its name for pip.
    """
    message = f"{who} needs the package '{package}', which is not installed"
    return ConfigError("extra-missing", message, hint=f"pip install {package}")


class Diagnostic(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error, a warning or a note about a robot.

    * error: the conversion stops, unless the user lowers the level; the result is defined then;
    * warning: the .mbs does not have something of the robot as a user would expect;
    * note: a decision of the program.
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
        """Format ``file:line: level[code]: message``, and below it the hint."""
        location = ""
        if self.file:
            location = f"{self.file}:{self.line}: " if self.line else f"{self.file}: "
        formatted = f"{location}{self.level}[{self.code}]: {self.message}"
        return _shorten_lines(f"{formatted}\n  {self.hint}" if self.hint else formatted)


#: Characters that a terminal acts on: controls, and those that turn the direction of writing.
_CONTROLS = r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]"
#: Longer lines of a message are cut in the middle (characters).
_MAX_LINE_LENGTH = 2000
#: A line break that is not followed by two blanks is part of a name.
_LINE_BREAK_IN_NAME = r"\n(?!  )"


def printable(text: str) -> str:
    r"""Escape the characters of a text that a terminal would act on, as ``\x1b``."""
    if text.replace("\n", "").isprintable():
        return text
    return re.sub(_CONTROLS, lambda match: match[0].encode("unicode_escape").decode(), text)


def _shorten_lines(message_text: str) -> str:
    """Make a message printable, and cut its long lines in the middle."""
    half_length = _MAX_LINE_LENGTH // 2
    lines = re.sub(_LINE_BREAK_IN_NAME, r"\\n", printable(message_text)).split("\n")
    return "\n".join(
        line if len(line) <= _MAX_LINE_LENGTH else f"{line[:half_length]} ... {line[-half_length:]}"
        for line in lines
    )


def quoted(text: str) -> str:
    r"""Escape what cannot be printed in a name, as ``\n``, ``\x1b`` or ``\u202e``.

    So a name in generated code, between quotes or in a comment, stays a name on one line.  A
    backslash is doubled.
    """
    return "".join(
        character
        if character.isprintable() and character != "\\"
        else character.encode("unicode_escape").decode()
        for character in text
    )


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: ``1 joint``, ``2 joints``."""
    plural = {"body": "bodies", "mesh": "meshes", "inertia": "inertias"}.get(noun, f"{noun}s")
    return f"{number} {noun if number == 1 else plural}"


def some(names: Iterable[str], n_listed: int = 5) -> str:
    """List the first few of some names, and how many more there are."""
    names = list(names)
    n_more = len(names) - n_listed
    return ", ".join(names[:n_listed]) + (f" and {n_more} more" if n_more > 0 else "")


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return a hint with the candidate that is most like a wrong name; None if none is like it."""
    from difflib import get_close_matches

    matches = get_close_matches(name, list(candidates), n=1, cutoff=0.5)
    return f"did you mean '{matches[0]}'?" if matches else None
