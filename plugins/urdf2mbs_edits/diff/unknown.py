"""The elements and attributes of an .mbs file that the model does not know: of other versions."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.plugin import INSIDE, OBJECTS, SENSOR_MEASURES, Table

if TYPE_CHECKING:
    from collections.abc import Container

    from lxml.etree import _Element

#: The objects whose elements are called otherwise.
OBJECT_OF = {"mbsDescR7": "mbs", "x3D": "view"}
#: The attributes that the model knows, in each element; all others are unknown.
_SENSOR = frozenset(["name", *SENSOR_MEASURES])
_ATTRIBUTES = {"color": frozenset("RGB"), "sensor": _SENSOR, "extforce": _SENSOR}
#: MBSysPad and urdf2mbs write it into every body, and no version reads it.
_IGNORED = frozenset(["x3D_frame"])


def unknown(element: _Element, objects: Container[_Element]) -> dict[str, str]:
    """The unknown elements and attributes of the element of an object, as canonical XML where
    numbers have one spelling, by their paths; ``objects`` are the elements of all objects, which
    have their own.  Comments and white space say nothing.
    """
    texts: dict[str, str] = {}

    def walk(element: _Element, table: Table, path: str) -> None:
        attributes: Any = element.items()
        for name, value in sorted(attributes):
            if name not in _ATTRIBUTES.get(element.tag, ()):
                texts[f"{path}@{name}"] = str(value)
        for child in element.iterchildren("*"):
            entry, at = table.get(child.tag), f"{path}{child.tag}"
            if child in objects or child.tag in _IGNORED:
                continue
            if entry is None:
                texts[at] = texts.get(at, "") + _canonical(child)
            else:
                inside = INSIDE.get(str(entry[1]), {}) if isinstance(entry, tuple) else entry
                walk(child, inside, f"{at}/")

    known = OBJECTS.get(OBJECT_OF.get(element.tag, element.tag))
    walk(element, known.table if known else {}, "")
    return texts


def _canonical(element: _Element) -> str:
    """The canonical XML of an element, with one spelling for each number."""
    plain = deepcopy(element)
    plain.tail = None
    for part in plain.iter("*"):
        part.text = spelling((part.text or "").strip())
        for name, value in part.items():
            part.set(name, spelling(str(value)))
        for child in part:
            child.tail = None
    return etree.tostring(plain, method="c14n", with_comments=False).decode()


def spelling(text: str) -> str:
    """One spelling for all that spell the same number; other text as it is."""
    try:
        return repr(float(text) + 0.0)
    except ValueError:
        return text
