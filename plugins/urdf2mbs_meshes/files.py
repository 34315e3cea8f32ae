"""Finds the files of meshes and textures by the names that a URDF has for them."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Sequence
from contextlib import suppress
from filecmp import cmp
from functools import cached_property
from pathlib import Path
from typing import NamedTuple
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

_PACKAGE_NAME = r"(?is)(package|model):/*([^/]*)/?(.*)"
_FILE_SCHEME = r"(?i)^file:(//localhost(?=/))?"
_DRIVE = r"^[A-Za-z]:[\\/]"

#: Number of parts at the end of a mesh's path that are searched above the robot.
MAX_PATH_PARTS = 16


class MeshName(NamedTuple):
    """The parts of a mesh's name in a URDF, such as ``package://arm/meshes/hand.stl``."""

    scheme: str
    """``package``, ``model``, ``file``, or empty for a path; or one that is not known."""
    package: str
    """Name of the package; empty for other schemes."""
    path: str
    """Path in the package, or from the URDF; empty for an unknown scheme."""


class FileRank(NamedTuple):
    """How well a file of the workspace fits a mesh's name; the smallest rank fits best."""

    lacks_package: bool
    """True if the path of the file does not have the package of the name."""
    is_of_other_robot: bool
    negative_end_length: int
    """Minus the number of parts at the end of its path that are those of the name."""
    levels_up: int
    """Number of folders from the source up to the one that holds the file."""
    lacks_source_name: bool
    """True if no folder of the file is called like the source."""


class MeshFiles:
    """Finds files in packages, in the URDF's folder, and elsewhere in the workspace.

    Attributes:
        packages: The packages of the robot.
        moved: The files that fit each name without a file at its place.
        borrowed: Names whose files are those of another robot.
    """

    def __init__(self, packages: Packages) -> None:
        self.packages = packages
        self.moved: dict[str, list[Path]] = {}
        self.borrowed: set[str] = set()
        self._robot_folders: set[Path] = set()
        """The folders of the workspace that hold robots."""

    def find(self, filename: str) -> Path | None:
        """Find the file of a mesh or texture.

        If there is no file at its place, one whose name is spelt differently is taken, or one from
        elsewhere in the workspace, if exactly one fits.

        Args:
            filename: The name in the URDF.

        Returns:
            The file; None if there is no such file.
        """
        path: Path | None = None
        try:
            path = self._compute_path(filename)
            if path is None or path.is_file():
                return path
        except (ConversionError, OSError, ValueError):
            pass
        if filename not in self.moved:
            file = self._find_respelt(filename) or self._find_above(filename)
            self.moved[filename] = [file] if file else self._find_in_workspace(filename)
        candidates = self.moved[filename]
        return candidates[0] if len(candidates) == 1 else None

    def list_moved(self) -> dict[str, Path]:
        """Return the files that were found elsewhere than their names say, by their names."""
        return {name: files[0] for name, files in self.moved.items() if len(files) == 1}

    def suggest_remedy(self, filename: str) -> str:
        """Return what to do about a file that ``find`` does not find, for a message."""
        name = _parse_name(filename)
        candidates = self.moved.get(filename, [])
        prefix, file = "", "file"
        if len(candidates) > 1:
            prefix, file = f"several files fit: {some(map(str, candidates), 3)}; ", "right one"
        try:
            path = self._compute_path(filename)
        except ConfigError as error:
            return error.message
        except ConversionError:
            return (
                f"{prefix}'packages: {{{name.package}: DIR}}' or '--package {name.package}=DIR' "
                f"says where the package '{name.package}' is"
            )
        if path is None:
            return f"give a file or a package: '{name.scheme}://' names are not known"
        if name.package in self.packages.table and not prefix:
            folder = self.packages.table[name.package]
            return f"by --package {name.package}={folder} it would be {path}, which does not exist"
        return f"{prefix}put the {file} into {path.parent}"

    def _compute_path(self, filename: str) -> Path | None:
        """Return the path of a name; None if its scheme is not known."""
        name = _parse_name(filename)
        if name.scheme in ("package", "model"):
            return self._find_package(name.package) / name.path
        return self.packages.source.parent / name.path if name.scheme in ("file", "") else None

    def _find_package(self, package: str) -> Path:
        """Find the folder of a package, also beyond the workspace, since a mesh is only data."""
        try:
            return self.packages.find(package)
        except ConversionError:
            if package in self.packages.table:
                raise
            folder = self.packages.find_outside(package)
            if folder is None:
                raise
            return folder

    def _find_respelt(self, filename: str) -> Path | None:
        """Return the file at its place whose name has ``%20``, backslashes or other capitals."""
        spellings = (filename.replace("\\", "/"), unquote(filename).replace("\\", "/"))
        for spelling in dict.fromkeys(spellings):
            try:
                path = self._compute_path(spelling)
                file = None if path is None else _find_ignoring_case(path)
            except (ConversionError, OSError, ValueError):
                continue
            if file is not None:
                return file
        return None

    def _find_above(self, filename: str) -> Path | None:
        """Return the file in a folder above the robot that has the longest end of its name.

        A robot that was copied out of its package has the folders of the package above it, but
        not its name.  The end is a folder and the file at least.
        """
        tail = _list_path_parts(filename)[-MAX_PATH_PARTS:]
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
        """The folders above the robot, and the names of their entries."""
        folders: dict[Path, frozenset[str]] = {}
        for folder in packages.folders_above(self.packages.source):
            with suppress(OSError):
                folders[folder] = frozenset(entry.name for entry in folder.iterdir())
        return folders

    def _find_in_workspace(self, filename: str) -> list[Path]:
        """Return the files of the workspace that may be meant; several, if they fit equally well.

        The path of a file must end as the name does, by a folder and the file at least, since
        other machines have other folders before.  ``FileRank`` decides between several files.
        """
        tail = _list_path_parts(filename)
        package = _parse_name(filename).package
        name_parts = [package, *tail] if package else tail
        candidates: dict[FileRank, list[Path]] = {}
        for path in self._workspace_files.get(tail[-1], []) if tail else []:
            end_length = _count_equal_ends(path.parts, name_parts)
            if end_length >= min(2, len(tail)):
                rank = self._rank_file(path, end_length, end_length < len(name_parts))
                candidates.setdefault(rank, []).append(path)
        best_rank = min(candidates, default=None)
        if best_rank is None:
            return []
        first, *equally_good = candidates[best_rank]
        if best_rank.is_of_other_robot:
            # The name may still say which robot it means, by a folder that is part of its end.
            ancestor = self.packages.source.parents[best_rank.levels_up]
            folders_in_ancestor = len(first.relative_to(ancestor).parts) - 1
            if -best_rank.negative_end_length <= min(len(tail), folders_in_ancestor):
                self.borrowed.add(filename)
        return [first, *(path for path in equally_good if not cmp(first, path, shallow=False))]

    def _rank_file(self, path: Path, end_length: int, lacks_package: bool) -> FileRank:
        """Return how well a file of the workspace fits a name."""
        ancestors = self.packages.source.parents
        levels_up = next(
            level for level, folder in enumerate(ancestors) if path.is_relative_to(folder)
        )
        ancestor = ancestors[levels_up]
        inner_parts = path.relative_to(ancestor).parts
        is_of_other_robot = (
            len(inner_parts) > 1 and ancestor / inner_parts[0] in self._robot_folders
        )
        lacks_source_name = stem(self.packages.source) not in path.parts
        return FileRank(lacks_package, is_of_other_robot, -end_length, levels_up, lacks_source_name)

    @cached_property
    def _workspace_files(self) -> dict[str, list[Path]]:
        """The files of the workspace by name; none if it has too many folders.

        The folders with robots are found, too.
        """
        files: dict[str, list[Path]] = {}
        folders = walk(self.packages.root, self.packages.source.parents)
        for number, (folder, _, names) in enumerate(folders):
            if number == packages.MAX_FOLDERS:
                return {}
            for name in names:
                files.setdefault(name, []).append(folder / name)
            if any(name.lower().endswith((".urdf", ".xacro")) for name in names):
                self._robot_folders.update((folder, *folder.parents))
        return files


def get_mesh_files(conversion: Conversion) -> MeshFiles:
    """Return the finder of a conversion; there is only one, which searches the workspace once."""
    files: MeshFiles = conversion.states.setdefault(MeshFiles, MeshFiles(conversion.packages))
    return files


def _find_ignoring_case(path: Path) -> Path | None:
    """Return the only file whose path differs at most in capital letters; None if there is none."""
    folder = Path(path.anchor)
    for part in path.parts[1:] if path.is_absolute() else ():
        if part == ".." or (folder / part).exists():
            folder = folder / part
            continue
        entries = [entry for entry in folder.iterdir() if entry.name.lower() == part.lower()]
        if len(entries) != 1:
            return None
        (folder,) = entries
    return folder if folder.is_file() else None


def _list_path_parts(filename: str) -> list[str]:
    """Return the folders and the file of a name, without its scheme, package and drive."""
    path = re.sub(_DRIVE, "/", _parse_name(filename).path).replace("\\", "/")
    return [part for part in posixpath.normpath(path).split("/") if part not in ("", ".", "..")]


def _count_equal_ends(first: Sequence[str], second: Sequence[str]) -> int:
    """Return how many parts at the ends of two paths are the same."""
    pairs = zip(reversed(first), reversed(second), strict=False)
    shorter_length = min(len(first), len(second))
    return next((index for index, (a, b) in enumerate(pairs) if a != b), shorter_length)


def _parse_name(filename: str) -> MeshName:
    """Split the name of a mesh into its parts."""
    match = re.fullmatch(_PACKAGE_NAME, filename)
    if match:
        return MeshName(match[1].lower(), match[2], match[3])
    path, is_file = re.subn(_FILE_SCHEME, "", filename)
    if is_file:
        path = re.sub("^/+", "/", unquote(path))
        has_drive = re.match(_DRIVE, path[1:])
        return MeshName("file", "", path[1:] if has_drive else path)
    if "://" in filename:
        return MeshName(filename.partition("://")[0], "", "")
    return MeshName("", "", filename)
