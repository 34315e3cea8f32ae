"""The file of a merged table: that of ours, in which only what the table has otherwise changes.

A path is a place in the element of its thing, so a value that theirs gives is an element that is
copied from there to here; a thing is its element, which moves with all that stands in it.  So the
numbers keep their text, and what nobody knows keeps its place, comments included.
"""

from __future__ import annotations

import re
from copy import deepcopy
from functools import cache
from typing import TYPE_CHECKING

from lxml import etree

from urdf2mbs.plugin import BASE, INSIDE, KEPT, OBJECTS, ORIGIN, SENSOR_MEASURES, Table
from urdf2mbs_edits.diff.flat import HELD
from urdf2mbs_edits.diff.unknown import OBJECT_OF

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lxml.etree import _Element

    from urdf2mbs_edits.diff.changes import Path
    from urdf2mbs_edits.merge.settle import Settled

_LISTS = {kind: field for field, kind in HELD.items()}


def write(settled: Settled, orders: dict[Path, list[int]], source: bytes) -> bytes:
    """The file of ours, this source, with what theirs gives; the elements of ours are changed."""
    ours, theirs = settled.ours.elements, settled.theirs.elements
    root = next(iter(ours.values()))
    before = etree.tostring(root)
    elements = dict(ours)
    objects = set(theirs.values())
    for number in settled.there:
        if number not in elements:
            elements[number] = _copy(theirs[number], objects)
    taken: dict[int, list[str]] = {}
    for number, field in sorted(settled.taken):
        if number in settled.there and field[0] != "[":
            taken.setdefault(number, []).append(field)
    for number, fields in taken.items():
        own = [field for field in settled.ours.values[number] if field[0] == "?"]
        _take_all(elements[number], theirs[number], fields, own)
    for number in settled.there:
        _name(elements[number], settled, number)
    for (number, field), order in orders.items():
        path = _paths(elements[number].tag)[_LISTS[field[1:-1]]]
        _arrange(elements[number], path, [elements[one] for one in order])
    for number, element in ours.items():
        if number not in settled.there:
            _detach(element)
    if etree.tostring(root) == before:
        return source
    _lay_out(root)
    return _spelled(root, source)


def _copy(element: _Element, objects: set[_Element]) -> _Element:
    """A copy of the element of a thing, without the things in it: each of them has its own."""
    made = deepcopy(element)
    made.tail = None
    both = list(zip(element.iter(), made.iter(), strict=True))
    for one, copy in both:
        if one in objects and one is not element:
            _detach(copy)
    return made


# --- values ---

#: Between two steps of a path; a namespace may have slashes, too.
_STEPS = re.compile(r"/(?![^{]*})")


def _take_all(mine: _Element, theirs: _Element, fields: list[str], own: list[str]) -> None:
    """Give an element these fields of theirs.  A field brings all that stands in its element, so
    what nobody knows, which has paths of its own, is given after it."""
    before, paths = deepcopy(mine) if own else mine, _paths(mine.tag)
    for field in fields:
        if field == "kind":
            mine.tag = theirs.tag
        elif field == "measures":
            for measure in SENSOR_MEASURES:
                _take(mine, theirs, f"@{measure}")
        elif field in paths:
            _take(mine, theirs, paths[field])
    for field in dict.fromkeys([*own, *fields]):
        if field[0] == "?" and not _has_gone(mine, before, field[1:]):
            _take(mine, theirs if field in fields else before, field[1:])


def _has_gone(now: _Element, before: _Element, path: str) -> bool:
    """True if the element in which a path ends was there before, and is not there now."""
    holder = "/".join(_STEPS.split(path)[:-1])
    return bool(holder) and before.find(holder) is not None and now.find(holder) is None


def _take(mine: _Element, other: _Element | None, path: str) -> None:
    """Give an element what another of its kind has at a path."""
    thing, way = mine.tag, ""
    *steps, name = _STEPS.split(path)
    for step in steps:
        other = None if other is None else other.find(step)
        if other is None and mine.find(step) is None:
            return
        mine = _step(mine, thing, way, step)
        way += f"{step}/"
    if name[0] == "@":
        value = None if other is None else other.get(name[1:])
        if value is not None:
            mine.set(name[1:], value)
        elif name[1:] in mine.attrib:
            del mine.attrib[name[1:]]
        return
    there, old = [] if other is None else other.findall(name), mine.findall(name)
    tags = _tags(thing, way)
    if name not in tags and there:
        tags = [str(one.tag) for one in there[0].itersiblings("*", preceding=True)] + [name]
    new = [deepcopy(one) for one in there]
    for one, its in zip(old, new, strict=False):
        its.tail = one.tail
        mine.replace(one, its)
    for one in new[len(old) :]:
        _insert(mine, _index(mine, tags, name), one)
    for one in old[len(new) :]:
        _detach(one)
    if name == "coordinates" and old and not new and mine.tag not in OBJECTS:
        _detach(mine)  # a place without coordinates cannot be read, whatever else is in it
    else:
        _prune(mine)


def _name(element: _Element, settled: Settled, number: int) -> None:
    """Write the name of a thing, and those of what it refers to."""
    thing, name, paths = settled.there[number], settled.name(number), _paths(element.tag)
    side = settled.ours if number in settled.ours.things else settled.theirs
    if thing.kind in ("sensor", "force"):
        element.set("name", name)
    elif name != side.things[number].name:
        _say(element, paths["name"], [name])
    for field in thing.refers:
        value = settled.value(number, field)
        names = [
            target if not isinstance(target, int)
            else None if settled.there[target].kind == "base" else settled.name(target)
            for target in (() if field == "name" else value)
        ]  # fmt: skip
        if field in ("place", "endpoint1", "endpoint2"):
            for part, said, own in zip(INSIDE["place"], names, (BASE, ORIGIN), strict=True):
                _say(element, f"{paths[field]}/{part}", [own if said is None else said])
        elif field != "name":
            _say(element, paths[field], [one or BASE for one in names])


def _say(element: _Element, path: str, texts: list[str]) -> None:
    """Let the elements at a path have these texts."""
    there = element.findall(path)
    if [(one.text or "").strip() for one in there] == texts:
        return
    if not there and texts in ([""], [BASE]):  # what the file leaves out
        return
    parent, tag = _parent(element, path)
    for one in there[len(texts) :]:
        _detach(one)
    for _ in texts[len(there) :]:
        _insert(parent, len(parent), etree.Element(tag))
    for one, text in zip(element.findall(path), texts, strict=True):
        one.text = text


# --- places ---


@cache
def _paths(tag: str) -> dict[str, str]:
    """Where the fields of an object stand in its element, in the order of the writer; what the
    writer marks has its path for a field."""

    def walk(table: Table, way: str, within: str) -> Iterator[tuple[str, str]]:
        for tag, entry in table.items():
            if isinstance(entry, tuple):
                holds = "" if isinstance(entry[1], str) else "/"  # a list is within its element
                yield f"{within}{entry[0]}", f"{way}{tag}{holds}"
                if entry[1] == "drawing":
                    yield from walk(INSIDE["drawing"], f"{way}{tag}/", "drawing.")
            elif entry is not None:
                yield from walk(entry, f"{way}{tag}/", within)
            else:
                yield f"{way}{tag}/", f"{way}{tag}"

    known = OBJECTS.get(OBJECT_OF.get(tag, tag))
    return dict(walk(known.table, "", "")) if known else {}


def _tags(thing: str, way: str) -> list[str]:
    """The tags of the children that stand at a way in a thing's element, in their order."""
    paths = [path[len(way) :] for path in _paths(thing).values() if path.startswith(way)]
    return [path.split("/")[0] for path in paths]


def _step(element: _Element, thing: str, way: str, tag: str) -> _Element:
    """The child of an element at a way in a thing's element, made where it is not there."""
    there = element.find(tag)
    if there is None:
        there = etree.Element(tag)
        _insert(element, _index(element, _tags(thing, way), tag), there)
    return there


def _parent(element: _Element, path: str) -> tuple[_Element, str]:
    """The element at a path in a thing's element but for its last tag, and this tag."""
    thing, way = element.tag, ""
    *steps, last = path.split("/")
    for step in steps:
        element = _step(element, thing, way, step)
        way += f"{step}/"
    return element, last


def _index(parent: _Element, tags: list[str], tag: str) -> int:
    """Where a new child goes: behind those whose tags stand before its own."""
    known = tag in tags
    first = {*tags[: tags.index(tag)], tag} if known else {tag}
    places = [place for place, child in enumerate(parent, 1) if child.tag in first]
    return places[-1] if places else 0 if known else len(parent)


def _arrange(element: _Element, path: str, order: list[_Element]) -> None:
    """Bring the things at a path into an order; what the order does not name stays where it is."""
    parent, _ = _parent(element, path)
    tags = _tags(element.tag, path[: path.rfind("/") + 1])
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
                index = _index(parent, tags, child.tag) if first is None else parent.index(first)
            _insert(parent, index, child)
        previous = child


def _insert(parent: _Element, index: int, child: _Element) -> None:
    """Insert an element; that it has no white space behind it says that it is laid out later."""
    if index and index == len(parent) and not (parent[-1].tail or "").strip():
        parent[-1].tail = None
    child.tail = None
    parent.insert(index, child)


def _detach(child: _Element) -> None:
    """Take an element away, and the line on which it stood; text after it stays."""
    parent, previous = child.getparent(), child.getprevious()
    if parent is None:
        return
    tail, child.tail = child.tail or "", None
    if previous is not None and (tail.strip() or child.getnext() is None):
        previous.tail = ((previous.tail or "") + tail).strip() or None
    elif tail.strip():
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


# --- text ---


def _lay_out(root: _Element) -> None:
    """Indent what is new, and what stands beside it."""
    for parent in list(root.iter("*")):
        if any(child.tail is None for child in parent):
            etree.indent(parent, level=len(list(parent.iterancestors())))


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
