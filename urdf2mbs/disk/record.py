"""The record: which files of a folder urdf2mbs wrote, each by its checksum.

A file whose checksum is in the record beside it was not changed since, so it may be replaced.  All
kinds of files are recorded alike, also the first version of the user's own files.  A comment in
the file itself would not do: many formats have none, and MBSysPad drops those of an .mbs.

Lines are only added, before the files are moved into place.  So a run that is killed, and another
run into the same folder, leave a record that is true.  Line ends are ignored, because git may
convert them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError

#: Name of the record, which has the format of ``sha256sum``.
RECORD = ".urdf2mbs"


def is_ours(path: Path) -> bool:
    """Return True if a file is as urdf2mbs wrote it."""
    file = Path(os.path.realpath(path))
    try:
        return b"\n" + _format_line(file, files.read_bytes(file)) in _read_record(file)
    except OSError:
        return False


def was_ours(path: Path) -> bool:
    """Return True if urdf2mbs has ever written a file of this name."""
    file = Path(os.path.realpath(path))
    return b"  " + os.fsencode(file.name) + b"\n" in _read_record(file)


def add_files(folder: Path, contents: Mapping[Path, bytes]) -> None:
    """Record files of a folder that are about to be written.

    Args:
        folder: The folder.
        contents: The bytes of each file.

    Raises:
        ConfigError: The record cannot be read.
        OSError: The record cannot be written.
    """
    recorded = _read_record(folder / RECORD)
    lines = [_format_line(file, data) for file, data in contents.items()]
    new_lines = b"".join(line for line in lines if b"\n" + line not in recorded)
    if new_lines:
        with (folder / RECORD).open("ab") as record:
            record.write(new_lines)


def checksum(data: bytes) -> str:
    r"""Compute the sha256 of the bytes of a file, where line ends are ``\n``."""
    from hashlib import sha256  # its library takes as long to load as all our passes

    return sha256(data.replace(b"\r\n", b"\n") if b"\r" in data else data).hexdigest()


def _format_line(file: Path, data: bytes) -> bytes:
    """Return the line of the record for a file."""
    return f"{checksum(data)}  ".encode() + os.fsencode(file.name) + b"\n"


def _read_record(file: Path) -> bytes:
    """Return the record beside a file, after a line feed; raise ConfigError if it is unreadable."""
    record = file.with_name(RECORD)
    try:
        data = record.read_bytes() if files.is_file(record) else b""
    except OSError as error:
        message = f"cannot read '{record}': {error.strerror}"
        raise ConfigError("file-unreadable", message) from None
    return b"\n" + data.replace(b"\r\n", b"\n")
