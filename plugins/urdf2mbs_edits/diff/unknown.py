"""The elements and attributes of an .mbs file that the model does not know, as of other versions.

They are compared and merged as text.
"""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.plugin import INSIDE, OBJECTS, SENSOR_MEASURES, Table

if TYPE_CHECKING:
    from collections.abc import Container

    from lxml.etree import _Element

#: The key of ``OBJECTS`` for an element whose tag is not the key.
OBJECT_KEYS = {"mbsDescR7": "mbs", "x3D": "view"}
_SENSOR_ATTRIBUTES = frozenset(["name", *SENSOR_MEASURES])
#: The attributes that the model knows, by tag.
_KNOWN_ATTRIBUTES = {
    "color": frozenset("RGB"),
    "sensor": _SENSOR_ATTRIBUTES,
    "extforce": _SENSOR_ATTRIBUTES,
}
#: MBSysPad and urdf2mbs write these elements into every body; no version reads them.
_IGNORED_TAGS = frozenset(["x3D_frame"])


def find_unknown_content(element: _Element, objects: Container[_Element]) -> dict[str, str]:
    """Find what the model does not know of an object's element.  Comments and blanks are ignored.

    Args:
        element: The element of the object.
        objects: The elements of all objects; those inside ``element`` are left out.

    Returns:
        Values of attributes and canonical XML of elements, with one spelling for each number, by
        path: ``brake/force``, ``nature/@unit``.
    """
    texts: dict[str, str] = {}

    def walk(element: _Element, table: Table, path: str) -> None:
        attributes: Any = element.items()
        for name, value in sorted(attributes):
            if name not in _KNOWN_ATTRIBUTES.get(element.tag, ()):
                texts[f"{path}@{name}"] = str(value)
        for child in element.iterchildren("*"):
            if child in objects or child.tag in _IGNORED_TAGS:
                continue
            entry, child_path = table.get(child.tag), f"{path}{child.tag}"
            if entry is None:
                texts[child_path] = texts.get(child_path, "") + _make_canonical(child)
            else:
                inside = INSIDE.get(str(entry[1]), {}) if isinstance(entry, tuple) else entry
                walk(child, inside, f"{child_path}/")

    object_ = OBJECTS.get(OBJECT_KEYS.get(element.tag, element.tag))
    walk(element, object_.table if object_ else {}, "")
    return texts


def _make_canonical(element: _Element) -> str:
    """Return the canonical XML of an element, with one spelling for each number."""
    copy = deepcopy(element)
    copy.tail = None
    for part in copy.iter("*"):
        part.text = normalize_number((part.text or "").strip())
        for name, value in part.items():
            part.set(name, normalize_number(str(value)))
        for child in part:
            child.tail = None
    return etree.tostring(copy, method="c14n", with_comments=False).decode()


def normalize_number(text: str) -> str:
    """Return the same text for all spellings of a number; return other text unchanged."""
    try:
        return repr(float(text) + 0.0)
    except ValueError:
        return text
