"""Where ROS packages are, without any ROS installed."""

from __future__ import annotations

import os
import re
from functools import cached_property
from itertools import islice
from pathlib import Path
from stat import S_IWOTH
from typing import TYPE_CHECKING

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

_NAME = rb"<name(?:\s[^<>]*)?>([^<>]*)</name>"
_COMMENT = rb"(?s)<!--.*?(?:-->|\Z)"
#: The most folders of a workspace that are searched for packages, or for meshes.
MAX_FOLDERS = 10_000
#: The root of a git checkout, or of a workspace of colcon or catkin, has one of these.  The last
#: three exist once it was built.
_ROOTS = (
    ".git",
    "colcon.meta",
    ".colcon",
    ".catkin_workspace",
    ".catkin_tools",
    ".rosinstall",
    "install/.colcon_install_layout",
    "build/.built_by",
    "devel/.catkin",
)
#: The variables of the environment that hold folders, of ROS 1 and 2.
_ENVIRONMENT = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
#: A folder with one of these holds no sources, such as one that colcon built: rospack skips it.
_NO_CRAWL = ("CATKIN_IGNORE", "AMENT_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs")


def absolute_path(path: str | Path) -> str:
    """Return the absolute path, with its links: for a user, a file is in the folder of its link."""
    return os.path.normpath(Path(path).absolute())


def workspace(source: Path) -> Path:
    """Return the folder that is searched for packages, besides the folders of the ROS environment.

    The workspace is the outermost folder above the source that is a package (with a
    ``package.xml``), a git checkout, a workspace of colcon or catkin, or a folder ``src`` that
    directly holds one of these; else the folder of the source.  The home folder and the folders
    above it are no workspace.  A package beside the workspace may be a stranger's, and xacro is
    code: ``packages:`` must name the package.
    """
    root, home = source.parent, _find_home()
    is_inner_marked = False
    for folder in source.parents:
        if folder == home or folder.parent == folder:
            break  # somebody's dotfiles in git are no workspace
        is_marked = (folder / "package.xml").exists() or _is_root(folder)
        if is_marked or (is_inner_marked and folder.name == "src"):
            root = folder
        is_inner_marked = is_marked
    return root


def _is_root(folder: Path) -> bool:
    """Return True for the root of a checkout or of a workspace of colcon or catkin."""
    return any((folder / mark).exists() for mark in _ROOTS)


def _list_siblings(root: Path) -> list[Path]:
    """Return the folders beside the root: an archive may hold packages side by side.

    A root that is a checkout or a workspace is complete, and has no siblings.  Nor has one in a
    folder in which anybody may write, such as /tmp.
    """
    parent = root.parent
    is_complete = root.name == "src" or _is_root(root)
    if is_complete or parent in (_find_home(), parent.parent) or _is_writable_by_all(parent):
        return []
    return _list_subfolders(parent)


def _is_writable_by_all(folder: Path) -> bool:
    return bool(folder.stat().st_mode & S_IWOTH)


def _find_home() -> Path:
    return Path(os.path.expanduser("~"))  # noqa: PTH111 Path.home may raise


def folders_above(source: Path) -> list[Path]:
    """Return the folders above a robot that may hold its meshes, the nearest first.

    They are those of the workspace.  A robot that was copied out of its package lies in no
    workspace: then they are all below the home folder, or below one that anybody may write to.
    """
    root = workspace(source)
    is_closed = (root / "package.xml").exists() or _is_root(root)
    folders = []
    for folder in source.parents:
        is_last = folder == _find_home() or folder.parent == folder
        if is_last or not folder.is_dir() or _is_writable_by_all(folder):
            break
        folders.append(folder)
        if is_closed and folder == root:
            break
    return folders


class Packages:
    """Finds packages: in the user's table, then around the source, then in the ROS environment."""

    def __init__(self, table: Mapping[str, Path], source: Path) -> None:
        self.table = dict(table)
        """The folders of the packages that the user has named."""
        self.source = Path(absolute_path(source))
        self._cache: dict[str, Path | None] = {}
        self._outside: dict[str, Path | None] = {}
        self._crawled: dict[str, dict[str, list[Path]]] = {}

    @cached_property
    def root(self) -> Path:
        """The folder that is searched."""
        return workspace(self.source)

    def find(self, name: str) -> Path:
        """Return the package's folder, which may hold code: never one outside the workspace.

        Raises:
            ConversionError: ``package-not-found``.
            ConfigError: ``package-folder``, the table names a folder that does not exist.
        """
        if name in self.table:
            folder = Path(absolute_path(self.table[name]))
            if not folder.is_dir():
                raise ConfigError(
                    "package-folder",
                    f"the folder given for package '{name}' does not exist: {folder}",
                    hint=f"correct it in `packages:` or `--package {name}=DIR`",
                )
            return folder
        if name not in self._cache:
            self._cache[name] = next(self._search(name), None) if _is_name(name) else None
        cached = self._cache[name]
        if cached is None:
            raise self._explain_missing(name)
        return cached

    def list_found(self) -> dict[str, Path]:
        """Return the packages that ``find`` has found, and those of the table, by name."""
        packages = {name: folder for name, folder in self._cache.items() if folder is not None}
        return dict(sorted({**self.table, **packages}.items()))

    def _explain_missing(self, name: str) -> ConversionError:
        """Return the error for a package that was not found."""
        outside, similar = self.find_outside(name), nearest(name, self.table)
        reason = f"{similar} else " if similar else ""
        if outside is not None:
            reason = f"there is one outside, in {outside}: if you trust it, "
        places = (
            f"the table of packages ({', '.join(self.table) or 'empty'})",
            f"{self.source.parent} and the folders above it; what is in {self.root} or, "
            "unless that is a checkout or workspace, beside it",
            *(f"{variable}={os.environ.get(variable) or '(not set)'}" for variable in _ENVIRONMENT),
        )
        return ConversionError(
            "package-not-found",
            "\n  ".join([f"package '{name}' was not found; looked in:", *places]),
            hint=f"{reason}add `packages: {{{name}: {outside or 'DIR'}}}` to the config, or "
            f"`--package {name}={outside or 'DIR'}`",
        )

    def _search(self, name: str) -> Iterator[Path]:
        """Yield the folders that may be the package, the best first."""
        above: list[Path] = []
        for folder in self.source.parents:
            above += [folder, folder / name] if folder.is_relative_to(self.root) else [folder]
        yield from (folder for folder in above if _read_name(folder) == name)
        yield from (folder for folder in _list_siblings(self.root) if _read_name(folder) == name)
        yield from sorted(self._crawl(self.root).get(name, []), key=self._count_levels)
        for entry in _list_entries("ROS_PACKAGE_PATH"):
            yield from self._crawl(entry).get(name, [])
        installed = self.root / "install"
        prefixes = (*_list_entries("AMENT_PREFIX_PATH"), installed, installed / name)
        shares = [prefix / "share" / name for prefix in prefixes]
        # without any package.xml: a folder of this name that is above or beside the source
        named = [folder for folder in above if folder.name == name]
        yield from (folder for folder in (*shares, *named) if folder.is_dir())

    def _count_levels(self, folder: Path) -> int:
        """Return how many levels above the source the first folder is that holds a folder."""
        return sum(not folder.is_relative_to(parent) for parent in self.source.parents)

    def find_outside(self, name: str) -> Path | None:
        """Return a package outside the workspace, in or below a folder above it, if any."""
        if name not in self._outside:
            parents = self.root.parents if _is_name(name) else ()
            folders = [
                folder / name
                for parent in parents
                for folder in (parent, *_list_subfolders(parent))
                if _read_name(folder / name) == name
            ]
            folders += [parent / name for parent in parents if (parent / name).is_dir()]
            self._outside[name] = next(iter(folders), None)
        return self._outside[name]

    def _crawl(self, top: Path) -> dict[str, list[Path]]:
        """Return the packages below a folder, by name.

        A package within another one is not searched for, unless the source is in it.
        """
        if str(top) not in self._crawled:
            packages = self._crawled[str(top)] = {}
            for folder, folders, names in islice(walk(top, (top,)), MAX_FOLDERS):
                name = _read_name(folder) if "package.xml" in names else None
                if name is not None:
                    packages.setdefault(name, []).append(folder)
                    if folder not in self.source.parents:
                        folders.clear()
        return self._crawled[str(top)]


def walk(top: Path, around: Collection[Path]) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Walk through folders of sources as ``os.walk``, but for those hidden or built by colcon.

    Args:
        top: The folder to begin with.
        around: Folders of sources, whatever they hold.

    Yields:
        A folder, and the names of the folders and of the files in it.
    """
    for root, folders, names in os.walk(top):
        folders[:] = sorted(folder for folder in folders if not folder.startswith("."))
        folder = Path(root)
        if any(mark in names for mark in _NO_CRAWL) and folder not in around:
            folders.clear()
        else:
            yield folder, folders, names


def _is_name(name: str) -> bool:
    return name not in ("", ".", "..") and "/" not in name and "\0" not in name


def _read_name(folder: Path) -> str | None:
    """Return the name in a folder's ``package.xml``; None if there is no such file."""
    try:
        text = re.sub(_COMMENT, b"", files.read_bytes(folder / "package.xml"))
    except (OSError, ValueError):
        return None
    match = re.search(_NAME, text)
    return match[1].strip().decode("utf-8", "replace") if match else None


def _list_subfolders(folder: Path) -> list[Path]:
    try:
        inner = [path for path in folder.iterdir() if not path.name.startswith(".")]
        return sorted(path for path in inner if path.is_dir())
    except OSError:
        return []


def _list_entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]
