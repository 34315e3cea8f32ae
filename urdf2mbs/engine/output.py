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
    file_contents = _list_files(conversion)
    write_files(
        file_contents,
        folders,
        once=conversion.files_of("starter"),
        obsolete=conversion.files_of("obsolete"),
        force=force,
        replaces=_list_replaced(file_contents),
    )


def _list_folders(conversion: Conversion, project: Path) -> list[Path]:
    """Return the folders of a project that plugins fill; raises ConfigError if none does."""
    folder_names = [
        folder_name
        for folder_names in conversion.hook.urdf2mbs_folders()
        for folder_name in folder_names
    ]
    if not folder_names:
        message = "no plugin writes the code of a Robotran project"
        hint = "name an .mbs file as the output, or install urdf2mbs whole"
        raise ConfigError("plugin-missing", message, hint=hint)
    return [project / folder_name for folder_name in folder_names]


def plan(conversion: Conversion, *, force: bool = False) -> dict[str, list[Path]]:
    """Return the files that ``write`` would create, change and remove, but for bases of merges.

    Args:
        conversion: The finished conversion.
        force: As in ``write``.

    Raises:
        ConfigError: As in ``write``.
    """
    file_contents = _list_files(conversion)
    if not force:
        check_ours(file_contents, _list_replaced(file_contents))
    file_contents |= _select_untouched(conversion.files_of("starter"))
    for file_path in conversion.files_of("base"):  # of the next merge, which no user looks for
        file_contents.pop(file_path, None)
    existing_contents = {
        file_path: _read_existing(file_path) for file_path in file_contents if file_path.is_file()
    }
    return {
        "new": [file_path for file_path in file_contents if not os.path.lexists(file_path)],
        "changed": [
            file_path
            for file_path, content in existing_contents.items()
            if content != file_contents[file_path]
        ],
        "removed": [
            file_path
            for file_path in conversion.files_of("obsolete")
            if file_path.is_file() and record.is_ours(file_path)
        ],
    }


def _list_files(conversion: Conversion) -> dict[Path, bytes]:
    """Return the files of a conversion, with those that are written only with the output."""
    ours = conversion.files_of("ours")
    if conversion.settings.output in ours:
        return {**ours, **conversion.files_of("base")}
    return ours


def _list_replaced(files: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """Return the edited files that a merge replaces, as it has read them."""
    merged_contents = {
        file_path: getattr(content, "replaces", None) for file_path, content in files.items()
    }
    return {
        file_path: content for file_path, content in merged_contents.items() if content is not None
    }


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
    for folder in (*folders, *(temporary_file.parent for temporary_file in (*files, *once))):
        with _naming_path(folder):
            folder.mkdir(parents=True, exist_ok=True)
    streams: list[Path] = []
    target_contents: dict[Path, bytes] = {}
    for file_path in files:
        with _naming_path(file_path):
            if file_path.exists() and not (file_path.is_file() or file_path.is_dir()):
                streams.append(file_path)
            else:
                target = _follow_link(file_path)
                _check_target(target)
                target_contents[target] = files[file_path]
    if not force:
        check_ours(
            target_contents,
            {_follow_link(file_path): content for file_path, content in replaces.items()},
        )
    target_contents |= _select_untouched(once)
    edited_targets = {_follow_link(file_path) for file_path in replaces}
    with _temporary_files(target_contents) as temporary_files:
        _add_to_records(
            {
                target: content
                for target, content in target_contents.items()
                if target not in edited_targets
            }
        )
        for target, temporary_file in temporary_files.items():
            with _naming_path(target):
                os.replace(temporary_file, target)  # noqa: PTH105  tests replace it
    for file_path in obsolete:
        with _naming_path(file_path):
            if (
                file_path.is_file()
                and _follow_link(file_path) not in target_contents
                and record.is_ours(file_path)
            ):
                file_path.unlink(missing_ok=True)
    for file_path in streams:
        with _naming_path(file_path):
            file_path.write_bytes(files[file_path])


@contextmanager
def _naming_path(file_path: Path) -> Iterator[None]:
    """Raise an error of the system as a ConfigError that names the path."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"cannot write '{file_path}': {reason}"
        raise ConfigError("output-unwritable", message) from None


@contextmanager
def _temporary_files(target_contents: Mapping[Path, bytes]) -> Iterator[dict[Path, Path]]:
    """Write the data of each place into a temporary file beside it; remove those that are left."""
    temporary_files = {target: temporary_name(target) for target in target_contents}
    try:
        for target, content in target_contents.items():
            with _naming_path(target):
                _write_temporary(temporary_files[target], target, content)
        yield temporary_files
    finally:
        for temporary_file in temporary_files.values():
            with suppress(OSError, ValueError):
                temporary_file.unlink(missing_ok=True)


def _add_to_records(target_contents: Mapping[Path, bytes]) -> None:
    """Record the files of each folder."""
    for folder in dict.fromkeys(target.parent for target in target_contents):
        with _naming_path(folder / record.RECORD):
            record.add_files(
                folder,
                {
                    target_path: content
                    for target_path, content in target_contents.items()
                    if target_path.parent == folder
                },
            )


def check_ours(
    target_contents: Mapping[Path, bytes], replaceable: Mapping[Path, bytes] = MappingProxyType({})
) -> None:
    """Raise ConfigError if writing would replace a file that people made or changed.

    Args:
        target_contents: The bytes that are to be written to each file.
        replaceable: Bytes of files that may be replaced, as people know of it.
    """
    faults: list[str] = []
    for target, content in target_contents.items():
        existing_content = _read_existing(target) if target.exists() else b""
        if (
            not existing_content
            or existing_content in (content, replaceable.get(target))
            or record.is_ours(target)
        ):
            continue
        was_ours = record.was_ours(target)
        reason = "was edited since urdf2mbs wrote it" if was_ours else "is not known to urdf2mbs"
        faults.append(f"'{target}' {reason}")
    if faults:
        message = "; ".join(faults[:3]) + (
            f"; and {len(faults) - 3} more" if len(faults) > 3 else ""
        )
        hint = (
            "nothing is written: move it away, write elsewhere, or replace it by --force "
            "(in Python: force=True)"
        )
        raise ConfigError("output-not-ours", message, hint=hint)


def _select_untouched(starters: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """Return the starters that do not exist, or are as an earlier run wrote them."""
    return {
        starter: content
        for starter, content in starters.items()
        # a link exists even if it leads nowhere
        if not os.path.lexists(starter)
        or (starter.is_file() and (_read_existing(starter) == content or record.is_ours(starter)))
    }


def _follow_link(file_path: Path) -> Path:
    """Return the file that a link leads to; the path itself if it is no link."""
    return Path(os.path.realpath(file_path))


def _read_existing(file_path: Path) -> bytes:
    """Return the bytes of a file; raises ConfigError if it cannot be read."""
    try:
        return read_bytes(file_path)
    except OSError as error:
        raise ConfigError(
            "file-unreadable", f"cannot read '{file_path}': {error.strerror}"
        ) from None


def _check_target(target: Path) -> None:
    """Raise OSError for a file that may not be written to, or whose name Windows would change.

    A rename would replace a write-protected file.  Windows takes some names for devices, and drops
    blanks and points at the end of others.
    """
    if WINDOWS and not is_portable(target.name):
        raise OSError(EINVAL, "Windows has no file of this name", str(target))
    if target.is_dir():
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(target))
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(EACCES, os.strerror(EACCES), str(target))


def _write_temporary(temporary_path: Path, target: Path, content: bytes) -> None:
    """Write a temporary file to disk, with the mode of the file that it replaces."""
    with temporary_path.open("xb") as stream:
        if target.exists():
            temporary_path.chmod(S_IMODE(target.stat().st_mode))
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())
