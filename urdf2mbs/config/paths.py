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


def expand(stated_path: str, config_lines: Lines, path_key: Key) -> str:
    """Return a path of a config with ``~`` and ``$VARIABLE`` filled in, as a shell does.

    The values of variables are not expanded again.

    Args:
        stated_path: The path.
        config_lines: The line of each value; a path that is not of a file stays as it is.
        path_key: The key of the path.

    Raises:
        ConfigError: ``variable-unset`` or ``variable-unclosed``.
    """
    if config_lines.file is None:
        return stated_path

    def replace_variable(variable: re.Match[str]) -> str:
        variable_name = variable["plain"] or variable["braced"]
        if variable_name is None:
            message = (
                f"'{stated_path}' has a '${{' that does not begin a variable; expected '${{NAME}}'"
            )
            raise config_lines.error(
                "variable-unclosed", message, path_key, "close it by '}' after the name"
            )
        variable_value = os.environ.get(variable_name)
        if not variable_value:
            message = f"'{stated_path}' uses ${variable_name}, which is not set or empty"
            hint = (
                f"for instance: export {variable_name}=DIR; "
                "the config's comments may say which folder"
            )
            raise config_lines.error("variable-unset", message, path_key, hint)
        return variable_value

    home_prefix = _HOME.match(stated_path)
    prefix_length = home_prefix.end() if home_prefix else 0
    home_folder = os.path.expanduser(stated_path[:prefix_length])  # noqa: PTH111
    return home_folder + _VARIABLE.sub(replace_variable, stated_path[prefix_length:])


def make_absolute(stated_path: str, config_lines: Lines, path_key: Key) -> Path:
    """Return the absolute path of a path of a config; raises ConfigError as ``expand``."""
    return files.absolute(config_lines.folder / expand(stated_path, config_lines, path_key))
