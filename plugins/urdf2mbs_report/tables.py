"""Tables of the page as data; ``templates/macros.html`` turns them into HTML."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TypeAlias

import msgspec

#: A number of a table up to this is a rounding of zero.
ROUNDING = 1e-14

Cell: TypeAlias = "str | float | Sequence[float | None] | None"
"""A text, a number, numbers, or nothing."""


class Row(msgspec.Struct):
    """A row of a table."""

    cells: Sequence[Cell]
    attributes: dict[str, str] = {}
    """HTML attributes: ``data-body``, ``data-joint``, ``data-link`` or ``data-urdf-joint`` names
    what a click on the row selects."""


class PageTable(msgspec.Struct):
    """A table of the page."""

    columns: Sequence[str]
    rows: list[Row]
    numeric_columns: Collection[int] = ()
    """Indices of the columns that are aligned on the right."""
    title: str = ""
    footer: Sequence[Cell] = ()


def format_cell(cell: Cell) -> str:
    """Return the text of a cell, not escaped: numbers have six digits, and roundings are 0."""
    if cell is None:
        return ""
    if isinstance(cell, str):
        return cell
    if isinstance(cell, (int, float)):
        return "0" if abs(cell) <= ROUNDING else f"{cell:.6g}"
    return ", ".join(map(format_cell, cell))
