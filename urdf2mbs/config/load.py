"""Reads configs, from a file, a command line or a call, and checks their values.

Errors name the file, the line and the key, and offer the nearest known one.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.config.lines import Key, Lines, dotted
from urdf2mbs.config.model import Config
from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError

#: The most bytes of a config that are read.
MAX_BYTES = 2**20

#: The exceptions by which msgspec refuses a value.
_REFUSED = (msgspec.ValidationError, UnicodeEncodeError)


def load(config_file: Path, **fields: Any) -> tuple[Config, Lines]:
    """Read a config file.

    Keys and values that are wrong are left out, and become faults of the lines, to which the
    pipeline adds its own, so that a user reads them all at once.

    Args:
        config_file: The config file.
        fields: Values that override those of the file, as in ``config_of``.

    Raises:
        ConfigError: The file cannot be read, or is no config.
    """
    config_text = read_text(config_file, "config-unreadable", "config")
    if config_text.lstrip().startswith("<"):
        raise _explain_xml(config_file)
    return parse(config_text, config_file, **fields)


def read_text(yaml_file: Path, code: str, noun: str) -> str:
    """Return the text of a YAML file.

    Args:
        yaml_file: The file.
        code: The code of the error if it cannot be read.
        noun: What the file is.

    Raises:
        ConfigError: The file cannot be read.
    """
    try:
        return files.read_bytes(yaml_file, MAX_BYTES).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        message = f"cannot read the {noun}: {reason}"
        is_missing = isinstance(error, FileNotFoundError)
        hint = files.suggest_file(yaml_file, (".yaml", ".yml")) if is_missing else None
        raise ConfigError(code, message, file=str(yaml_file), hint=hint) from None


def _explain_xml(xml_file: Path) -> ConfigError:
    """Return the error for a robot or a model in place of a config."""
    message = "this is XML, such as a robot, and no config"
    hint = (
        f"urdf2mbs init {xml_file} writes a config for a robot; "
        f"urdf2mbs convert {xml_file} needs none"
    )
    if xml_file.suffix.lower() == ".mbs":
        message = "this is a model, and no config"
        hint = f"urdf2mbs verify ROBOT {xml_file} compares it; urdf2mbs report {xml_file} shows it"
    return ConfigError("config-yaml", message, file=str(xml_file), hint=hint)


def parse(config_text: str, config_file: Path | None, **fields: Any) -> tuple[Config, Lines]:
    """Read the text of a config, as ``load`` reads a file."""
    from urdf2mbs.config import (
        yaml_text,
    )  # imports PyYAML, which a robot without a config needs not

    config_data, lines_by_key = yaml_text.parse_yaml(config_text, config_file)
    config_lines = Lines(config_file, lines_by_key, config_file.parent if config_file else Path())
    if not isinstance(config_data, dict):
        message = "a config is a list of 'key: value' lines, such as 'source: robot.urdf'"
        raise config_lines.error("config-type", message)
    _override(config_data, _to_plain_data(fields), config_lines)
    return _read_fields(Config, config_data, config_lines, ()), config_lines


def config_of(
    source: Config | Mapping[str, Any] | str | os.PathLike[str], **fields: Any
) -> tuple[Config, Lines]:
    """Return the config of a call from Python.

    Paths are relative to the working folder, those of a config file to its folder.

    Args:
        source: A robot, a config file, a ``Config``, or a mapping of its fields.
        fields: Fields of ``Config`` that override those of the source.  A block of keys, such as
            ``xacro_args``, changes the block of the source; of ``passes``, the block of each pass.
            A path is allowed in place of a text, any sequence in place of a list.

    Raises:
        ConfigError: A value is wrong.  With a config file, wrong values become faults of the lines.
    """
    source_fields: Any = {"source": source}
    if isinstance(source, Config):
        source_fields = msgspec.structs.asdict(source)
    elif isinstance(source, Mapping):
        source_fields = source
    elif os.fspath(source).lower().endswith((".yaml", ".yml")):
        return load(Path(source), **fields)
    config_lines = Lines()
    config_data = _to_plain_data(source_fields)
    _override(config_data, _to_plain_data(fields), config_lines)
    config = _read_fields(Config, config_data, config_lines, ())
    config_lines.check()
    return config, config_lines


def typed(struct_class: Any, plain_data: Any, config_lines: Lines, at: Key = ()) -> Any:
    """Convert data into an instance of a Struct.

    Args:
        struct_class: The Struct.
        plain_data: The data, a dict.
        config_lines: The line of each value.
        at: The key of the data in the config.

    Raises:
        ConfigError: A value is wrong; it names the key.
    """
    config_lines = Lines(
        config_lines.file,
        config_lines.places,
        config_lines.folder,
        overridden=config_lines.overridden,
    )
    typed_data = _read_fields(struct_class, plain_data, config_lines, at)
    config_lines.check()
    return typed_data


def _to_plain_data(call_values: Any) -> dict[str, Any]:
    """Convert values of a call into dicts, lists, texts and numbers."""
    plain_data: dict[str, Any] = msgspec.to_builtins(
        call_values, enc_hook=_convert_value, str_keys=True
    )
    return plain_data


def _convert_value(call_value: Any) -> Any:
    if isinstance(call_value, os.PathLike):
        return os.fspath(call_value)
    if isinstance(call_value, Mapping):
        return dict(call_value)
    try:
        return list(call_value)
    except TypeError:
        raise ConfigError(
            "config-type", f"expected text, a number, a list or a mapping, got {call_value!r}"
        ) from None


def _override(config_data: dict[str, Any], fields: dict[str, Any], config_lines: Lines) -> None:
    """Put fields of a command line or a call into the data of a config."""
    for field_name, field_value in fields.items():
        field_block = config_data.get(field_name)
        if not isinstance(field_value, dict) or not isinstance(field_block, dict):
            config_data[field_name] = field_value
            config_lines.overridden.add((field_name,))
            continue
        for block_key, block_value in field_value.items():
            if (
                field_name == "passes"
                and isinstance(field_block.get(block_key), dict)
                and isinstance(block_value, dict)
            ):
                field_block[block_key] = {**field_block[block_key], **block_value}
                config_lines.overridden |= {
                    (field_name, block_key, option) for option in block_value
                }
            else:
                field_block[block_key] = block_value
                config_lines.overridden.add((field_name, block_key))


def _read_fields(struct_class: Any, plain_data: Any, config_lines: Lines, block_key: Key) -> Any:
    """Convert data into an instance of a Struct; wrong values are left out and become faults.

    A key that is nearly a known one is read as the known one.  Raises ConfigError if nothing can
    be read.
    """
    with suppress(TypeError, *_REFUSED):
        # a class by its defaults: msgspec takes long for the first value of a class
        return struct_class() if plain_data == {} else msgspec.convert(plain_data, struct_class)
    if not isinstance(plain_data, dict):
        message = f"'{dotted(block_key)}': expected 'key: value' lines, got {plain_data!r}"
        raise config_lines.error("config-type", message, block_key)
    json_schema = msgspec.json.schema(struct_class)
    properties = json_schema["$defs"][json_schema["$ref"].rpartition("/")[2]]["properties"]
    # one word in place of a list is a list of one
    plain_data = {
        key: [value] if isinstance(value, str) and properties.get(key, {}).get("items") else value
        for key, value in plain_data.items()
    }
    try:
        return msgspec.convert(plain_data, struct_class)
    except _REFUSED as error:
        from urdf2mbs.config.faults import take_faults

        faults = take_faults(json_schema, plain_data, config_lines, block_key)
        if not faults:  # values that the class refuses together, or a text with a lone surrogate
            reason = str(error).partition(" - at `")[0]
            raise config_lines.error(
                "config-type", f"'{dotted(block_key)}': {reason}", block_key
            ) from None
    config_lines.faults += faults
    with suppress(*_REFUSED):
        return msgspec.convert(plain_data, struct_class)
    config_lines.check()
    return None
