"""Where in a plugin's own code an exception came from."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import TracebackType

#: The exceptions of a plugin that become a message, ``sys.exit()`` among them.
FAILURES = (Exception, SystemExit)


def in_words(error: BaseException) -> str:
    """An exception in one line; a SyntaxError repeats its own file and line otherwise."""
    text = error.msg if isinstance(error, SyntaxError) else " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def line_in(file: Path, error: BaseException) -> int | None:
    own = (str(file), os.path.abspath(file))  # noqa: PTH100 importlib names the whole path
    if isinstance(error, SyntaxError) and error.filename in own:
        return error.lineno
    frames = frames_in(str(file), error.__traceback__)
    return frames[-1][1] if frames else None


def frames_in(file: str, tb: TracebackType | None) -> list[tuple[str, int]]:
    """The frames of a traceback (file, line) in a plugin's own code: its file, or its folder if
    that is a package."""
    import traceback

    own = os.path.abspath(file)  # noqa: PTH100 importlib names the whole path
    folder = own.removesuffix("__init__.py")
    frames = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(tb)]
    return [
        (name, line)
        for name, line in frames
        if name in (file, own) or (folder != own and name.startswith(folder))
    ]
