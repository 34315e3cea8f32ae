"""Defaults of a config that the robot's own file states, such as its gravity.

A file of another format may say what a URDF cannot: its reader puts that into
``Expansion.settings``.  The values lie beneath those of the user's config, key by key.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import msgspec

from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.order import ConfiguredPass, merge_options
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.summary import list_robot_settings

#: The keys of a config that a robot's file may state.
KEYS = ("base", "gravity", "passes")


def apply_robot_settings(
    conversion: Conversion, config_lines: Lines, later_passes: list[ConfiguredPass]
) -> None:
    """Put the settings of the robot's file beneath those of the config.

    Passes that are not in the pipeline get none: the config has left them out.

    Args:
        conversion: The conversion; its ``settings`` get the merged config, and its ``input`` the
            settings of the robot that are in force.
        config_lines: The line of each value of the config.
        later_passes: The passes that have not run; those with such options are replaced.

    Raises:
        ConversionError: ``robot-settings-invalid``, a reader returns what no config has.
    """
    expansion = conversion.input.expansion
    if expansion is None or not expansion.settings:
        return
    config = conversion.settings.config
    stated: dict[str, Any] = msgspec.to_builtins(expansion.settings)
    _check_keys(conversion, stated)
    used: dict[str, Any] = {
        key: stated[key]
        for key in ("base", "gravity")
        if key in stated and not _is_set(key, config, config_lines)
    }
    pass_options = stated.get("passes", {})
    used_options: dict[str, Any] = {}
    for position, configured_pass in enumerate(later_passes):
        options = pass_options.get(configured_pass.name)
        if options:
            later_passes[position] = _add_options(conversion, configured_pass, options)
            if unused := _remove_keys(options, configured_pass.options):
                used_options[configured_pass.name] = unused
    if used_options:
        used["passes"] = used_options
    if not used:
        return
    merged_passes = merge_options(used_options, config.passes)
    fields = {**msgspec.to_builtins(config), **used, "passes": merged_passes}
    try:
        merged_config = msgspec.convert(fields, Config)
    except msgspec.ValidationError as error:
        raise _invalid_error(conversion, str(error)) from None
    conversion.settings = msgspec.structs.replace(conversion.settings, config=merged_config)
    conversion.input.settings = used
    names = ", ".join(list_robot_settings(conversion))
    conversion.note("robot-settings", f"settings of the robot's own file: {names}")


@contextmanager
def naming_robot_settings(pass_name: str, conversion: Conversion) -> Iterator[None]:
    """Add to an error about an option that the robot's file has stated it."""
    try:
        yield
    except ConfigError as error:
        options = conversion.input.settings.get("passes", {}).get(pass_name)
        if options and error.file is None:
            names = ", ".join(f"'{pass_name}.{name}'" for name in options)
            source = conversion.settings.source.name
            hint = f"{source} sets {names}; the config overrules it"
            error.hint = f"{error.hint}\n  {hint}" if error.hint else hint
        raise


def _check_keys(conversion: Conversion, stated: Mapping[str, Any]) -> None:
    """Raise ConversionError for a key that no robot's file may state."""
    for key in stated:
        if key not in KEYS:
            raise _invalid_error(conversion, f"'{key}'; expected {', '.join(KEYS)}")


def _invalid_error(conversion: Conversion, reason: str) -> ConversionError:
    """Return the error for settings that no config can have."""
    message = f"the reader of this file returns settings that no config has: {reason}"
    source = str(conversion.settings.source)
    return ConversionError("robot-settings-invalid", message, file=source)


def _is_set(key: str, config: Config, config_lines: Lines) -> bool:
    """Return whether the user has set a key of the config, also to its default."""
    is_stated = (key,) in config_lines.places or (key,) in config_lines.overridden
    return is_stated or getattr(config, key) != getattr(Config(source="x"), key)


def _add_options(
    conversion: Conversion, configured_pass: ConfiguredPass, options: dict[str, Any]
) -> ConfiguredPass:
    """Return a pass with options beneath its own."""
    try:
        return configured_pass.add_defaults(options)
    except ConversionError as error:
        raise _invalid_error(conversion, error.message) from error


def _remove_keys(options: dict[str, Any], removed: Mapping[str, Any]) -> dict[str, Any]:
    """Return options without those that others overrule."""
    kept = {key: value for key, value in options.items() if key not in removed}
    for key in options.keys() & removed.keys():
        if isinstance(options[key], dict) and isinstance(removed[key], dict):
            kept[key] = _remove_keys(options[key], removed[key])
    return {key: kept[key] for key in options if kept.get(key, {}) != {}}
