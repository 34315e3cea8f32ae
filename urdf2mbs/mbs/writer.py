"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cache, partial
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

from lxml import etree

from urdf2mbs.mbs.fields import INSIDE, KEPT, MARK, OBJECTS, Kind, Object, Table
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
from urdf2mbs.mbs.rewrite import AT, FROM, rewrite

if TYPE_CHECKING:
    from lxml.etree import _Element


class _NotFiniteError(ValueError):
    """A number that no .mbs file can hold."""


class _Numbers(dict[float, str]):
    """Each number as text, to its last digit; minus zero is zero."""

    def __missing__(self, value: float) -> str:
        number = float(value)
        if not isfinite(number):
            raise _NotFiniteError(f"has the number {number}, which no .mbs file can hold")
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
_NOT_FINITE = ("inf", "infinity", "nan")
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


class _Writer:
    def __init__(self, source: bytes | None = None, other: bytes | None = None) -> None:
        self.source, self.other = source, other
        """The files to which the origins belong that are marked."""
        self.marked: set[int] = set()
        self.number = _Numbers()
        self.text = _Texts()

    def mbs(self, mbs: Mbs) -> str:
        _check(mbs)
        inside = _object("mbs", "  ")(self, mbs)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{inside}</mbsDescR7>\n'

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


#: Writes a value or an object.
Write: TypeAlias = Callable[[_Writer, Any], str]


@cache
def _object(key: str, pad: str) -> Write:
    """Writes the children of the element of one of the ``OBJECTS``; ``pad`` stands before each."""
    return _elements(OBJECTS[key].table, pad, OBJECTS[key])


def _part(tag: str, pad: str) -> Write:
    inside = _object(tag, f"{pad}  ")

    def write(w: _Writer, part: Any) -> str:
        mark = w.mark(part) if w.source is not None else ""
        return f"{pad}<{tag}{mark}>\n{inside(w, part)}{pad}</{tag}>\n"

    return write


def _elements(table: Table, pad: str, owner: Object | None = None) -> Write:
    """Writes the elements of a table, without those whose value is None; ``owner`` is the object
    that an error names."""
    entries: list[tuple[str, Any]] = []
    for tag, entry in table.items():
        if isinstance(entry, tuple):
            entries.append((entry[0], _value(tag, entry[1], pad)))
        else:
            kept = entry is MARK or tag in KEPT
            write_nested = _around(tag, _elements(entry or {}, f"{pad}  "), pad, kept=kept)
            if not _has_fields(entry or {}):
                write_nested = partial(_constant, write_nested(_Writer(), ""))
            entries.append(("", write_nested))

    def write(w: _Writer, thing: Any) -> str:
        text = ""
        try:
            for field, write_value in entries:
                value = getattr(thing, field) if field else thing
                if value is not None:
                    text += write_value(w, value)
        except _NotFiniteError as error:
            if owner is None or not owner.what:
                raise
            raise ValueError(f"{owner.in_words(thing)} {error}") from None
        return text

    return write


def _has_fields(table: Table) -> bool:
    return any(
        isinstance(entry, tuple) or (entry is not MARK and _has_fields(entry))
        for entry in table.values()
    )


def _constant(text: str, *_: Any) -> str:
    return text


def _around(tag: str, inside: Write, pad: str, *, kept: bool = True) -> Write:
    """Writes an element around others; without others only if it is ``kept``."""

    def write(w: _Writer, value: Any) -> str:
        inner = inside(w, value)
        if inner:
            return f"{pad}<{tag}>\n{inner}{pad}</{tag}>\n"
        return f"{pad}<{tag}/>\n" if kept else ""

    return write


def _each(write: Write) -> Write:
    return lambda w, values: "".join([write(w, value) for value in values])


def _value(tag: str, kind: Kind | frozenset[str], pad: str) -> Write:
    """Writes a value of a kind."""
    within = f"{pad}  "
    if isinstance(kind, frozenset):
        parts = {tag: _part(tag, within) for tag in kind}
        only = next(iter(kind))
        write_each = _each(lambda w, part: parts[getattr(part, "kind", only)](w, part))
        return _around(tag, write_each, pad, kept=tag in KEPT)
    if kind == "parts":
        return _each(_part(tag, pad))
    if kind == "texts":
        return _each(_value(tag, "text", pad))
    if kind in ("base", "drawing", "view"):
        return _around(tag, _object(kind, within), pad)
    if kind == "coordinates":
        return _around(tag, _value("coordinates", "xyz", within), pad)
    if kind == "control points":
        return _around(tag, _each(_value("control_point", "xy", within)), pad)
    if kind == "symbols":
        return _around(tag, _each(lambda _, symbol: f"{within}<{symbol}/>\n"), pad)
    if kind in ("xy", "xyz", "inertia"):
        numbers = "".join([f"{within}<{part}>%s</{part}>\n" for part in INSIDE[kind]])
        gaps = f"{pad}<{tag}>\n{numbers}{pad}</{tag}>\n"
        return lambda w, values: gaps % tuple([w.number[value] for value in values])
    begin, end = f"{pad}<{tag}", f"</{tag}>\n"
    write: dict[str, Write] = {
        "text": lambda w, text: f"{begin}>{w.text[text]}{end}",
        "title": lambda w, text: f"{begin}>{w.text[text]}{end}" if text else "",
        "word": lambda _, word: f"{begin}>{word}{end}",
        "number": lambda w, number: f"{begin}>{w.number[number]}{end}",
        "flag": lambda _, flag: f"{begin}/>\n" if flag else "",
        "color": lambda _, rgb: f'{begin} R="{rgb[0]:d}" G="{rgb[1]:d}" B="{rgb[2]:d}"/>\n',
        "sensor": lambda w, sensor: (
            f'{begin}{w.mark(sensor)} name="{w.text[sensor.name]}"'
            + "".join([f' {measure}="true"' for measure in sensor.measures])
            + "/>\n"
        ),
        "place": lambda w, place: (
            f"{begin}>\n"
            f"{within}<bodyname>{BASE if place[0] is None else w.text[place[0]]}</bodyname>\n"
            f"{within}<pointname>{ORIGIN if place[1] is None else w.text[place[1]]}</pointname>\n"
            f"{pad}{end}"
        ),
    }
    return write[kind]


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
