"""Read files up to a maximal size, so that no file takes more memory than that."""

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

from urdf2mbs.messages.diagnostics import ConfigError, ConversionError

#: The largest file (bytes) that is read: a robot, a mesh, an .mbs.
MAX_FILE_SIZE = 256 * 2**20

#: Names that Windows takes for a device, whatever the suffix.
WINDOWS_DEVICES = frozenset(
    ["con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))]
)

#: How messages call standard input, and the name that replaces that of a file.
STDIN = "<stdin>"
#: The content of standard input, once ``take_stdin`` has read it.
_stdin_content: list[bytes] = []

#: The files that this thread has read since ``noting`` began; None outside of ``noting``.
_noted_files: ContextVar[dict[str, None] | None] = ContextVar("noted_files", default=None)


@contextmanager
def noting() -> Iterator[dict[str, None]]:
    """Note the files that are read within a ``with`` block.

    Yields:
        Their absolute paths, in the order of reading.
    """
    noted_paths: dict[str, None] = {}
    context_token = _noted_files.set(noted_paths)
    try:
        yield noted_paths
    finally:
        _noted_files.reset(context_token)


# --- reading ---


def read_bytes(path: Path, max_size: int | None = None) -> bytes:
    """Read a file, or standard input where that was taken for it.

    Args:
        path: The file.
        max_size: The largest size (bytes); None for ``MAX_FILE_SIZE``.

    Raises:
        OSError: The file cannot be read, is larger, or is a pipe or a device, which may never end.
    """
    if is_stdin(path):
        return _stdin_content[0]
    noted_files = _noted_files.get()
    if noted_files is not None:
        noted_files[os.path.abspath(path)] = None  # noqa: PTH100
    try:
        if stat.S_IFMT(path.stat().st_mode) not in (stat.S_IFREG, stat.S_IFDIR):
            raise OSError(EINVAL, "it is a pipe or a device, and no file", str(path))
        with path.open("rb", buffering=0) as stream:
            return read_stream(stream, str(path), max_size, os.fstat(stream.fileno()).st_size)
    except ValueError as error:  # a name with a NUL
        raise OSError(0, str(error), str(path)) from None


def read_model(model: str | os.PathLike[str]) -> bytes:
    """Read an .mbs file, or standard input for ``-``.

    Raises:
        ConfigError: ``model-unreadable``.
    """
    try:
        return read_stdin() if os.fspath(model) == "-" else read_bytes(Path(model))
    except OSError as error:
        is_missing = isinstance(error, FileNotFoundError)
        hint = suggest_file(Path(model), (".mbs",)) if is_missing else None
        message = f"cannot read '{model}': {error.strerror}"
        raise ConfigError("model-unreadable", message, hint=hint) from None


def is_stdin(path: Path) -> bool:
    """Return True if standard input was taken, and this is the name of its file."""
    return path.name == STDIN and bool(_stdin_content)


def take_stdin() -> str:
    """Read all of standard input, and return the name to use as that of a file.

    Raises:
        ConversionError: ``file-unreadable``.
    """
    try:
        _stdin_content[:] = [read_stdin()]
    except OSError as error:
        message = f"cannot be read: {error.strerror}"
        raise ConversionError("file-unreadable", message, file=STDIN) from None
    return STDIN


def read_stdin() -> bytes:
    """Read all of standard input; raise OSError if that fails."""
    if sys.stdin is None:
        raise OSError(EBADF, "standard input is closed", STDIN)
    return read_stream(sys.stdin.buffer, STDIN)


def read_stream(
    stream: IO[bytes], name: str, max_size: int | None = None, expected_size: int = 0
) -> bytes:
    """Read all bytes of a stream.

    Args:
        stream: The stream.
        name: Its name, for the error.
        max_size: The largest size (bytes); None for ``MAX_FILE_SIZE``.
        expected_size: Its probable size (bytes), which is read at once.

    Raises:
        OSError: The stream cannot be read, or is larger.
    """
    max_size = MAX_FILE_SIZE if max_size is None else max_size
    chunk_size = max(expected_size, 2**16) + 1
    chunks, n_bytes_read = [], 0
    while chunk := stream.read(min(chunk_size, max_size + 1 - n_bytes_read)):
        chunks.append(chunk)
        n_bytes_read += len(chunk)
    if n_bytes_read > max_size:
        message = f"it is larger than {_format_size(max_size)}, the most that is read"
        raise OSError(EFBIG, message, name)
    return b"".join(chunks)


def _format_size(size: int) -> str:
    """Return a size (bytes) with its unit."""
    return f"{size >> 20} MiB" if size >= 2**20 else f"{size} bytes"


def read_beginning(path: Path, count: int) -> bytes:
    """Read the first bytes of a file; return none if it cannot be read."""
    try:
        with path.open("rb") as stream:
            return stream.read(count)
    except (OSError, ValueError):
        return b""


# --- paths ---


def is_portable(name: str) -> bool:
    """Return True if every operating system can have a file of this name."""
    return (
        name.partition(".")[0].strip().lower() not in WINDOWS_DEVICES
        and not name.endswith((" ", "."))
        and not set(name) & set('<>:"/\\|?*')
        and min(name, default="") >= " "
    )


def size(path: Path) -> int:
    """Return the size of a file (bytes); 0 if it cannot be found out."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


def temporary_name(file: Path) -> Path:
    """Return a new path in the folder of a file, for data that will be renamed to the file.

    The name is random, so that threads and processes that write one file never meet.  A file that
    is opened under it has the mode of any new file; those of ``tempfile`` are for their owner only.
    """
    return file.with_name(f".urdf2mbs.{os.urandom(16).hex()}.part")


def list_files(folder: Path, n_entries: int) -> Iterator[Path]:
    """Yield the files of a folder and of those below it, sorted, but for hidden folders.

    Args:
        folder: The folder.
        n_entries: The most files and folders that are looked at, as a home has very many.
    """
    for name, subfolders, file_names in os.walk(folder):
        subfolders[:] = sorted(subfolder for subfolder in subfolders if subfolder[0] != ".")
        yield from (Path(name, file_name) for file_name in sorted(file_names)[:n_entries])
        n_entries -= len(subfolders) + len(file_names)
        if n_entries <= 0:
            return


def suggest_file(path: Path, endings: tuple[str, ...]) -> str | None:
    """Return a hint with the file beside a path that its user may have meant; None: none is near.

    Args:
        path: A file that does not exist.
        endings: The endings of the files that are offered, in lower case.
    """
    try:
        names = sorted(entry.name for entry in path.parent.iterdir())
    except (OSError, ValueError):
        return None
    names_by_stem: dict[str, list[str]] = {}
    for name in names:
        if name.lower().endswith(endings):
            names_by_stem.setdefault(name.split(".")[0], []).append(name)
    from difflib import get_close_matches

    stems = get_close_matches(path.name.split(".")[0], names_by_stem, n=1, cutoff=0.5)
    if not stems:
        return None
    (name,) = get_close_matches(path.name, names_by_stem[stems[0]], n=1, cutoff=0.0)
    return f"did you mean '{name}'?"


def project_of(model: Path) -> Path:
    """Return the project's folder of an .mbs: the parent of ``dataR``, else the file's folder."""
    return model.parent.parent if model.parent.name == "dataR" else model.parent


def is_folder(path: Path) -> bool:
    """Return True if a folder exists; False also for a name that no folder can have."""
    return os.path.isdir(path)  # noqa: PTH112  Path.is_dir may raise


def is_file(path: Path) -> bool:
    """Return True if a file exists; False also for a name that no file can have."""
    return os.path.isfile(path)  # noqa: PTH113  Path.is_file may raise


def absolute(path: Path) -> Path:
    """Return the absolute path, in which links keep their name, unlike with ``Path.resolve``.

    Raises:
        ConfigError: ``path-invalid``: no file can have such a path, as it is too long, say.
    """
    try:
        absolute_path = os.path.abspath(path)  # noqa: PTH100
    except OSError:
        message = f"there is no file '{path}': the working folder does not exist any more"
        raise ConfigError("path-invalid", message, hint="cd to a folder that exists") from None
    try:
        os.stat(absolute_path)  # noqa: PTH116
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        pass  # the reader of the file reports it
    except (OSError, ValueError) as error:
        shown_path = str(path) if len(str(path)) <= 80 else f"{str(path)[:77]}..."
        failure_reason = getattr(error, "strerror", None) or error
        message = f"there can be no file {shown_path!r}: {failure_reason}"
        raise ConfigError("path-invalid", message) from None
    return Path(absolute_path)


def model_of(path: Path) -> Path | None:
    """Return the .mbs of a project's folder, or an .mbs itself.

    Args:
        path: A project's folder, an .mbs, or another file.

    Returns:
        The .mbs; None for another file, which is a robot or a config.

    Raises:
        ConfigError: ``project-unknown``: the folder is not that of a project.
    """
    if path.suffix.lower() == ".mbs":
        return path
    if not is_folder(path):
        return None
    models = list_models(path)
    if len(models) != 1:
        message = (
            f"the folder '{path}' is not a Robotran project: expected 1 model (.mbs) in its "
            f"dataR, got {len(models)}; those called rejected or orphaned are ignored"
        )
        raise ConfigError("project-unknown", message, hint="name the .mbs itself")
    return models[0]


def list_models(project: Path) -> list[Path]:
    """Return the models of a project's folder; none if it is another folder."""
    return sorted(file for file in project.glob("dataR/*.mbs") if is_model_name(file.name))


def is_model_name(name: str) -> bool:
    """Return whether a name is that of a model, and not of one that was rejected or orphaned."""
    return name.endswith(".mbs") and not name.endswith((".rejected.mbs", ".orphaned.mbs"))
