"""What xacro made before, kept in the user's cache folder.

An expansion depends on the files that were read, the arguments, the packages that were found, the
environment variables that were asked for, and the program.  All of them are compared; nothing is
taken for unchanged because of its date.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from tempfile import mkstemp

import msgspec

from urdf2mbs import files
from urdf2mbs.diagnostics import ConversionError, Diagnostic
from urdf2mbs.urdf import packages as finding
from urdf2mbs.urdf import xacro, xml
from urdf2mbs.urdf.packages import Packages, absolute
from urdf2mbs.urdf.xacro import Expansion

#: So many expansions lie in one of the 256 folders of the cache at most.
MOST = 16


class Kept(msgspec.Struct):
    """An expansion, and what it was made from."""

    text: bytes
    read: list[str]
    warnings: list[Diagnostic]
    files: dict[str, str | None]
    """The sha256 of every file that was read or looked for; None: it was not there."""
    packages: dict[str, str]
    environment: dict[str, str | None]


def cache_folder() -> Path:
    """The user's, by the custom of the system."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.path.expanduser(base)) / "urdf2mbs" / "xacro"  # noqa: PTH111 which raises nothing


def expand(
    source: Path,
    packages: Packages,
    args: Mapping[str, str],
    make: Callable[[Path, Packages, Mapping[str, str]], Expansion] = xacro.expand,
) -> Expansion:
    """``xacro.expand``, or what it gave before where nothing has changed since."""
    file = _place(source, packages, args)
    kept = _read(file)
    if kept is not None and _holds(kept, packages):
        return Expansion(kept.text, kept.read, kept.warnings)
    expansion = make(source, packages, args)
    asked = expansion.asked
    if asked is not None:
        kept = Kept(
            expansion.text, expansion.files, expansion.warnings,
            {name: _digest(name) for name in asked.files}, asked.packages, asked.environment,
        )  # fmt: skip
        _write(file, kept)
    return expansion


def _place(source: Path, packages: Packages, args: Mapping[str, str]) -> Path:
    """Where an expansion is kept: by what is known before xacro runs."""
    table = {name: absolute(folder) for name, folder in packages.table.items()}
    theirs = find_spec("xacro")
    program = [__file__, xacro.__file__, xml.__file__, finding.__file__]
    program += [theirs.origin] if theirs and theirs.origin else []
    known = [
        absolute(source),
        str(Path.cwd()),
        dict(args),
        table,
        [_version(one) for one in program],
    ]
    name = sha256(msgspec.json.encode(known, order="sorted")).hexdigest()
    return cache_folder() / name[:2] / f"{name[2:]}.json"


def _version(module: str) -> tuple[str, int, int]:
    try:
        stat = Path(module).stat()
    except OSError:
        return module, 0, 0
    return module, stat.st_size, stat.st_mtime_ns


def _read(file: Path) -> Kept | None:
    try:
        return msgspec.json.decode(file.read_bytes(), type=Kept)
    except (OSError, msgspec.MsgspecError):
        return None


def _holds(kept: Kept, packages: Packages) -> bool:
    """Whether all that an expansion was made from is still so."""
    if any(os.environ.get(name) != value for name, value in kept.environment.items()):
        return False
    try:
        if any(str(packages.find(name)) != folder for name, folder in kept.packages.items()):
            return False
    except ConversionError:
        return False
    return all(_digest(name) == digest for name, digest in kept.files.items())


def _digest(file: str) -> str | None:
    try:
        return sha256(files.read(Path(file))).hexdigest()
    except OSError:
        return None


def _write(file: Path, kept: Kept) -> None:
    """A cache that cannot be written to is no error."""
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        others = sorted(file.parent.iterdir(), key=lambda one: one.stat().st_mtime_ns)
        for old in others[: max(0, len(others) - MOST + 1)]:
            old.unlink(missing_ok=True)
        descriptor, name = mkstemp(dir=file.parent)
        with os.fdopen(descriptor, "wb") as part:
            part.write(msgspec.json.encode(kept))
        Path(name).replace(file)
