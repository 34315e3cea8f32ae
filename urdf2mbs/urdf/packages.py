"""Where ROS packages are, without any ROS installed."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from urdf2mbs.diagnostics import ConfigError, ConversionError, nearest

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_NAME = re.compile(rb"<name[^>]*>\s*([^<]*?)\s*</name>")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_SCHEME = re.compile(r"(package|model|file):/*", re.IGNORECASE)
#: Folders that a crawl through a ROS_PACKAGE_PATH entry does not enter, as rospack does.
_NO_CRAWL = ("CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs")


def absolute(path: str | Path) -> str:
    """Not ``Path.resolve``: links stay, since the folders above a link are where its user
    thinks the file is."""
    return os.path.normpath(Path(path).absolute())


class Packages:
    """Finds packages: the user's table, then around the source, then the ROS environment."""

    def __init__(self, table: Mapping[str, Path], source: Path) -> None:
        self.table = dict(table)
        self.source = Path(absolute(source))
        self._found: dict[str, Path | None] = {}
        self._crawled: dict[str, dict[str, Path]] = {}

    def find(self, name: str) -> Path:
        """The package's folder.

        :raises ConversionError: ``package-not-found``
        :raises ConfigError: ``package-folder``, the table names a folder that does not exist
        """
        if name in self.table:
            folder = Path(absolute(self.table[name]))
            if not folder.is_dir():
                raise ConfigError(
                    "package-folder",
                    f"the folder given for package '{name}' does not exist: {folder}",
                    hint=f"correct it in `packages:` or `--package {name}=DIR`",
                )
            return folder
        if name not in self._found:
            self._found[name] = self._search(name)
        found = self._found[name]
        if found is None:
            places = "".join(f"\n  {place}" for place in self.places(name))
            close = nearest(name, self.table)
            raise ConversionError(
                "package-not-found",
                f"package '{name}' was not found; looked in:{places}",
                hint=f"{close + ' else ' if close else ''}"
                f"add `packages: {{{name}: DIR}}` to the config, or `--package {name}=DIR`",
            )
        return found

    def places(self, name: str) -> list[str]:
        """Where ``find`` looks for a package, for a message."""
        known = ", ".join(self.table) or "empty"
        return [
            f"the table of packages ({known})",
            f"{self.source.parent} and the folders above it, "
            f"each with its subfolders {name} and */{name}",
            *(
                f"{variable}={os.environ.get(variable) or '(not set)'}"
                for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
            ),
        ]

    def resolve(self, filename: str) -> Path | None:
        """The file that a mesh or texture name means, or None where there is none."""
        try:
            path = self._path(filename)
            return path if path is not None and path.is_file() else None
        except (ConversionError, OSError, ValueError):
            return None

    def looked(self, filename: str) -> list[str]:
        """Where ``resolve`` looks for a file, for a message."""
        scheme, name, _ = _split(filename)
        try:
            path = self._path(filename)
        except ConfigError as error:
            return [error.message]
        except ConversionError:
            return [f"package '{name}':", *self.places(name)]
        return [str(path)] if path else [f"'{scheme}://' names are not known"]

    def _path(self, filename: str) -> Path | None:
        scheme, name, rest = _split(filename)
        if scheme in ("package", "model"):
            return self.find(name) / rest
        if scheme in ("file", ""):
            return self.source.parent / rest
        return None

    def _search(self, name: str) -> Path | None:
        if not name or name in (".", "..") or "/" in name or "\0" in name:
            return None
        for candidate in self._candidates(name):
            if _package_name(candidate) == name:
                return candidate
        for prefix in _entries("AMENT_PREFIX_PATH"):
            if (prefix / "share" / name).is_dir():
                return prefix / "share" / name
        # No package.xml at all: a folder of that name that the source is in, or beside.
        for ancestor in self.source.parents:
            if ancestor.name == name:
                return ancestor
            if (ancestor / name).is_dir():
                return ancestor / name
        return None

    def _candidates(self, name: str) -> Iterator[Path]:
        for ancestor in self.source.parents:
            yield ancestor
            yield ancestor / name
            for folder in _subfolders(ancestor):
                yield folder / name
        for entry in _entries("ROS_PACKAGE_PATH"):
            yield entry
            yield entry / name
            crawled = self._crawl(entry)
            if name in crawled:
                yield crawled[name]

    def _crawl(self, top: Path) -> dict[str, Path]:
        """All packages below a folder, by name; a package's own folder is not searched further."""
        packages = self._crawled.get(str(top))
        if packages is None:
            packages = self._crawled[str(top)] = {}
            for root, folders, files in os.walk(top):
                name = _package_name(Path(root)) if "package.xml" in files else None
                if name is not None:
                    packages.setdefault(name, Path(root))
                if name is not None or any(mark in files for mark in _NO_CRAWL):
                    folders.clear()
                folders[:] = sorted(folder for folder in folders if not folder.startswith("."))
        return packages


def _split(filename: str) -> tuple[str, str, str]:
    """Scheme, package (for ``package`` and ``model``) and the path."""
    match = _SCHEME.match(filename)
    if match:
        scheme = match[1].lower()
        rest = filename[match.end() :]
        if scheme == "file":
            absolute = "/" in match[0]
            return scheme, "", unquote(f"/{rest}" if absolute else rest)
        name, _, rest = rest.partition("/")
        return scheme, name, rest
    if "://" in filename:
        return filename.partition("://")[0], "", ""
    return "", "", filename


def _package_name(folder: Path) -> str | None:
    try:
        text = _COMMENT.sub(b"", (folder / "package.xml").read_bytes())
    except (OSError, ValueError):
        return None
    match = _NAME.search(text)
    return match[1].decode("utf-8", "replace") if match else None


def _subfolders(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            names = [
                entry.name for entry in entries if not entry.name.startswith(".") and entry.is_dir()
            ]
    except OSError:
        return []
    return [folder / name for name in sorted(names)]


def _entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]
