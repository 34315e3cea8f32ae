"""The file of a merged table: that of ours, in which only what the table has otherwise changes.

A path is a place in the element of its thing, so a value that theirs gives is an element that is
copied from there to here; a thing is its element, which moves with all that stands in it.  So the
numbers keep their text, and what nobody knows keeps its place, comments and white space included.
"""

from __future__ import annotations

import re
from copy import deepcopy
from functools import cache
from typing import TYPE_CHECKING

from lxml import etree

from urdf2mbs.mbs.fields import INSIDE, KEPT, OBJECTS, Table
from urdf2mbs.mbs.model import BASE, ORIGIN, SENSOR_MEASURES
from urdf2mbs_edits.diff.flat import HELD
from urdf2mbs_edits.unknown import ATTRIBUTES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lxml.etree import _Element

    from urdf2mbs_edits.diff.changes import Path
    from urdf2mbs_edits.merge.settle import Settled

    #: The elements of a file's things, by their numbers.
    Elements = dict[int, _Element]

_LISTS = {kind: field for field, kind in HELD.items()}
#: The tags of the objects whose elements are called otherwise.
_OBJECT_OF = {"mbsDescR7": "mbs", "x3D": "view"}


def write(
    settled: Settled, orders: dict[Path, list[int]], source: bytes, ours: Elements, theirs: Elements
) -> bytes:
    """The file of ours, this source, with what theirs gives; ``ours`` are changed."""
    root = next(iter(ours.values()))
    before = etree.tostring(root)
    elements = dict(ours)
    numbers = {element: number for number, element in theirs.items()}
    for number in settled.there:
        if number not in elements:
            _copy(theirs[number], settled, elements, numbers)
    for number, field in sorted(settled.taken):
        if number in settled.there and field[0] != "[":
            _take(elements[number], theirs[number], field)
    for number in settled.there:
        _name(elements[number], settled, number)
    for (number, field), order in orders.items():
        *way, _ = _paths(elements[number].tag)[_LISTS[field[1:-1]]].split("/")
        _arrange(_step(elements[number], way), [elements[one] for one in order])
    for number, element in ours.items():
        if number not in settled.there:
            _detach(element)
    return source if etree.tostring(root) == before else _spelled(root, source)


def _copy(
    element: _Element, settled: Settled, elements: Elements, numbers: dict[_Element, int]
) -> None:
    """Copy the element of a thing that theirs has alone, with what theirs alone has in it."""
    made = deepcopy(element)
    made.tail = None
    copies = [
        (numbers[one], copy)
        for one, copy in zip(element.iter(), made.iter(), strict=True)
        if one in numbers
    ]
    for number, copy in copies:
        if number in settled.there and number not in elements:
            elements[number] = copy
        else:
            _detach(copy)


def _take(mine: _Element, theirs: _Element | None, field: str) -> None:
    """Give an element what stands in that of theirs for a field of the thing."""
    known = field[0] != "?"
    if field == "kind" and theirs is not None:
        mine.tag = theirs.tag
    elif field == "measures" and theirs is not None:
        for measure in SENSOR_MEASURES:
            _set(mine, measure, theirs.get(measure))
    elif not known or field in _paths(mine.tag):
        *way, name = re.split(r"/(?![^{]*})", _paths(mine.tag)[field] if known else field[1:])
        for step in way:
            theirs = None if theirs is None else theirs.find(step)
            mine = _step(mine, [step])
        if name[0] == "@":
            _set(mine, name[1:], None if theirs is None else theirs.get(name[1:]))
            return
        there = [] if theirs is None else theirs.findall(name)
        before = [one.tag for one in there[0].itersiblings("*", preceding=True)] if there else []
        new, old = deepcopy(there), mine.findall(name)
        if len(old) == len(new) == 1:
            if known:
                _keep_unknown(old[0], new[0])
            new[0].tail = old[0].tail
            mine.replace(old[0], new[0])
            return
        for one in new:
            one.tail = None
            _insert(mine, _index(mine, name, () if known else before), one)
        for one in old:
            _detach(one)
        _prune(mine)


def _set(element: _Element, name: str, value: str | None) -> None:
    if value is not None:
        element.set(name, value)
    elif name in element.attrib:
        del element.attrib[name]


def _keep_unknown(old: _Element, new: _Element) -> None:
    """Let a new element have of what nobody knows what the old has; it has paths of its own."""
    known = ATTRIBUTES.get(new.tag, ())
    for name in [*new.keys(), *old.keys()]:
        if name not in known:
            _set(new, str(name), old.get(name))
    tags = _tags().get(new.tag, {})
    for child in [child for child in new if child.tag not in tags]:
        new.remove(child)
    new.extend([deepcopy(child) for child in old if child.tag not in tags])


def _name(element: _Element, settled: Settled, number: int) -> None:
    """Write the name of a thing, and those of what it refers to."""
    thing, name = settled.there[number], settled.name(number)
    side = settled.ours if number in settled.ours.things else settled.theirs
    if element.tag in ("sensor", "extforce"):
        element.set("name", name)
    elif name != side.things[number].name:
        _say(element, _paths(element.tag)["name"], [name])
    for field in thing.refers:
        value = settled.value(number, field)
        names = [
            target if not isinstance(target, int)
            else None if settled.there[target].kind == "base" else settled.name(target)
            for target in (() if field == "name" else value)
        ]  # fmt: skip
        if field in ("place", "endpoint1", "endpoint2"):
            path = _paths(element.tag)[field]
            for part, said, own in zip(INSIDE["place"], names, (BASE, ORIGIN), strict=True):
                _say(element, f"{path}/{part}", [own if said is None else said])
        elif field != "name":
            _say(element, _paths(element.tag)[field], [one or BASE for one in names])


def _say(element: _Element, path: str, texts: list[str]) -> None:
    """Let the elements at a path have these texts."""
    *way, tag = path.split("/")
    there = element.findall(path)
    if [(one.text or "").strip() for one in there] == texts:
        return
    if not there and texts in ([""], [BASE]):  # what the file leaves out
        return
    parent = _step(element, way)
    for one in there[len(texts) :]:
        _detach(one)
    for _ in texts[len(there) :]:
        _insert(parent, _index(parent, tag), etree.Element(tag))
    for one, text in zip(element.findall(path), texts, strict=True):
        one.text = text


# --- places ---


@cache
def _paths(tag: str) -> dict[str, str]:
    """Where the fields of an object stand in its element."""

    def walk(table: Table, way: str, within: str) -> Iterator[tuple[str, str]]:
        for tag, entry in table.items():
            if isinstance(entry, tuple):
                holds = "" if isinstance(entry[1], str) else "/"  # a list is within its element
                yield f"{within}{entry[0]}", f"{way}{tag}{holds}"
                if entry[1] == "drawing":
                    yield from walk(INSIDE["drawing"], f"{way}{tag}/", "drawing.")
            elif entry is not None:
                yield from walk(entry, f"{way}{tag}/", within)

    known = OBJECTS.get(_OBJECT_OF.get(tag, tag))
    return dict(walk(known.table, "", "")) if known else {}


@cache
def _tags() -> dict[str, dict[str, None]]:
    """The tags of the children of each element, in the order of the writer."""
    tags: dict[str, dict[str, None]] = {}

    def note(tag: str, table: Table) -> None:
        for child, entry in table.items():
            tags.setdefault(tag, {})[child] = None
            if isinstance(entry, tuple):
                note(child, INSIDE.get(str(entry[1]), {}))
            elif entry is not None:
                note(child, entry)

    called = {key: tag for tag, key in _OBJECT_OF.items()}
    for key, known in OBJECTS.items():
        note(called.get(key, key), known.table)
    return tags


def _step(element: _Element, way: list[str]) -> _Element:
    """The element at the end of a way, made where it is not there."""
    for tag in way:
        there = element.find(tag)
        if there is None:
            there = etree.Element(tag)
            _insert(element, _index(element, tag), there)
        element = there
    return element


def _index(parent: _Element, tag: str, before: Iterable[object] = ()) -> int:
    """Where a new child goes: behind those that the writer writes before it, or these."""
    tags = list(_tags().get(parent.tag, ()))
    first = {*before, *tags[: tags.index(tag) + 1]} if tag in tags else {*before, tag}
    places = [place for place, child in enumerate(parent, 1) if child.tag in first]
    return places[-1] if places else 0 if tag in tags else len(parent)


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
                index = _index(parent, child.tag) if first is None else parent.index(first)
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
    _prune(parent)


def _prune(element: _Element) -> None:
    """Take away an element that holds nothing any more, unless it is written empty, too."""
    if len(element) or (element.text or "").strip():
        return
    element.text = None
    if element.tag not in KEPT and element.tag not in OBJECTS and not element.attrib:
        _detach(element)


def _blank(text: str | None, otherwise: str) -> str:
    return text if text and not text.strip() else otherwise


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
