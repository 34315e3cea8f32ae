"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache, lru_cache
from math import isfinite
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.mbs.fields import INSIDE, KEPT, MARK, OBJECTS, Kind, Table
from urdf2mbs.mbs.model import (
    BASE,
    CUTS,
    JOINT_TYPES,
    LINKS,
    NATURES,
    ORIGIN,
    SENSOR_MEASURES,
    SHAPES,
    SYMBOLS,
    Mbs,
    Part,
)
from urdf2mbs.mbs.reader import read_again
from urdf2mbs.mbs.rewrite import AT, FROM, Rewriter

if TYPE_CHECKING:
    from lxml.etree import _Element


class _NotFiniteError(ValueError):
    """A number that no .mbs file can hold."""


_ESCAPED = str.maketrans({
    "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#x27;", "\r": "&#13;",
    "\n": "&#10;",
})  # fmt: skip
#: As Python reads it.
_NOT_FINITE = ("inf", "infinity", "nan")
_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]").search


def write(mbs: Mbs, *, other: bytes | None = None) -> bytes:
    """The file as bytes: the same bytes for the same model.

    Bodies, joints and points are written in the order of the model.  Numbers are written to
    the last digit.  What is None is left out; MBSysPad wants every body's ``drawing``, the
    3D viewer wants ``view``.  A model that was read is written into its file: only what has
    changed in the model changes there.  Objects may come from one ``other`` file, with all that
    stands in their elements.

    Raises ValueError for what no .mbs can hold: a number that is not finite, a character
    that is not XML's, a word that the format does not have, a body without a joint, a sensor
    or force on a point of the base.
    """
    if mbs.origin is None:
        return _Writer().mbs(mbs).encode()
    source = mbs.origin.source
    before, elements = read_again(source)
    texts = [_Writer(source).mbs(before), _Writer(source, other).mbs(mbs)]
    if texts[0] == texts[1]:
        return source
    others = None
    if other is not None:
        theirs, their_elements = read_again(other)
        others = their_elements, etree.fromstring(_Writer(other).mbs(theirs).encode())
    was, now = [etree.fromstring(text.encode()) for text in texts]
    Rewriter(elements, was, now, others).change(elements[0], was, now)
    return _spelled(elements[0], source)


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


class _Writer:
    """Gives the elements of a model as text.  ``pad`` stands before each of them."""

    def __init__(self, source: bytes | None = None, other: bytes | None = None) -> None:
        self.source, self.other = source, other
        """The files to which the origins belong that are marked."""
        self.marked: set[int] = set()

    def mbs(self, mbs: Mbs) -> str:
        _check(mbs)
        inside = self.object("mbs", mbs, "  ")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{inside}</mbsDescR7>\n'

    def object(self, key: str, thing: Any, pad: str) -> str:
        """The children of the element of one of the ``OBJECTS``."""
        owner = OBJECTS[key]
        try:
            return self.table(owner.table, thing, pad)
        except _NotFiniteError as error:
            if not owner.what:
                raise
            raise ValueError(f"{owner.in_words(thing)} {error}") from None

    def table(self, table: Table, thing: Any, pad: str) -> str:
        texts: list[str] = []
        for tag, entry in table.items():
            if isinstance(entry, tuple):
                value = getattr(thing, entry[0])
                if value is not None:
                    texts.append(self.value(tag, entry[1], value, pad))
            elif entry is MARK:
                texts.append(f"{pad}<{tag}/>\n")
            else:
                texts.append(_around(tag, self.table(entry, thing, f"{pad}  "), pad))
        return "".join(texts)

    def part(self, tag: str, part: Part, pad: str) -> str:
        inside = self.object(tag, part, f"{pad}  ")
        return f"{pad}<{tag}{self.mark(part)}>\n{inside}{pad}</{tag}>\n"

    def mark(self, part: Part) -> str:
        """The mark of an object that was read; a copy of one is new."""
        origin = part.origin
        if self.source is None or origin is None:
            return ""
        if origin.source is self.other:
            return f' {FROM}="{origin.number}"'
        if origin.source is not self.source or origin.number in self.marked:
            return ""
        self.marked.add(origin.number)
        return f' {AT}="{origin.number}"'

    def value(self, tag: str, kind: Kind | frozenset[str], value: Any, pad: str) -> str:
        within = f"{pad}  "
        match kind:
            case "xyz" | "xy" | "inertia":
                return _gaps(tag, kind, pad) % tuple(map(_number, value))
            case "number":
                return f"{pad}<{tag}>{_number(value)}</{tag}>\n"
            case "text" | "word":
                return f"{pad}<{tag}>{_text(value)}</{tag}>\n"
            case "title":
                return f"{pad}<{tag}>{_text(value)}</{tag}>\n" if value else ""
            case "texts":
                return "".join([f"{pad}<{tag}>{_text(text)}</{tag}>\n" for text in value])
            case "flag":
                return f"{pad}<{tag}/>\n" if value else ""
            case "color":
                red, green, blue = value
                return f'{pad}<{tag} R="{red:d}" G="{green:d}" B="{blue:d}"/>\n'
            case "sensor":
                measures = "".join([f' {measure}="true"' for measure in value.measures])
                return f'{pad}<{tag}{self.mark(value)} name="{_text(value.name)}"{measures}/>\n'
            case "place":
                body, point = value
                inside = self.value("bodyname", "text", BASE if body is None else body, within)
                inside += self.value(
                    "pointname", "text", ORIGIN if point is None else point, within
                )
            case "coordinates":
                inside = self.value("coordinates", "xyz", value, within)
            case "control points":
                inside = "".join([self.value("control_point", "xy", xy, within) for xy in value])
            case "symbols":
                inside = "".join([f"{within}<{symbol}/>\n" for symbol in value])
            case "base" | "drawing" | "view":
                inside = self.object(kind, value, within)
            case "parts":
                return "".join([self.part(tag, part, pad) for part in value])
            case _:
                only = next(iter(kind))
                inside = "".join(
                    [self.part(getattr(part, "kind", only), part, within) for part in value]
                )
        return _around(tag, inside, pad)


@cache
def _gaps(tag: str, kind: str, pad: str) -> str:
    """An element of numbers, with ``%s`` for each."""
    parts = "".join([f"{pad}  <{part}>%s</{part}>\n" for part in INSIDE[kind]])
    return f"{pad}<{tag}>\n{parts}{pad}</{tag}>\n"


def _around(tag: str, inside: str, pad: str) -> str:
    """An element around others; without others only if it is ``KEPT``."""
    if inside:
        return f"{pad}<{tag}>\n{inside}{pad}</{tag}>\n"
    return f"{pad}<{tag}/>\n" if tag in KEPT else ""


@lru_cache(4096)
def _number(value: float) -> str:
    """A number to its last digit; minus zero is zero."""
    number = float(value)
    if not isfinite(number):
        raise _NotFiniteError(f"has the number {number}, which no .mbs file can hold")
    return repr(number + 0.0)


def _text(text: str) -> str:
    if _NOT_XML(text):
        raise ValueError(f"an .mbs file cannot hold the name {text!r}")
    return text.translate(_ESCAPED)


def _check(mbs: Mbs) -> None:
    """Raises ValueError for what no .mbs can hold."""
    for point in mbs.base.points:
        if point.sensor is not None or point.extforce is not None:
            raise ValueError(
                f"point '{point.name}' of the base has a sensor or an external force: "
                "Robotran's C library cannot read that"
            )
    words: list[tuple[Iterable[str], frozenset[str], str]] = [
        ([cut.kind for cut in mbs.cuts], CUTS, "a cut"),
        ([link.kind for link in mbs.links], LINKS, "a link"),
        ([shape.kind for shape in mbs.base.shapes], SHAPES, "a shape"),
    ]
    for body in mbs.bodies:
        if not body.joints:
            raise ValueError(f"body '{body.name}' has no joint: Robotran would lose it")
        words.append(([shape.kind for shape in body.shapes], SHAPES, "a shape"))
        for joint in body.joints:
            if joint.type not in JOINT_TYPES or joint.nature not in NATURES:
                raise ValueError(
                    f"joint '{joint.name}' is '{joint.type}', '{joint.nature}': "
                    ".mbs has no such joint"
                )
            words.append((joint.symbols or (), SYMBOLS, f"joint '{joint.name}'"))
        for point in body.points:
            for tag, sensor in (("sensor", point.sensor), ("extforce", point.extforce)):
                if sensor is not None:
                    words.append((sensor.measures, SENSOR_MEASURES, f"{tag} '{sensor.name}'"))
    for said, known, what in words:
        for word in said:
            if word not in known:
                raise ValueError(f"{what} is or has '{word}': .mbs has no such word")
    for model in mbs.user_models:
        for parameter in model.parameters:
            for value in parameter.values if parameter.type != "structure" else ():
                if value.strip().lstrip("+-").lower() in _NOT_FINITE:
                    raise ValueError(
                        f"parameter '{parameter.name}' of user model '{model.name}' has the number "
                        f"{float(value)}, which no .mbs file can hold"
                    )
