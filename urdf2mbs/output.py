"""Writes what a conversion made: never half a file, and never over somebody's work."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from errno import EACCES, EISDIR
from pathlib import Path
from shutil import copy2
from stat import S_IMODE
from tempfile import NamedTemporaryFile, mkstemp

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError

#: In a project folder, what we wrote there, in the form of ``sha256sum``.
RECORD = ".urdf2mbs"


def write(conversion: Conversion) -> None:
    """Write what a conversion made, and for a project the folders that Robotran expects.

    An .mbs in a project that was edited since (in MBSysPad, say) is not ours any more and is
    never overwritten: that is a ConfigError.
    """
    settings = conversion.settings
    files = dict(conversion.files)
    # links count as well, even those that lead nowhere
    files |= {path: data for path, data in conversion.starters.items() if not os.path.lexists(path)}
    if settings.project is not None and settings.output in files:
        record = settings.project / RECORD
        line = _checksum(settings.project, settings.output, files[settings.output])
        if settings.output.exists():
            there = _checksum(settings.project, settings.output, _read(settings.output))
            known = _read(record) if record.exists() else b""
            if there != line and known != there.encode():
                raise ConfigError(
                    "output-not-ours",
                    f"'{settings.output}' was not written by urdf2mbs, or was edited since",
                    hint="move it away, or convert into another project",
                )
        files[record] = line.encode()
    if settings.project is not None:
        for name in ("animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR"):
            folder = settings.project / name
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise ConfigError(
                    "output-unwritable", f"cannot make the folder '{folder}': {error.strerror}"
                ) from None
    write_files(files)


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{file}': {error.strerror}") from None


def _checksum(folder: Path, file: Path, data: bytes) -> str:
    from hashlib import sha256

    return f"{sha256(data).hexdigest()}  {file.relative_to(folder).as_posix()}\n"


def write_files(files: Mapping[Path, bytes]) -> None:
    """Write all of the files or, where one cannot be written, none.

    Each file is written and synced beside its place, with the mode of the one that it replaces;
    then all are renamed into place.  Where a rename fails, those before it are undone.  So there is
    never half a file, and after a crash of the machine each file is the old or the new one.  Only a
    process that is killed between two renames leaves some files new and some old.
    A link stays, and what it leads to is replaced.  A device or pipe is written to, last of all.

    Raises ConfigError where a folder or file cannot be written.
    """
    path = Path()
    parts: dict[Path, Path] = {}
    kept: dict[Path, Path | None] = {}
    streams: list[tuple[Path, bytes]] = []
    try:
        for path, data in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            place = Path(os.path.realpath(path))
            if path.exists() and not path.is_file() and not path.is_dir():
                streams.append((path, data))
            else:
                _check_place(place)
                if place in parts:  # by another name, which is a link
                    parts.pop(place).unlink()
                parts[place] = _part(place, data)
        for path, part in parts.items():
            kept[path] = _backup(path)
            part.replace(path)
        for path, data in streams:
            with path.open("wb") as stream:
                stream.write(data)
        for folder in {place.parent for place in parts}:
            _sync_folder(folder)
    except BaseException as error:
        for place, old in kept.items():
            with suppress(OSError):
                _undo(place, old, parts[place])
        if not isinstance(error, OSError):
            raise
        raise ConfigError(
            "output-unwritable", f"cannot write '{path}': {error.strerror or error}"
        ) from None
    finally:
        for left in (*parts.values(), *kept.values()):
            if left is not None:
                with suppress(OSError):
                    left.unlink(missing_ok=True)


def _check_place(place: Path) -> None:
    """A rename would replace a file that may not be written to."""
    if place.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(place))
    if place.exists() and not os.access(place, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES), str(place))


def _part(place: Path, data: bytes) -> Path:
    """A new file beside a place with the data on disk."""
    descriptor, name = mkstemp(prefix=f".{place.name[:100]}.", suffix=".part", dir=place.parent)
    part = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            part.chmod(_mode(place))
            os.fsync(file.fileno())
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return part


def _mode(place: Path) -> int:
    """Of the file that is there, else what a new file gets."""
    try:
        return S_IMODE(place.stat().st_mode)
    except FileNotFoundError:
        mask = os.umask(0o077)
        os.umask(mask)
        return 0o666 & ~mask


def _backup(place: Path) -> Path | None:
    """A second name for the file that is there, to go back to; None: there is none."""
    if not place.exists():
        return None
    with NamedTemporaryFile(
        prefix=f".{place.name[:100]}.", suffix=".old", dir=place.parent
    ) as free:
        name = Path(free.name)
    try:
        os.link(place, name)
    except OSError:  # a file system without links
        copy2(place, name)
    return name


def _undo(place: Path, old: Path | None, part: Path) -> None:
    if part.exists():
        return  # it has not been renamed
    if old is None:
        place.unlink()
    else:
        old.replace(place)


def _sync_folder(folder: Path) -> None:
    """Put the renames on disk; some file systems, and Windows, have no such thing."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
