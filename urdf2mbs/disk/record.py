"""The record: which files of a folder urdf2mbs wrote, each by its checksum.

Nobody has changed a file that is as the record beside it says, so it may be replaced.  All kinds
of files are recorded alike, also the user's own files as they were first.  A comment in the file
itself would not do: many kinds have none, and MBSysPad drops those of an .mbs.

Lines are only added, before the files get their places.  So a run that is killed, and another run
into the same folder, leave a record that is true.  Line ends do not count, because git may convert
them.  A run of many robots sorts the lines at its end.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError

#: The file, in the format of ``sha256sum``.
RECORD = ".urdf2mbs"


def is_ours(path: Path) -> bool:
    """True if nobody has changed a file since urdf2mbs wrote it."""
    place = Path(os.path.realpath(path))
    try:
        return b"\n" + _line(place, files.read_bytes(place)) in _recorded(place)
    except OSError:
        return False


def was_ours(path: Path) -> bool:
    """True if urdf2mbs has written a file of this name."""
    place = Path(os.path.realpath(path))
    return b"  " + os.fsencode(place.name) + b"\n" in _recorded(place)


def add_files(folder: Path, places: Mapping[Path, bytes]) -> None:
    """Record files of a folder that are about to be written.

    Raises:
        ConfigError: The record cannot be read.
        OSError: The record cannot be written.
    """
    known = _recorded(folder / RECORD)
    lines = [_line(place, data) for place, data in places.items()]
    missing = b"".join(line for line in lines if b"\n" + line not in known)
    if missing:
        with (folder / RECORD).open("ab") as record:
            record.write(missing)


def checksum(data: bytes) -> str:
    """The sha256 of a text, its lines ended by a line feed."""
    from hashlib import sha256  # its library takes as long to load as all our passes

    return sha256(data.replace(b"\r\n", b"\n") if b"\r" in data else data).hexdigest()


def _line(place: Path, data: bytes) -> bytes:
    return f"{checksum(data)}  ".encode() + os.fsencode(place.name) + b"\n"


def _recorded(place: Path) -> bytes:
    """Return the record beside a file, after a line feed; raise ConfigError if it is unreadable."""
    record = place.with_name(RECORD)
    try:
        data = record.read_bytes() if files.is_file(record) else b""
    except OSError as error:
        message = f"cannot read '{record}': {error.strerror}"
        raise ConfigError("file-unreadable", message) from None
    return b"\n" + data.replace(b"\r\n", b"\n")
