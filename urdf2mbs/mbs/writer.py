"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache, lru_cache
from math import isfinite
from typing import Any

from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, KEPT, MARK, OBJECTS, Kind, Table
from urdf2mbs.mbs.model import BASE, ORIGIN, Mbs, Part


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
    """Writes a model, element by element; ``pad`` stands before each line."""

    def mbs(self, mbs: Mbs) -> str:
        _check(mbs)
        inside = self.object("mbs", mbs, "  ")
        return f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{inside}</mbsDescR7>\n'

    def mark(self, part: Part) -> str:
        """What stands behind the tag of an object, for a writer that finds the object again."""
        return ""

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
        texts = []
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

    def value(self, tag: str, kind: Kind | frozenset[str], value: Any, pad: str) -> str:
        """A value of a kind as an element, or as several."""
        match kind:
            case "text" | "word":
                return f"{pad}<{tag}>{_text(value)}</{tag}>\n"
            case "xy" | "xyz" | "inertia":
                return _lines(tag, kind, pad) % tuple(map(_number, value))
            case "number":
                return f"{pad}<{tag}>{_number(value)}</{tag}>\n"
            case "texts":
                return "".join([f"{pad}<{tag}>{_text(text)}</{tag}>\n" for text in value])
            case "place":
                return _lines(tag, kind, pad) % _names(*value)
            case "flag":
                return f"{pad}<{tag}/>\n" if value else ""
            case "parts":
                return "".join([self.part(tag, one, pad) for one in value])
            case "symbols":
                return _around(tag, "".join([f"{pad}  <{word}/>\n" for word in value]), pad)
            case "coordinates":
                return _around(tag, self.value("coordinates", "xyz", value, f"{pad}  "), pad)
            case "control_points":
                ways = [self.value("control_point", "xy", xy, f"{pad}  ") for xy in value]
                return _around(tag, "".join(ways), pad)
            case "base" | "drawing" | "view":
                return _around(tag, self.object(kind, value, f"{pad}  "), pad)
            case "color":
                return '{}<{} R="{:d}" G="{:d}" B="{:d}"/>\n'.format(pad, tag, *value)
            case "title":
                return f"{pad}<{tag}>{_text(value)}</{tag}>\n" if value else ""
            case "sensor":
                measures = "".join([f' {measure}="true"' for measure in value.measures])
                name = _text(value.name)
                return f'{pad}<{tag}{self.mark(value)} name="{name}"{measures}/>\n'
            case _:
                only = next(iter(kind))
                parts = [self.part(getattr(one, "kind", only), one, f"{pad}  ") for one in value]
                return _around(tag, "".join(parts), pad)

    def part(self, tag: str, part: Part, pad: str) -> str:
        inside = self.object(tag, part, f"{pad}  ")
        return f"{pad}<{tag}{self.mark(part)}>\n{inside}{pad}</{tag}>\n"


def _around(tag: str, inside: str, pad: str) -> str:
    """An element around others; without others only if it is ``KEPT``."""
    if inside:
        return f"{pad}<{tag}>\n{inside}{pad}</{tag}>\n"
    return f"{pad}<{tag}/>\n" if tag in KEPT else ""


@cache
def _lines(tag: str, kind: str, pad: str) -> str:
    """The element of a value of several parts, with a place for each."""
    parts = "".join([f"{pad}  <{part}>%s</{part}>\n" for part in INSIDE[kind]])
    return _around(tag, parts, pad)


def _names(body: str | None, point: str | None) -> tuple[str, str]:
    return _text(BASE if body is None else body), _text(ORIGIN if point is None else point)


@lru_cache(4096)
def _number(value: float) -> str:
    """A number to its last digit; minus zero is zero."""
    number = float(value)
    if not isfinite(number):
        raise _NotFiniteError(f"has the number {number}, which no .mbs file can hold")
    return repr(number + 0.0)


@lru_cache(4096)
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
    for _, owner in mbs.base_and_bodies():
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
