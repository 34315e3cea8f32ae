"""Where ROS packages are, without any ROS installed."""

from __future__ import annotations

import os
import posixpath
import re
from functools import cached_property
from itertools import chain
from pathlib import Path
from stat import S_IWOTH
from typing import TYPE_CHECKING
from urllib.parse import unquote

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest, some

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_NAME = rb"<name(?:\s[^<>]*)?>([^<>]*)</name>"
_COMMENT = rb"(?s)<!--.*?(?:-->|\Z)"
_SCHEME = r"(?i)(package|model|file):/*"
_LOCALHOST = r"(?i)^//localhost(?=/)"
#: A mesh that is not at its place is not looked for in a workspace of more folders.
MOST_FOLDERS = 10_000
_DRIVE = r"(?i)[A-Z](:|%3A)[\\/]"
#: The root of a git checkout, or of a workspace of colcon or catkin, has one of these.  The last
#: three are there once it was built.
_ROOTS = (
    ".git", "colcon.meta", ".colcon", ".catkin_workspace", ".catkin_tools", ".rosinstall",
    "install/.colcon_install_layout", "build/.built_by", "devel/.catkin",
)  # fmt: skip
#: The variables of the environment that hold folders, of ROS 1 and 2.
_ENVIRONMENT = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
#: A folder with one of these holds no sources, as what colcon built: rospack skips it, too.
_NO_CRAWL = ("CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs")


def absolute(path: str | Path) -> str:
    """The absolute path, with its links: for a user, a file is in the folder of its link."""
    return os.path.normpath(Path(path).absolute())


def workspace(source: Path) -> Path:
    """The folder that is searched for packages, besides the folders of the ROS environment.

    The workspace is the outermost folder above the source that is a package (with a
    ``package.xml``), a git checkout, a workspace of colcon or catkin, or a folder ``src`` that
    directly holds one of these; else the folder of the source.  The home folder and the folders
    above it are no workspace.  A package beside the workspace may be a stranger's, and xacro is
    code: ``packages:`` must name the package.
    """
    root, home = source.parent, _home()
    inner = False
    for folder in source.parents:
        if folder == home or folder.parent == folder:
            break  # somebody's dotfiles in git are no workspace
        marked = _is_marked(folder)
        if marked or (inner and folder.name == "src"):
            root = folder
        inner = marked
    return root


def _neighbours(root: Path) -> list[Path]:
    """The folders beside the root: an archive may hold packages side by side.

    There are none if the root is a checkout or a workspace, which is complete by itself, or if
    anybody may write beside the root, as in /tmp.
    """
    holder = root.parent
    closed = root.name == "src" or any((root / mark).exists() for mark in _ROOTS)
    if closed or holder in (_home(), holder.parent) or holder.stat().st_mode & S_IWOTH:
        return []
    return _subfolders(holder)


def _home() -> Path:
    return Path(os.path.expanduser("~"))  # noqa: PTH111 Path.home may raise


def _is_marked(folder: Path) -> bool:
    return any((folder / mark).exists() for mark in ("package.xml", *_ROOTS))


class Packages:
    """Finds packages: the user's table, then around the source, then the ROS environment."""

    def __init__(self, table: Mapping[str, Path], source: Path) -> None:
        self.table = dict(table)
        self.source = Path(absolute(source))
        self._found: dict[str, Path | None] = {}
        self._beyond: dict[str, Path | None] = {}
        self.moved: dict[str, list[Path]] = {}
        """The files that fit each name without a file at its place."""
        self._crawled: dict[str, dict[str, Path]] = {}

    @cached_property
    def root(self) -> Path:
        """The folder that is searched."""
        return workspace(self.source)

    def find(self, name: str) -> Path:
        """The package's folder, which may hold code: never one beyond the workspace.

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
        known = self._found[name]
        if known is None:
            raise self._missing(name)
        return known

    def found(self) -> dict[str, Path]:
        """All packages found so far that ``find`` gives, by name."""
        there = {name: folder for name, folder in self._found.items() if folder is not None}
        return dict(sorted({**self.table, **there}.items()))

    def _missing(self, name: str) -> ConversionError:
        stranger, close = self._further(name), nearest(name, self.table)
        said = f"{close} else " if close else ""
        if stranger is not None:
            said = f"there is one outside, in {stranger}: if you trust it, "
        places = (
            f"the table of packages ({', '.join(self.table) or 'empty'})",
            f"{self.source.parent} and the folders above it; what is in {self.root} or, "
            "unless that is a checkout or workspace, beside it",
            *(f"{place}={os.environ.get(place) or '(not set)'}" for place in _ENVIRONMENT),
        )
        return ConversionError(
            "package-not-found",
            "\n  ".join([f"package '{name}' was not found; looked in:", *places]),
            hint=f"{said}add `packages: {{{name}: {stranger or 'DIR'}}}` to the config, or "
            f"`--package {name}={stranger or 'DIR'}`",
        )

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
            self.moved[filename] = self._elsewhere(filename)
        fitting = self.moved[filename]
        return fitting[0] if len(fitting) == 1 else None

    def _elsewhere(self, filename: str) -> list[Path]:
        """The files of the workspace whose paths end as the file's name does."""
        _, name, rest = _split(filename)
        rest = re.sub(_DRIVE, "/", rest).replace("\\", "/") if re.match(_DRIVE, rest) else rest
        local = posixpath.normpath(rest).split("/")
        fitting = self._files.get(local[-1])
        if fitting is None:
            return []
        tail = [part for part in local if part not in ("", "..")]
        # the folders before a package are those of another machine, as are those of a whole path
        shortest = min(2, len(tail)) if rest.startswith("/") else len(tail)
        tail = [name, *tail] if name else tail
        longest = max(len(path.parts) for path in fitting)
        for start in range(max(0, len(tail) - longest), len(tail) - shortest + 1):
            end = tuple(tail[start:])
            found = [path for path in fitting if path.parts[-len(end) :] == end]
            if found:
                return found
        return []

    @cached_property
    def _files(self) -> dict[str, list[Path]]:
        """The files of the workspace by name; none if it has too many folders."""
        found: dict[str, list[Path]] = {}
        around = self.source.parents
        for number, (folder, folders, names) in enumerate(os.walk(self.root)):
            if number == MOST_FOLDERS:
                return {}
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            if any(mark in names for mark in _NO_CRAWL) and Path(folder) not in around:
                folders.clear()  # copies of the sources
                continue
            for name in names:
                found.setdefault(name, []).append(Path(folder, name))
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
                return self.find(name) / rest
            except ConversionError:
                # a mesh is data: it may lie beyond the workspace
                folder = None if name in self.table else self._further(name)
                if folder is None:
                    raise
                return folder / rest
        if scheme in ("file", ""):
            return self.source.parent / rest
        return None

    def _search(self, name: str) -> Path | None:
        if not _is_name(name):
            return None
        for candidate in self._candidates(name):
            if _package_name(candidate) == name:
                return candidate
        installed = self.root / "install"
        for prefix in (*_entries("AMENT_PREFIX_PATH"), installed, installed / name):
            if (prefix / "share" / name).is_dir():
                return prefix / "share" / name
        # without any package.xml: a folder of this name that is above or beside the source
        for ancestor in self.source.parents:
            if ancestor.name == name:
                return ancestor
            if ancestor.is_relative_to(self.root) and (ancestor / name).is_dir():
                return ancestor / name
        return None

    def _candidates(self, name: str) -> Iterator[Path]:
        for ancestor in self.source.parents:
            yield ancestor
            if ancestor.is_relative_to(self.root):
                yield from _below(ancestor, name)
        yield from _neighbours(self.root)
        # a folder may have another name than its package
        for folder in _subfolders(self.root):
            yield folder
            if self.root.name == "src" or _is_marked(self.root):  # else it may be large
                yield self._crawl(folder).get(name, folder)
        for entry in _entries("ROS_PACKAGE_PATH"):
            yield entry
            yield entry / name
            yield self._crawl(entry).get(name, entry)

    def _further(self, name: str) -> Path | None:
        """A package outside the workspace, below a folder above it; None: there is none."""
        if name not in self._beyond:
            beyond = self.root.parents if _is_name(name) else ()
            below = chain.from_iterable(_below(above, name) for above in beyond)
            found = [folder for folder in below if _package_name(folder) == name]
            found += [above / name for above in beyond if (above / name).is_dir()]
            self._beyond[name] = next(iter(found), None)
        return self._beyond[name]

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
    match = re.match(_SCHEME, filename)
    if match:
        scheme = match[1].lower()
        rest = filename[match.end() :]
        if scheme == "file":
            return scheme, "", unquote(_local(filename[len("file:") :]))
        name, _, rest = rest.partition("/")
        return scheme, name, rest
    if "://" in filename:
        return filename.partition("://")[0], "", ""
    return "", "", filename


def _local(rest: str) -> str:
    """The path that a ``file:`` URI means, of what follows the scheme."""
    rest = re.sub(_LOCALHOST, "", rest)
    if not rest.startswith("/"):
        return rest
    path = rest.lstrip("/")
    return path if re.match(_DRIVE, path) else f"/{path}"


def _is_name(name: str) -> bool:
    return name not in ("", ".", "..") and "/" not in name and "\0" not in name


def _below(folder: Path, name: str) -> Iterator[Path]:
    """``NAME`` and ``*/NAME``."""
    yield folder / name
    for inner in _subfolders(folder):
        yield inner / name


def _package_name(folder: Path) -> str | None:
    try:
        text = re.sub(_COMMENT, b"", files.read(folder / "package.xml"))
    except (OSError, ValueError):
        return None
    match = re.search(_NAME, text)
    return match[1].strip().decode("utf-8", "replace") if match else None


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
