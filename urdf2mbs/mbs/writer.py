"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes.

The tables of ``fields`` become functions once, as in the reader.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache, lru_cache
from math import isfinite
from typing import TYPE_CHECKING, Any

from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, KEPT, MARK, OBJECTS, Kind, Table
from urdf2mbs.mbs.model import BASE, ORIGIN, Mbs, Part

if TYPE_CHECKING:
    from collections.abc import Callable

    #: Gives a value as text, with the marks that the writer knows.
    Write = Callable[["Writer", Any], str]


class _NotFiniteError(ValueError):
    """A number that no .mbs file can hold."""


_ESCAPED = str.maketrans({
    "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#x27;", "\r": "&#13;",
    "\n": "&#10;",
})  # fmt: skip
#: As Python reads it.
_NOT_FINITE = ("inf", "infinity", "nan")
_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]").search


def write(mbs: Mbs) -> bytes:
    """The file as bytes: the same bytes for the same model.

    Bodies, joints and points are written in the order of the model.  Numbers are written to
    the last digit.  What is None is left out; MBSysPad wants every body's ``drawing``, the
    3D viewer wants ``view``.

    Raises ValueError for what no .mbs can hold: a number that is not finite, a character
    that is not XML's, a word that the format does not have, a body without a joint, a sensor
    or force on a point of the base.
    """
    return Writer().mbs(mbs).encode()


class Writer:
    """Writes a model."""

    def mbs(self, mbs: Mbs) -> str:
        _check(mbs)
        inside = _object("mbs", "  ")(self, mbs)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{inside}</mbsDescR7>\n'

    def mark(self, part: Part) -> str:
        """What stands behind the tag of an object, for a writer that finds the object again."""
        return ""


@cache
def _object(key: str, pad: str) -> Write:
    """Writes the children of the element of one of the ``OBJECTS``; ``pad`` stands before each."""
    owner = OBJECTS[key]
    write = _table(owner.table, pad)

    def write_object(writer: Writer, thing: Any) -> str:
        try:
            return write(writer, thing)
        except _NotFiniteError as error:
            if not owner.what:
                raise
            raise ValueError(f"{owner.in_words(thing)} {error}") from None

    return write_object


def _table(table: Table, pad: str) -> Write:
    entries: list[tuple[str, Write]] = []
    for tag, entry in table.items():
        if isinstance(entry, tuple):
            entries.append((entry[0], _value(tag, entry[1], pad)))
        elif entry is MARK:
            entries.append(("", _constant(f"{pad}<{tag}/>\n")))
        else:
            entries.append(("", _around(tag, _table(entry, f"{pad}  "), pad)))

    def write_table(writer: Writer, thing: Any) -> str:
        texts = []
        for field, write in entries:
            value = getattr(thing, field) if field else thing
            if value is not None:
                texts.append(write(writer, value))
        return "".join(texts)

    return write_table


def _value(tag: str, kind: Kind | frozenset[str], pad: str) -> Write:
    """Writes a value of a kind as an element, or as several."""
    within = f"{pad}  "
    line = f"{pad}<{tag}>%s</{tag}>\n"
    match kind:
        case "xyz" | "xy" | "inertia":
            parts = "".join([f"{within}<{part}>%s</{part}>\n" for part in INSIDE[kind]])
            lines = f"{pad}<{tag}>\n{parts}{pad}</{tag}>\n"
            return lambda _, value: lines % tuple(map(_number, value))
        case "number":
            return lambda _, value: line % _number(value)
        case "text" | "word":
            return lambda _, value: line % _text(value)
        case "title":
            return lambda _, value: line % _text(value) if value else ""
        case "texts":
            return lambda _, value: "".join([line % _text(text) for text in value])
        case "flag":
            return lambda _, value: f"{pad}<{tag}/>\n" if value else ""
        case "color":
            return lambda _, rgb: '{}<{} R="{:d}" G="{:d}" B="{:d}"/>\n'.format(pad, tag, *rgb)
        case "sensor":
            return lambda writer, sensor: (
                f'{pad}<{tag}{writer.mark(sensor)} name="{_text(sensor.name)}"'
                + "".join([f' {measure}="true"' for measure in sensor.measures])
                + "/>\n"
            )
        case "place":
            lines = "".join([f"{within}<{part}>%s</{part}>\n" for part in INSIDE[kind]])
            return _around(tag, lambda _, place: lines % _names(*place), pad)
        case "coordinates":
            return _around(tag, _value("coordinates", "xyz", within), pad)
        case "control points":
            write = _value("control_point", "xy", within)
            return _around(tag, lambda _, ways: "".join([write(_, xy) for xy in ways]), pad)
        case "symbols":
            lines = f"{within}<%s/>\n"
            return _around(tag, lambda _, words: "".join([lines % word for word in words]), pad)
        case "base" | "drawing" | "view":
            return _around(tag, _object(kind, within), pad)
        case "parts":
            part = _part(tag, pad)
            return lambda writer, parts: "".join([part(writer, one) for one in parts])
        case _:
            inside = {one: _part(one, within) for one in kind}
            only = next(iter(kind))
            return _around(
                tag,
                lambda writer, parts: "".join(
                    [inside[getattr(one, "kind", only)](writer, one) for one in parts]
                ),
                pad,
            )


def _part(tag: str, pad: str) -> Write:
    write = _object(tag, f"{pad}  ")
    return lambda writer, part: (
        f"{pad}<{tag}{writer.mark(part)}>\n{write(writer, part)}{pad}</{tag}>\n"
    )


def _around(tag: str, write: Write, pad: str) -> Write:
    """Writes an element around others; without others only if it is ``KEPT``."""
    empty = f"{pad}<{tag}/>\n" if tag in KEPT else ""

    def write_around(writer: Writer, value: Any) -> str:
        inside = write(writer, value)
        return f"{pad}<{tag}>\n{inside}{pad}</{tag}>\n" if inside else empty

    return write_around


def _constant(text: str) -> Write:
    return lambda *_: text


def _names(body: str | None, point: str | None) -> tuple[str, str]:
    return _text(BASE if body is None else body), _text(ORIGIN if point is None else point)


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

    def check(words: Iterable[str], known: frozenset[str], what: str) -> None:
        for word in words:
            if word not in known:
                raise ValueError(f"{what} is or has '{word}': .mbs has no such word")

    for point in mbs.base.points:
        if point.sensor is not None or point.extforce is not None:
            raise ValueError(
                f"point '{point.name}' of the base has a sensor or an external force: "
                "Robotran's C library cannot read that"
            )
    check([cut.kind for cut in mbs.cuts], model.CUTS, "a cut")
    check([link.kind for link in mbs.links], model.LINKS, "a link")
    for _, owner in mbs.owners():
        check([shape.kind for shape in owner.shapes], model.SHAPES, "a shape")
    for body in mbs.bodies:
        if not body.joints:
            raise ValueError(f"body '{body.name}' has no joint: Robotran would lose it")
        for joint in body.joints:
            if joint.type not in model.JOINT_TYPES or joint.nature not in model.NATURES:
                raise ValueError(
                    f"joint '{joint.name}' is '{joint.type}', '{joint.nature}': "
                    ".mbs has no such joint"
                )
            check(joint.symbols or (), model.SYMBOLS, f"joint '{joint.name}'")
        for point in body.points:
            for tag, sensor in (("sensor", point.sensor), ("extforce", point.extforce)):
                if sensor is not None:
                    check(sensor.measures, model.SENSOR_MEASURES, f"{tag} '{sensor.name}'")
    for own in mbs.user_models:
        for parameter in own.parameters:
            for value in parameter.values if parameter.type != "structure" else ():
                if value.strip().lstrip("+-").lower() in _NOT_FINITE:
                    raise ValueError(
                        f"parameter '{parameter.name}' of user model '{own.name}' has the number "
                        f"{float(value)}, which no .mbs file can hold"
                    )
