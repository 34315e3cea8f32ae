"""The lines of the elements of a long XML file.

libxml2 keeps 16 bits of an element's line.  Past line 65,534 lxml's ``sourceline`` is the line of
some neighbour.  There the lines are counted by a second parser, expat.
"""

from __future__ import annotations

from array import array
from typing import Any

from lxml import etree

#: From this line on, ``sourceline`` is a guess.
LIMIT = 65535


class _Placed(etree.ElementBase):
    """An element whose line was counted; None: not known."""

    sourceline: Any = None
    placed: Any = None
    """All elements, kept at the root: lxml makes an unused element anew, without its line."""


def parser(**options: Any) -> etree.XMLParser:
    """A parser for files that may come from anywhere: it reads nothing but the text."""
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, **options)


def parse(data: bytes, parser: etree.XMLParser) -> Any:
    """``lxml.etree.fromstring``, with every element's true ``sourceline``, or None if unknown.

    :raises lxml.etree.XMLSyntaxError: as that does
    """
    if len(data) < LIMIT or data.count(b"\n") + 1 < LIMIT:
        return etree.fromstring(data, parser)
    parser.set_element_class_lookup(etree.ElementDefaultClassLookup(element=_Placed))
    root: Any = etree.fromstring(data, parser)
    if root is not None:
        root.placed = list(root.iter("*"))
        lines = _lines(data)
        if len(lines) == len(root.placed):
            for element, line in zip(root.placed, lines, strict=True):
                element.sourceline = line
    return root


def line(element: Any, data: bytes) -> int | None:
    """The line of an element of a tree that lxml has made of ``data``; None: not known."""
    near: int | None = element.sourceline
    if near is None or near < LIMIT:
        return near
    every, lines = list(element.getroottree().getroot().iter("*")), _lines(data)
    return lines[every.index(element)] if len(lines) == len(every) else None


def _lines(data: bytes) -> array[int]:
    """The line on which each element begins, in the order of the file."""
    from xml.parsers import expat

    lines = array("I")
    counter = expat.ParserCreate()
    counter.StartElementHandler = lambda *_: lines.append(counter.CurrentLineNumber)
    try:
        counter.Parse(data, True)
    except (expat.ExpatError, LookupError, ValueError):
        return array("I")  # an encoding, say, that only libxml2 knows
    return lines
