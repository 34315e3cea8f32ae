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


def load(file: Path, **fields: Any) -> tuple[Config, Lines]:
    """Read a config file.

    Keys and values that are wrong are left out, and become faults of the lines, to which the
    pipeline adds its own, so that a user reads them all at once.

    Args:
        file: The config file.
        fields: Values that override those of the file, as in ``config_of``.

    Raises:
        ConfigError: The file cannot be read, or is no config.
    """
    try:
        text = files.read_bytes(file, MAX_BYTES).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        message = f"cannot read the config: {reason}"
        raise ConfigError("config-unreadable", message, file=str(file)) from None
    if text.lstrip().startswith("<"):
        raise _explain_xml(file)
    return parse(text, file, **fields)


def _explain_xml(file: Path) -> ConfigError:
    """Return the error for a robot or a model in place of a config."""
    message = "this is XML, such as a robot, and no config"
    hint = f"urdf2mbs init {file} writes a config for a robot; urdf2mbs convert {file} needs none"
    if file.suffix.lower() == ".mbs":
        message = "this is a model, and no config"
        hint = f"urdf2mbs verify ROBOT {file} compares it; urdf2mbs report {file} shows it"
    return ConfigError("config-yaml", message, file=str(file), hint=hint)


def parse(text: str, file: Path | None, **fields: Any) -> tuple[Config, Lines]:
    """Read the text of a config, as ``load`` reads a file."""
    from urdf2mbs.config import yaml_text  # PyYAML: not for a robot without a config

    data, places = yaml_text.parse_yaml(text, file)
    lines = Lines(file, places, file.parent if file else Path())
    if not isinstance(data, dict):
        message = "a config is a list of 'key: value' lines, such as 'source: robot.urdf'"
        raise lines.error("config-type", message)
    _override(data, _to_plain_data(fields), lines)
    return _read_fields(Config, data, lines, ()), lines


def config_of(
    source: Config | Mapping[str, Any] | str | os.PathLike[str], **fields: Any
) -> tuple[Config, Lines]:
    """Return the config of a call from Python.

    Paths are relative to the working folder, those of a config file to its folder.

    Args:
        source: A robot, a config file, a ``Config``, or a mapping of its fields.
        fields: Fields of ``Config`` that override those of the source.  A block of keys, such as
            ``xacro_args``, changes the block of the source; of ``passes``, the block of each pass.
            A path may stand for a text, any sequence for a list.

    Raises:
        ConfigError: A value is wrong.  With a config file, wrong values become faults of the lines.
    """
    values: Any = {"source": source}
    if isinstance(source, Config):
        values = msgspec.structs.asdict(source)
    elif isinstance(source, Mapping):
        values = source
    elif os.fspath(source).lower().endswith((".yaml", ".yml")):
        return load(Path(source), **fields)
    lines = Lines()
    data = _to_plain_data(values)
    _override(data, _to_plain_data(fields), lines)
    config = _read_fields(Config, data, lines, ())
    lines.check()
    return config, lines


def typed(kind: Any, data: Any, lines: Lines, at: Key = ()) -> Any:
    """Convert data into an instance of a Struct.

    Args:
        kind: The Struct.
        data: The data, a dict.
        lines: The line of each value.
        at: The key of the data in the config.

    Raises:
        ConfigError: A value is wrong; it names the key.
    """
    lines = Lines(lines.file, lines.places, lines.folder, overridden=lines.overridden)
    value = _read_fields(kind, data, lines, at)
    lines.check()
    return value


def _to_plain_data(values: Any) -> dict[str, Any]:
    """Convert values of a call into dicts, lists, texts and numbers."""
    plain: dict[str, Any] = msgspec.to_builtins(values, enc_hook=_convert_value, str_keys=True)
    return plain


def _convert_value(value: Any) -> Any:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return dict(value)
    try:
        return list(value)
    except TypeError:
        raise ConfigError("config-type", f"a config holds no such thing: {value!r}") from None


def _override(data: dict[str, Any], fields: dict[str, Any], lines: Lines) -> None:
    """Put fields of a command line or a call into the data of a config."""
    for name, value in fields.items():
        block = data.get(name)
        if not isinstance(value, dict) or not isinstance(block, dict):
            data[name] = value
            lines.overridden.add((name,))
            continue
        for key, inner in value.items():
            if name == "passes" and isinstance(block.get(key), dict) and isinstance(inner, dict):
                block[key] = {**block[key], **inner}
                lines.overridden |= {(name, key, option) for option in inner}
            else:
                block[key] = inner
                lines.overridden.add((name, key))


def _read_fields(kind: Any, data: Any, lines: Lines, at: Key) -> Any:
    """Convert data into an instance of a Struct, without what is wrong, which becomes faults.

    A key that is nearly a known one is read as the known one.  Raises ConfigError if nothing can
    be read.
    """
    with suppress(TypeError, *_REFUSED):
        # a class by its defaults: msgspec takes long for the first value of a class
        return kind() if data == {} else msgspec.convert(data, kind)
    if not isinstance(data, dict):
        message = f"'{dotted(at)}': expected 'key: value' lines, got {data!r}"
        raise lines.error("config-type", message, at)
    schema = msgspec.json.schema(kind)
    properties = schema["$defs"][schema["$ref"].rpartition("/")[2]]["properties"]
    # one word in place of a list is a list of one
    data = {
        key: [value] if isinstance(value, str) and properties.get(key, {}).get("items") else value
        for key, value in data.items()
    }
    try:
        return msgspec.convert(data, kind)
    except _REFUSED as error:
        from urdf2mbs.config.faults import take_faults  # jsonschema takes long

        faults = take_faults(schema, data, lines, at)
        if not faults:  # values that the class refuses together, or a text with half a letter
            reason = str(error).partition(" - at `")[0]
            raise lines.error("config-type", f"'{dotted(at)}': {reason}", at) from None
    lines.faults += faults
    with suppress(*_REFUSED):
        return msgspec.convert(data, kind)
    lines.check()
    return None
