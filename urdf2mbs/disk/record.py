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
    real_path = Path(os.path.realpath(path))
    try:
        return b"\n" + _format_line(real_path, files.read_bytes(real_path)) in _read_record(
            real_path
        )
    except OSError:
        return False


def was_ours(path: Path) -> bool:
    """Return True if urdf2mbs has ever written a file of this name."""
    real_path = Path(os.path.realpath(path))
    return b"  " + os.fsencode(real_path.name) + b"\n" in _read_record(real_path)


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
    record_lines = [_format_line(file_path, content) for file_path, content in contents.items()]
    new_lines = b"".join(
        record_line for record_line in record_lines if b"\n" + record_line not in recorded
    )
    if new_lines:
        with (folder / RECORD).open("ab") as record:
            record.write(new_lines)


def checksum(data: bytes) -> str:
    r"""Compute the sha256 of the bytes of a file, where line ends are ``\n``."""
    from hashlib import sha256  # its library takes as long to load as all our passes

    return sha256(data.replace(b"\r\n", b"\n") if b"\r" in data else data).hexdigest()


def _format_line(file_path: Path, content: bytes) -> bytes:
    """Return the line of the record for a file."""
    return f"{checksum(content)}  ".encode() + os.fsencode(file_path.name) + b"\n"


def _read_record(file_path: Path) -> bytes:
    """Return the record beside a file, after a line feed; raise ConfigError if it is unreadable."""
    record_file = file_path.with_name(RECORD)
    try:
        record_bytes = record_file.read_bytes() if files.is_file(record_file) else b""
    except OSError as error:
        message = f"cannot read '{record_file}': {error.strerror}"
        raise ConfigError("file-unreadable", message) from None
    return b"\n" + record_bytes.replace(b"\r\n", b"\n")
