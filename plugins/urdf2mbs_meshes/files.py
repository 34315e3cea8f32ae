"""Where the files of meshes and textures are, by the names that a URDF has for them."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Sequence
from contextlib import suppress
from filecmp import cmp
from functools import cached_property
from pathlib import Path
from urllib.parse import unquote

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    ConversionError,
    Packages,
    packages,
    some,
    stem,
    walk,
)

_PACKAGE = r"(?is)(package|model):/*([^/]*)/?(.*)"
_FILE = r"(?i)^file:(//localhost(?=/))?"
_DRIVE = r"^[A-Za-z]:[\\/]"


#: Of the path of a mesh, no more parts than these are looked for above the robot.
MOST_PARTS = 16


class MeshFiles:
    """Finds files in packages, in the URDF's folder, and elsewhere in the workspace."""

    def __init__(self, packages: Packages) -> None:
        self.packages = packages
        self.moved: dict[str, list[Path]] = {}
        """The files that fit each name without a file at its place."""
        self.borrowed: set[str] = set()
        """Names whose files are those of another robot."""
        self._robots: set[Path] = set()
        """The folders of the workspace that hold robots."""

    def find(self, filename: str) -> Path | None:
        """Return the file of a mesh or texture by its name; None if there is no such file.

        A file that is not at its place is taken where its name is spelt otherwise, or from
        elsewhere in the workspace, if one fits.
        """
        path: Path | None = None
        try:
            path = self._path(filename)
            if path is None or path.is_file():
                return path
        except (ConversionError, OSError, ValueError):
            pass
        if filename not in self.moved:
            found = self._find_respelt(filename) or self._find_above(filename)
            self.moved[filename] = [found] if found else self._find_moved(filename)
        fitting = self.moved[filename]
        return fitting[0] if len(fitting) == 1 else None

    def _find_respelt(self, filename: str) -> Path | None:
        """Return the file at its place whose name has ``%20`` or ``\\``, or is in another case."""
        for spelling in dict.fromkeys(
            (filename.replace("\\", "/"), unquote(filename).replace("\\", "/"))
        ):
            try:
                path = self._path(spelling)
                found = None if path is None else _ignore_case(path)
            except (ConversionError, OSError, ValueError):
                continue
            if found is not None:
                return found
        return None

    def _find_above(self, filename: str) -> Path | None:
        """Return the file in a folder above the robot by the longest end of its name.

        A robot that was copied out of its package has the folders of the package above it, but
        not its name.  The end is a folder and the file at least.
        """
        tail = _list_parts(filename)[-MOST_PARTS:]
        for length in range(len(tail), 1, -1):
            for folder, names in self._folders_above.items():
                if tail[-length] in names:
                    path = folder.joinpath(*tail[-length:])
                    with suppress(OSError, ValueError):
                        if path.is_file():
                            return path
        return None

    @cached_property
    def _folders_above(self) -> dict[Path, frozenset[str]]:
        """The folders above the robot, and the names of what is in each."""
        folders: dict[Path, frozenset[str]] = {}
        for folder in packages.folders_above(self.packages.source):
            with suppress(OSError):
                folders[folder] = frozenset(entry.name for entry in folder.iterdir())
        return folders

    def _find_moved(self, filename: str) -> list[Path]:
        """Return the files of the workspace that may be meant; several, if they fit equally well.

        The path of a file must end as the name does, by a folder and the file at least: other
        machines have other folders before.  A file that has the name's package, too, comes first;
        then the robot's own before those of other robots, longer ends, files near the source, and
        files in a folder that is called as the source.
        """
        _, name, _ = _split(filename)
        tail = _list_parts(filename)
        whole = [name, *tail] if name else tail
        fitting: dict[tuple[bool, bool, int, int, bool], list[Path]] = {}
        for path in self._files.get(tail[-1], []) if tail else []:
            end = _equal_end(path.parts, whole)
            if end >= min(2, len(tail)):
                up, of_other = self._place(path)
                called = stem(self.packages.source) in path.parts
                key = (end < len(whole), of_other, -end, up, not called)
                fitting.setdefault(key, []).append(path)
        best = min(fitting, default=None)
        if best is None:
            return []
        first, *others = fitting[best]
        above = self.packages.source.parents[best[3]]
        if best[1] and -best[2] <= min(len(tail), len(first.relative_to(above).parts) - 1):
            self.borrowed.add(filename)  # the name says neither the package nor the robot
        return [first, *(other for other in others if not cmp(first, other, shallow=False))]

    def _place(self, path: Path) -> tuple[int, bool]:
        """How many folders above the source the first one is that holds the file, and whether the
        way from there to the file leads into the folder of another robot."""
        above = self.packages.source.parents
        up = next(n for n, folder in enumerate(above) if path.is_relative_to(folder))
        inner = path.relative_to(above[up]).parts
        return up, len(inner) > 1 and above[up] / inner[0] in self._robots

    @cached_property
    def _files(self) -> dict[str, list[Path]]:
        """The files of the workspace by name, and its robots; none if it has too many folders."""
        found: dict[str, list[Path]] = {}
        for number, (folder, _, names) in enumerate(
            walk(self.packages.root, self.packages.source.parents)
        ):
            if number == packages.MAX_FOLDERS:
                return {}
            for name in names:
                found.setdefault(name, []).append(folder / name)
            if any(name.lower().endswith((".urdf", ".xacro")) for name in names):
                self._robots.update((folder, *folder.parents))
        return found

    def suggest_remedy(self, filename: str) -> str:
        """What to do about a file that ``find`` does not find, for a message."""
        scheme, name, _ = _split(filename)
        several = self.moved.get(filename, [])
        fit = f"several files fit: {some(map(str, several), 3)}; " if len(several) > 1 else ""
        try:
            path = self._path(filename)
        except ConfigError as error:
            return error.message
        except ConversionError:
            return (
                f"{fit}'packages: {{{name}: DIR}}' or '--package {name}=DIR' says where the "
                f"package '{name}' is"
            )
        if path is None:
            return f"give a file or a package: '{scheme}://' names are not known"
        if name in self.packages.table and not fit:
            folder = self.packages.table[name]
            return f"by --package {name}={folder} it would be {path}, which does not exist"
        return f"{fit}put the {'right one' if fit else 'file'} into {path.parent}"

    def _path(self, filename: str) -> Path | None:
        scheme, name, rest = _split(filename)
        if scheme in ("package", "model"):
            try:
                return self.packages.find(name) / rest
            except ConversionError:
                # a mesh is data: it may lie beyond the workspace
                folder = None if name in self.packages.table else self.packages.find_outside(name)
                if folder is None:
                    raise
                return folder / rest
        return self.packages.source.parent / rest if scheme in ("file", "") else None


def get_mesh_files(conversion: Conversion) -> MeshFiles:
    """The one finder of a conversion: it searches the workspace once."""
    files: MeshFiles = conversion.states.setdefault(MeshFiles, MeshFiles(conversion.packages))
    return files


def _ignore_case(path: Path) -> Path | None:
    """Return the only file whose path differs in capital letters at most; None: there is none."""
    folder = Path(path.anchor)
    for part in path.parts[1:] if path.is_absolute() else ():
        if part == ".." or (folder / part).exists():
            folder = folder / part
            continue
        fitting = [entry for entry in folder.iterdir() if entry.name.lower() == part.lower()]
        if len(fitting) != 1:
            return None
        (folder,) = fitting
    return folder if folder.is_file() else None


def _list_parts(filename: str) -> list[str]:
    """Return the folders and the file of a name, without its scheme, package and drive."""
    rest = re.sub(_DRIVE, "/", _split(filename)[2]).replace("\\", "/")
    return [part for part in posixpath.normpath(rest).split("/") if part not in ("", ".", "..")]


def _equal_end(one: Sequence[str], two: Sequence[str]) -> int:
    """How many parts at the ends of two paths are the same."""
    pairs = zip(reversed(one), reversed(two), strict=False)
    return next((n for n, (a, b) in enumerate(pairs) if a != b), min(len(one), len(two)))


def _split(filename: str) -> tuple[str, str, str]:
    """Scheme, package (for ``package`` and ``model``) and the path."""
    match = re.fullmatch(_PACKAGE, filename)
    if match:
        return match[1].lower(), match[2], match[3]
    path, is_file = re.subn(_FILE, "", filename)
    if is_file:
        path = re.sub("^/+", "/", unquote(path))
        return "file", "", path[1:] if re.match(_DRIVE, path[1:]) else path
    return (filename.partition("://")[0], "", "") if "://" in filename else ("", "", filename)
