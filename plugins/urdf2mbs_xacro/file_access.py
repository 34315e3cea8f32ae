"""The files that an expansion may read: those of the workspace, of packages, and of arguments."""

from __future__ import annotations

import os
import re
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.plugin import ConversionError, read_bytes, workspace
from urdf2mbs_xacro.limits import MAX_FILE, TRUST, too_large

if TYPE_CHECKING:
    from collections.abc import Iterable

    from urdf2mbs.plugin import Packages


class FileAccess:
    """Reads files for one expansion, and refuses those outside of what the robot may read."""

    def __init__(self, source: str, packages: Packages, args: Iterable[str], trust: bool) -> None:
        self.packages = packages
        self.trust = trust
        self._source = Path(os.path.realpath(source))
        self._argument_files = set(map(os.path.realpath, args))

    def read(self, name: str) -> bytes:
        """Return the bytes of a file.

        Raises:
            ConversionError: ``xacro-file`` or ``xacro-too-large``.
            OSError: The file cannot be read.
        """
        self.check(name)
        content = read_bytes(Path(name))
        if len(content) > MAX_FILE and not self.trust:
            raise too_large(f"'{Path(name).name}' has more than {MAX_FILE >> 20} MiB")
        return content

    def glob(self, pattern: str) -> list[str]:
        """Return the files that match a pattern; raise as ``read`` does."""
        fixed_prefix, _, pattern_rest = pattern.partition(re.findall(r"[*?[]", pattern)[0])
        self.check(str(Path(fixed_prefix + "x").parent) if ".." not in pattern_rest else "/")
        return glob(pattern)  # noqa: PTH207 just what xacro calls

    def check(self, name: str) -> None:
        """Raise ConversionError for a file or folder that the robot may not read."""
        real_file = Path(os.path.realpath(name))
        if self.trust or str(real_file) in self._argument_files or not real_file.exists():
            return
        for allowed_root in map(os.path.realpath, self._list_roots()):
            inner_parts = (
                real_file.relative_to(allowed_root).parts
                if real_file.is_relative_to(allowed_root)
                else (".",)
            )
            if not any(path_part.startswith(".") for path_part in inner_parts):
                return
        raise ConversionError(
            "xacro-file",
            f"'{Path(name).name}' is not read: {name} is outside the workspace "
            f"{self.packages.root} and the packages that were found",
            hint="add its folder to the config: "
            f"`packages: {{NAME: {real_file.parent}}}`; or, {TRUST}",
        )

    def _list_roots(self) -> list[Path]:
        """Return the folders whose files the robot may read, but for hidden ones."""
        allowed_roots = [self.packages.root, workspace(self._source)]
        for folder in self.packages.list_found().values():
            # in a workspace of links, the files are where the package.xml leads
            package_file = Path(os.path.realpath(folder / "package.xml"))
            allowed_roots += [
                folder,
                package_file.parent if package_file.name == "package.xml" else folder,
            ]
        return allowed_roots
