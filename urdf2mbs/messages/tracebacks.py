"""Where in a plugin's code an exception came from."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import TracebackType

#: The exceptions of a plugin that become a message, ``sys.exit()`` among them.
FAILURES = (Exception, SystemExit)


def describe_exception(error: BaseException) -> str:
    """Return an exception in one line; of a SyntaxError without its file and line."""
    message = error.msg if isinstance(error, SyntaxError) else " ".join(str(error).split())
    return f"{type(error).__name__}: {message}" if message else type(error).__name__


def find_line(plugin_file: Path, error: BaseException) -> int | None:
    """Return the innermost line of a file that an exception came from; None: no line of it."""
    file_names = (str(plugin_file), os.path.abspath(plugin_file))  # noqa: PTH100 importlib names the whole path
    if isinstance(error, SyntaxError) and error.filename in file_names:
        return error.lineno
    plugin_frames = list_frames(str(plugin_file), error.__traceback__)
    return plugin_frames[-1][1] if plugin_frames else None


def list_frames(file: str, traceback: TracebackType | None) -> list[tuple[str, int]]:
    """Return the frames of a traceback in the code of a plugin, as file and line.

    Args:
        file: The file of the plugin; all files of its folder count if it is an ``__init__.py``.
        traceback: The traceback of an exception.
    """
    from traceback import walk_tb

    plugin_file = os.path.abspath(file)  # noqa: PTH100 importlib names the whole path
    folder = plugin_file.removesuffix("__init__.py")
    frames = [(frame.f_code.co_filename, line) for frame, line in walk_tb(traceback)]
    return [
        (file_name, line)
        for file_name, line in frames
        if file_name in (file, plugin_file)
        or (folder != plugin_file and file_name.startswith(folder))
    ]
