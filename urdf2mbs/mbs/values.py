"""Read the values of the elements of an .mbs file, with errors that name the line."""

from __future__ import annotations

import re
from math import isfinite, nan
from sys import intern
from typing import TYPE_CHECKING, Any, NoReturn

from urdf2mbs.mbs.fields import INSIDE, REPEATED, Field, Table
from urdf2mbs.mbs.model import SYMBOLS
from urdf2mbs.messages.diagnostics import ConversionError

if TYPE_CHECKING:
    from collections.abc import Collection

    from lxml.etree import _Element

    from urdf2mbs.mbs.model import RGB, XY
    from urdf2mbs.spatial import Sym, Vec

    Children = dict[str, list[_Element]]

_is_number = re.compile(
    r"\s*[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*"
).fullmatch
_is_color_part = re.compile(r"\s*[0-9]{1,3}\s*").fullmatch
_XY, _XYZ, _INERTIA = [list(INSIDE[kind]) for kind in ("xy", "xyz", "inertia")]


class ValueReader:
    """Reads values of the elements of one file: a method for each kind of ``fields``."""

    def __init__(self, data: bytes, file: str) -> None:
        self.data, self.file = data, file
        self._numbers: dict[str, float] = {}
        """The numbers that were read, by their texts: most are repeated."""

    # --- texts and numbers ---

    def read_text(self, element: _Element) -> str:
        """Return the text of an element without children."""
        if len(element):
            self.fail(
                element,
                "mbs-not-plain",
                f"<{element.tag}> contains a comment or an element; expected a text only",
                "move it out of the name or number",
            )
        return (element.text or "").strip()

    def read_word(self, element: _Element) -> str:
        """Return one of a few texts, which all elements share."""
        return intern(self.read_text(element))

    def read_flag(self, _: _Element) -> bool:
        """Return True, as the element exists."""
        return True

    def read_number(self, element: _Element) -> float:
        """Return a finite number."""
        number_text = element.text or ""
        value = self._numbers.get(number_text)
        if value is None or len(element):
            try:
                value = self._numbers[number_text] = float(number_text)
            except ValueError:
                value = nan
            # Python also parses texts that an .mbs must not have: nan, 1_0, digits of all scripts.
            if (
                not isfinite(value)
                or len(element)
                or "_" in number_text
                or not number_text.isascii()
            ):
                self._fail_number(element)
        return value

    def _fail_number(self, element: _Element) -> NoReturn:
        """Fail since the text of an element is not a number, or too large for a double."""
        number_text = self.read_text(element)
        expected, hint = "a number", "write it as 0.5 or 5e-1"
        if _is_number(number_text):
            expected, hint = "a smaller number", "a double goes up to 1.8e308"
        message = f"<{element.tag}> is '{number_text}'; expected {expected}"
        self.fail(element, "number-invalid", message, hint)

    # --- values of several numbers ---

    def read_xy(self, element: _Element) -> XY:
        """Return the children <x> and <y>."""
        x, y = self._read_coordinates(element, _XY)
        return x, y

    def read_xyz(self, element: _Element) -> Vec:
        """Return the children <x>, <y> and <z>."""
        x, y, z = self._read_coordinates(element, _XYZ)
        return x, y, z

    def _read_coordinates(self, element: _Element, tags: list[str]) -> list[float]:
        """Return the numbers of the children with these tags, all required."""
        children = self.find_children(element, tags)
        if None in children:
            missing = tags[children.index(None)]
            self.fail(element, "number-missing", f"<{element.tag}> has no <{missing}>")
        return list(map(self.read_number, children))

    def read_control_points(self, element: _Element) -> tuple[XY, ...]:
        """Return the children <control_point>."""
        return tuple(map(self.read_xy, element.iterchildren("control_point")))

    def read_coordinates(self, element: _Element) -> Vec:
        """Return the vector of the child <coordinates>."""
        [child] = self.find_children(element, ["coordinates"])
        if child is None:
            self.fail(
                element,
                "mbs-incomplete",
                f"<{element.tag}> has no <coordinates>",
                "Robotran's C library cannot read it: give x, y and z, or leave the element out",
            )
        self.check_first(child)
        return self.read_xyz(child)

    def read_inertia(self, element: _Element) -> Sym:
        """Return a tensor; a missing component is zero."""
        xx, xy, xz, yy, yz, zz = [
            0.0 if child is None else self.read_number(child)
            for child in self.find_children(element, _INERTIA)
        ]
        return (xx, xy, xz, yy, yz, zz)

    def read_color(self, element: _Element) -> RGB:
        """Return the attributes R, G and B."""
        color_parts = [element.get(attribute, "") for attribute in "RGB"]
        for attribute, part_text in zip("RGB", color_parts, strict=True):
            if not _is_color_part(part_text) or int(part_text) > 255:
                message = (
                    f"{attribute} of <{element.tag}> is '{part_text}'; "
                    "expected a whole number from 0 to 255"
                )
                self.fail(element, "number-invalid", message)
        return int(color_parts[0]), int(color_parts[1]), int(color_parts[2])

    def read_symbols(self, element: _Element) -> tuple[str, ...]:
        """Return the tags of the children that are symbols."""
        return tuple(tag for tag in self.group_children(element, SYMBOLS) if tag in SYMBOLS)

    # --- elements ---

    def find_children(self, element: _Element, tags: list[str]) -> list[Any]:
        """Return the child with each of these tags, in this order; None if it is missing."""
        # Half of all elements come through here, nearly always with just these children.
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        if [child.tag for child in children] == tags:
            return children
        children_by_tag = self.group_children(element, tags)
        return [children_by_tag[tag][0] if tag in children_by_tag else None for tag in tags]

    def group_children(self, element: _Element, table: Table | Collection[str]) -> Children:
        """Group the children of an element by tag.

        Fail if two have a tag of the table, unless the table says that it is repeated.
        """
        # A slice is twice as fast as list().
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        children_by_tag: Children = {child.tag: [child] for child in children}
        if len(children_by_tag) < len(children):
            children_by_tag = {tag: [] for tag in children_by_tag}
            for child in children:
                children_by_tag[child.tag].append(child)
            for tag, equal_children in children_by_tag.items():
                field_or_table = table.get(tag) if isinstance(table, dict) else None
                is_repeated = isinstance(field_or_table, Field) and field_or_table.kind in REPEATED
                if len(equal_children) > 1 and tag in table and not is_repeated:
                    self.fail(
                        equal_children[1], "doubled-element", f"<{element.tag}> has two <{tag}>"
                    )
        return children_by_tag

    def check_first(self, child: _Element) -> None:
        """Fail if an element is not the first child: Robotran reads any first child as it."""
        previous = child.getprevious()
        if previous is not None:
            previous_label = f"<{previous.tag}>" if isinstance(previous.tag, str) else "a comment"
            parent: Any = child.getparent()
            self.fail(
                child,
                "mbs-not-first",
                f"{previous_label} comes before <{child.tag}> in <{parent.tag}>",
                f"Robotran's C library reads the first child as <{child.tag}>, and so zeros or no "
                f"name: move <{child.tag}> to the front",
            )

    def fail(self, element: _Element, code: str, message: str, hint: str | None = None) -> NoReturn:
        """Raise a ConversionError at the line of an element."""
        line: Any = element.sourceline
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)
