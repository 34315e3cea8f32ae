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
#: No more folders of a workspace are searched for packages, and a larger one not for meshes.
MAX_FOLDERS = 10_000
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


def absolute_path(path: str | Path) -> str:
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
        marked = any((folder / mark).exists() for mark in ("package.xml", *_ROOTS))
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


def folders_above(source: Path) -> list[Path]:
    """Return the folders above a robot that may hold its meshes, the nearest first.

    They are those of the workspace.  A robot that was copied out of its package lies in no
    workspace: then they are all below the home folder, or below one that anybody may write to.
    """
    root = workspace(source)
    closed = any((root / mark).exists() for mark in ("package.xml", *_ROOTS))
    folders = []
    for folder in source.parents:
        is_last = folder == _home() or folder.parent == folder
        if is_last or not folder.is_dir() or folder.stat().st_mode & S_IWOTH:
            break
        folders.append(folder)
        if closed and folder == root:
            break
    return folders


class Packages:
    """Finds packages: the user's table, then around the source, then the ROS environment."""

    def __init__(self, table: Mapping[str, Path], source: Path) -> None:
        self.table = dict(table)
        self.source = Path(absolute_path(source))
        self._found: dict[str, Path | None] = {}
        self._beyond: dict[str, Path | None] = {}
        self._crawled: dict[str, dict[str, list[Path]]] = {}

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
            folder = Path(absolute_path(self.table[name]))
            if not folder.is_dir():
                raise ConfigError(
                    "package-folder",
                    f"the folder given for package '{name}' does not exist: {folder}",
                    hint=f"correct it in `packages:` or `--package {name}=DIR`",
                )
            return folder
        if name not in self._found:
            self._found[name] = next(self._search(name), None) if _is_name(name) else None
        known = self._found[name]
        if known is None:
            raise self._missing(name)
        return known

    def list_found(self) -> dict[str, Path]:
        """All packages found so far that ``find`` gives, by name."""
        there = {name: folder for name, folder in self._found.items() if folder is not None}
        return dict(sorted({**self.table, **there}.items()))

    def _missing(self, name: str) -> ConversionError:
        stranger, close = self.find_outside(name), nearest(name, self.table)
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

    def _search(self, name: str) -> Iterator[Path]:
        """The folders that may be the package, the best first."""
        near: list[Path] = []
        for folder in self.source.parents:
            near += [folder, folder / name] if folder.is_relative_to(self.root) else [folder]
        yield from (folder for folder in near if _package_name(folder) == name)
        yield from (folder for folder in _neighbours(self.root) if _package_name(folder) == name)
        yield from sorted(self._crawl(self.root).get(name, []), key=self._distance)
        for entry in _entries("ROS_PACKAGE_PATH"):
            yield from self._crawl(entry).get(name, [])
        installed = self.root / "install"
        prefixes = (*_entries("AMENT_PREFIX_PATH"), installed, installed / name)
        shares = [prefix / "share" / name for prefix in prefixes]
        # without any package.xml: a folder of this name that is above or beside the source
        named = [folder for folder in near if folder.name == name]
        yield from (folder for folder in (*shares, *named) if folder.is_dir())

    def _distance(self, folder: Path) -> int:
        """How many folders above the source the first one is that holds this folder, too."""
        return sum(not folder.is_relative_to(above) for above in self.source.parents)

    def find_outside(self, name: str) -> Path | None:
        """A package outside the workspace, below a folder above it; None: there is none."""
        if name not in self._beyond:
            beyond = self.root.parents if _is_name(name) else ()
            found = [
                folder / name
                for above in beyond
                for folder in (above, *_subfolders(above))
                if _package_name(folder / name) == name
            ]
            found += [above / name for above in beyond if (above / name).is_dir()]
            self._beyond[name] = next(iter(found), None)
        return self._beyond[name]

    def _crawl(self, top: Path) -> dict[str, list[Path]]:
        """The packages below a folder by name; none within another, but where the source is."""
        if str(top) not in self._crawled:
            packages = self._crawled[str(top)] = {}
            for folder, folders, names in islice(walk(top, (top,)), MAX_FOLDERS):
                name = _package_name(folder) if "package.xml" in names else None
                if name is not None:
                    packages.setdefault(name, []).append(folder)
                    if folder not in self.source.parents:
                        folders.clear()
        return self._crawled[str(top)]


def walk(top: Path, around: Collection[Path]) -> Iterator[tuple[Path, list[str], list[str]]]:
    """What ``os.walk`` gives of folders of sources: none that is hidden, or that colcon built.

    A folder ``around`` the source is one of sources, whatever it holds.
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


def _package_name(folder: Path) -> str | None:
    try:
        text = re.sub(_COMMENT, b"", files.read_bytes(folder / "package.xml"))
    except (OSError, ValueError):
        return None
    match = re.search(_NAME, text)
    return match[1].strip().decode("utf-8", "replace") if match else None


def _subfolders(folder: Path) -> list[Path]:
    try:
        inner = [path for path in folder.iterdir() if not path.name.startswith(".")]
        return sorted(path for path in inner if path.is_dir())
    except OSError:
        return []


def _entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]
