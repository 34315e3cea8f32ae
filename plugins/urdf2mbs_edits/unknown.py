"""The elements and attributes of an .mbs file that the model does not know: of other versions."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.mbs.fields import INSIDE, MBS, OBJECTS, Table
from urdf2mbs.mbs.model import SENSOR_MEASURES, Mbs
from urdf2mbs.mbs.reader import read_again

if TYPE_CHECKING:
    from lxml.etree import _Element

#: The attributes that the model knows, in each element; all others are unknown.
_SENSOR = frozenset(["name", *SENSOR_MEASURES])
ATTRIBUTES = {"color": frozenset("RGB"), "sensor": _SENSOR, "extforce": _SENSOR}
#: MBSysPad and urdf2mbs write it into every body, and no version reads it.
IGNORED = frozenset(["x3D_frame"])


def unknown(mbs: Mbs) -> dict[int, dict[str, str]]:
    """The unknown elements and attributes of the file from which a model was read, as canonical XML
    where numbers have one spelling; none of a model that was not read.

    By the number of the nearest object's ``origin``, then by the path from its element.  Comments
    and white space say nothing.
    """
    if mbs.origin is None:
        return {}
    _, elements = read_again(mbs.origin.source)
    numbers = {element: number for number, element in enumerate(elements)}
    texts: dict[int, dict[str, str]] = {}

    def note(number: int, path: str, text: str) -> None:
        there = texts.setdefault(number, {})
        there[path] = there.get(path, "") + text

    def walk(element: _Element, table: Table, number: int, path: str) -> None:
        attributes: Any = element.items()
        for name, value in sorted(attributes):
            if name not in ATTRIBUTES.get(element.tag, ()):
                note(number, f"{path}@{name}", str(value))
        for child in element.iterchildren("*"):
            entry = table.get(child.tag)
            if child in numbers:
                known = OBJECTS[child.tag].table if child.tag in OBJECTS else {}
                walk(child, known, numbers[child], "")
            elif entry is not None:
                if isinstance(entry, tuple):
                    entry = INSIDE.get(str(entry[1]), {})
                walk(child, entry, number, f"{path}{child.tag}/")
            elif child.tag not in IGNORED:
                note(number, f"{path}{child.tag}", _canonical(child))

    walk(elements[0], MBS, 0, "")
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
