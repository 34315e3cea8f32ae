"""Finds all that is wrong with a config, by the JSON schema of its class.

msgspec, which reads configs, stops at the first fault: this runs where msgspec has refused one.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from jsonschema import Draft202012Validator, ValidationError
from jsonschema.validators import extend

from urdf2mbs.config.lines import Key, Lines, dotted
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.ranges import describe_range

#: The types of JSON, in the words of a reader of YAML.
_TYPES = {
    "string": "a word",
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "array": "a list",
    "object": "a block of 'key: value' lines",
    "null": "nothing",
}

_TYPE_CHECKER = Draft202012Validator.TYPE_CHECKER
#: Values from Python may be tuples, and nan is not a number.
_CHECKER = _TYPE_CHECKER.redefine("array", lambda _, value: isinstance(value, list | tuple))
_CHECKER = _CHECKER.redefine(
    "number", lambda _, value: _TYPE_CHECKER.is_type(value, "number") and value == value
)
_Validator: Any = extend(Draft202012Validator, type_checker=_CHECKER)


def take_faults(
    schema: dict[str, Any], data: dict[Any, Any], lines: Lines, at: Key
) -> list[ConfigError]:
    """Take the wrong values out of a block of a config, and return the fault of each.

    The value of a key that is nearly a known one goes to the known key.

    Args:
        schema: The JSON schema of the block's class.
        data: The block.
        lines: The line of each value.
        at: The key of the block in the config.
    """
    errors = list(_Validator(schema).iter_errors(data))
    faults = [fault for error in errors for fault in _describe(error, lines, at)]
    for error in errors:
        if error.path:
            data.pop(error.path[0], None)
        elif error.validator == "additionalProperties":
            known_keys = error.schema["properties"]
            for key in [key for key in data if key not in known_keys]:
                value = data.pop(key)
                for close in get_close_matches(str(key), known_keys, n=1, cutoff=0.75):
                    data.setdefault(close, value)
    return faults


def _describe(error: ValidationError, lines: Lines, at: Key) -> Iterator[ConfigError]:
    """Yield the faults that an error of jsonschema stands for."""
    key = (*at, *error.absolute_path)
    match error.validator:
        case "anyOf":
            yield from _describe_alternatives(error, lines, at)
        case "additionalProperties":
            yield from _describe_unknown_keys(error, lines, key)
        case "required":
            yield from _describe_missing_keys(error, lines, key)
        case "type":
            yield _describe_type([error.validator_value], error.instance, lines, key)
        case "items":
            pass  # a list that is too long has a second error, of "maxItems"
        case _:
            yield _describe_value(error, lines, key)


def _describe_alternatives(error: ValidationError, lines: Lines, at: Key) -> Iterator[ConfigError]:
    """Yield the faults of a value that may have one of several types."""
    alternatives: dict[Any, list[ValidationError]] = {}
    for inner in error.context:
        alternatives.setdefault(inner.schema_path[0], []).append(inner)
    # the type that the value has is the one that is meant
    matching = [
        inners
        for inners in alternatives.values()
        if any(inner.validator != "type" or inner.path for inner in inners)
    ]
    if not matching:
        types = [inner.validator_value for inner in error.context]
        yield _describe_type(types, error.instance, lines, (*at, *error.absolute_path))
        return
    for inner in max(matching, key=lambda inners: max(len(inner.path) for inner in inners)):
        yield from _describe(inner, lines, at)


def _describe_unknown_keys(error: ValidationError, lines: Lines, key: Key) -> Iterator[ConfigError]:
    known_keys = error.schema["properties"]
    for name in [name for name in error.instance if name not in known_keys]:
        listed = ", ".join(known_keys) or "no keys at all"
        hint = nearest(str(name), known_keys) or f"known: {listed}"
        unknown = (*key, name)
        yield lines.error("unknown-key", f"unknown key '{dotted(unknown)}'", unknown, hint)


def _describe_missing_keys(error: ValidationError, lines: Lines, key: Key) -> Iterator[ConfigError]:
    hints = [nearest(str(name), error.schema["properties"]) for name in error.instance]
    for name in [name for name in error.validator_value if name not in error.instance]:
        if not any(f"'{name}'" in hint for hint in hints if hint):
            block = f" under '{dotted(key)}'" if key else ""
            message = f"'{dotted((*key, name))}' must be given"
            yield lines.error("config-key-missing", message, key, f"add '{name}: ...'{block}")


def _describe_value(error: ValidationError, lines: Lines, key: Key) -> ConfigError:
    """Return the fault of a value of the right type."""
    value, expected, code, hint = error.instance, error.validator_value, "config-type", None
    text = f": {error.message}"
    match error.validator:
        case "enum":
            text = f": {_shorten(value)} is not one of its values"
            hint = f"it is one of: {', '.join(map(str, expected))}"
            close = nearest(value, expected) if isinstance(value, str) else None
            hint = f"{hint}; {close}" if close else hint
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            code, text = "value-range", f": expected {describe_range(error.schema)}, got {value!r}"
        case "minLength":
            subject = "a key" if "propertyNames" in error.schema_path else "the value"
            text = f": {subject} is empty; expected a name or a path"
        case "minItems" | "maxItems":
            text = f": expected a list of {expected}, got one of {len(value)}"
    return lines.error(code, f"'{dotted(key)}'{text}", key, hint)


def _describe_type(types: list[str], value: Any, lines: Lines, key: Key) -> ConfigError:
    expected = " or ".join(_TYPES[name] for name in types)
    message = f"'{dotted(key)}': expected {expected}, got {_shorten(value)}"
    return lines.error("config-type", message, key)


def _shorten(value: Any) -> str:
    """Return a value as a message shows it."""
    if isinstance(value, (dict, list)):
        return _TYPES["object" if isinstance(value, dict) else "array"]
    return _TYPES["null"] if value is None else repr(value)
