"""Writes what a conversion made: never half a file, and never over somebody's work.

Each file is written and synced beside its place, with the mode of the one that it replaces; then
all are renamed into place.  Where a rename fails, those before it are undone, and so are the
folders.  So there is never half a file, and after a crash of the machine each file is the old or
the new one.  Only a process that is killed between two renames leaves some files new and some old;
what it leaves beside them goes at the next run.  Two runs into one folder wait for each other,
except on Windows.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from errno import EACCES, EINVAL, EISDIR
from pathlib import Path
from stat import S_IMODE
from types import MappingProxyType

from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.files import is_portable, read
from urdf2mbs.disk.seal import RECORD, can_hold, checksum, has_seal, intact, seal
from urdf2mbs.messages.diagnostics import ConfigError

#: What Robotran expects in a project's folder.
FOLDERS = ("animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR")
WINDOWS = os.name == "nt"


def write(conversion: Conversion, *, force: bool = False) -> None:
    """Write what a conversion made, and for a project the folders that Robotran expects.

    What fits the robot no more is removed, of the files that nobody has changed.  ``force``
    replaces files, too, that were edited or that are somebody else's.
    """
    _complete(conversion)
    project = conversion.settings.project
    folders = [] if project is None else [project / name for name in FOLDERS]
    write_files(
        conversion.files, folders,
        once=conversion.starters, obsolete=conversion.obsolete, force=force,
        replaces=conversion.replaces,
    )  # fmt: skip


def plan(conversion: Conversion, *, force: bool = False) -> dict[str, list[Path]]:
    """The files that ``write`` would write anew, change and remove; raises ConfigError as it."""
    _complete(conversion)
    files = conversion.files
    if not force:
        check_ours(files, conversion.replaces)
    files = files | _untouched(conversion.starters)
    there = {path: _read(path) for path in files if path.is_file()}
    return {
        "new": [path for path in files if not os.path.lexists(path)],
        "changed": [path for path, data in there.items() if data != files[path]],
        "removed": [p for p in conversion.obsolete if p.is_file() and _is_ours(p, _read(p))],
    }


def _complete(conversion: Conversion) -> None:
    """Give the files of a conversion their seals, and those that go with the output."""
    if conversion.settings.output in conversion.files:
        conversion.files = {**conversion.ahead, **conversion.files, **conversion.behind}
    conversion.files = _sealed(conversion.files, conversion.replaces)


def _sealed(files: Mapping[Path, bytes], replaces: Collection[Path]) -> dict[Path, bytes]:
    """Files with their seals; those that hold the work of people, too, get none."""
    return {path: data if path in replaces else seal(path, data) for path, data in files.items()}


def write_files(
    files: Mapping[Path, bytes],
    folders: Sequence[Path] = (),
    *,
    once: Mapping[Path, bytes] | None = None,
    obsolete: Collection[Path] = (),
    force: bool = False,
    replaces: Mapping[Path, bytes] | None = None,
) -> None:
    """Write all of the files or, where one cannot be written, none; ``folders`` are made, too.

    ``files`` are sealed, and get their places in their order.  A file that is there is replaced if
    its seal is intact or it is empty; with ``force`` in any case.  One of ``replaces`` is replaced
    if it is still what that says, by the new file as it is, without a seal.  The files of ``once``
    are the user's: they are written as they are, where nothing is and where nobody has touched
    what an earlier run wrote.  ``obsolete`` files are removed if nobody has changed them.
    A link stays, and what it leads to is replaced.  A device or pipe is written to, last of all.

    Raises ConfigError where a file is not ours to replace, and where a folder or file cannot be
    written.
    """
    once, replaces = once or {}, replaces or {}
    path = Path()
    parts: dict[Path, Path] = {}
    kept: dict[Path, Path | None] = {}
    made: list[Path] = []
    with ExitStack() as locks:
        try:
            for path in (*folders, *(file.parent for file in (*files, *once))):
                _make_folder(path, made)
            sealed_files = _sealed(files, replaces)
            streams = [path for path in files if path.exists() and _is_stream(path)]
            places = {
                Path(os.path.realpath(path)): data
                for path, data in sealed_files.items()
                if path not in streams
            }
            gone = [Path(os.path.realpath(path)) for path in obsolete if path.is_file()]
            _lock_all((*places, *gone, *once), locks)
            for path in places:
                _check_place(path)
            if not force:
                check_ours(places, {Path(os.path.realpath(p)): replaces[p] for p in replaces})
            starters = _untouched(once)
            places = {**_records(places, starters), **places, **starters}
            for path, data in places.items():
                parts[path] = _part(path, data)
            for path, part in parts.items():
                kept[path] = _backup(path)
                part.replace(path)
            for path in gone:
                if path not in places and _is_ours(path, read(path)):
                    kept[path] = _backup(path)
                    path.unlink()
            for path in streams:
                with path.open("wb") as stream:
                    stream.write(sealed_files[path])
            for folder in {place.parent for place in kept}:
                _sync_folder(folder)
        except BaseException as error:
            _undo_all(kept, parts, made)
            if not isinstance(error, (OSError, ValueError)):
                raise
            raise ConfigError(
                "output-unwritable",
                f"cannot write '{path}': {getattr(error, 'strerror', None) or error}",
            ) from None
        finally:
            _take_away([*parts.values(), *kept.values()])


def _is_stream(path: Path) -> bool:
    return not path.is_file() and not path.is_dir()


def _lock_all(files: Collection[Path], locks: ExitStack) -> None:
    """Wait until no other run writes into the folders of these files; take its litter away."""
    for folder in sorted({file.parent for file in files}):
        if _lock(folder, locks):
            names = [file.name for file in files if file.parent == folder]
            _sweep(folder, [*names, RECORD])


def check_ours(
    places: Mapping[Path, bytes], known: Mapping[Path, bytes] = MappingProxyType({})
) -> None:
    """Raise ConfigError if a file is there that somebody has made or edited, and would be lost;
    not if it is still what is ``known`` of it."""
    lost: list[str] = []
    for place, data in places.items():
        if not place.exists():
            continue
        there = _read(place)
        if not there or there in (data, known.get(place)) or _is_ours(place, there):
            continue
        edited = has_seal(there) or f"  {place.name}\n" in "".join(_recorded(place))
        why = (
            "was edited since urdf2mbs wrote it"
            if edited
            else "has no seal of urdf2mbs: another program wrote or saved it"
        )
        lost.append(f"'{place}' {why}")
    if lost:
        raise ConfigError(
            "output-not-ours",
            "; ".join(lost[:3]) + (f"; and {len(lost) - 3} more" if len(lost) > 3 else ""),
            hint="nothing is written: move it away, write elsewhere, or replace it by --force "
            "(in Python: force=True)",
        )


def _is_ours(place: Path, there: bytes) -> bool:
    """True if nobody has changed a file since we wrote it."""
    return intact(there) or _line(place, there) in _recorded(place)


def _records(places: Mapping[Path, bytes], starters: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """For each folder, the checksums of its files that hold no seal.

    The record is put in place before its files: whenever a process is killed, each file is one
    of those that are recorded.
    """
    records: dict[Path, set[str]] = {}
    without = {place: data for place, data in places.items() if not can_hold(place, data)}
    for place, data in {**without, **starters}.items():
        record = place.with_name(RECORD)
        there = _line(place, _read(place)) if place.exists() else ""
        lines = records.setdefault(record, {*_recorded(place)})
        own = {line for line in lines if line.endswith(f"  {place.name}\n")}
        lines -= own - {there}
        lines.add(_line(place, data))
    return {file: "".join(sorted(lines)).encode() for file, lines in records.items()}


def _untouched(once: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """The files of the user that are not there, or still are as an earlier run wrote them."""
    return {
        file: data
        for file, data in once.items()
        # a link counts as well, even where it leads nowhere
        if not os.path.lexists(file)
        or (file.is_file() and (_line(file, _read(file)) in (_line(file, data), *_recorded(file))))
    }


def _recorded(place: Path) -> list[str]:
    """The record beside a file, line by line."""
    record = place.with_name(RECORD)
    text = _read(record).decode("utf-8", "replace") if record.is_file() else ""
    return text.splitlines(keepends=True)


def _line(place: Path, data: bytes) -> str:
    """What a record says of a file."""
    return f"{checksum(data)}  {place.name}\n"


def _read(file: Path) -> bytes:
    try:
        return read(file)
    except OSError as error:
        raise ConfigError("file-unreadable", f"cannot read '{file}': {error.strerror}") from None


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
    for above in reversed(missing):
        try:
            above.mkdir()
        except FileExistsError:
            if not above.is_dir():  # another run may have made it just now
                raise
        else:
            made.append(above)


def _lock(folder: Path, locks: ExitStack) -> bool:
    """Wait until no other run writes into a folder; False where folders cannot be locked, as on
    Windows.

    The system lets go of the lock when the process ends, however it ends.  The package ``filelock``
    takes 75 ms to import, and leaves a file in each folder.
    """
    try:
        from fcntl import LOCK_EX, flock

        descriptor = os.open(folder, os.O_RDONLY)
        locks.callback(os.close, descriptor)
        flock(descriptor, LOCK_EX)
    except (OSError, ImportError):
        return False
    return True


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
    """The mode of the file that is there, else the mode of a new file."""
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


def _undo_all(
    kept: Mapping[Path, Path | None], parts: Mapping[Path, Path], made: Sequence[Path]
) -> None:
    """Bring back what was there before, files and folders."""
    for place, old in kept.items():
        part = parts.get(place)
        with suppress(OSError):
            if part is not None and part.exists():
                continue  # it has not been renamed
            if old is None:
                place.unlink()
            else:
                old.replace(place)
    _take_away(parts.values())
    for folder in reversed(made):
        with suppress(OSError):
            folder.rmdir()  # which does nothing where somebody has put something


def _sync_folder(folder: Path) -> None:
    """Put the renames on disk; some file systems, and Windows, have no such thing."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
