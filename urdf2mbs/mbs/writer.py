"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from math import isfinite
from typing import TYPE_CHECKING, Any

from lxml import etree

from urdf2mbs.mbs.fields import INSIDE, KEPT, MBS, OBJECTS, POINT, Table
from urdf2mbs.mbs.model import (
    BASE,
    CUTS,
    JOINT_TYPES,
    LINKS,
    NATURES,
    ORIGIN,
    RGB,
    SENSOR_MEASURES,
    SHAPES,
    SYMBOLS,
    XY,
    Mbs,
    Part,
    Sensor,
)
from urdf2mbs.mbs.reader import read_again
from urdf2mbs.mbs.rewrite import AT, FROM, rewrite

if TYPE_CHECKING:
    from lxml.etree import _Element


class _Numbers(dict[float, str]):
    """Each number as text, to its last digit; minus zero is zero."""

    where = ""
    """The element that is being written."""

    def __missing__(self, value: float) -> str:
        number = float(value)
        if not isfinite(number):
            raise ValueError(f"{self.where} has the number {number}, which no .mbs file can hold")
        text = self[value] = repr(number + 0.0)
        return text


class _Texts(dict[str, str]):
    """Each text with the characters escaped that XML needs itself."""

    def __missing__(self, value: str) -> str:
        text = value
        if not (value.isidentifier() or _PLAIN(value)):
            if re.search(_NOT_XML, value):
                raise ValueError(f"an .mbs file cannot hold the name {value!r}")
            text = value.translate(_ESCAPED)
        self[value] = text
        return text


_ESCAPED = str.maketrans(
    {
        "&": "&amp;",
        "<": "&lt;",
        ">": "&gt;",
        '"': "&quot;",
        "'": "&#x27;",
        "\r": "&#13;",
        "\n": "&#10;",
    }
)
_PLAIN = re.compile(r"[A-Za-z0-9_./ -]*").fullmatch
#: As Python reads it.
_NOT_FINITE = r"(?i)\s*[+-]?(inf|infinity|nan)\s*"
_NOT_XML = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"


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
    was = _Writer(source).mbs(before).encode()
    now = _Writer(source, other).mbs(mbs).encode()
    if was == now:
        return source
    others = None
    if other is not None:
        theirs, their_elements = read_again(other)
        others = their_elements, etree.fromstring(_Writer(other).mbs(theirs).encode())
    rewrite(elements, etree.fromstring(was), etree.fromstring(now), others)
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


#: A body's own frame is not drawn.
_OWN_FRAME = {tag: entry for tag, entry in POINT.items() if tag != "graphics"}


class _Writer:
    def __init__(self, source: bytes | None = None, other: bytes | None = None) -> None:
        self.source, self.other = source, other
        """The files to which the origins belong that are marked."""
        self.marked: set[int] = set()
        self.number = _Numbers()
        self.text = _Texts()

    def mbs(self, mbs: Mbs) -> str:
        _check(mbs)
        elements = self.elements(mbs, MBS, "  ")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{elements}</mbsDescR7>\n'

    def elements(self, thing: Any, table: Table, pad: str) -> str:
        """The elements of a table, without those whose value is None."""
        out: list[str] = []
        for tag, entry in table.items():
            if isinstance(entry, tuple):
                field, kind = entry
                value = getattr(thing, field)
                if value is None:
                    continue
                if isinstance(kind, str):
                    out.append(_KINDS[kind](self, tag, value, pad))
                    continue
                only = next(iter(kind))
                inner = "".join([self.part(getattr(part, "kind", only), part, f"{pad}  ")
                                 for part in value])  # fmt: skip
            elif entry is None:
                out.append(f"{pad}<{tag}/>\n")
                continue
            else:
                inner = self.elements(thing, entry, f"{pad}  ")
            if inner or tag in KEPT:
                out.append(_element(tag, inner, pad))
        return "".join(out)

    def part(self, tag: str, part: Any, pad: str) -> str:
        """The element of an object."""
        _, table, what = OBJECTS[tag]
        above = self.number.where
        if tag == "point":
            table = _OWN_FRAME if part.name == ORIGIN else table
        elif what:
            self.number.where = f"{what} '{part.name}'"
        inner = self.elements(part, table, f"{pad}  ")
        self.number.where = above
        return f"{pad}<{tag}{self.at(part)}>\n{inner}{pad}</{tag}>\n"

    def at(self, part: Part) -> str:
        """The mark of an object that was read; a copy of one is new."""
        origin = part.origin
        if self.source is None or origin is None:
            return ""
        if self.other is not None and origin.source is self.other:
            return f' {FROM}="{origin.number}"'
        if origin.source is not self.source:
            return ""
        if origin.number in self.marked:
            return ""
        self.marked.add(origin.number)
        return f' {AT}="{origin.number}"'

    # --- the kinds of values ---

    def nested(self, kind: str, where: str, tag: str, value: Any, pad: str) -> str:
        above = self.number.where
        self.number.where = where or above
        inner = self.elements(value, INSIDE[kind], f"{pad}  ")
        self.number.where = above
        return _element(tag, inner, pad)

    def parts(self, tag: str, parts: Iterable[Part], pad: str) -> str:
        return "".join([self.part(tag, part, pad) for part in parts])

    def texts(self, tag: str, texts: Iterable[str], pad: str) -> str:
        return "".join([f"{pad}<{tag}>{self.text[text]}</{tag}>\n" for text in texts])

    def numbers(self, tag: str, tags: Iterable[str], values: Iterable[float], pad: str) -> str:
        """An element with one for each of several numbers."""
        n = self.number
        parts = zip(tags, values, strict=False)
        inner = "".join([f"{pad}  <{part}>{n[value]}</{part}>\n" for part, value in parts])
        return f"{pad}<{tag}>\n{inner}{pad}</{tag}>\n"

    def control_points(self, tag: str, points: Iterable[XY], pad: str) -> str:
        return _element(
            tag, "".join(self.numbers("control_point", "xy", xy, f"{pad}  ") for xy in points), pad
        )

    def place(self, tag: str, place: tuple[str | None, str | None], pad: str) -> str:
        body, point = place
        inner = self.texts("bodyname", [BASE if body is None else body], f"{pad}  ")
        inner += self.texts("pointname", [ORIGIN if point is None else point], f"{pad}  ")
        return _element(tag, inner, pad)

    def sensor(self, tag: str, sensor: Sensor, pad: str) -> str:
        measures = "".join([f' {measure}="true"' for measure in sensor.measures])
        return f'{pad}<{tag}{self.at(sensor)} name="{self.text[sensor.name]}"{measures}/>\n'


def _element(tag: str, inner: str, pad: str) -> str:
    return f"{pad}<{tag}>\n{inner}{pad}</{tag}>\n" if inner else f"{pad}<{tag}/>\n"


def _color(tag: str, color: RGB, pad: str) -> str:
    red, green, blue = color
    return f'{pad}<{tag} R="{red:d}" G="{green:d}" B="{blue:d}"/>\n'


_KINDS: dict[str, Callable[[_Writer, str, Any, str], str]] = {
    "text": lambda w, tag, value, pad: f"{pad}<{tag}>{w.text[value]}</{tag}>\n",
    "title": lambda w, tag, value, pad: w.texts(tag, [value] if value else [], pad),
    "word": lambda _, tag, value, pad: f"{pad}<{tag}>{value}</{tag}>\n",
    "number": lambda w, tag, value, pad: f"{pad}<{tag}>{w.number[value]}</{tag}>\n",
    "xy": lambda w, tag, value, pad: w.numbers(tag, "xy", value, pad),
    "xyz": lambda w, tag, value, pad: w.numbers(tag, "xyz", value, pad),
    "coordinates": lambda w, tag, value, pad: _element(
        tag, w.numbers("coordinates", "xyz", value, f"{pad}  "), pad
    ),
    "inertia": lambda w, tag, value, pad: w.numbers(tag, INSIDE["inertia"], value, pad),
    "control points": _Writer.control_points,
    "color": lambda _, tag, value, pad: _color(tag, value, pad),
    "flag": lambda _, tag, value, pad: f"{pad}<{tag}/>\n" if value else "",
    "symbols": lambda _, tag, value, pad: _element(
        tag, "".join(f"{pad}  <{symbol}/>\n" for symbol in value), pad
    ),
    "place": _Writer.place,
    "sensor": _Writer.sensor,
    "texts": _Writer.texts,
    "parts": _Writer.parts,
    "base": lambda w, tag, value, pad: w.nested("base", "the base", tag, value, pad),
    "drawing": lambda w, tag, value, pad: w.nested("drawing", "", tag, value, pad),
    "view": lambda w, tag, value, pad: w.nested("view", "the 3D view", tag, value, pad),
}


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
                if re.fullmatch(_NOT_FINITE, value):
                    raise ValueError(
                        f"parameter '{parameter.name}' of user model '{model.name}' has the number "
                        f"{float(value)}, which no .mbs file can hold"
                    )
