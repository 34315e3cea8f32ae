"""The messages about one URDF file: errors with their line, warnings about many links at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NoReturn

import msgspec

from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic, nearest, some
from urdf2mbs.urdf import written

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

#: A message about more links or joints than these says how many more there are.
_NAMES_SHOWN = 4
#: The most errors of one file that are reported together.
MAX_ERRORS = 20

Level = Literal["error", "warning", "note"]


class _MessageGroup(msgspec.Struct):
    """Equal messages about several elements, which become one."""

    level: Level
    line: int | None
    hint: str | None
    owners: dict[tuple[str, str], str] = {}
    """Kind and name of each element, and the detail that the message adds for it alone."""


class Messages:
    """The messages about one file, and the element of it that is being read."""

    def __init__(self, file: str, expanded: Sequence[str]) -> None:
        self.file = file
        self.expanded = expanded
        """The files from which xacro has made the text that is read."""
        self.groups: dict[tuple[str, str], _MessageGroup] = {}
        self.errors: list[Diagnostic] = []
        """All errors but the last."""
        self.last: ConversionError | None = None
        """The last error."""
        self.owner = ("robot", "")
        """Kind and name of the element being read, for messages."""

    @property
    def where(self) -> str:
        """The element being read, as messages name it: ``joint 'knee'``."""
        owner_kind, owner_name = self.owner
        return f"{owner_kind} '{owner_name}'" if owner_name else f"<{owner_kind}>"

    def fail(
        self, code: str, message: str, element: Any = None, hint: str | None = None
    ) -> NoReturn:
        """Raise the error about an element.

        Args:
            code: The code of the error.
            message: The fault, and the expected value.
            element: The element of lxml, or its line; None if it is not known.
            hint: What to do.

        Raises:
            ConversionError: Always.
        """
        line = element if element is None or isinstance(element, int) else element.sourceline
        if self.expanded:
            expanded_line = (
                f"it is line {line} of the text that xacro made: 'urdf2mbs convert --dump DIR' "
                "writes it, as DIR/expanded.urdf"
            )
            declaration = written.find_declaration(*self.owner, self.expanded)
            declared = (
                f"{self.where} is in {declaration[0]}:{declaration[1]}" if declaration else None
            )
            hint = "; ".join(filter(None, [hint, declared, expanded_line]))
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)

    def keep(self, error: ConversionError) -> None:
        """Keep an error, so that it is reported together with those that follow.

        Raises:
            ConversionError: The error, if it is number ``MAX_ERRORS``.
        """
        if self.last is not None:
            self.errors.append(self.last.diagnostic())
        self.last = error
        if len(self.errors) + 1 == MAX_ERRORS:
            limit_text = f"these are the first {MAX_ERRORS} errors: there may be more"
            error.hint = f"{error.hint}; {limit_text}" if error.hint else limit_text
            raise error

    def warn(
        self,
        code: str,
        message: str,
        line: int | None,
        *,
        hint: str | None = None,
        like: tuple[str, Iterable[str]] | None = None,
        owner: tuple[str, str] | None = None,
        level: Level = "warning",
        detail: str = "",
    ) -> None:
        """Add a warning; the same message about several elements becomes one, with their names.

        Args:
            code: The code of the warning.
            message: The text, which is the same for all elements that it is about.
            line: The line of the element.
            hint: What to do.
            like: A wrong name and the right ones; the hint offers the nearest of these.
            owner: Kind and name of the element; by default, the one being read.
            level: The level, if it is not a warning.
            detail: What differs from one element to the next, such as a number.
        """
        group = self.groups.get((code, message))
        if group is None:
            if like is not None:
                hint = nearest(like[0], sorted(like[1]))
            group = self.groups[code, message] = _MessageGroup(level, line, hint)
        owner = owner or self.owner
        previous_details = group.owners.get(owner, "")
        details = dict.fromkeys(filter(None, [*previous_details.split("; "), detail]))
        group.owners[owner] = "; ".join(details)

    def diagnostics(self) -> list[Diagnostic]:
        """Return all messages but the errors, each with the names of the elements it is about."""
        diagnostics = []
        for (code, message), group in self.groups.items():
            elements = (
                f"{owner_kind} '{owner_name}'" + (f" ({detail})" if detail else "")
                for (owner_kind, owner_name), detail in group.owners.items()
                if owner_name
            )
            element_names = some(elements, _NAMES_SHOWN)
            message_text = f"{message}: {element_names}" if element_names else message
            owner_kind, owner_name = next(iter(group.owners))
            owner_fields = {owner_kind: owner_name} if len(group.owners) == 1 else {}
            declaring_file, declared_line = written.locate(
                owner_kind, owner_name, self.expanded, self.file, group.line
            )
            diagnostics.append(
                Diagnostic(
                    group.level,
                    code,
                    message_text,
                    link=owner_fields.get("link"),
                    joint=owner_fields.get("joint"),
                    file=declaring_file,
                    line=declared_line,
                    hint=group.hint,
                )
            )
        return diagnostics
