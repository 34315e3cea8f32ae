"""Write a model that was read into its file: only what changed in the model changes there.

The writer's text of the model as it was read, and as it is now, are compared as trees.  What is
alike in both is not touched in the file: its numbers keep their text, and what the model does not
know keeps its place, comments and white space included.
"""

from __future__ import annotations

import re
from copy import deepcopy
from typing import TYPE_CHECKING

from lxml import etree

from urdf2mbs.mbs import writer
from urdf2mbs.mbs.reader import read_again

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lxml.etree import _Element

    from urdf2mbs.mbs.model import Mbs, Part
    from urdf2mbs_edits.unknown import Unknown

    Key = int | tuple[str, int]

#: The attribute by which the writer marks the element of an object: the number of its origin.
AT = "at"
#: The same of an object that comes from another file.
FROM = "from"


def write(
    mbs: Mbs, *, other: bytes | None = None, unknown: Sequence[tuple[int, str, Unknown | None]] = ()
) -> bytes:
    """The file of a model that was read, with what has changed in the model; of any other model,
    what ``mbs.writer`` writes.  Raises ValueError for what no .mbs can hold.

    Objects may come from one ``other`` file, with all that stands in their elements.  ``unknown``
    are elements and attributes to set, or None to take away, by the number of the object's origin
    and their path in it (``unknown.unknown_elements``).
    """
    if mbs.origin is None:
        return writer.write(mbs)
    source = mbs.origin.source
    before, elements = read_again(source)
    texts = [_Marker(source).mbs(before), _Marker(source, other).mbs(mbs)]
    if texts[0] == texts[1] and not unknown:
        return source
    others = None
    if other is not None:
        theirs, their_elements = read_again(other)
        others = their_elements, etree.fromstring(_Marker(other).mbs(theirs).encode())
    was, now = [etree.fromstring(text.encode()) for text in texts]
    places = [(_place(elements[number], path), value) for number, path, value in unknown]
    _Rewriter(elements, was, now, others).change(elements[0], was, now)
    for (element, name, there), value in places:
        _put(element, name, there, value)
    return _spelled(elements[0], source)


class _Marker(writer.Writer):
    """Marks the objects that were read from ``source`` or ``other``."""

    def __init__(self, source: bytes, other: bytes | None = None) -> None:
        self.source, self.other = source, other
        self.marked: set[int] = set()

    def mark(self, part: Part) -> str:
        """The mark of an object that was read; a copy of one is new."""
        origin = part.origin
        if origin is None:
            return ""
        if origin.source is self.other is not self.source:
            return f' {FROM}="{origin.number}"'
        if origin.source is not self.source or origin.number in self.marked:
            return ""
        self.marked.add(origin.number)
        return f' {AT}="{origin.number}"'


def _spelled(root: _Element, source: bytes) -> bytes:
    """A tree as bytes, with the encoding, the first line and the line ends of its file."""
    tree = root.getroottree()
    text = etree.tostring(tree, encoding="unicode") + source[len(source.rstrip()) :].decode()
    if b" />" in source:  # as MBSysPad has it
        text = re.sub(r"(?s)(<!--.*?-->|<\?.*?\?>)|/>", lambda found: found[1] or " />", text)
    if b"\r\n" in source:
        text = text.replace("\r\n", "\n")
        text = text.replace("\n", "\r\n")
    head = re.match(rb"(\xef\xbb\xbf)?<\?xml[^>]*\?>\s*", source)
    data = text.encode(tree.docinfo.encoding or "UTF-8", "xmlcharrefreplace")
    return (head[0] if head else b"") + data


class _Rewriter:
    """Changes the elements of a file.

    ``elements`` are those of the objects in the file by the numbers of their origins, the root
    first; ``was`` and ``now`` are what the writer writes of the model before and after.
    ``others`` are the elements of another file, from which objects come, and what the writer
    writes of its model.
    """

    def __init__(
        self,
        elements: list[_Element],
        was: _Element,
        now: _Element,
        others: tuple[list[_Element], _Element] | None = None,
    ) -> None:
        self.elements = elements
        self.objects = set(elements)
        self.was, self.now = _marked(was), _marked(now)
        self.others, theirs = others or ([], etree.Element("none"))
        self.others_were = _marked(theirs)
        for element in self.others_were.values():
            del element.attrib[AT]

    def change(self, kept: _Element, was: _Element, now: _Element) -> None:
        """Change one element of the file, and what is in it."""
        kept.tag = now.tag
        if (was.text or "").strip() != (now.text or "").strip():
            kept.text = now.text
        for name in dict.fromkeys([*was.keys(), *now.keys()]):
            value = now.get(name)
            if name not in (AT, FROM) and value != was.get(name):
                if value is None and name in kept.attrib:
                    del kept.attrib[name]
                elif value is not None:
                    kept.set(name, value)
        if len(was) or len(now):
            self.children(kept, was, now)

    def children(self, kept: _Element, was: _Element, now: _Element) -> None:
        before, after = _keyed(was), _keyed(now)
        there = _keyed((child for child in kept if child not in self.objects), marked=False)
        order: list[_Element] = []
        for key, child in after.items():
            same = self.elements[key] if isinstance(key, int) else there.get(key)
            changed = key not in before or _text(before[key]) != _text(child)
            if key not in before and isinstance(key, int):
                order.append(self.made(child))  # from another parent
            elif same is not None:
                if changed:
                    self.change(same, before.get(key, etree.Element(child.tag)), child)
                order.append(same)
            elif changed:
                order.append(self.made(child))
        for key, child in before.items():
            gone = self.elements[key] if isinstance(key, int) else there.get(key)
            if key in after or key in self.now or gone is None:
                continue
            if kept is self.elements[0]:  # a list of the file may have more than the model knows
                self.change(gone, child, etree.Element(child.tag))
            if kept is not self.elements[0] or not len(gone):
                _detach(gone)
        _arrange(kept, order)

    def made(self, now: _Element) -> _Element:
        """A new element; what comes from elsewhere in the file is taken from there."""
        at = now.get(AT)
        if at is not None:
            kept = self.elements[int(at)]
            self.change(kept, self.was[int(at)], now)
            _detach(kept)
            return kept
        other = now.get(FROM)
        if other is not None:
            kept = deepcopy(self.others[int(other)])
            kept.tail = None
            self.change(kept, self.others_were[int(other)], now)
            return kept
        made = etree.Element(now.tag)
        for name, value in now.items():
            made.set(name, value)
        made.text = now.text
        for child in now:
            part = self.made(child)
            made.append(part)
            part.tail = child.tail
        return made


def _place(element: _Element, path: str) -> tuple[_Element, str, _Element | None]:
    """The element in which an unknown one or an attribute stands, what the path calls it there, and
    the unknown element, if it is there."""
    *way, name = re.split(r"/(?![^{]*})", path)  # no slash of a name space
    for step in way:
        child = element.find(step)
        if child is None:
            child = etree.Element(step)
            _insert(element, len(element), child)
        element = child
    tag, number = re.fullmatch(r"(.*?)(?:\[(\d+)\])?", name).groups()  # type: ignore[union-attr]
    there = [] if name.startswith("@") else [c for c in element.iterchildren("*") if c.tag == tag]
    place = int(number or 1)
    return element, name, there[place - 1] if place <= len(there) else None


def _put(parent: _Element, name: str, there: _Element | None, value: Unknown | None) -> None:
    """Set an unknown element or attribute, or take it away."""
    if isinstance(value, str):
        parent.set(name[1:], value)
    elif value is not None:
        made = deepcopy(value)
        before = [child.tag for child in value.itersiblings("*", preceding=True)]
        index = max((n for n, child in enumerate(parent, 1) if child.tag in before), default=0)
        if there is None:
            made.tail = None
            _insert(parent, index or len(parent), made)
        else:
            made.tail = there.tail
            parent.replace(there, made)
    elif there is not None:
        _detach(there)
    elif name[1:] in parent.attrib:
        del parent.attrib[name[1:]]


def _marked(tree: _Element) -> dict[int, _Element]:
    return {int(element.get(AT, "")): element for element in tree.iter() if AT in element.attrib}


def _keyed(children: Iterable[_Element], *, marked: bool = True) -> dict[Key, _Element]:
    """Elements by the number of their origin, else by tag and their number among their like."""
    counts: dict[str, int] = {}
    keyed: dict[Key, _Element] = {}
    for child in children:
        tag = child.tag
        at = child.get(AT) if marked else None
        if at is not None:
            keyed[int(at)] = child
        elif isinstance(tag, str):
            counts[tag] = counts.get(tag, 0) + 1
            keyed[tag, counts[tag]] = child
    return keyed


def _text(element: _Element) -> str:
    return etree.tostring(element, encoding="unicode", with_tail=False)


def _arrange(parent: _Element, order: list[_Element]) -> None:
    """Bring children into an order; what the order does not name stays where it is."""
    places = {child: place for place, child in enumerate(parent)}
    first = next((child for child in order if child in places), None)
    last, previous = -1, None
    for child in order:
        place = places.get(child, -1)
        if place > last:
            last = place
        else:
            _detach(child)
            if previous is not None:
                index = parent.index(previous) + 1
            else:
                index = len(parent) if first is None else parent.index(first)
            _insert(parent, index, child)
        previous = child


def _insert(parent: _Element, index: int, child: _Element) -> None:
    """Insert an element, indented as its siblings are."""
    depth = sum(1 for _ in parent.iterancestors())
    closing, between = "\n" + "  " * depth, "\n" + "  " * (depth + 1)
    if len(parent):
        between = _blank(parent.text, between)
    else:
        parent.text = (parent.text or "").strip() + between
    if index < len(parent):
        child.tail = between
    else:
        child.tail = closing
        if index:
            child.tail = _blank(parent[-1].tail, closing)
            parent[-1].tail = (parent[-1].tail or "").strip() + between
    parent.insert(index, child)


def _detach(child: _Element) -> None:
    """Take an element away, and the line on which it stood; text after it stays."""
    parent, previous = child.getparent(), child.getprevious()
    if parent is None:
        return
    tail, child.tail = child.tail or "", None
    if tail.strip() or child.getnext() is None:
        if previous is not None:
            previous.tail = (previous.tail or "").rstrip() + tail
        else:
            parent.text = (parent.text or "").rstrip() + tail
    parent.remove(child)
    if not len(parent) and not (parent.text or "").strip():
        parent.text = None


def _blank(text: str | None, otherwise: str) -> str:
    return text if text and not text.strip() else otherwise
