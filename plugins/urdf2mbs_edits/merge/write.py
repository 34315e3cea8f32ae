"""Write the merged model into the edited file, in which only what the merge changes is touched.

A value that the converted side gives is an XML element, which is copied from the converted file to
the same path in the edited one.  An entity that moves is an element that moves with everything in
it.  So numbers keep their spelling; comments and unknown elements keep their places.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from copy import deepcopy
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from lxml import etree

from urdf2mbs.plugin import BASE, INSIDE, KEPT, OBJECTS, ORIGIN, SENSOR_MEASURES, Table
from urdf2mbs_edits.diff.table import CHILD_KINDS
from urdf2mbs_edits.diff.unknown import OBJECT_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lxml.etree import _Element

    from urdf2mbs_edits.merge.decide import MergedTable

#: The field of the model that holds the children of a kind.
_CHILD_FIELDS = {kind: field for field, kind in CHILD_KINDS.items()}


def write(table: MergedTable, source: bytes) -> bytes:
    """Write the merged file.

    Args:
        table: The decisions.  The XML elements of its edited side are changed.
        source: The edited file.

    Returns:
        The merged file; ``source`` itself if the merge changes nothing in it.
    """
    edited, converted = table.edited.elements, table.converted.elements
    root = next(iter(edited.values()))
    text_before = etree.tostring(root)
    elements = dict(edited)
    converted_objects = set(converted.values())
    for number in table.entities:
        if number not in elements:
            elements[number] = _copy_without_children(converted[number], converted_objects)
    for number, fields in _list_copied_fields(table).items():
        unknown = [field for field in table.edited.values[number] if field[0] == "?"]
        _copy_fields(elements[number], converted[number], fields, unknown)
    for number in table.entities:
        _write_names(elements[number], table, number)
    for (number, field), order in table.orders.items():
        path = _list_paths(elements[number].tag)[_CHILD_FIELDS[field[1:-1]]]
        _arrange(elements[number], path, [elements[child] for child in order])
    for number, element in edited.items():
        if number not in table.entities:
            _detach(element)
    if etree.tostring(root) == text_before:
        return source
    _indent(root)
    return _serialize(root, source)


def _list_copied_fields(table: MergedTable) -> dict[int, list[str]]:
    """List the fields that each entity takes from the converted side, without orders."""
    fields: dict[int, list[str]] = {}
    for number, field in sorted(table.from_converted):
        if number in table.entities and field[0] != "[":
            fields.setdefault(number, []).append(field)
    return fields


def _copy_without_children(element: _Element, objects: set[_Element]) -> _Element:
    """Copy an entity's element without the elements of entities in it."""
    copy = deepcopy(element)
    copy.tail = None
    pairs = list(zip(element.iter(), copy.iter(), strict=True))
    for part, part_of_copy in pairs:
        if part in objects and part is not element:
            _detach(part_of_copy)
    return copy


# --- values ---

#: Between two steps of a path; an XML namespace may contain slashes, too.
_PATH_SEPARATOR = re.compile(r"/(?![^{]*})")


def _copy_fields(
    element: _Element, converted: _Element, fields: list[str], unknown: list[str]
) -> None:
    """Copy fields from the converted element of an entity.

    A field is copied with all that its element contains.  So unknown content, which has paths of
    its own, is copied or put back afterwards.

    Args:
        element: The element that is changed.
        converted: The element of the same entity in the converted file.
        fields: The fields to copy.
        unknown: The fields of unknown content in ``element``.
    """
    before = deepcopy(element) if unknown else element
    paths = _list_paths(element.tag)
    for field in fields:
        if field == "kind":
            element.tag = converted.tag
        elif field == "measures":
            for name in [*element.attrib, *converted.attrib]:
                if name in SENSOR_MEASURES:
                    _copy_attribute(element, converted, str(name))
        elif field in paths:
            _copy_path(element, converted, paths[field])
    for field in dict.fromkeys([*unknown, *fields]):
        if field[0] == "?" and not _is_container_removed(element, before, field[1:]):
            _copy_path(element, converted if field in fields else before, field[1:])


def _is_container_removed(element: _Element, before: _Element, path: str) -> bool:
    """Return whether the element that contains the end of a path was removed."""
    container = "/".join(_PATH_SEPARATOR.split(path)[:-1])
    if not container:
        return False
    return before.find(container) is not None and element.find(container) is None


def _copy_path(element: _Element, source: _Element | None, path: str) -> None:
    """Make an element have what another of its kind has at a path, an element or attribute."""
    *steps, name = _PATH_SEPARATOR.split(path)
    parent = element
    for index, step in enumerate(steps):
        source = None if source is None else source.find(step)
        if source is None and parent.find(step) is None:
            return
        parent = _make_step(parent, _Location(element.tag, steps[:index]), step)
    if name[0] == "@":
        _copy_attribute(parent, source, name[1:])
        return
    originals = [] if source is None else source.findall(name)
    new = [deepcopy(original) for original in originals]
    old = parent.findall(name)
    tags = _Location(element.tag, steps).list_tags()
    if name not in tags and originals:
        siblings = originals[0].itersiblings("*", preceding=True)
        tags = [*(str(sibling.tag) for sibling in siblings), name]
    for old_element, new_element in zip(old, new, strict=False):
        new_element.tail = old_element.tail
        parent.replace(old_element, new_element)
    for new_element in new[len(old) :]:
        _insert(parent, _find_index(parent, tags, name), new_element)
    for old_element in old[len(new) :]:
        _detach(old_element)
    if name == "coordinates" and old and not new and parent.tag not in OBJECTS:
        _detach(parent)  # a reader requires the coordinates, whatever else is in the element
    else:
        _prune(parent)


def _copy_attribute(element: _Element, source: _Element | None, name: str) -> None:
    """Make an element have the attribute that another has, or not have it."""
    value = None if source is None else source.get(name)
    if value is not None:
        element.set(name, value)
    elif name in element.attrib:
        del element.attrib[name]


def _write_names(element: _Element, table: MergedTable, number: int) -> None:
    """Write the merged names of an entity and of its references' targets."""
    entity, name, paths = table.entities[number], table.get_name(number), _list_paths(element.tag)
    if entity.kind in ("sensor", "force"):
        element.set("name", name)
    elif name != entity.name:
        _write_texts(element, paths["name"], [name])
    for field in entity.references:
        if field == "name":
            continue
        names = [_get_target_name(table, target) for target in table.get_value(number, field)]
        if field in ("place", "endpoint1", "endpoint2"):
            for tag, text, default in zip(INSIDE["place"], names, (BASE, ORIGIN), strict=True):
                _write_texts(element, f"{paths[field]}/{tag}", [default if text is None else text])
        else:
            _write_texts(element, paths[field], [text or BASE for text in names])


def _get_target_name(table: MergedTable, target: int | str | None) -> str | None:
    """Return the merged name of what an entity refers to; None for the base."""
    if not isinstance(target, int):
        return target
    return None if table.entities[target].kind == "base" else table.get_name(target)


def _write_texts(element: _Element, path: str, texts: list[str]) -> None:
    """Make the elements at a path have these texts, one each."""
    old = element.findall(path)
    if [(old_element.text or "").strip() for old_element in old] == texts:
        return
    if not old and texts in ([""], [BASE]):  # the file omits the default
        return
    parent, tag = _make_parent(element, path)
    for surplus in old[len(texts) :]:
        _detach(surplus)
    for _ in texts[len(old) :]:
        _insert(parent, len(parent), etree.Element(tag))
    for text_element, text in zip(element.findall(path), texts, strict=True):
        text_element.text = text


# --- positions in the file ---


class _Location(NamedTuple):
    """An element inside the element of an object."""

    object_tag: str
    steps: Sequence[str]
    """Tags from the object's element to the element."""

    def list_tags(self) -> list[str]:
        """List the tags of the children that a writer gives this element, in their order."""
        start = "".join(f"{step}/" for step in self.steps)
        paths = _list_paths(self.object_tag).values()
        return [path[len(start) :].split("/")[0] for path in paths if path.startswith(start)]


@cache
def _list_paths(tag: str) -> dict[str, str]:
    """List where the fields of an object are in its element, in the order of the writer.

    Args:
        tag: Tag of the object's element.

    Returns:
        Paths by field.  An empty element that marks something has its path for a field.
    """

    def walk(table: Table, start: str, prefix: str) -> Iterator[tuple[str, str]]:
        for tag, entry in table.items():
            if isinstance(entry, tuple):
                is_list = not isinstance(entry[1], str)  # its children are inside its element
                yield f"{prefix}{entry[0]}", f"{start}{tag}" + ("/" if is_list else "")
                if entry[1] == "drawing":
                    yield from walk(INSIDE["drawing"], f"{start}{tag}/", "drawing.")
            elif entry is not None:
                yield from walk(entry, f"{start}{tag}/", prefix)
            else:
                yield f"{start}{tag}/", f"{start}{tag}"

    object_ = OBJECTS.get(OBJECT_KEYS.get(tag, tag))
    return dict(walk(object_.table, "", "")) if object_ else {}


def _make_step(element: _Element, location: _Location, tag: str) -> _Element:
    """Return the child of an element at a location; make it if it does not exist."""
    child = element.find(tag)
    if child is None:
        child = etree.Element(tag)
        _insert(element, _find_index(element, location.list_tags(), tag), child)
    return child


def _make_parent(element: _Element, path: str) -> tuple[_Element, str]:
    """Return the parent element of a path in an object's element, and the last tag."""
    *steps, last = path.split("/")
    parent = element
    for index, step in enumerate(steps):
        parent = _make_step(parent, _Location(element.tag, steps[:index]), step)
    return parent, last


def _find_index(parent: _Element, tags: list[str], tag: str) -> int:
    """Return the index of a new child: after all children whose tags come before its own."""
    is_known = tag in tags
    predecessors = {*tags[: tags.index(tag)], tag} if is_known else {tag}
    indices = [index for index, child in enumerate(parent, 1) if child.tag in predecessors]
    if indices:
        return indices[-1]
    return 0 if is_known else len(parent)


def _arrange(element: _Element, path: str, order: list[_Element]) -> None:
    """Bring the children at a path into an order; all other children keep their places."""
    parent, _ = _make_parent(element, path)
    tags = _Location(element.tag, path.split("/")[:-1]).list_tags()
    indices = {child: index for index, child in enumerate(parent)}
    first = next((child for child in order if child in indices), None)
    last_index, previous = -1, None
    for child in order:
        index = indices.get(child, -1)
        if index > last_index:
            last_index = index
        else:
            _detach(child)
            if previous is not None:
                index = parent.index(previous) + 1
            elif first is not None:
                index = parent.index(first)
            else:
                index = _find_index(parent, tags, child.tag)
            _insert(parent, index, child)
        previous = child


def _insert(parent: _Element, index: int, child: _Element) -> None:
    """Insert an element without a tail, so that ``_indent`` finds it."""
    if index and index == len(parent) and not (parent[-1].tail or "").strip():
        parent[-1].tail = None
    child.tail = None
    parent.insert(index, child)


def _detach(child: _Element) -> None:
    """Remove an element and its line; keep text that follows it."""
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
    """Remove an element that has become empty, unless a writer writes it empty, too."""
    if len(element) or (element.text or "").strip():
        return
    element.text = None
    if element.tag not in KEPT and element.tag not in OBJECTS and not element.attrib:
        _detach(element)


# --- text ---


def _indent(root: _Element) -> None:
    """Indent inserted elements and their siblings."""
    for parent in list(root.iter("*")):
        if any(child.tail is None for child in parent):
            etree.indent(parent, level=len(list(parent.iterancestors())))


def _serialize(root: _Element, source: bytes) -> bytes:
    """Return a tree as bytes, with the encoding, first line and line ends of its file."""
    tree = root.getroottree()
    text = etree.tostring(tree, encoding="unicode") + source[len(source.rstrip()) :].decode()
    if b" />" in source:  # as MBSysPad writes it
        text = re.sub(r"(?s)(<!--.*?-->|<\?.*?\?>)|/>", lambda match: match[1] or " />", text)
    if b"\r\n" in source:
        text = text.replace("\r\n", "\n")
        text = text.replace("\n", "\r\n")
    first_line = re.match(rb"(\xef\xbb\xbf)?<\?xml[^>]*\?>\s*", source)
    data = text.encode(tree.docinfo.encoding or "UTF-8", "xmlcharrefreplace")
    return (first_line[0] if first_line else b"") + data
