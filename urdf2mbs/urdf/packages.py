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
    workspace_root, home_folder = source.parent, _find_home()
    is_inner_marked = False
    for folder in source.parents:
        if folder == home_folder or folder.parent == folder:
            break  # somebody's dotfiles in git are no workspace
        is_marked = (folder / "package.xml").exists() or _is_root(folder)
        if is_marked or (is_inner_marked and folder.name == "src"):
            workspace_root = folder
        is_inner_marked = is_marked
    return workspace_root


def _is_root(folder: Path) -> bool:
    """Return True for the root of a checkout or of a workspace of colcon or catkin."""
    return any((folder / root_marker).exists() for root_marker in _ROOTS)


def _list_siblings(workspace_root: Path) -> list[Path]:
    """Return the folders beside the root: an archive may hold packages side by side.

    A root that is a checkout or a workspace is complete, and has no siblings.  Nor has one in a
    folder in which anybody may write, such as /tmp.
    """
    parent_folder = workspace_root.parent
    is_complete = workspace_root.name == "src" or _is_root(workspace_root)
    if (
        is_complete
        or parent_folder in (_find_home(), parent_folder.parent)
        or _is_writable_by_all(parent_folder)
    ):
        return []
    return _list_subfolders(parent_folder)


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
    home_folder, folders = _find_home(), []
    for folder in source.parents:
        is_last = folder == home_folder or folder.parent == folder
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
        self._found_folders: dict[str, Path | None] = {}
        self._outside_folders: dict[str, Path | None] = {}
        self._crawled_packages: dict[str, dict[str, list[Path]]] = {}

    @cached_property
    def root(self) -> Path:
        """The folder that is searched."""
        return workspace(self.source)

    def find(self, package_name: str) -> Path:
        """Return the package's folder, which may hold code: never one outside the workspace.

        Raises:
            ConversionError: ``package-not-found``.
            ConfigError: ``package-folder``, the table names a folder that does not exist.
        """
        if package_name in self.table:
            package_folder = Path(absolute_path(self.table[package_name]))
            if not package_folder.is_dir():
                raise ConfigError(
                    "package-folder",
                    f"the folder given for package '{package_name}' does not exist: "
                    f"{package_folder}",
                    hint=f"correct it in `packages:` or `--package {package_name}=DIR`",
                )
            return package_folder
        if package_name not in self._found_folders:
            self._found_folders[package_name] = (
                next(self._search(package_name), None) if _is_package_name(package_name) else None
            )
        cached_folder = self._found_folders[package_name]
        if cached_folder is None:
            raise self._explain_missing(package_name)
        return cached_folder

    def list_found(self) -> dict[str, Path]:
        """Return the packages that ``find`` has found, and those of the table, by name."""
        packages = {
            package_name: folder
            for package_name, folder in self._found_folders.items()
            if folder is not None
        }
        return dict(sorted({**self.table, **packages}.items()))

    def _explain_missing(self, package_name: str) -> ConversionError:
        """Return the error for a package that was not found."""
        outside_folder = self.find_outside(package_name)
        similar_hint = nearest(package_name, self.table)
        reason = f"{similar_hint} else " if similar_hint else ""
        if outside_folder is not None:
            reason = f"there is one outside, in {outside_folder}: if you trust it, "
        searched_places = (
            f"the table of packages ({', '.join(self.table) or 'empty'})",
            f"{self.source.parent} and the folders above it; what is in {self.root} or, "
            "unless that is a checkout or workspace, beside it",
            *(f"{variable}={os.environ.get(variable) or '(not set)'}" for variable in _ENVIRONMENT),
        )
        return ConversionError(
            "package-not-found",
            "\n  ".join([f"package '{package_name}' was not found; looked in:", *searched_places]),
            hint=f"{reason}add `packages: {{{package_name}: {outside_folder or 'DIR'}}}` to the "
            f"config, or `--package {package_name}={outside_folder or 'DIR'}`",
        )

    def _search(self, package_name: str) -> Iterator[Path]:
        """Yield the folders that may be the package, the best first."""
        folders_above_source: list[Path] = []
        for folder in self.source.parents:
            folders_above_source += (
                [folder, folder / package_name] if folder.is_relative_to(self.root) else [folder]
            )
        yield from (
            folder for folder in folders_above_source if _read_package_name(folder) == package_name
        )
        yield from (
            folder
            for folder in _list_siblings(self.root)
            if _read_package_name(folder) == package_name
        )
        yield from sorted(self._crawl(self.root).get(package_name, []), key=self._count_levels)
        for search_folder in _list_entries("ROS_PACKAGE_PATH"):
            yield from self._crawl(search_folder).get(package_name, [])
        installed = self.root / "install"
        prefixes = (*_list_entries("AMENT_PREFIX_PATH"), installed, installed / package_name)
        share_folders = [prefix / "share" / package_name for prefix in prefixes]
        # without any package.xml: a folder of this name that is above or beside the source
        folders_of_that_name = [
            folder for folder in folders_above_source if folder.name == package_name
        ]
        yield from (folder for folder in (*share_folders, *folders_of_that_name) if folder.is_dir())

    def _count_levels(self, folder: Path) -> int:
        """Return how many levels above the source the first folder is that holds a folder."""
        return sum(
            not folder.is_relative_to(source_parent) for source_parent in self.source.parents
        )

    def find_outside(self, package_name: str) -> Path | None:
        """Return a package outside the workspace, in or below a folder above it, if any."""
        if package_name not in self._outside_folders:
            parents = self.root.parents if _is_package_name(package_name) else ()
            folders = [
                folder / package_name
                for parent in parents
                for folder in (parent, *_list_subfolders(parent))
                if _read_package_name(folder / package_name) == package_name
            ]
            folders += [
                parent / package_name for parent in parents if (parent / package_name).is_dir()
            ]
            self._outside_folders[package_name] = next(iter(folders), None)
        return self._outside_folders[package_name]

    def _crawl(self, top_folder: Path) -> dict[str, list[Path]]:
        """Return the packages below a folder, by name.

        A package within another one is not searched for, unless the source is in it.
        """
        if str(top_folder) not in self._crawled_packages:
            packages = self._crawled_packages[str(top_folder)] = {}
            for folder, subfolders, file_names in islice(
                walk(top_folder, (top_folder,)), MAX_FOLDERS
            ):
                package_name = _read_package_name(folder) if "package.xml" in file_names else None
                if package_name is not None:
                    packages.setdefault(package_name, []).append(folder)
                    if folder not in self.source.parents:
                        subfolders.clear()
        return self._crawled_packages[str(top_folder)]


def walk(top_folder: Path, around: Collection[Path]) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Walk through folders of sources as ``os.walk``, but for those hidden or built by colcon.

    Args:
        top_folder: The folder to begin with.
        around: Folders of sources, whatever they hold.

    Yields:
        A folder, and the names of the folders and of the files in it.
    """
    for folder_name, subfolder_names, file_names in os.walk(top_folder):
        subfolder_names[:] = sorted(
            folder for folder in subfolder_names if not folder.startswith(".")
        )
        folder = Path(folder_name)
        if any(ignore_marker in file_names for ignore_marker in _NO_CRAWL) and folder not in around:
            subfolder_names.clear()
        else:
            yield folder, subfolder_names, file_names


def _is_package_name(package_name: str) -> bool:
    return (
        package_name not in ("", ".", "..") and "/" not in package_name and "\0" not in package_name
    )


def _read_package_name(folder: Path) -> str | None:
    """Return the name in a folder's ``package.xml``; None if there is no such file."""
    try:
        package_xml = re.sub(_COMMENT, b"", files.read_bytes(folder / "package.xml"))
    except (OSError, ValueError):
        return None
    name_match = re.search(_NAME, package_xml)
    return name_match[1].strip().decode("utf-8", "replace") if name_match else None


def _list_subfolders(folder: Path) -> list[Path]:
    try:
        visible_entries = [
            entry_path for entry_path in folder.iterdir() if not entry_path.name.startswith(".")
        ]
        return sorted(entry_path for entry_path in visible_entries if entry_path.is_dir())
    except OSError:
        return []


def _list_entries(variable: str) -> list[Path]:
    return [
        Path(stated_folder)
        for stated_folder in os.environ.get(variable, "").split(os.pathsep)
        if stated_folder
    ]
