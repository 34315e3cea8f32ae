"""What an .mbs file says and the model does not know: elements and attributes of other versions."""

from __future__ import annotations

from collections.abc import Container
from copy import deepcopy
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.mbs.model import SENSOR_MEASURES, Mbs, Origin
from urdf2mbs.mbs.reader import NO_LISTS, _parse, _Reader

if TYPE_CHECKING:
    from lxml.etree import _Element

    from urdf2mbs.mbs.reader import Children, Lists

#: The attributes that the model knows, in each element; all others are unknown.
_SENSOR = frozenset(["name", *SENSOR_MEASURES])
ATTRIBUTES = {"color": frozenset("RGB"), "sensor": _SENSOR, "extforce": _SENSOR}
#: MBSysPad and urdf2mbs write it into every body, and no version reads it.
IGNORED = frozenset(["x3D_frame"])


def unknown(mbs: Mbs) -> dict[int, dict[str, str]]:
    """What the model does not know of the file that it was read from; nothing of a model that
    was not read.

    By the number of the nearest object's ``origin``, then by the path from its element: the
    canonical XML, where numbers have one spelling.  Comments and white space say nothing.
    """
    if mbs.origin is None:
        return {}
    reader = _NotingReader(mbs.origin.source, "")
    root = _parse(mbs.origin.source, "")
    reader.mbs(root)
    numbers = {element: number for number, element in enumerate(reader.elements)}
    texts: dict[int, dict[str, str]] = {}

    def note(number: int, path: str, text: str) -> None:
        there = texts.setdefault(number, {})
        count = sum(key.split("[")[0] == path for key in there)
        there[f"{path}[{count + 1}]" if count else path] = text

    def walk(element: _Element, number: int, path: str) -> None:
        attributes: Any = element.items()
        for name, value in sorted(attributes):
            if name not in ATTRIBUTES.get(element.tag, ()):
                note(number, f"{path}@{name}", str(value))
        for child in element.iterchildren("*"):
            below = f"{path}{child.tag}"
            if child in numbers:
                walk(child, numbers[child], "")
            elif child in reader.known:
                walk(child, number, f"{below}/")
            elif child.tag not in IGNORED:
                note(number, below, _canonical(child))

    walk(root, 0, "")
    return texts


class _NotingReader(_Reader):
    """A reader that notes each element from which it takes something."""

    def __init__(self, data: bytes, file: str) -> None:
        super().__init__(data, file)
        self.known: set[_Element] = set()

    def children(
        self, element: _Element, known: Container[str], many: Lists = NO_LISTS
    ) -> Children:
        self.known.update(child for child in element if child.tag in known or child.tag in many)
        return super().children(element, known, many)

    def listed(self, element: _Element | None, tag: str) -> list[_Element]:
        elements = super().listed(element, tag)
        self.known.update(elements)
        return elements

    def axes(self, element: _Element, tags: list[str]) -> list[_Element]:
        elements = super().axes(element, tags)
        self.known.update(elements)
        return elements

    def origin(self, element: _Element) -> Origin | None:
        self.known.add(element)
        return super().origin(element)


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
