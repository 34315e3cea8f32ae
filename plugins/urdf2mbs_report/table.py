"""Tables of the report as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TypeAlias


class Html(str):
    """Text that is HTML already."""


Cell: TypeAlias = "str | float | Sequence[float | None] | Html | None"
"""A text, a number, numbers, HTML, or nothing."""
Row: TypeAlias = "tuple[dict[str, str], Sequence[Cell]]"
"""The attributes of a row, and its cells."""


def table(
    head: Iterable[str], rows: Iterable[Row], right: Iterable[int] = (), foot: Sequence[Cell] = ()
) -> str:
    """A table; ``right`` are columns of numbers."""
    numeric = set(right)

    def line(tag: str, cells: Iterable[Cell]) -> str:
        return "".join(
            f"<{tag}{' class=n' * (index in numeric)}>{_html(cell)}</{tag}>"
            for index, cell in enumerate(cells)
        )

    body = "\n".join(f"<tr{_attributes(about)}>{line('td', cells)}</tr>" for about, cells in rows)
    tail = f"<tfoot><tr>{line('td', foot)}</tr></tfoot>" if foot else ""
    return (
        f'<div class="scroll" tabindex="0"><table><thead><tr>{line("th", head)}</tr></thead>'
        f"<tbody>\n{body}\n</tbody>{tail}</table></div>"
    )


def titled(title: str, head: Iterable[str], rows: Sequence[Row], right: Iterable[int] = ()) -> str:
    """A table below its title; nothing where there are no rows."""
    return f"<h3>{title}</h3>{table(head, rows, right)}" if rows else ""


def plain(*cells: Cell) -> Row:
    """A row that stands for no body, joint or link."""
    return {}, cells


def _attributes(about: dict[str, str]) -> str:
    return "".join(f' {name}="{escape(value)}"' for name, value in about.items())


def _html(cell: Cell) -> str:
    if isinstance(cell, Html):
        return cell
    if cell is None or isinstance(cell, str):
        return escape(cell or "")
    if isinstance(cell, (int, float)):
        return f"{cell + 0.0:.6g}"
    return ", ".join(map(_html, cell))
