"""The robots in a folder."""

from __future__ import annotations

import os
import re
import unicodedata
from collections import Counter
from pathlib import Path
from typing import NoReturn

from urdf2mbs.plugin import ConfigError, is_file, stem
from urdf2mbs.plugin import read_bytes as read

#: The root of a robot.  That of a file with nothing but macros has no name.
_ROBOT = re.compile(rb"<robot\s[^<>]*?\bname\s*=")


def robots_in(folder: Path) -> dict[Path, Path]:
    """Each robot in a folder and those below it, and the .mbs to make of it, relative to another.

    Robots are the ``.urdf`` files, and the ``.xacro`` files whose ``<robot>`` has a name: those
    without one hold macros for others.  Raises ConfigError where there is none, or a folder cannot
    be looked into.
    """
    found = sorted(
        file
        for above, _, names in os.walk(folder, onerror=_closed)
        for file in (Path(above, name) for name in names)
        if is_file(file) and (file.suffix.lower() == ".urdf" or _is_xacro_robot(file))
    )
    if not found:
        raise ConfigError(
            "folder-empty", f"there is no robot in '{folder}'",
            hint="a robot is a .urdf file, or a .xacro file whose <robot> has a name",
        )  # fmt: skip
    places = {file: file.relative_to(folder).with_name(f"{stem(file)}.mbs") for file in found}
    times = Counter(one_name(str(place)) for place in places.values())
    for file, place in places.items():
        if times[one_name(str(place))] > 1:  # robot.urdf and robot.urdf.xacro
            places[file] = place.with_name(f"{file.name.replace('.', '_')}.mbs")
    return places


def one_name(path: str) -> str:
    """The same for all names that are one file on Windows or macOS."""
    return unicodedata.normalize("NFC", os.path.normpath(path)).casefold()


def _closed(error: OSError) -> NoReturn:
    """Its robots would be missing without a word."""
    raise ConfigError(
        "file-unreadable", f"cannot look into the folder '{error.filename}': {error.strerror}",
        hint="look at its rights, or move it elsewhere",
    ) from None  # fmt: skip


def _is_xacro_robot(file: Path) -> bool:
    if file.suffix.lower() != ".xacro":
        return False
    try:
        return _ROBOT.search(read(file)) is not None
    except OSError:
        return True  # the conversion then reports why
