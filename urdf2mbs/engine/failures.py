"""The error for an exception of a pass or a hook: in whose code, at which line, on which robot."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from urdf2mbs.config.lines import Key, Lines
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.hookspecs import PassEntry
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
        describe: Returns what has failed, as the subject of a sentence, for the name of a plugin.
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
        plugin, file = culprit
        raise _explain(
            "plugin-failed", describe(plugin), error, conversion, file=file, hint=_DEBUG
        ) from error


@contextmanager
def naming_pass(
    entry: PassEntry, conversion: Conversion, earlier: Sequence[PassEntry]
) -> Iterator[None]:
    """Raise an exception of a pass as an error that names the pass.

    Args:
        entry: The pass.
        conversion: What it changes.
        earlier: The passes that ran before it.

    Raises:
        ConversionError: ``plugin-failed``, or ``internal`` if the pass is one of ours.
    """
    try:
        yield
    except ConversionError:
        raise
    except MemoryError as error:
        raise memory_full_error(f"pass '{entry.name}' on robot '{_name(conversion)}'") from error
    except FAILURES as error:
        if not entry.is_ours:
            what = f"pass '{entry.name}' of plugin '{entry.plugin}'"
            raise _explain(
                "plugin-failed", what, error, conversion, file=entry.source, hint=_DEBUG
            ) from error
        strangers = [f"'{each.name}' ({each.plugin})" for each in earlier if not each.is_ours]
        hint = "this is a mistake in urdf2mbs: please report it with the robot; --debug shows more"
        if strangers:
            hint = f"a plugin's pass may have caused it before: {', '.join(strangers)}"
        what = f"pass '{entry.name}'"
        raise _explain("internal", what, error, conversion, file=entry.source, hint=hint) from error


@contextmanager
def locating_option(name: str, config: Config, lines: Lines) -> Iterator[None]:
    """Add to an error about an option of a pass the option's line in the config.

    An error that has a file keeps it.  Without options of the pass in the config file, nothing is
    added: a preset, the command line or a call from Python has set them.

    Args:
        name: The name of the pass.
        config: The config, with the options of the pass.
        lines: The line of each value of the config.
    """
    try:
        yield
    except ConfigError as error:
        key: Key = ("passes", name)
        if error.file is None and key in lines.places:
            key = _find_option(error.message, config.passes.get(name, {}), key)
            located = lines.error(error.code, error.message, key)
            error.file, error.line = located.file, located.line
        raise


def _find_option(message: str, options: dict[str, Any], key: Key) -> Key:
    """Return the key of the option that a message quotes: its value, its name, or its path."""
    quoted = set(re.findall(r"'([^']*)'", message))
    values = dict(_list_values(options, key))
    for words in (
        {place: str(value) for place, value in values.items()},
        {place: str(place[-1]) for place in values},
        {place: ".".join(map(str, place[2:])) for place in values},
    ):
        matching = [place for place, word in words.items() if place[2:] and word in quoted]
        if matching:
            return matching[0]
    return key


def _list_values(value: Any, key: Key) -> Iterator[tuple[Key, Any]]:
    """Yield each value of some options with its key, outer values first."""
    pending = [(key, value)]
    while pending:
        place, current = pending.pop(0)
        yield place, current
        if isinstance(current, dict):
            pending += [((*place, name), inner) for name, inner in current.items()]
        elif isinstance(current, list):
            pending += [((*place, index), inner) for index, inner in enumerate(current)]


def _explain(
    code: str,
    what: str,
    error: BaseException,
    conversion: Conversion | None,
    *,
    file: str,
    hint: str,
) -> ConversionError:
    """Return the error for an exception, at the innermost line of the plugin's code."""
    source, line = [(file, None), *list_frames(file, error.__traceback__)][-1]
    if conversion is None:  # of the config, so that it is reported with the config's other faults
        message = f"{what} failed: {describe_exception(error)}"
        return ConfigError(code, message, file=source, line=line)
    message = f"{what} failed on robot '{_name(conversion)}': {describe_exception(error)}"
    return ConversionError(code, message, file=source, line=line, hint=hint)


def _name(conversion: Conversion) -> str:
    """Return the robot's name; a plugin may have left no robot."""
    return getattr(conversion.robot, "name", "") or conversion.settings.source.name
