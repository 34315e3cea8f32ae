"""Where each value of a config comes from, so that an error names its file and line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from urdf2mbs.messages.diagnostics import ConfigError

#: The keys, and positions in lists, that lead to a value of a config.
Key = tuple[str | int, ...]


class Lines(msgspec.Struct):
    """The line of each value of a config file, and the faults of the config."""

    file: Path | None = None
    """The config file; None: the config comes from a command line or a call."""
    places: dict[Key, int] = {}
    """The line of each value."""
    folder: Path = Path()
    """The folder of the relative paths in the config."""
    faults: list[ConfigError] = []
    """The faults in the part of the config that has been read; ``check`` raises them."""
    overridden: set[Key] = set()
    """The values that a command line or a call has set, and not the file."""

    def error(self, code: str, message: str, at: Key = (), hint: str | None = None) -> ConfigError:
        """Return the error for a value, at its line or at that of the block that holds it."""
        enclosing_keys = [at[:length] for length in range(len(at), -1, -1)]
        located_key = next(
            (
                located_key
                for located_key in enclosing_keys
                if located_key in self.overridden or located_key in self.places
            ),
            (),
        )
        if self.file is None or located_key in self.overridden:
            return ConfigError(code, message, hint=hint)
        return ConfigError(
            code, message, file=str(self.file), line=self.places.get(located_key), hint=hint
        )

    @contextmanager
    def gather(self) -> Iterator[None]:
        """Keep a ConfigError among the faults."""
        try:
            yield
        except ConfigError as error:
            self.faults.append(error)

    def check(self) -> None:
        """Raise the faults as one ConfigError, in the order of their lines."""
        if self.faults:
            *earlier, last = sorted(self.faults, key=lambda fault: fault.line or 0)
            self.faults = []
            diagnostics = [
                diagnostic
                for fault in earlier
                for diagnostic in (*fault.earlier, fault.diagnostic())
            ]
            last.earlier = diagnostics + last.earlier
            raise last


def dotted(config_key: Key) -> str:
    """Return the key of a value as a message shows it."""
    return ".".join(map(str, config_key)) or "config"
