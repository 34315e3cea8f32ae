"""Finds all values that contradict the JSON schema that msgspec makes of a class.

Only the keywords that msgspec writes are checked.  A keyword that only describes (``title``,
``format``, ``default``, ...) is not.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import msgspec

from urdf2mbs.config.lines import Key


class SchemaFault(msgspec.Struct):
    """A value that contradicts one keyword of its schema."""

    keyword: str
    expected: Any
    """The value of the keyword."""
    value: Any
    key: Key
    """The keys and indices that lead to the value."""
    schema: dict[str, Any]
    """The schema with the keyword."""
    alternatives: list[list[SchemaFault]] = []
    """Of ``anyOf``: the faults by each alternative."""
    is_name: bool = False
    """Whether the value is the name of a key."""


def is_number(value: Any) -> bool:
    """Return whether a value is a number; true, false and nan are none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and value == value


#: A tuple is a list, since values of a call in Python may be tuples.
_TYPES: dict[str, Callable[[Any], bool]] = {
    "string": lambda value: isinstance(value, str),
    "integer": lambda value: is_number(value) and value % 1 == 0,
    "number": is_number,
    "boolean": lambda value: isinstance(value, bool),
    "array": lambda value: isinstance(value, list | tuple),
    "object": lambda value: isinstance(value, dict),
    "null": lambda value: value is None,
}
#: For each keyword that holds for one type only: the type, and whether a value of it fits.
_CHECKS: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "minimum": ("number", lambda value, bound: value >= bound),
    "exclusiveMinimum": ("number", lambda value, bound: value > bound),
    "maximum": ("number", lambda value, bound: value <= bound),
    "exclusiveMaximum": ("number", lambda value, bound: value < bound),
    "multipleOf": ("number", lambda value, factor: value % factor == 0),
    "minLength": ("string", lambda value, length: len(value) >= length),
    "maxLength": ("string", lambda value, length: len(value) <= length),
    "pattern": ("string", lambda value, pattern: re.search(pattern, value) is not None),
    "minItems": ("array", lambda value, length: len(value) >= length),
    "maxItems": ("array", lambda value, length: len(value) <= length),
    "minProperties": ("object", lambda value, length: len(value) >= length),
    "maxProperties": ("object", lambda value, length: len(value) <= length),
    "required": ("object", lambda value, names: value.keys() >= set(names)),
}


def find_schema_faults(
    value: Any, schema: dict[str, Any], definitions: dict[str, Any], key: Key = ()
) -> Iterator[SchemaFault]:
    """Yield the faults of the parts of a value, then those of the value itself.

    Args:
        value: Dicts, lists, texts and numbers.
        schema: The schema, or a part of it.
        definitions: The schema's ``$defs``.
        key: The keys and indices that lead to the value.
    """
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        yield from find_schema_faults(value, definitions[name], definitions, key)
    for child_key, child, child_schema in _list_children(value, schema):
        yield from find_schema_faults(child, child_schema, definitions, (*key, child_key))
    for keyword, expected in schema.items():
        fault = SchemaFault(keyword, expected, value, key, schema)
        if keyword == "anyOf":
            fault.alternatives = [
                list(find_schema_faults(value, alternative, definitions, key))
                for alternative in expected
            ]
            if all(fault.alternatives):
                yield fault
        elif _contradicts(value, keyword, expected, schema):
            yield fault
    if isinstance(value, dict) and "propertyNames" in schema:
        for name in value:
            for fault in find_schema_faults(name, schema["propertyNames"], definitions, key):
                fault.is_name = True
                yield fault


def _contradicts(value: Any, keyword: str, expected: Any, schema: dict[str, Any]) -> bool:
    """Return whether a value itself, not one of its children, contradicts a keyword."""
    if keyword == "type":
        return not _TYPES[expected](value)
    if keyword == "enum":
        return not any(
            value == one and isinstance(value, bool) == isinstance(one, bool) for one in expected
        )
    if keyword == "additionalProperties" and expected is False:
        return isinstance(value, dict) and not value.keys() <= schema["properties"].keys()
    type_name, fits = _CHECKS.get(keyword, ("null", None))
    return fits is not None and _TYPES[type_name](value) and not fits(value, expected)


def _list_children(value: Any, schema: dict[str, Any]) -> Iterator[tuple[Any, Any, Any]]:
    """Yield the key, the value and the schema of each child that has a schema."""
    if isinstance(value, dict):
        others = schema.get("additionalProperties")
        for key, child in value.items():
            child_schema = schema.get("properties", {}).get(key, others)
            if isinstance(child_schema, dict):
                yield key, child, child_schema
    if isinstance(value, list | tuple):
        first = schema.get("prefixItems", [])
        for index, child in enumerate(value):
            child_schema = first[index] if index < len(first) else schema.get("items")
            if isinstance(child_schema, dict):
                yield index, child, child_schema
