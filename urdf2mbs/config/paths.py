"""The paths in a config: ``~``, variables, and relative paths."""

from __future__ import annotations

import os
import re
from pathlib import Path

from urdf2mbs.config.lines import Key, Lines
from urdf2mbs.disk import files

#: A variable in a path, ``$NAME`` or ``${NAME}``, or the beginning of one that is not closed.
_VARIABLE = re.compile(r"\$(?:(?P<plain>[A-Za-z_]\w*)|\{(?P<braced>[A-Za-z_]\w*)\}|\{)")
#: ``~`` or ``~USER`` at the beginning of a path.
_HOME = re.compile(r"~[^/\\$]*(?![^/\\])")


def expand(given: str, lines: Lines, at: Key) -> str:
    """Return a path of a config with ``~`` and ``$VARIABLE`` filled in, as a shell does.

    The values of variables are not expanded again.

    Args:
        given: The path.
        lines: The line of each value; a path that is not of a file stays as it is.
        at: The key of the path.

    Raises:
        ConfigError: ``variable-unset`` or ``variable-unclosed``.
    """
    if lines.file is None:
        return given

    def replace_variable(variable: re.Match[str]) -> str:
        name = variable["plain"] or variable["braced"]
        if name is None:
            message = f"'{given}' has a '${{' that does not begin a variable; expected '${{NAME}}'"
            raise lines.error("variable-unclosed", message, at, "close it by '}' after the name")
        value = os.environ.get(name)
        if not value:
            message = f"'{given}' uses ${name}, which is not set or empty"
            hint = f"for instance: export {name}=DIR; the config's comments may say which folder"
            raise lines.error("variable-unset", message, at, hint)
        return value

    home = _HOME.match(given)
    start = home.end() if home else 0
    folder = os.path.expanduser(given[:start])  # noqa: PTH111
    return folder + _VARIABLE.sub(replace_variable, given[start:])


def make_absolute(given: str, lines: Lines, at: Key) -> Path:
    """Return the absolute path of a path of a config; raises ConfigError as ``expand``."""
    return files.absolute(lines.folder / expand(given, lines, at))
