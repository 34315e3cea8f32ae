"""Write an .mbs file: the elements of ``fields``, in the order that MBSysPad itself writes."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache, lru_cache, partial
from math import isfinite
from typing import Any

from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, KEPT, MARK, OBJECTS, Field, Table
from urdf2mbs.mbs.model import BASE, ORIGIN, Mbs

_ESCAPE_TABLE = str.maketrans(
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
#: Texts that Python reads as a number that is not finite.
_NOT_FINITE = ("inf", "infinity", "nan")
_find_invalid_character = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]").search


class _NotFiniteError(ValueError):
    """A number that no .mbs file can hold."""


def write(mbs: Mbs) -> bytes:
    """Return the content of the .mbs file of a model: the same bytes for the same model.

    Bodies, joints and points are written in the order of the model, and numbers to the last digit.
    A value that is None is left out.  MBSysPad needs the ``drawing`` of every body, the 3D viewer
    needs ``view``.

    Raises:
        ValueError: The model is not valid: it has a number that is not finite, a character that
            XML does not allow, a word that the format does not have, a body without a joint,
            or a sensor or force on a point of the base.
    """
    _check_model(mbs)
    children = _write_object("mbs", mbs, "  ")
    file_text = f'<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n{children}</mbsDescR7>\n'
    return file_text.encode()


# --- objects; ``indent`` is the white space before each line ---


def _write_object(object_key: str, mbs_object: Any, indent: str) -> str:
    """Return the children of the element of one of the ``OBJECTS``."""
    object_type = OBJECTS[object_key]
    try:
        return _write_children(object_type.table, mbs_object, indent)
    except _NotFiniteError as error:
        if not object_type.noun:
            raise
        raise ValueError(f"{object_type.describe(mbs_object)} {error}") from None


def _write_children(table: Table, mbs_object: Any, indent: str) -> str:
    """Return the children of a table, with the values of an object."""
    child_texts = []
    for tag, field_or_table in table.items():
        if isinstance(field_or_table, Field):
            attribute, kind = field_or_table
            value = getattr(mbs_object, attribute)
            if value is None:
                continue
            if isinstance(kind, str):
                child_texts.append(_VALUE_WRITERS[kind](tag, value, indent))
            else:
                child_texts.append(_write_list(tag, kind, value, indent))
        elif field_or_table is MARK:
            child_texts.append(f"{indent}<{tag}/>\n")
        else:
            child_texts.append(
                _enclose(tag, _write_children(field_or_table, mbs_object, f"{indent}  "), indent)
            )
    return "".join(child_texts)


def _write_list(tag: str, part_tags: frozenset[str], mbs_objects: list[Any], indent: str) -> str:
    """Return an element around the elements of a list of objects.

    Objects whose elements may have several tags have theirs as ``kind``.
    """
    only_tag = next(iter(part_tags))
    object_texts = [
        _write_element(getattr(mbs_object, "kind", only_tag), mbs_object, f"{indent}  ")
        for mbs_object in mbs_objects
    ]
    return _enclose(tag, "".join(object_texts), indent)


def _write_element(tag: str, mbs_object: Any, indent: str) -> str:
    """Return the element of an object, which is written even if it is empty."""
    return f"{indent}<{tag}>\n{_write_object(tag, mbs_object, f'{indent}  ')}{indent}</{tag}>\n"


def _enclose(tag: str, children: str, indent: str) -> str:
    """Return an element around others; without others only if it is ``KEPT``."""
    if children:
        return f"{indent}<{tag}>\n{children}{indent}</{tag}>\n"
    return f"{indent}<{tag}/>\n" if tag in KEPT else ""


# --- a function for each kind of value ---


def _write_text(tag: str, text: str, indent: str) -> str:
    return f"{indent}<{tag}>{_escape(text)}</{tag}>\n"


def _write_title(tag: str, text: str, indent: str) -> str:
    return _write_text(tag, text, indent) if text else ""


def _write_texts(tag: str, texts: tuple[str, ...], indent: str) -> str:
    return "".join([_write_text(tag, text, indent) for text in texts])


def _write_number(tag: str, number: float, indent: str) -> str:
    return f"{indent}<{tag}>{_format_number(number)}</{tag}>\n"


def _write_numbers(kind: str, tag: str, numbers: tuple[float, ...], indent: str) -> str:
    return _make_template(tag, kind, indent) % tuple(map(_format_number, numbers))


def _write_place(tag: str, place: tuple[str | None, str | None], indent: str) -> str:
    body_name = BASE if place[0] is None else place[0]
    point_name = ORIGIN if place[1] is None else place[1]
    return _make_template(tag, "place", indent) % (_escape(body_name), _escape(point_name))


def _write_flag(tag: str, is_set: bool, indent: str) -> str:
    return f"{indent}<{tag}/>\n" if is_set else ""


def _write_color(tag: str, color: model.RGB, indent: str) -> str:
    red, green, blue = color
    return f'{indent}<{tag} R="{red:d}" G="{green:d}" B="{blue:d}"/>\n'


def _write_symbols(tag: str, symbols: tuple[str, ...], indent: str) -> str:
    return _enclose(tag, "".join([f"{indent}  <{symbol}/>\n" for symbol in symbols]), indent)


def _write_coordinates(tag: str, vector: tuple[float, ...], indent: str) -> str:
    return _enclose(tag, _write_numbers("xyz", "coordinates", vector, f"{indent}  "), indent)


def _write_control_points(tag: str, points: tuple[model.XY, ...], indent: str) -> str:
    point_texts = [_write_numbers("xy", "control_point", point, f"{indent}  ") for point in points]
    return _enclose(tag, "".join(point_texts), indent)


def _write_sensor(tag: str, sensor: model.Sensor, indent: str) -> str:
    measures = "".join([f' {measure}="true"' for measure in sensor.measures])
    return f'{indent}<{tag} name="{_escape(sensor.name)}"{measures}/>\n'


def _write_parts(tag: str, mbs_objects: list[Any], indent: str) -> str:
    return "".join([_write_element(tag, mbs_object, indent) for mbs_object in mbs_objects])


def _write_single_object(kind: str, tag: str, mbs_object: Any, indent: str) -> str:
    return _enclose(tag, _write_object(kind, mbs_object, f"{indent}  "), indent)


#: By kind: the function that writes a value, given the tag, the value and the indent.
_VALUE_WRITERS: dict[str, Callable[[str, Any, str], str]] = {
    "text": _write_text,
    "title": _write_title,
    "word": _write_text,
    "number": _write_number,
    "flag": _write_flag,
    "color": _write_color,
    "xy": partial(_write_numbers, "xy"),
    "xyz": partial(_write_numbers, "xyz"),
    "coordinates": _write_coordinates,
    "control_points": _write_control_points,
    "inertia": partial(_write_numbers, "inertia"),
    "symbols": _write_symbols,
    "place": _write_place,
    "sensor": _write_sensor,
    "texts": _write_texts,
    "parts": _write_parts,
    "base": partial(_write_single_object, "base"),
    "drawing": partial(_write_single_object, "drawing"),
    "view": partial(_write_single_object, "view"),
}


# --- texts and numbers ---


@cache
def _make_template(tag: str, kind: str, indent: str) -> str:
    """Return the element of a value of several parts, with ``%s`` for each part."""
    part_elements = "".join(
        [f"{indent}  <{part_tag}>%s</{part_tag}>\n" for part_tag in INSIDE[kind]]
    )
    return _enclose(tag, part_elements, indent)


@lru_cache(4096)
def _format_number(number: float) -> str:
    """Return a number to its last digit; minus zero becomes zero."""
    value = float(number)
    if not isfinite(value):
        raise _NotFiniteError(f"has the number {value}, which no .mbs file can hold")
    return repr(value + 0.0)


@lru_cache(4096)
def _escape(text: str) -> str:
    """Return a text with the special characters of XML escaped."""
    if _find_invalid_character(text):
        raise ValueError(f"an .mbs file cannot hold the name {text!r}")
    return text.translate(_ESCAPE_TABLE)


# --- checks of the model ---


def _check_model(mbs: Mbs) -> None:
    """Raise a ValueError for a model that is not valid, but for its numbers and characters."""
    for point in mbs.base.points:
        if point.sensor is not None or point.extforce is not None:
            raise ValueError(
                f"point '{point.name}' of the base has a sensor or an external force: "
                "Robotran's C library cannot read that"
            )
    for cut in mbs.cuts:
        _check_word(cut.kind, model.CUTS, "the kind of cut", cut.name)
    for link in mbs.links:
        _check_word(link.kind, model.LINKS, "the kind of link", link.name)
    for _, owner in mbs.base_and_bodies():
        for shape in owner.shapes:
            _check_word(shape.kind, model.SHAPES, "the kind of shape", shape.name)
    for body in mbs.bodies:
        _check_body(body)
    for user_model in mbs.user_models:
        _check_user_model(user_model)


def _check_word(stated_word: str, allowed: frozenset[str], subject: str, element_name: str) -> None:
    """Raise a ValueError if a word is not one of those that the format has."""
    if stated_word not in allowed:
        expected = ", ".join(sorted(allowed))
        raise ValueError(
            f"{subject} '{element_name}' is '{stated_word}'; expected one of {expected}"
        )


def _check_body(body: model.Body) -> None:
    """Raise a ValueError for a body without joint, and for unknown words in it."""
    if not body.joints:
        raise ValueError(f"body '{body.name}' has no joint: Robotran would drop it")
    for joint in body.joints:
        _check_word(joint.type, model.JOINT_TYPES, "the type of joint", joint.name)
        _check_word(joint.nature, model.NATURES, "the nature of joint", joint.name)
        for symbol in joint.symbols or ():
            _check_word(symbol, model.SYMBOLS, "a symbol of joint", joint.name)
    for point in body.points:
        for tag, sensor in (("sensor", point.sensor), ("extforce", point.extforce)):
            if sensor is not None:
                for measure in sensor.measures:
                    _check_word(measure, model.SENSOR_MEASURES, f"a measure of {tag}", sensor.name)


def _check_user_model(user_model: model.UserModel) -> None:
    """Raise a ValueError for a parameter that is not a finite number."""
    for parameter in user_model.parameters:
        for value in parameter.values if parameter.type != "structure" else ():
            if value.strip().lstrip("+-").lower() in _NOT_FINITE:
                raise ValueError(
                    f"parameter '{parameter.name}' of user model '{user_model.name}' has the "
                    f"number {float(value)}, which no .mbs file can hold"
                )
