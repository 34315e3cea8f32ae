"""Where in a config the option is that an error of a running pass is about."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from urdf2mbs.config.model import Config, Key, Lines
from urdf2mbs.messages.diagnostics import ConfigError


def locate_option(error: ConfigError, name: str, config: Config, lines: Lines) -> None:
    """Add the file and line of the option that an error of a pass is about.

    An error that has a file keeps it.  Without options of the pass in the config file, nothing is
    added: a preset, the command line or a call from Python has set them.

    Args:
        error: The error that the pass raised.
        name: The name of the pass.
        config: The config, with the options of the pass.
        lines: Where each value of the config stands.
    """
    key: Key = ("passes", name)
    if error.file is not None or key not in lines.places:
        return
    quoted = set(re.findall(r"'([^']*)'", error.message))
    values = dict(_list_values(config.passes.get(name, {}), key))
    for words in (
        {place: str(value) for place, value in values.items()},
        {place: str(place[-1]) for place in values},
        {place: ".".join(map(str, place[2:])) for place in values},
    ):
        about = [place for place, word in words.items() if place[2:] and word in quoted]
        if about:
            key = about[0]
            break
    located = lines.error(error.code, error.message, key)
    error.file, error.line = located.file, located.line


def _list_values(value: Any, key: Key) -> Iterator[tuple[Key, Any]]:
    """Yield each value of some options with its key, outer values first."""
    pending = [(key, value)]
    while pending:
        place, found = pending.pop(0)
        yield place, found
        if isinstance(found, dict):
            pending += [((*place, name), inner) for name, inner in found.items()]
        elif isinstance(found, list):
            pending += [((*place, index), inner) for index, inner in enumerate(found)]
