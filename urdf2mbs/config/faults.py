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
_CONFIG_TYPE_CHECKER = _TYPE_CHECKER.redefine(
    "array", lambda _, value: isinstance(value, list | tuple)
)
_CONFIG_TYPE_CHECKER = _CONFIG_TYPE_CHECKER.redefine(
    "number", lambda _, value: _TYPE_CHECKER.is_type(value, "number") and value == value
)
_Validator: Any = extend(Draft202012Validator, type_checker=_CONFIG_TYPE_CHECKER)


def take_faults(
    schema: dict[str, Any], block_data: dict[Any, Any], config_lines: Lines, block_key: Key
) -> list[ConfigError]:
    """Take the wrong values out of a block of a config, and return the fault of each.

    The value of a key that is nearly a known one goes to the known key.

    Args:
        schema: The JSON schema of the block's class.
        block_data: The block.
        config_lines: The line of each value.
        block_key: The key of the block in the config.
    """
    schema_errors = list(_Validator(schema).iter_errors(block_data))
    faults = [
        fault
        for schema_error in schema_errors
        for fault in _describe(schema_error, config_lines, block_key)
    ]
    for schema_error in schema_errors:
        if schema_error.path:
            block_data.pop(schema_error.path[0], None)
        elif schema_error.validator == "additionalProperties":
            known_keys = schema_error.schema["properties"]
            for unknown_key in [
                unknown_key for unknown_key in block_data if unknown_key not in known_keys
            ]:
                misspelt_value = block_data.pop(unknown_key)
                for known_key in get_close_matches(str(unknown_key), known_keys, n=1, cutoff=0.75):
                    block_data.setdefault(known_key, misspelt_value)
    return faults


def _describe(
    schema_error: ValidationError, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    """Yield the faults that cause an error of jsonschema."""
    faulty_key = (*block_key, *schema_error.absolute_path)
    match schema_error.validator:
        case "anyOf":
            yield from _describe_alternatives(schema_error, config_lines, block_key)
        case "additionalProperties":
            yield from _describe_unknown_keys(schema_error, config_lines, faulty_key)
        case "required":
            yield from _describe_missing_keys(schema_error, config_lines, faulty_key)
        case "type":
            yield _describe_type(
                [schema_error.validator_value], schema_error.instance, config_lines, faulty_key
            )
        case "items":
            pass  # a list that is too long has a second error, of "maxItems"
        case _:
            yield _describe_value(schema_error, config_lines, faulty_key)


def _describe_alternatives(
    schema_error: ValidationError, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    """Yield the faults of a value that may have one of several types."""
    alternatives: dict[Any, list[ValidationError]] = {}
    for inner_error in schema_error.context:
        alternatives.setdefault(inner_error.schema_path[0], []).append(inner_error)
    # the type that the value has is the one that is meant
    matching_alternatives = [
        inner_errors
        for inner_errors in alternatives.values()
        if any(inner_error.validator != "type" or inner_error.path for inner_error in inner_errors)
    ]
    if not matching_alternatives:
        expected_types = [inner_error.validator_value for inner_error in schema_error.context]
        yield _describe_type(
            expected_types,
            schema_error.instance,
            config_lines,
            (*block_key, *schema_error.absolute_path),
        )
        return
    for inner_error in max(
        matching_alternatives,
        key=lambda inner_errors: max(len(inner_error.path) for inner_error in inner_errors),
    ):
        yield from _describe(inner_error, config_lines, block_key)


def _describe_unknown_keys(
    schema_error: ValidationError, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    known_keys = schema_error.schema["properties"]
    for unknown_key in [
        unknown_key for unknown_key in schema_error.instance if unknown_key not in known_keys
    ]:
        known_names = ", ".join(known_keys) or "no keys at all"
        hint = nearest(str(unknown_key), known_keys) or f"known: {known_names}"
        full_key = (*block_key, unknown_key)
        yield config_lines.error("unknown-key", f"unknown key '{dotted(full_key)}'", full_key, hint)


def _describe_missing_keys(
    schema_error: ValidationError, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    near_names = [
        nearest(str(missing_key), schema_error.schema["properties"])
        for missing_key in schema_error.instance
    ]
    for missing_key in [
        missing_key
        for missing_key in schema_error.validator_value
        if missing_key not in schema_error.instance
    ]:
        if not any(f"'{missing_key}'" in near_name for near_name in near_names if near_name):
            block_text = f" under '{dotted(block_key)}'" if block_key else ""
            message = f"'{dotted((*block_key, missing_key))}' must be given"
            yield config_lines.error(
                "config-key-missing", message, block_key, f"add '{missing_key}: ...'{block_text}"
            )


def _describe_value(
    schema_error: ValidationError, config_lines: Lines, config_key: Key
) -> ConfigError:
    """Return the fault of a value of the right type."""
    value, expected, code, hint = (
        schema_error.instance,
        schema_error.validator_value,
        "config-type",
        None,
    )
    fault_text = f": {schema_error.message}"
    match schema_error.validator:
        case "enum":
            fault_text = f": {_shorten(value)} is not one of its values"
            hint = f"it is one of: {', '.join(map(str, expected))}"
            near_value = nearest(value, expected) if isinstance(value, str) else None
            hint = f"{hint}; {near_value}" if near_value else hint
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            code, fault_text = (
                "value-range",
                f": expected {describe_range(schema_error.schema)}, got {value!r}",
            )
        case "minLength":
            subject = "a key" if "propertyNames" in schema_error.schema_path else "the value"
            fault_text = f": {subject} is empty; expected a name or a path"
        case "minItems" | "maxItems":
            fault_text = f": expected a list of {expected}, got one of {len(value)}"
    return config_lines.error(code, f"'{dotted(config_key)}'{fault_text}", config_key, hint)


def _describe_type(
    expected_types: list[str], value: Any, config_lines: Lines, config_key: Key
) -> ConfigError:
    expected = " or ".join(_TYPES[type_name] for type_name in expected_types)
    message = f"'{dotted(config_key)}': expected {expected}, got {_shorten(value)}"
    return config_lines.error("config-type", message, config_key)


def _shorten(value: Any) -> str:
    """Return a value as a message shows it."""
    if isinstance(value, (dict, list)):
        return _TYPES["object" if isinstance(value, dict) else "array"]
    return _TYPES["null"] if value is None else repr(value)
