"""All that is wrong with a config, by the JSON schema of its class.

msgspec, which reads configs, stops at the first fault: this runs where msgspec has refused one.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from jsonschema import Draft202012Validator, ValidationError
from jsonschema.validators import extend

from urdf2mbs.config.model import Key, Lines, dotted
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.ranges import describe_range

#: The types of JSON, in the words of a reader of YAML.
_TYPES = {
    "string": "a word", "integer": "a whole number", "number": "a number",
    "boolean": "true or false", "array": "a list", "object": "a block of 'key: value' lines",
    "null": "nothing",
}  # fmt: skip


_TYPE_CHECKER = Draft202012Validator.TYPE_CHECKER
#: Values from Python may be tuples, and nan is no number.
_CHECKER = _TYPE_CHECKER.redefine("array", lambda _, value: isinstance(value, list | tuple))
_CHECKER = _CHECKER.redefine(
    "number", lambda _, value: _TYPE_CHECKER.is_type(value, "number") and value == value
)
_Validator: Any = extend(Draft202012Validator, type_checker=_CHECKER)


def take_faults(
    schema: dict[str, Any], data: dict[Any, Any], lines: Lines, at: Key
) -> list[ConfigError]:
    """Take the wrong values out of a block of a config, and say what is wrong with each.

    The value of a key that is nearly a known one goes to the known key.  ``at`` is the place of
    the block in the config.
    """
    errors = list(_Validator(schema).iter_errors(data))
    faults = [fault for error in errors for fault in _describe_all(error, lines, at)]
    for error in errors:
        if error.path:
            data.pop(error.path[0], None)
        elif error.validator == "additionalProperties":
            known = error.schema["properties"]
            for key in [key for key in data if key not in known]:
                value = data.pop(key)
                for close in get_close_matches(str(key), known, n=1, cutoff=0.75):
                    data.setdefault(close, value)
    return faults


def _describe_all(error: ValidationError, lines: Lines, at: Key) -> Iterator[ConfigError]:
    """The faults that an error of jsonschema stands for."""
    key, value, wanted = (*at, *error.absolute_path), error.instance, error.validator_value
    if error.validator == "anyOf":
        choices: dict[Any, list[ValidationError]] = {}
        for inner in error.context:
            choices.setdefault(inner.schema_path[0], []).append(inner)
        # of the types that a value may have, the type of the value is meant
        meant = [
            inners
            for inners in choices.values()
            if any(inner.validator != "type" or inner.path for inner in inners)
        ]
        for inner in max(meant, key=lambda each: max(len(one.path) for one in each), default=()):
            yield from _describe_all(inner, lines, at)
        if not meant:
            yield _wrong_type([inner.validator_value for inner in error.context], value, lines, key)
    elif error.validator == "additionalProperties":
        known = error.schema["properties"]
        for wrong in [wrong for wrong in value if wrong not in known]:
            hint = nearest(str(wrong), known) or f"known: {', '.join(known) or 'no keys at all'}"
            at = (*key, wrong)
            yield lines.error("unknown-key", f"unknown key '{dotted(at)}'", at, hint)
    elif error.validator == "required":
        meant_keys = [nearest(str(other), error.schema["properties"]) for other in value]
        for missing in [one for one in wanted if one not in value]:
            if not any(f"'{missing}'" in hint for hint in meant_keys if hint):
                under = f" under '{dotted(key)}'" if key else ""
                yield lines.error(
                    "config-key-missing", f"'{dotted((*key, missing))}' must be given", key,
                    f"add '{missing}: ...'{under}",
                )  # fmt: skip
    elif error.validator == "type":
        yield _wrong_type([wanted], value, lines, key)
    elif error.validator != "items":  # a list that is too long has two errors
        yield _describe_value(error, lines, key)


def _describe_value(error: ValidationError, lines: Lines, key: Key) -> ConfigError:
    """The fault of a value of the right type."""
    value, wanted, code, hint = error.instance, error.validator_value, "config-type", None
    said = f": {error.message}"
    match error.validator:
        case "enum":
            said = f": {_short(value)} is not one of its values"
            hint = f"it is one of: {', '.join(map(str, wanted))}"
            close = nearest(value, wanted) if isinstance(value, str) else None
            hint = f"{hint}; {close}" if close else hint
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            code, said = "value-range", f" is {value!r}: {describe_range(error.schema)} is wanted"
        case "minLength":
            what = "a key" if "propertyNames" in error.schema_path else "this"
            said = f": {what} is empty: write the name or the path that is meant"
        case "minItems" | "maxItems":
            said = f": a list of {wanted} is wanted, and this is one of {len(value)}"
    return lines.error(code, f"'{dotted(key)}'{said}", key, hint)


def _wrong_type(types: list[str], value: Any, lines: Lines, at: Key) -> ConfigError:
    wanted = " or ".join(_TYPES[name] for name in types)
    said = f"'{dotted(at)}': {wanted} is wanted, and this is {_short(value)}"
    return lines.error("config-type", said, at)


def _short(value: Any) -> str:
    """A value in a message."""
    if isinstance(value, (dict, list)):
        return _TYPES["object" if isinstance(value, dict) else "array"]
    return _TYPES["null"] if value is None else repr(value)
