"""Files are read up to a bound: no file, however large, takes more memory than that."""

from __future__ import annotations

import os
from errno import EFBIG
from pathlib import Path

from urdf2mbs.diagnostics import ConfigError

#: The most that is read of one file: a robot, a mesh, an .mbs.
MOST = 256 * 2**20


def read(path: Path, most: int | None = None) -> bytes:
    """The bytes of a file, a pipe or a device.

    Raises OSError; for more than ``most`` bytes (default: ``MOST``) it says the bound.
    """
    most = MOST if most is None else most
    try:
        with path.open("rb") as file:
            step = max(os.fstat(file.fileno()).st_size, 2**16) + 1
            data = file.read(min(step, most + 1))
            parts, count = [data], len(data)
            while data and count <= most:
                data = file.read(min(step, most + 1 - count))
                parts.append(data)
                count += len(data)
    except ValueError as error:  # a name with a NUL
        raise OSError(0, str(error), str(path)) from None
    if count > most:
        raise OSError(EFBIG, f"it is larger than {_size(most)}, the most that is read", str(path))
    return b"".join(parts)


def _size(count: int) -> str:
    return f"{count >> 20} MiB" if count >= 2**20 else f"{count} bytes"


def is_folder(path: Path) -> bool:
    """Whether there is such a folder; what is wrong with a name is said where it is used."""
    try:
        return path.is_dir()
    except OSError:
        return False


def absolute(path: Path) -> Path:
    """The path from the root, where links keep their name, unlike with ``Path.resolve``.

    Raises ConfigError where no file can have such a path: it is too long, say.
    """
    try:
        whole = os.path.abspath(path)  # noqa: PTH100
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
