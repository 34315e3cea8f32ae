"""The values of the elements of an .mbs file, and errors with their lines."""

from __future__ import annotations

import re
from math import isfinite, nan
from sys import intern
from typing import TYPE_CHECKING, Any, NoReturn

from urdf2mbs.mbs.fields import INSIDE, REPEATED, Table
from urdf2mbs.mbs.model import SYMBOLS
from urdf2mbs.messages.diagnostics import ConversionError

if TYPE_CHECKING:
    from collections.abc import Collection

    from lxml.etree import _Element

    from urdf2mbs.mbs.model import XY
    from urdf2mbs.spatial import Sym, Vec

    Children = dict[str, list[_Element]]

_NUMBER = re.compile(r"\s*[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*").fullmatch
_COLOR = re.compile(r"\s*[0-9]{1,3}\s*").fullmatch
_XY, _XYZ, _INERTIA = [list(INSIDE[kind]) for kind in ("xy", "xyz", "inertia")]


class Values:
    """Reads the values of one file's elements: a method for each kind of ``fields``."""

    def __init__(self, data: bytes, file: str) -> None:
        self.data, self.file = data, file
        self._numbers: dict[str, float] = {}

    def text(self, element: _Element) -> str:
        if len(element):
            self.fail(
                element, "mbs-not-plain", f"<{element.tag}> holds more than a text",
                "comments and elements do not belong within a name or a number",
            )  # fmt: skip
        return (element.text or "").strip()

    texts = title = text

    def word(self, element: _Element) -> str:
        """One of a few texts: all elements share it."""
        return intern(self.text(element))

    def flag(self, _: _Element) -> bool:
        return True

    def number(self, element: _Element) -> float:
        text = element.text or ""
        value = self._numbers.get(text)
        if value is None or len(element):
            try:
                value = self._numbers[text] = float(text)
            except ValueError:
                value = nan
            # Python reads more than a file may hold: nan, 1_0, the digits of all scripts.
            if not isfinite(value) or len(element) or "_" in text or not text.isascii():
                self._fail_number(element)
        return value

    def _fail_number(self, element: _Element) -> NoReturn:
        text = self.text(element)
        why, hint = "no number", "write it as 0.5 or 5e-1"
        if _NUMBER(text):
            why, hint = "too large", "a double goes up to 1.8e308"
        self.fail(element, "number-invalid", f"'{text}' in <{element.tag}> is {why}", hint)

    def xy(self, element: _Element) -> XY:
        x, y = self._coordinates(element, _XY)
        return x, y

    def xyz(self, element: _Element) -> Vec:
        x, y, z = self._coordinates(element, _XYZ)
        return x, y, z

    def _coordinates(self, element: _Element, tags: list[str]) -> list[float]:
        children = self.parts(element, tags)
        if None in children:
            missing = tags[children.index(None)]
            self.fail(element, "number-missing", f"<{element.tag}> has no <{missing}>")
        return list(map(self.number, children))

    def control_points(self, element: _Element) -> tuple[XY, ...]:
        return tuple(map(self.xy, element.iterchildren("control_point")))

    def coordinates(self, element: _Element) -> Vec:
        """The vector of the child <coordinates>."""
        [child] = self.parts(element, ["coordinates"])
        if child is None:
            self.fail(
                element, "mbs-incomplete", f"<{element.tag}> has no <coordinates>",
                "Robotran's C library cannot read it: give x, y and z, or leave the element out",
            )  # fmt: skip
        self.check_first(child)
        return self.xyz(child)

    def inertia(self, element: _Element) -> Sym:
        xx, xy, xz, yy, yz, zz = [
            0.0 if child is None else self.number(child) for child in self.parts(element, _INERTIA)
        ]
        return (xx, xy, xz, yy, yz, zz)

    def color(self, element: _Element) -> tuple[int, int, int]:
        rgb = [element.get(part, "") for part in "RGB"]
        for text in rgb:
            if not _COLOR(text) or int(text) > 255:
                self.fail(
                    element, "number-invalid", f"'{text}' is no part of a colour",
                    "R, G and B are whole numbers from 0 to 255",
                )  # fmt: skip
        return int(rgb[0]), int(rgb[1]), int(rgb[2])

    def symbols(self, element: _Element) -> tuple[str, ...]:
        return tuple(tag for tag in self.children(element, SYMBOLS) if tag in SYMBOLS)

    # --- elements ---

    def parts(self, element: _Element, tags: list[str]) -> list[Any]:
        """The children with these tags, in this order; None for one that is not there."""
        # Half of all elements come through here, nearly always with just these children.
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        if [child.tag for child in children] == tags:
            return children
        kids = self.children(element, tags)
        return [kids[tag][0] if tag in kids else None for tag in tags]

    def children(self, element: _Element, known: Table | Collection[str]) -> Children:
        """The children by tag.  Two with a known tag are an error, unless they are ``REPEATED``."""
        # A slice is twice as fast as list().
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        kids: Children = {child.tag: [child] for child in children}
        if len(kids) < len(children):
            kids = {tag: [] for tag in kids}
            for child in children:
                kids[child.tag].append(child)
            for tag, found in kids.items():
                entry = known.get(tag) if isinstance(known, dict) else None
                repeated = isinstance(entry, tuple) and entry[1] in REPEATED
                if len(found) > 1 and tag in known and not repeated:
                    self.fail(found[1], "doubled-element", f"<{element.tag}> has two <{tag}>")
        return kids

    def check_first(self, child: _Element) -> None:
        """Fail if an element is not the first child: Robotran takes any first child for it."""
        before = child.getprevious()
        if before is not None:
            what = f"<{before.tag}>" if isinstance(before.tag, str) else "a comment"
            parent: Any = child.getparent()
            self.fail(
                child, "mbs-not-first", f"{what} stands before <{child.tag}> in <{parent.tag}>",
                "Robotran's C library takes the first for it, and reads zeros or no name: "
                f"<{child.tag}> must be the first",
            )  # fmt: skip

    def fail(self, element: _Element, code: str, message: str, hint: str | None = None) -> NoReturn:
        at: Any = element.sourceline
        raise ConversionError(code, message, file=self.file, line=at, hint=hint)
