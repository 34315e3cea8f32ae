"""Tables of the report."""

from __future__ import annotations

from collections.abc import Iterable


def table(
    head: Iterable[str],
    rows: Iterable[tuple[str, list[str]]],
    right: Iterable[int] = (),
    foot: list[str] | None = None,
) -> str:
    """Rows of escaped cells, each row with its attributes; ``right`` are columns of numbers."""
    numeric = set(right)

    def cells(tag: str, texts: Iterable[str]) -> str:
        return "".join(
            f"<{tag} class=n>{text}</{tag}>" if index in numeric else f"<{tag}>{text}</{tag}>"
            for index, text in enumerate(texts)
        )

    body = "\n".join(f"<tr{attributes}>{cells('td', row)}</tr>" for attributes, row in rows)
    tail = f"<tfoot><tr>{cells('td', foot)}</tr></tfoot>" if foot else ""
    return (
        f'<div class="scroll" tabindex="0"><table><thead><tr>{cells("th", head)}</tr></thead>'
        f"<tbody>\n{body}\n</tbody>{tail}</table></div>"
    )


def titled(
    title: str, head: Iterable[str], rows: list[tuple[str, list[str]]], right: Iterable[int] = ()
) -> str:
    """A table below its title; nothing where there are no rows."""
    return f"<h3>{title}</h3>{table(head, rows, right)}" if rows else ""


def number(value: float | None) -> str:
    """Six digits; nothing for None."""
    return "" if value is None else f"{value + 0.0:.6g}"


def vector(values: Iterable[float | None] | None) -> str:
    """Numbers with commas; nothing for None."""
    return "" if values is None else ", ".join(map(number, values))
