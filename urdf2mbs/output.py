"""Writes what a conversion made: never half a file, and never over somebody's work."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from errno import EACCES, EDEADLK, EINVAL, EISDIR
from functools import partial
from pathlib import Path
from stat import S_IMODE
from typing import Any

from urdf2mbs.conversion import Conversion, Settings
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.files import is_portable, read
from urdf2mbs.stopping import Unfinished

#: What Robotran expects in a project's folder.
FOLDERS = ("animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR")
WINDOWS = os.name == "nt"
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
    if settings.project is None:
        write_files(files)
        return
    folders = [settings.project / name for name in FOLDERS]
    record = partial(_record, settings, files) if settings.output in files else None
    first = {} if record is None else {settings.project / RECORD: record}
    write_files({**first, **files}, folders)


def _record(settings: Settings, files: Mapping[Path, bytes]) -> bytes:
    """The checksum of the .mbs to come, and of the one that is there.

    The record is put in place before the .mbs: whenever a process is killed, the .mbs is one of
    the two.
    """
    assert settings.project is not None
    record = settings.project / RECORD
    lines = [_checksum(settings.project, settings.output, files[settings.output])]
    if settings.output.exists():
        there = _checksum(settings.project, settings.output, _read(settings.output))
        known = _read(record) if record.exists() else b""
        if there != lines[0]:
            if there.encode() not in known.splitlines(keepends=True):
                raise ConfigError(
                    "output-not-ours",
                    f"'{settings.output}' was not written by urdf2mbs, or was edited since",
                    hint="move it away, or convert into another project",
                )
            lines.append(there)
    return "".join(lines).encode()


def _read(file: Path) -> bytes:
    try:
        return read(file)
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{file}': {error.strerror}") from None


def _checksum(folder: Path, file: Path, data: bytes) -> str:
    from hashlib import sha256

    return f"{sha256(data).hexdigest()}  {file.relative_to(folder).as_posix()}\n"


def write_files(
    files: Mapping[Path, bytes | Callable[[], bytes]], folders: Sequence[Path] = ()
) -> None:
    """Write all of the files or, where one cannot be written, none; ``folders`` are made, too.

    What depends on the files that are there is given by a function, which is called when no other
    run can write.
    Each file is written and synced beside its place, with the mode of the one that it replaces;
    then all are renamed into place.  Where a rename fails, those before it are undone, and so are
    the folders.  So there is never half a file, and after a crash of the machine each file is the
    old or the new one.  Only a process that is killed between two renames leaves some files new
    and some old; what it leaves beside them goes at the next run.  Two runs into one folder wait
    for each other.
    A link stays, and what it leads to is replaced.  A device or pipe is written to, last of all.

    Raises ConfigError where a folder or file cannot be written.
    """
    path = Path()
    parts: dict[Path, Path] = {}
    kept: dict[Path, Path | None] = {}
    made: list[Path] = []
    streams: list[tuple[Path, bytes]] = []
    with Unfinished(), ExitStack() as locks:
        try:
            for path in (*folders, *(file.parent for file in files)):
                _make_folder(path, made)
            places: dict[Path, Path] = {}
            for path, data in files.items():
                if path.exists() and not path.is_file() and not path.is_dir():
                    streams.append((path, data if isinstance(data, bytes) else data()))
                else:
                    places[path] = Path(os.path.realpath(path))
            for path in sorted({place.parent for place in places.values()}):
                if _lock(path, locks):
                    _sweep(path, [p.name for p in places.values() if p.parent == path])
            for path, place in places.items():
                _check_place(place)
                if place in parts:  # by another name, which is a link
                    parts.pop(place).unlink()
                data = files[path]
                parts[place] = _part(place, data if isinstance(data, bytes) else data())
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
            _take_away(parts.values())
            for folder in reversed(made):
                with suppress(OSError):
                    folder.rmdir()  # which does nothing where somebody has put something
            if not isinstance(error, (OSError, ValueError)):
                raise
            raise ConfigError(
                "output-unwritable",
                f"cannot write '{path}': {getattr(error, 'strerror', None) or error}",
            ) from None
        finally:
            _take_away([*parts.values(), *kept.values()])


def _take_away(files: Iterable[Path | None]) -> None:
    for file in files:
        if file is not None:
            with suppress(OSError):
                file.unlink(missing_ok=True)


def _make_folder(folder: Path, made: list[Path]) -> None:
    """Make a folder and those above it; ``made`` gets all that were not there."""
    missing = []
    while not folder.is_dir():
        missing.append(folder)
        folder = folder.parent
        if folder == missing[-1]:
            break
    for one in reversed(missing):
        try:
            one.mkdir()
        except FileExistsError:
            if not one.is_dir():  # another run may have made it just now
                raise
        else:
            made.append(one)


def _lock(folder: Path, locks: ExitStack) -> bool:
    """Wait until no other run writes into a folder; False where folders cannot be locked.

    The system lets go of the lock when the process ends, however it ends.  The package ``filelock``
    would double the time of a conversion (75 ms of imports), and leave a file in each folder.
    """
    try:
        if WINDOWS:
            _lock_on_windows(folder, locks)
        else:
            from fcntl import LOCK_EX, flock

            descriptor = os.open(folder, os.O_RDONLY)
            locks.callback(os.close, descriptor)
            flock(descriptor, LOCK_EX)
    except (OSError, ImportError):
        return False
    return True


def _lock_on_windows(folder: Path, locks: ExitStack) -> None:
    """Windows locks bytes of files, and no folders: an empty file of the user stands for one."""
    import msvcrt
    from hashlib import sha256
    from tempfile import gettempdir

    windows: Any = msvcrt  # a type checker on another system does not know its names
    known = sha256(os.path.normcase(os.path.realpath(folder)).encode("utf-8", "surrogatepass"))
    place = Path(gettempdir(), f"urdf2mbs-{known.hexdigest()[:16]}.lock")
    descriptor = os.open(place, os.O_RDWR | os.O_CREAT)
    locks.callback(os.close, descriptor)
    while True:
        try:
            windows.locking(descriptor, windows.LK_LOCK, 1)
        except OSError as error:
            if error.errno != EDEADLK:  # it has waited for ten seconds
                raise
        else:
            return


def _sweep(folder: Path, names: Sequence[str]) -> None:
    """Take away what a run that was killed has left beside files of these names."""
    found = [
        name
        for name in os.listdir(folder)  # noqa: PTH208
        if name.startswith(".") and name.endswith((".part", ".old"))
    ]
    if found:
        known = "|".join(re.escape(name[:100]) for name in names)
        ours = re.compile(rf"\.({known})\.[a-z0-9_]{{8}}\.(part|old)")
        _take_away([folder / name for name in found if ours.fullmatch(name)])


def _check_place(place: Path) -> None:
    """A rename would replace a file that may not be written to; and Windows takes some names for
    devices, and drops blanks and points at the end of others."""
    if WINDOWS and not is_portable(place.name):
        raise OSError(EINVAL, "Windows has no file of this name", str(place))
    if place.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(place))
    if place.exists() and not os.access(place, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES), str(place))


def _part(place: Path, data: bytes) -> Path:
    """A new file beside a place with the data on disk."""
    part = _beside(place, "part")
    try:
        with open(part, "xb", opener=_private) as file:
            file.write(data)
            file.flush()
            part.chmod(_mode(place))
            os.fsync(file.fileno())
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return part


def _private(file: str, flags: int) -> int:
    """Open a file that nobody else may read yet."""
    return os.open(file, flags, 0o600)


def _beside(place: Path, ending: str) -> Path:
    """A name beside a file that no other file has, nor gets from another run."""
    return place.with_name(f".{place.name[:100]}.{os.urandom(4).hex()}.{ending}")


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
    name = _beside(place, "old")
    try:
        os.link(place, name)
    except OSError:  # a file system without links
        from shutil import copy2

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
