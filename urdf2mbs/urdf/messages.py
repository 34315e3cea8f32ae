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
#: So many errors of one file are told together.
MAX_ERRORS = 20


class _Group(msgspec.Struct):
    """Warnings of one kind, said once for all the elements they are about."""

    level: Literal["error", "warning", "note"]
    line: int | None
    hint: str | None
    owners: dict[tuple[str, str], str] = {}
    """Kind and name of each element, and what the message adds for it alone."""


class Messages:
    """All that is said about one file, and which element of it is being read."""

    def __init__(self, file: str, expanded: Sequence[str]) -> None:
        self.file = file
        self.expanded = expanded
        """The files from which xacro has written the text that is read."""
        self.groups: dict[tuple[str, str], _Group] = {}
        self.errors: list[Diagnostic] = []
        """All errors but the last."""
        self.last: ConversionError | None = None
        self.owner = ("robot", "")
        """Kind and name of the element being read, for messages."""

    @property
    def where(self) -> str:
        kind, name = self.owner
        return f"{kind} '{name}'" if name else f"<{kind}>"

    def fail(
        self, code: str, message: str, element: Any = None, hint: str | None = None
    ) -> NoReturn:
        line = element if element is None or isinstance(element, int) else element.sourceline
        if self.expanded:
            made = (
                f"it is line {line} of the text that xacro made: 'urdf2mbs convert --dump DIR' "
                "writes it, as DIR/expanded.urdf"
            )
            place = written.find_declaration(*self.owner, self.expanded)
            at = f"{self.where} is in {place[0]}:{place[1]}" if place else None
            hint = "; ".join(filter(None, [hint, at, made]))
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)

    def keep(self, error: ConversionError) -> None:
        """Go on after an error, so that those that follow are told with it."""
        if self.last is not None:
            self.errors.append(self.last.diagnostic())
        self.last = error
        if len(self.errors) + 1 == MAX_ERRORS:
            more = f"these are the first {MAX_ERRORS} errors: there may be more"
            error.hint = f"{error.hint}; {more}" if error.hint else more
            raise error

    def warn(
        self, code: str, message: str, line: int | None, *, hint: str | None = None,
        like: tuple[str, Iterable[str]] | None = None, owner: tuple[str, str] | None = None,
        level: Literal["error", "warning", "note"] = "warning", detail: str = "",
    ) -> None:  # fmt: skip
        """The same message about several links or joints is said once, with their names.

        ``like``: a wrong name and the right ones, the nearest of which is offered; ``detail``:
        what differs from one link or joint to the next.
        """
        group = self.groups.get((code, message))
        if group is None:
            if like is not None:
                hint = nearest(like[0], sorted(like[1]))
            group = self.groups[code, message] = _Group(level, line, hint)
        owner = owner or self.owner
        before = group.owners.get(owner, "")
        details = dict.fromkeys(filter(None, [*before.split("; "), detail]))
        group.owners[owner] = "; ".join(details)

    def diagnostics(self) -> list[Diagnostic]:
        said = []
        for (code, message), group in self.groups.items():
            owners = list(group.owners)
            kind, name = owners[0]
            elements = (
                f"{kind} '{name}'" + (f" ({detail})" if detail else "")
                for (kind, name), detail in group.owners.items()
                if name
            )
            names = some(elements, _NAMES_SHOWN)
            text = f"{message}: {names}" if names else message
            only = {kind: name} if len(owners) == 1 else {}
            place = written.locate(kind, name, self.expanded, self.file, group.line)
            link, joint = only.get("link"), only.get("joint")
            said.append(Diagnostic(group.level, code, text, link, joint, *place, group.hint))
        return said
