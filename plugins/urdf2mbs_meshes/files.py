"""Where the files of meshes and textures are, by the names that a URDF has for them."""

from __future__ import annotations

import posixpath
import re
from functools import cached_property
from pathlib import Path
from urllib.parse import unquote

from urdf2mbs.conversion import Conversion
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, some
from urdf2mbs.urdf import packages
from urdf2mbs.urdf.packages import Packages, walk

_PACKAGE = r"(?is)(package|model):/*([^/]*)/?(.*)"
_FILE = r"(?i)^file:(//localhost(?=/))?"
_DRIVE = r"^[A-Za-z]:[\\/]"


class MeshFiles:
    """Finds files in packages, in the URDF's folder, and elsewhere in the workspace."""

    def __init__(self, packages: Packages) -> None:
        self.packages = packages
        self.moved: dict[str, list[Path]] = {}
        """The files that fit each name without a file at its place."""

    def resolve(self, filename: str) -> Path | None:
        """The file of a mesh or texture by its name; None if there is no such file.

        A file that is not at its place is taken from elsewhere in the workspace, if one fits.
        """
        try:
            path = self._path(filename)
            if path is None or path.is_file():
                return path
        except (ConversionError, OSError, ValueError):
            pass
        if filename not in self.moved:
            self.moved[filename] = self._find_moved(filename)
        fitting = self.moved[filename]
        return fitting[0] if len(fitting) == 1 else None

    def _find_moved(self, filename: str) -> list[Path]:
        """The files of the workspace whose paths end as the file's name does."""
        _, name, rest = _split(filename)
        rest = re.sub(_DRIVE, "/", rest).replace("\\", "/")
        tail = [part for part in posixpath.normpath(rest).split("/") if part not in ("", "..")]
        # the folders before a package are those of another machine, as are those of a whole path
        shortest = min(2, len(tail)) if rest.startswith("/") else len(tail)
        fitting = self._files.get(tail[-1], []) if tail else []
        tail = [name, *tail] if name else tail
        longest = max((len(path.parts) for path in fitting), default=0)
        for size in range(min(len(tail), longest), shortest - 1, -1):
            found = [path for path in fitting if path.parts[-size:] == tuple(tail[-size:])]
            if found:
                return found
        return []

    @cached_property
    def _files(self) -> dict[str, list[Path]]:
        """The files of the workspace by name; none if it has too many folders."""
        found: dict[str, list[Path]] = {}
        for number, (folder, _, names) in enumerate(
            walk(self.packages.root, self.packages.source.parents)
        ):
            if number == packages.MOST_FOLDERS:
                return {}
            for name in names:
                found.setdefault(name, []).append(folder / name)
        return found

    def places_of(self, filename: str) -> list[str]:
        """The folders where ``resolve`` looks for a file, for a message."""
        scheme, name, _ = _split(filename)
        several = self.moved.get(filename, [])
        if len(several) > 1:
            return [f"several files of the workspace, which all fit: {some(map(str, several), 3)}"]
        try:
            path = self._path(filename)
        except ConfigError as error:
            return [error.message]
        except ConversionError:
            return [
                f"package '{name}', which was not found: 'packages: {{{name}: DIR}}' says where"
            ]
        return [str(path.parent)] if path else [f"'{scheme}://' names are not known"]

    def _path(self, filename: str) -> Path | None:
        scheme, name, rest = _split(filename)
        if scheme in ("package", "model"):
            try:
                return self.packages.find(name) / rest
            except ConversionError:
                # a mesh is data: it may lie beyond the workspace
                folder = None if name in self.packages.table else self.packages.find_beyond(name)
                if folder is None:
                    raise
                return folder / rest
        return self.packages.source.parent / rest if scheme in ("file", "") else None


def files_of(conversion: Conversion) -> MeshFiles:
    """The one finder of a conversion: it searches the workspace once."""
    files: MeshFiles = conversion.states.setdefault(MeshFiles, MeshFiles(conversion.packages))
    return files


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
