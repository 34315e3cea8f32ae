"""Finds all that is wrong with a config, by the JSON schema of its class.

msgspec, which reads configs, stops at the first fault: this runs where msgspec has refused one.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from urdf2mbs.config.lines import Key, Lines, dotted
from urdf2mbs.config.schema_faults import SchemaFault, find_schema_faults
from urdf2mbs.messages.diagnostics import ConfigError, counted, nearest
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
    schema_faults = list(find_schema_faults(block_data, schema, schema["$defs"]))
    faults = [
        fault
        for schema_fault in schema_faults
        for fault in _describe(schema_fault, config_lines, block_key)
    ]
    for schema_fault in schema_faults:
        if schema_fault.key:
            block_data.pop(schema_fault.key[0], None)
        elif schema_fault.keyword == "additionalProperties":
            known_keys = schema_fault.schema["properties"]
            for unknown_key in [
                unknown_key for unknown_key in block_data if unknown_key not in known_keys
            ]:
                misspelt_value = block_data.pop(unknown_key)
                for known_key in get_close_matches(str(unknown_key), known_keys, n=1, cutoff=0.75):
                    block_data.setdefault(known_key, misspelt_value)
    return faults


def _describe(
    schema_fault: SchemaFault, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    """Yield the errors of a config for a fault of its data."""
    faulty_key = (*block_key, *schema_fault.key)
    match schema_fault.keyword:
        case "anyOf":
            yield from _describe_alternatives(schema_fault, config_lines, block_key)
        case "additionalProperties":
            yield from _describe_unknown_keys(schema_fault, config_lines, faulty_key)
        case "required":
            yield from _describe_missing_keys(schema_fault, config_lines, faulty_key)
        case "type":
            expected_types = [schema_fault.expected]
            yield _describe_type(expected_types, schema_fault.value, config_lines, faulty_key)
        case _:
            yield _describe_value(schema_fault, config_lines, faulty_key)


def _describe_alternatives(
    schema_fault: SchemaFault, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    """Yield the errors of a value that may have one of several types."""
    # the type that the value has is the one that is meant
    matching_alternatives = [
        inner_faults
        for inner_faults in schema_fault.alternatives
        if any(fault.keyword != "type" or fault.key != schema_fault.key for fault in inner_faults)
    ]
    if not matching_alternatives:
        expected_types = [
            fault.expected for inner_faults in schema_fault.alternatives for fault in inner_faults
        ]
        faulty_key = (*block_key, *schema_fault.key)
        yield _describe_type(expected_types, schema_fault.value, config_lines, faulty_key)
        return
    for inner_fault in max(
        matching_alternatives, key=lambda faults: max(len(fault.key) for fault in faults)
    ):
        yield from _describe(inner_fault, config_lines, block_key)


def _describe_unknown_keys(
    schema_fault: SchemaFault, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    known_keys = schema_fault.schema["properties"]
    for unknown_key in [
        unknown_key for unknown_key in schema_fault.value if unknown_key not in known_keys
    ]:
        known_names = ", ".join(known_keys) or "no keys at all"
        hint = nearest(str(unknown_key), known_keys) or f"known: {known_names}"
        full_key = (*block_key, unknown_key)
        yield config_lines.error("unknown-key", f"unknown key '{dotted(full_key)}'", full_key, hint)


def _describe_missing_keys(
    schema_fault: SchemaFault, config_lines: Lines, block_key: Key
) -> Iterator[ConfigError]:
    near_names = [
        nearest(str(given_key), schema_fault.schema["properties"])
        for given_key in schema_fault.value
    ]
    for missing_key in [
        missing_key
        for missing_key in schema_fault.expected
        if missing_key not in schema_fault.value
    ]:
        if not any(f"'{missing_key}'" in near_name for near_name in near_names if near_name):
            block_text = f" under '{dotted(block_key)}'" if block_key else ""
            message = f"'{dotted((*block_key, missing_key))}' must be given"
            yield config_lines.error(
                "config-key-missing", message, block_key, f"add '{missing_key}: ...'{block_text}"
            )


def _describe_value(schema_fault: SchemaFault, config_lines: Lines, config_key: Key) -> ConfigError:
    """Return the error of a value of the right type."""
    value, expected = schema_fault.value, schema_fault.expected
    code, hint = "config-type", None
    match schema_fault.keyword:
        case "enum":
            fault_text = f"{_shorten(value)} is not one of its values"
            hint = f"it is one of: {', '.join(map(str, expected))}"
            near_value = nearest(value, expected) if isinstance(value, str) else None
            hint = f"{hint}; {near_value}" if near_value else hint
        case "minimum" | "exclusiveMinimum" | "maximum" | "exclusiveMaximum":
            code = "value-range"
            fault_text = f"expected {describe_range(schema_fault.schema)}, got {value!r}"
        case "minLength":
            subject = "a key" if schema_fault.is_name else "the value"
            fault_text = f"{subject} is empty; expected a name or a path"
        case "minItems" | "maxItems":
            fault_text = f"expected a list of {expected}, got one of {len(value)}"
        case "maxLength":
            fault_text = f"expected at most {expected} letters, got {value!r}"
        case "multipleOf":
            fault_text = f"expected a multiple of {expected}, got {value!r}"
        case "pattern":
            fault_text = f"{value!r} does not match {expected!r}"
        case _:  # minProperties or maxProperties
            bound = "more" if schema_fault.keyword == "minProperties" else "less"
            fault_text = f"expected {counted(expected, 'key')} or {bound}, got {len(value)}"
    return config_lines.error(code, f"'{dotted(config_key)}': {fault_text}", config_key, hint)


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
