"""Files are read up to a bound: no file, however large, takes more memory than that."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from errno import EBADF, EFBIG, EINVAL
from pathlib import Path
from typing import IO

from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, counted

#: The most that is read of one file: a robot, a mesh, an .mbs.
MAX_FILE_SIZE = 256 * 2**20

#: What Windows takes for a device, whatever the ending.
WINDOWS_DEVICES = frozenset(
    ["con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))]
)

#: What messages call standard input, and the name of the file that it stands for.
STDIN = "<stdin>"
#: What standard input held, once ``take_stdin`` has read it.
_taken: list[bytes] = []

#: The files that this thread has read since ``noting`` began; None: nobody asks.
_noted: ContextVar[dict[str, None] | None] = ContextVar("noted", default=None)


@contextmanager
def noting() -> Iterator[dict[str, None]]:
    """Gives the files that are read within it."""
    noted: dict[str, None] = {}
    token = _noted.set(noted)
    try:
        yield noted
    finally:
        _noted.reset(token)


def read_bytes(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file, or of standard input where that was taken.

    Raises OSError: for a pipe or device, which may never end, and for more than ``most`` bytes
    (default: ``MAX_FILE_SIZE``).
    """
    if is_stdin(path):
        return _taken[0]
    noted = _noted.get()
    if noted is not None:
        noted[os.path.abspath(path)] = None  # noqa: PTH100
    try:
        if stat.S_IFMT(path.stat().st_mode) not in (stat.S_IFREG, stat.S_IFDIR):
            raise OSError(EINVAL, "it is a pipe or a device, and no file", str(path))
        with path.open("rb", buffering=0) as file:
            return read_stream(file, str(path), most, os.fstat(file.fileno()).st_size)
    except ValueError as error:  # a name with a NUL
        raise OSError(0, str(error), str(path)) from None


def read_model(model: str | os.PathLike[str]) -> bytes:
    """The bytes of an .mbs file; ``-`` is standard input.  Raises ConfigError."""
    try:
        return read_stdin() if os.fspath(model) == "-" else read_bytes(Path(model))
    except OSError as error:
        raise ConfigError("model-unreadable", f"cannot read '{model}': {error.strerror}") from None


def is_stdin(path: Path) -> bool:
    """True if standard input was taken, and this is the name of its file."""
    return path.name == STDIN and bool(_taken)


def take_stdin() -> str:
    """Read all of standard input; gives the source that stands for it.

    :raises ConversionError: ``file-unreadable``
    """
    try:
        _taken[:] = [read_stdin()]
    except OSError as error:
        said = f"cannot be read: {error.strerror}"
        raise ConversionError("file-unreadable", said, file=STDIN) from None
    return STDIN


def read_stdin() -> bytes:
    """All of standard input; raises OSError."""
    if sys.stdin is None:
        raise OSError(EBADF, "standard input is closed", STDIN)
    return read_stream(sys.stdin.buffer, STDIN)


def read_stream(stream: IO[bytes], name: str, most: int | None = None, size: int = 0) -> bytes:
    """All bytes of a stream, which probably are ``size``; raises OSError as ``read`` does."""
    most = MAX_FILE_SIZE if most is None else most
    step = max(size, 2**16) + 1
    parts, count = [], 0
    while data := stream.read(min(step, most + 1 - count)):
        parts.append(data)
        count += len(data)
    if count > most:
        raise OSError(EFBIG, f"it is larger than {_size(most)}, the most that is read", name)
    return b"".join(parts)


def _size(count: int) -> str:
    return f"{count >> 20} MiB" if count >= 2**20 else f"{count} bytes"


def is_portable(name: str) -> bool:
    """True if every system can have a file of this name."""
    return (
        name.partition(".")[0].strip().lower() not in WINDOWS_DEVICES
        and not name.endswith((" ", "."))
        and not set(name) & set('<>:"/\\|?*')
        and min(name, default="") >= " "
    )


def read_beginning(path: Path, count: int) -> bytes:
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


def temporary_name(place: Path) -> Path:
    """Return a new path in the folder of a file, for data that will be renamed to the file.

    The name is random, so that threads and processes that write one file never meet.  A file that
    is opened under it has the mode of any new file; those of ``tempfile`` are for their owner only.
    """
    return place.with_name(f".urdf2mbs.{os.urandom(16).hex()}.part")


def project_of(model: Path) -> Path:
    """The project's folder of an .mbs: the one around ``dataR``, else the file's own."""
    return model.parent.parent if model.parent.name == "dataR" else model.parent


def is_folder(path: Path) -> bool:
    """True if there is such a folder; False for a name that no folder can have."""
    return os.path.isdir(path)  # noqa: PTH112  Path.is_dir may raise


def is_file(path: Path) -> bool:
    """True if there is such a file; False for a name that no file can have."""
    return os.path.isfile(path)  # noqa: PTH113  Path.is_file may raise


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
        pass  # the reader of the file reports it
    except (OSError, ValueError) as error:
        shown = str(path) if len(str(path)) <= 80 else f"{str(path)[:77]}..."
        raise ConfigError(
            "path-invalid",
            f"there can be no file {shown!r}: {getattr(error, 'strerror', None) or error}",
        ) from None
    return Path(whole)


def model_of(place: Path) -> Path | None:
    """The .mbs of a project's folder, or the .mbs itself; None: it is a robot or a config.

    Raises ConfigError for a folder that is no project.
    """
    if place.suffix.lower() == ".mbs":
        return place
    if not is_folder(place):
        return None
    beside = (".rejected.mbs", ".orphaned.mbs")
    models = [file for file in place.glob("dataR/*.mbs") if not file.name.endswith(beside)]
    if len(models) != 1:
        raise ConfigError(
            "project-unknown",
            f"the folder '{place}' is no Robotran project: its dataR has "
            f"{counted(len(models), 'model')} (.mbs; those called rejected or orphaned are none)",
            hint="name the .mbs itself",
        )
    return models[0]
