"""Writes what a conversion made: never half a file, and never over somebody's work."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

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
            there = _checksum(settings.project, settings.output, settings.output.read_bytes())
            if there != line and not (record.exists() and record.read_text("utf-8") == there):
                raise ConfigError(
                    "output-not-ours",
                    f"'{settings.output}' was not written by urdf2mbs, or was edited since",
                    hint="move it away, or convert into another project",
                )
        files[record] = line.encode()
    write_files(files)
    if settings.project is not None:
        for name in ("animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR"):
            (settings.project / name).mkdir(parents=True, exist_ok=True)


def _checksum(folder: Path, file: Path, data: bytes) -> str:
    from hashlib import sha256

    return f"{sha256(data).hexdigest()}  {file.relative_to(folder).as_posix()}\n"


def write_files(files: Mapping[Path, bytes]) -> None:
    """Write each file beside its place, then rename all: there is never half a file.

    Raises ConfigError where a folder or file cannot be written.
    """
    parts: list[tuple[Path, Path]] = []
    path = Path()
    try:
        for path, data in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f".{path.name}.{os.getpid()}.part")
            parts.append((part, path))
            part.write_bytes(data)
        for part, path in parts:
            part.replace(path)
    except OSError as error:
        raise ConfigError(
            "output-unwritable", f"cannot write '{path}': {error.strerror or error}"
        ) from None
    finally:
        for part, _ in parts:
            part.unlink(missing_ok=True)
