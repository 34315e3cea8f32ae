"""The error for an exception of a pass or a hook: in whose code, at which line, on which robot."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from urdf2mbs.config.lines import Key, Lines
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.order import ConfiguredPass
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, memory_full_error
from urdf2mbs.messages.tracebacks import FAILURES, describe_exception, list_frames

_DEBUG = "--debug shows the traceback"


@contextmanager
def naming_plugin(
    plugins: Plugins, describe: Callable[[str], str], conversion: Conversion | None = None
) -> Iterator[None]:
    """Raise an exception that went through the code of a plugin as an error that names it.

    Args:
        plugins: The plugins that are loaded.
        describe: Returns the subject of the message, given the name of the plugin that failed.
        conversion: The conversion; None while its config is read.

    Raises:
        ConversionError: ``plugin-failed``.
    """
    try:
        yield
    except ConversionError:
        raise
    except FAILURES as error:
        culprit = plugins.find_culprit(error.__traceback__)
        if culprit is None:
            raise
        plugin_name, plugin_file = culprit
        raise _make_failure_error(
            "plugin-failed", describe(plugin_name), error, conversion, file=plugin_file, hint=_DEBUG
        ) from error


@contextmanager
def naming_pass(
    plugins: Plugins,
    configured_pass: ConfiguredPass,
    conversion: Conversion,
    finished_passes: Sequence[ConfiguredPass],
) -> Iterator[None]:
    """Raise an exception of a pass as an error that names the pass, or a plugin that it called.

    Args:
        plugins: The plugins that are loaded.
        configured_pass: The pass.
        conversion: The conversion that the pass changes.
        finished_passes: The passes that ran before it.

    Raises:
        ConversionError: ``plugin-failed``, or ``internal`` if the code of urdf2mbs has failed.
    """
    entry = configured_pass.entry
    subject = f"pass '{entry.name}'"
    # of another author's pass, each exception goes through its own plugin
    naming_hooks: AbstractContextManager[None] = nullcontext()
    if entry.is_ours:
        called_plugin = f"plugin '{{}}', called by {subject},"
        naming_hooks = naming_plugin(plugins, called_plugin.format, conversion)
    try:
        with naming_hooks:
            yield
    except ConversionError:
        raise
    except MemoryError as error:
        raise memory_full_error(f"{subject} on robot '{_get_robot_name(conversion)}'") from error
    except FAILURES as error:
        code, hint = "plugin-failed", _DEBUG
        if entry.is_ours:
            code, hint = "internal", _explain_internal_error(finished_passes)
        else:
            subject += f" of plugin '{entry.plugin}'"
        raise _make_failure_error(
            code, subject, error, conversion, file=entry.source, hint=hint
        ) from error


def _explain_internal_error(finished_passes: Sequence[ConfiguredPass]) -> str:
    """Return the hint for an error of urdf2mbs: other authors' passes may be the cause."""
    foreign_entries = [step.entry for step in finished_passes if not step.entry.is_ours]
    if foreign_entries:
        named = ", ".join(f"'{entry.name}' ({entry.plugin})" for entry in foreign_entries)
        return f"a plugin's pass may have caused it before: {named}"
    return "this is a mistake in urdf2mbs: please report it with the robot; --debug shows more"


@contextmanager
def locating_option(pass_name: str, config: Config, config_lines: Lines) -> Iterator[None]:
    """Add to an error about an option of a pass the option's line in the config.

    An error that has a file keeps it.  Without options of the pass in the config file, nothing is
    added: a preset, the command line or a call from Python has set them.

    Args:
        pass_name: The name of the pass.
        config: The config, with the options of the pass.
        config_lines: The line of each value of the config.
    """
    try:
        yield
    except ConfigError as error:
        option_key: Key = ("passes", pass_name)
        if error.file is None and option_key in config_lines.places:
            option_key = _find_option(error.message, config.passes.get(pass_name, {}), option_key)
            located = config_lines.error(error.code, error.message, option_key)
            error.file, error.line = located.file, located.line
        raise


def _find_option(message: str, options: dict[str, Any], pass_key: Key) -> Key:
    """Return the key of the option that a message quotes: its value, its name, or its path."""
    quoted_words = set(re.findall(r"'([^']*)'", message))
    values_by_key = dict(_list_values(options, pass_key))
    for words_by_key in (
        {option_key: str(option_value) for option_key, option_value in values_by_key.items()},
        {option_key: str(option_key[-1]) for option_key in values_by_key},
        {option_key: ".".join(map(str, option_key[2:])) for option_key in values_by_key},
    ):
        matching_keys = [
            option_key
            for option_key, word in words_by_key.items()
            if option_key[2:] and word in quoted_words
        ]
        if matching_keys:
            return matching_keys[0]
    return pass_key


def _list_values(options: Any, options_key: Key) -> Iterator[tuple[Key, Any]]:
    """Yield each value of some options with its key, outer values first."""
    pending = [(options_key, options)]
    while pending:
        current_key, current_value = pending.pop(0)
        yield current_key, current_value
        if isinstance(current_value, dict):
            pending += [
                ((*current_key, name), inner_value) for name, inner_value in current_value.items()
            ]
        elif isinstance(current_value, list):
            pending += [
                ((*current_key, index), inner_value)
                for index, inner_value in enumerate(current_value)
            ]


def _make_failure_error(
    error_code: str,
    subject: str,
    error: BaseException,
    conversion: Conversion | None,
    *,
    file: str,
    hint: str,
) -> ConversionError:
    """Return the error for an exception, at the innermost line of the plugin's code."""
    source_file, line = [(file, None), *list_frames(file, error.__traceback__)][-1]
    if conversion is None:  # of the config, so that it is reported with the config's other faults
        message = f"{subject} failed: {describe_exception(error)}"
        return ConfigError(error_code, message, file=source_file, line=line)
    message = (
        f"{subject} failed on robot '{_get_robot_name(conversion)}': {describe_exception(error)}"
    )
    return ConversionError(error_code, message, file=source_file, line=line, hint=hint)


def _get_robot_name(conversion: Conversion) -> str:
    """Return the robot's name; a plugin may have left no robot."""
    return getattr(conversion.robot, "name", "") or conversion.settings.source.name
