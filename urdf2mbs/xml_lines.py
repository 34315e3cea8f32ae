"""Long XML files: the lines of their elements, and reading them piece by piece.

libxml2 keeps 16 bits of an element's line.  Past line 65,534 lxml's ``sourceline`` is the line of
some neighbour.  There the lines are counted by a second parser, expat.

A tree takes about 20 times the memory of its text.  So the children of the root of a large file
can be had one after the other, without the whole tree.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from typing import Any
from weakref import ref

from lxml import etree

#: From this line on, ``sourceline`` is a guess.
LIMIT = 65535
#: So many bytes of an .mbs are read piece by piece.
LARGE = 2**21
#: So many bytes at a time.
_PIECE = 2**16


class NotPieceByPieceError(Exception):
    """A file must be read as a whole."""


class _Placed(etree.ElementBase):
    """An element whose line was counted; None: not known."""

    sourceline: Any = None
    placed: Any = None
    """Of the root: all elements, since lxml forgets what it made of an element in no use."""


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
        lines, _ = _lines(data)
        if len(lines) == len(root.placed):
            for element, line in zip(root.placed, lines, strict=True):
                element.sourceline = line
    return root


def pieces(data: bytes, tag: str, **options: Any) -> Iterator[Any]:
    """The root of an XML file, then each of its children with all that is in it.

    A child is good only until the next one is asked for; soon after, it is taken out of the tree.
    In between the root has no text and no other children that can be relied on.  ``tag`` is the
    root's; ``options`` are those of lxml's parser.

    :raises lxml.etree.XMLSyntaxError: as lxml's parser does, maybe after some children
    :raises NotPieceByPieceError: where this does not work
    """
    parser: Any = etree.XMLPullParser(events=("start",), tag=tag, **options)
    if data.count(b"\n") + 1 < LIMIT:
        return _pieces(data, parser)
    lines = _Lines(data)
    parser.set_element_class_lookup(etree.ElementDefaultClassLookup(element=lines.element()))
    return map(lines.at, _pieces(data, parser))


def _pieces(data: bytes, parser: Any) -> Iterator[Any]:
    root: Any = None
    for at in range(0, len(data), _PIECE):
        parser.feed(data[at : at + _PIECE])
        if root is None:
            root = next((element for _, element in parser.read_events()), None)
            if root is None:
                continue
            if root.getparent() is not None:
                raise NotPieceByPieceError
            yield root
        # the last one stays until another follows: the text after it may not be whole
        whole = max(0, len(root) - 1)
        yield from root[:whole]
        del root[:whole]
    parser.close()
    if root is None:
        raise NotPieceByPieceError
    yield from root[:]


def ends(data: bytes, parser: Any) -> Iterator[Any]:
    """The elements of which a pull parser says that they end, each soon after it has ended."""
    for at in range(0, len(data), _PIECE):
        parser.feed(data[at : at + _PIECE])
        for _, element in parser.read_events():
            yield element


class _Lines:
    """The lines of the elements of the child that is being read, and of the root."""

    def __init__(self, data: bytes) -> None:
        self.lines, self.starts = _lines(data)
        if not self.lines:
            raise NotPieceByPieceError
        self._root: Any = None
        self._count = -1
        self._child: Any = None
        self._below: dict[Any, int] = {}

    def at(self, piece: Any) -> Any:
        """Go on to the next piece, the root first; a comment is none that has a line."""
        self._below.clear()
        if self._root is None:
            self._root = piece
        elif isinstance(piece.tag, str):
            self._count += 1
            self._child = piece
        return piece

    def line(self, element: Any) -> int:
        if element is self._root:
            return self.lines[0]
        first = self.starts[self._count]
        if element is self._child:
            return self.lines[first]
        if not self._below:
            for number, one in enumerate(self._child.iter("*"), start=first):
                self._below[one] = self.lines[number]
        return self._below[element]

    def element(self) -> type[etree.ElementBase]:
        """The class of elements that have their lines from here."""
        own = ref(self)  # a class lives until the garbage collector comes

        def line(element: Any) -> int | None:
            lines = own()
            return None if lines is None else lines.line(element)

        class Counted(etree.ElementBase):
            __slots__ = ()
            sourceline: Any = property(line)

        return Counted


def _lines(data: bytes) -> tuple[array[int], array[int]]:
    """The line on which each element begins, in the order of the file; and the places in this
    list of the root's children."""
    from xml.parsers import expat

    lines, starts = array("I"), array("I")
    depth = 0
    counter = expat.ParserCreate()

    def start(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth == 2:
            starts.append(len(lines))
        lines.append(counter.CurrentLineNumber)

    def end(_: object) -> None:
        nonlocal depth
        depth -= 1

    counter.StartElementHandler = start
    counter.EndElementHandler = end
    try:
        counter.Parse(data, True)
    except (expat.ExpatError, LookupError, ValueError):
        return array("I"), array("I")  # an encoding, say, that only libxml2 knows
    return lines, starts
