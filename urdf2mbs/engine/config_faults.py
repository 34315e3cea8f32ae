"""All that is wrong with a config, by the JSON schema of its class.

msgspec, which reads configs, stops at the first fault: this runs where msgspec has refused one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from difflib import get_close_matches
from typing import Any

from jsonschema import Draft202012Validator, ValidationError
from jsonschema.validators import extend

from urdf2mbs.engine.config import Key, Lines, dotted
from urdf2mbs.messages.diagnostics import ConfigError, nearest
from urdf2mbs.ranges import in_words

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
    if error.validator != "anyOf":
        yield from _describe(error, lines, at)
        return
    choices: dict[Any, list[ValidationError]] = {}
    for inner in error.context:
        choices.setdefault(inner.schema_path[0], []).append(inner)
    # of the types that a value may have, the type of the value is meant
    meant = [
        inners
        for inners in choices.values()
        if any(inner.validator != "type" or inner.path for inner in inners)
    ]
    if meant:
        for inner in max(meant, key=lambda inners: max(len(inner.path) for inner in inners)):
            yield from _describe_all(inner, lines, at)
    else:
        types = [inner.validator_value for inner in error.context]
        yield _wrong_type(types, error.instance, lines, (*at, *error.absolute_path))


def _describe(error: ValidationError, lines: Lines, at: Key) -> Iterator[ConfigError]:
    key, value, wanted = (*at, *error.absolute_path), error.instance, error.validator_value
    rule, name = error.validator, dotted(key)
    if rule == "additionalProperties":
        known = error.schema["properties"]
        for wrong in [wrong for wrong in value if wrong not in known]:
            yield _unknown_key(wrong, known, lines, key)
    elif rule == "required":
        meant = [nearest(str(other), error.schema["properties"]) for other in value]
        for missing in [one for one in wanted if one not in value]:
            if not any(f"'{missing}'" in hint for hint in meant if hint):
                under = f" under '{name}'" if key else ""
                yield lines.error(
                    "config-key-missing", f"'{dotted((*key, missing))}' must be given", key,
                    f"add '{missing}: ...'{under}",
                )  # fmt: skip
    elif rule == "type":
        yield _wrong_type([wanted], value, lines, key)
    elif rule == "enum":
        close = nearest(value, wanted) if isinstance(value, str) else None
        choices = f"it is one of: {', '.join(map(str, wanted))}"
        yield lines.error(
            "config-type", f"'{name}': {_short(value)} is not one of its values", key,
            f"{choices}; {close}" if close else choices,
        )  # fmt: skip
    elif rule in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"):
        said = f"'{name}' is {value!r}: {in_words(error.schema)} is wanted"
        yield lines.error("value-range", said, key)
    elif rule == "minLength":
        what = "a key" if "propertyNames" in error.schema_path else "this"
        said = f"'{name}': {what} is empty: write the name or the path that is meant"
        yield lines.error("config-type", said, key)
    elif rule in ("minItems", "maxItems"):
        said = f"'{name}': a list of {wanted} is wanted, and this is one of {len(value)}"
        yield lines.error("config-type", said, key)
    elif rule != "items":  # a list that is too long has two errors
        yield lines.error("config-type", f"'{name}': {error.message}", key)


def _unknown_key(key: Any, known: Collection[str], lines: Lines, at: Key) -> ConfigError:
    hint = nearest(str(key), known) or f"known: {', '.join(known) or 'no keys at all'}"
    said = f"unknown key '{dotted((*at, key))}'"
    return lines.error("unknown-key", said, (*at, key), hint)


def _wrong_type(types: list[str], value: Any, lines: Lines, at: Key) -> ConfigError:
    wanted = " or ".join(_TYPES[name] for name in types)
    said = f"'{dotted(at)}': {wanted} is wanted, and this is {_short(value)}"
    return lines.error("config-type", said, at)


def _short(value: Any) -> str:
    """A value in a message."""
    if isinstance(value, (dict, list)):
        return _TYPES["object" if isinstance(value, dict) else "array"]
    return _TYPES["null"] if value is None else repr(value)
