"""Writes the files of a conversion: never half a file, and never over people's work.

Each file is written in its folder under a random name, with the mode of the file that it replaces,
and then renamed.  Threads and processes may write one output at the same time: each file is that of
one of them.  A run that fails or is killed between two files leaves some of them new, and the next
run writes the others.  Only a run that is killed leaves temporary files.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from errno import EACCES, EINVAL, EISDIR
from pathlib import Path
from stat import S_IMODE
from types import MappingProxyType

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk import record
from urdf2mbs.disk.files import is_portable, read_bytes, temporary_name
from urdf2mbs.messages.diagnostics import ConfigError

WINDOWS = os.name == "nt"


def write(conversion: Conversion, *, force: bool = False) -> None:
    """Write the files of a conversion, and for a project the folders that Robotran expects.

    Obsolete files are removed if nobody has changed them.

    Args:
        conversion: The finished conversion.
        force: Whether to replace files that were edited, or that urdf2mbs has not written.

    Raises:
        ConfigError: A file cannot be written, or is not ours to replace; or no plugin writes the
            code of a project.
    """
    project = conversion.settings.project
    folders = [] if project is None else _list_folders(conversion, project)
    files = _list_files(conversion)
    write_files(
        files,
        folders,
        once=conversion.files_of("starter"),
        obsolete=conversion.files_of("obsolete"),
        force=force,
        replaces=_list_replaced(files),
    )


def _list_folders(conversion: Conversion, project: Path) -> list[Path]:
    """Return the folders of a project that plugins fill; raises ConfigError if none does."""
    names = [name for names in conversion.hook.urdf2mbs_folders() for name in names]
    if not names:
        message = "no plugin writes the code of a Robotran project"
        hint = "name an .mbs file as the output, or install urdf2mbs whole"
        raise ConfigError("plugin-missing", message, hint=hint)
    return [project / name for name in names]


def plan(conversion: Conversion, *, force: bool = False) -> dict[str, list[Path]]:
    """Return the files that ``write`` would create, change and remove.

    Args:
        conversion: The finished conversion.
        force: As in ``write``.

    Raises:
        ConfigError: As in ``write``.
    """
    files = _list_files(conversion)
    if not force:
        check_ours(files, _list_replaced(files))
    files |= _untouched(conversion.files_of("starter"))
    existing = {path: _read(path) for path in files if path.is_file()}
    return {
        "new": [path for path in files if not os.path.lexists(path)],
        "changed": [path for path, data in existing.items() if data != files[path]],
        "removed": [
            path
            for path in conversion.files_of("obsolete")
            if path.is_file() and record.is_ours(path)
        ],
    }


def _list_files(conversion: Conversion) -> dict[Path, bytes]:
    """Return the files of a conversion, with those that are written only with the output."""
    ours = conversion.files_of("ours")
    if conversion.settings.output in ours:
        return {**conversion.files_of("orphans"), **ours, **conversion.files_of("base")}
    return ours


def _list_replaced(files: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """Return the edited files that a merge replaces, as it has read them."""
    read = {path: getattr(data, "replaces", None) for path, data in files.items()}
    return {path: data for path, data in read.items() if data is not None}


def write_files(
    files: Mapping[Path, bytes],
    folders: Sequence[Path] = (),
    *,
    once: Mapping[Path, bytes] = MappingProxyType({}),
    obsolete: Collection[Path] = (),
    force: bool = False,
    replaces: Mapping[Path, bytes] = MappingProxyType({}),
) -> None:
    """Write files, in their order.

    An existing file is replaced if it is empty or nobody has changed it.  A link stays, and the
    file that it leads to is replaced.  A device or pipe is written to, last of all.

    Args:
        files: The bytes of each file.
        folders: Folders that are created, too.
        once: The starters, which are the user's: a file is written if it does not exist, or if
            nobody has changed what an earlier run wrote.
        obsolete: Files that are removed if nobody has changed them.
        force: Whether to replace files that people have changed.
        replaces: Edited files that a merge has read: each is replaced if it still has these bytes.
            The new file contains people's edits, too, and is not recorded as ours.

    Raises:
        ConfigError: A file is not ours to replace, or cannot be written, before any file is
            replaced; or a file cannot be renamed.
    """
    for folder in (*folders, *(file.parent for file in (*files, *once))):
        with _naming(folder):
            folder.mkdir(parents=True, exist_ok=True)
    streams: list[Path] = []
    places: dict[Path, bytes] = {}
    for path in files:
        with _naming(path):
            if path.exists() and not (path.is_file() or path.is_dir()):
                streams.append(path)
            else:
                place = _resolve(path)
                _check_place(place)
                places[place] = files[path]
    if not force:
        check_ours(places, {_resolve(path): data for path, data in replaces.items()})
    places |= _untouched(once)
    people = {_resolve(path) for path in replaces}
    with _temporary_files(places) as temporary:
        _add_to_records({place: data for place, data in places.items() if place not in people})
        for place, file in temporary.items():
            with _naming(place):
                os.replace(file, place)  # noqa: PTH105  tests stand in for it
    for path in obsolete:
        with _naming(path):
            if path.is_file() and _resolve(path) not in places and record.is_ours(path):
                path.unlink(missing_ok=True)
    for path in streams:
        with _naming(path):
            path.write_bytes(files[path])


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Raise an error of the system as a ConfigError that names the path."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"cannot write '{path}': {reason}"
        raise ConfigError("output-unwritable", message) from None


@contextmanager
def _temporary_files(places: Mapping[Path, bytes]) -> Iterator[dict[Path, Path]]:
    """Write the data of each place into a temporary file beside it; remove those that are left."""
    temporary = {place: temporary_name(place) for place in places}
    try:
        for place, data in places.items():
            with _naming(place):
                _write_temporary(temporary[place], place, data)
        yield temporary
    finally:
        for file in temporary.values():
            with suppress(OSError, ValueError):
                file.unlink(missing_ok=True)


def _add_to_records(places: Mapping[Path, bytes]) -> None:
    """Record the files of each folder."""
    for folder in dict.fromkeys(place.parent for place in places):
        with _naming(folder / record.RECORD):
            record.add_files(folder, {p: data for p, data in places.items() if p.parent == folder})


def check_ours(
    places: Mapping[Path, bytes], known: Mapping[Path, bytes] = MappingProxyType({})
) -> None:
    """Raise ConfigError if writing would replace a file that people made or changed.

    Args:
        places: The bytes that are to be written to each file.
        known: Bytes of files that may be replaced, as people know of it.
    """
    lost: list[str] = []
    for place, data in places.items():
        existing = _read(place) if place.exists() else b""
        if not existing or existing in (data, known.get(place)) or record.is_ours(place):
            continue
        was_ours = record.was_ours(place)
        reason = "was edited since urdf2mbs wrote it" if was_ours else "is not known to urdf2mbs"
        lost.append(f"'{place}' {reason}")
    if lost:
        message = "; ".join(lost[:3]) + (f"; and {len(lost) - 3} more" if len(lost) > 3 else "")
        hint = (
            "nothing is written: move it away, write elsewhere, or replace it by --force "
            "(in Python: force=True)"
        )
        raise ConfigError("output-not-ours", message, hint=hint)


def _untouched(once: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """Return the starters that do not exist, or are as an earlier run wrote them."""
    return {
        file: data
        for file, data in once.items()
        # a link exists even if it leads nowhere
        if not os.path.lexists(file)
        or (file.is_file() and (_read(file) == data or record.is_ours(file)))
    }


def _resolve(path: Path) -> Path:
    """Return the file that a link leads to; the path itself if it is no link."""
    return Path(os.path.realpath(path))


def _read(file: Path) -> bytes:
    """Return the bytes of a file; raises ConfigError if it cannot be read."""
    try:
        return read_bytes(file)
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{file}': {error.strerror}") from None


def _check_place(place: Path) -> None:
    """Raise OSError for a file that may not be written to, or whose name Windows would change.

    A rename would replace a write-protected file.  Windows takes some names for devices, and drops
    blanks and points at the end of others.
    """
    if WINDOWS and not is_portable(place.name):
        raise OSError(EINVAL, "Windows has no file of this name", str(place))
    if place.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(place))
    if place.exists() and not os.access(place, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES), str(place))


def _write_temporary(temporary: Path, place: Path, data: bytes) -> None:
    """Write a temporary file to disk, with the mode of the file that it replaces."""
    with temporary.open("xb") as file:
        if place.exists():
            temporary.chmod(S_IMODE(place.stat().st_mode))
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
