"""Files are read up to a bound: no file, however large, takes more memory than that."""

from __future__ import annotations

import os
import select
import stat
from contextlib import suppress
from errno import EFBIG, ENXIO, ETIMEDOUT
from pathlib import Path
from time import monotonic, sleep
from typing import IO

from urdf2mbs.diagnostics import ConfigError

#: The most that is read of one file: a robot, a mesh, an .mbs.
MOST = 256 * 2**20

#: What Windows takes for a device, whatever the ending.
DEVICES = frozenset(
    ["con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))]
)

#: Seconds that a pipe into which no program writes is waited for.
PATIENCE = 5.0


def read(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file, a pipe or a device.

    Raises OSError; for more than ``most`` bytes (default: ``MOST``) it says the bound.
    """
    try:
        if _is_pipe(path):
            return _read_pipe(path, most)
        with path.open("rb", buffering=0) as file:
            return read_stream(file, str(path), most, os.fstat(file.fileno()).st_size)
    except ValueError as error:  # a name with a NUL
        raise OSError(0, str(error), str(path)) from None


def read_stream(stream: IO[bytes], name: str, most: int | None = None, size: int = 0) -> bytes:
    """All bytes of a stream, which probably are ``size``; raises OSError as ``read`` does."""
    most = MOST if most is None else most
    step = max(size, 2**16) + 1
    parts, count = [], 0
    while data := stream.read(min(step, most + 1 - count)):
        parts.append(data)
        count += len(data)
    if count > most:
        raise OSError(EFBIG, f"it is larger than {_size(most)}, the most that is read", name)
    return b"".join(parts)


def _is_pipe(path: Path) -> bool:
    try:
        return stat.S_ISFIFO(path.stat().st_mode)
    except OSError:
        return False


def _read_pipe(path: Path, most: int | None) -> bytes:
    """All that comes through a pipe; a plain ``open`` waits without an end for a program that
    writes into it.

    Raises OSError where none has it open after ``PATIENCE`` seconds.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with os.fdopen(descriptor, "rb") as pipe:
        begin = b""
        if not select.select([descriptor], [], [], PATIENCE)[0]:
            with suppress(BlockingIOError):  # a program has it open, and is still at work
                begin = os.read(descriptor, 1)
                if not begin:
                    raise OSError(
                        ETIMEDOUT, "it is a pipe, and no program writes into it", str(path)
                    )
        os.set_blocking(descriptor, True)
        return begin + read_stream(pipe, str(path), most)


def open_stream(path: Path) -> IO[bytes]:
    """A pipe or a device to write to.

    Raises OSError where no program reads from a pipe for ``PATIENCE`` seconds.
    """
    end = monotonic() + PATIENCE
    while _is_pipe(path):
        try:
            descriptor = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
        except OSError as error:
            if error.errno != ENXIO:
                raise
            if monotonic() > end:
                raise OSError(
                    ETIMEDOUT, "it is a pipe, and no program reads from it", str(path)
                ) from None
            sleep(0.01)
        else:
            os.set_blocking(descriptor, True)
            return os.fdopen(descriptor, "wb")
    return path.open("wb")


def _size(count: int) -> str:
    return f"{count >> 20} MiB" if count >= 2**20 else f"{count} bytes"


def is_portable(name: str) -> bool:
    """Whether every system has files of this name."""
    return (
        name.partition(".")[0].strip().lower() not in DEVICES
        and not name.endswith((" ", "."))
        and not set(name) & set('<>:"/\\|?*')
        and min(name, default="") >= " "
    )


def beginning(path: Path, count: int) -> bytes:
    """The first bytes of a file; none of one that cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(count)
    except (OSError, ValueError):
        return b""


def size(path: Path) -> int:
    """Bytes of a file; 0 where that is not known."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


def is_folder(path: Path) -> bool:
    """Whether there is such a folder; what is wrong with a name is said where it is used."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Whether there is such a file; what is wrong with a name is said where it is used."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def absolute(path: Path) -> Path:
    """The path from the root, where links keep their name, unlike with ``Path.resolve``.

    Raises ConfigError where no file can have such a path: it is too long, say.
    """
    try:
        whole = os.path.abspath(path)  # noqa: PTH100
    except OSError:
        raise ConfigError(
            "path-invalid",
            f"there is no file '{path}': the working folder is not there any more",
            hint="cd to a folder that is there",
        ) from None
    try:
        os.stat(whole)  # noqa: PTH116
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        pass  # which is said where the file is used
    except (OSError, ValueError) as error:
        shown = str(path) if len(str(path)) <= 80 else f"{str(path)[:77]}..."
        raise ConfigError(
            "path-invalid",
            f"there can be no file {shown!r}: {getattr(error, 'strerror', None) or error}",
        ) from None
    return Path(whole)
