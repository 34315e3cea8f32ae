"""Find the files of an MJCF before MuJoCo reads any, and refuse those outside of its folders.

MuJoCo reads each file that an MJCF names, wherever it is.  So the files are found here first: each
place is tried where MuJoCo might look for a name, and a file that exists there must be in a folder
that the robot may read.  MuJoCo reads XML by tinyxml2, which knows neither encodings nor document
types: a text by which the two readers could differ is refused.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from urdf2mbs.plugin import ConversionError, Packages, absolute_path, files, workspace, xml

#: The elements of MuJoCo that hold XML of their own: an include, and a model that is attached.
_XML_TAGS = ("include", "model")
#: The attributes of ``<compiler>`` that name folders of assets.
_FOLDERS = ("assetdir", "meshdir", "texturedir")
#: Attributes that name a file: ``file``, and ``fileup`` ... of a texture.
_FILE_ATTRIBUTE = re.compile(r"file\w*")
#: The most files of one robot, and the largest XML (bytes).
MAX_FILES, MAX_XML = 10_000, 50 * 2**20
#: A name that another program would read, such as ``https:``; a drive of Windows has one letter.
_SCHEME = re.compile(r"\w{2,}:")
_TRUST = "if you trust the robot's author: `trust_xacro: true` in the config, or --trust-xacro"


class FileFinder:
    """Finds the files of one MJCF.

    Args:
        source: The MJCF.
        packages: The folders of packages, whose files it may read.
        trust: Whether it may read any file.
    """

    def __init__(self, source: Path, packages: Packages, *, trust: bool) -> None:
        self.xml_files: dict[str, None] = {}
        """The XML files, the source first."""
        self.trust = trust
        self._source = Path(absolute_path(source))
        self._roots = [
            Path(os.path.realpath(folder))
            for folder in (
                packages.root,
                find_model_folder(self._source),
                *packages.list_found().values(),
            )
        ]
        self._folders = {""}
        """The folders of assets, as any ``<compiler>`` names them."""
        self._waiting: list[Path] = []
        """XML files that are to be read."""

    def find(self, data: bytes) -> list[str]:
        """Return the XML files of the robot, the source first.

        Raises:
            ConversionError: A file is not XML, or is not allowed.
        """
        references: list[tuple[Any, Path]] = []
        self._waiting = [self._source]
        while self._waiting:
            path = self._waiting.pop()
            if str(path) in self.xml_files:  # MuJoCo says if a file is included twice
                continue
            self.xml_files[str(path)] = None
            root = self._parse(path, data if path == self._source else files.read_bytes(path))
            references += self._list_references(root, path)
        for element, path in references:
            self._check_assets(element, path)
        return list(self.xml_files)

    def _parse(self, path: Path, data: bytes) -> Any:
        """Return the root element of an XML file."""
        name = str(path)
        if len(self.xml_files) > MAX_FILES or len(data) > MAX_XML:
            raise ConversionError("mjcf-too-large", "the XML of the robot is too large", file=name)
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            message = "the file is not UTF-8, which MuJoCo expects"
            raise ConversionError("mjcf-invalid", message, file=name, line=line) from None
        if re.search(r"<!(DOCTYPE|ENTITY)", re.sub(r"(?s)<!--.*?-->", "", text)):
            message = "the file has a document type, which MuJoCo does not read"
            raise ConversionError("mjcf-invalid", message, file=name)
        # both readers see the same bytes: without a declaration, they are UTF-8 for both
        declaration = re.match(r"\s*<\?xml[^>]*\?>", text)
        if declaration is not None:
            text = re.sub(r"[^\n]", " ", declaration[0]) + text[declaration.end() :]
        root, _ = xml.parse(text.encode(), name)
        return root

    def _list_references(self, root: Any, path: Path) -> Iterator[tuple[Any, Path]]:
        """Yield the elements that name assets; the XML files that are named are to be read."""
        for element in root.iter(etree.Element):
            tag = etree.QName(element).localname
            if tag == "compiler":
                self._folders |= {element.get(name, "") for name in _FOLDERS}
            names = [value for key, value in element.items() if _FILE_ATTRIBUTE.fullmatch(key)]
            if names and tag in _XML_TAGS:
                self._waiting += self._list_candidates(element, names, path)
            elif names:
                yield element, path

    def _check_assets(self, element: Any, path: Path) -> None:
        """Raise ConversionError if an element names an asset that the robot may not read."""
        names = [value for key, value in element.items() if _FILE_ATTRIBUTE.fullmatch(key)]
        for _ in self._list_candidates(element, names, path):
            pass

    def _list_candidates(self, element: Any, names: list[str], path: Path) -> Iterator[Path]:
        """Yield the files that exist where MuJoCo might look for a name.

        MuJoCo looks in the folder of the source, of the file itself, and in those of assets, and
        with ``strippath`` for the last part of the name.
        """
        bases = dict.fromkeys([self._source.parent, path.parent])
        for name in names:
            if _SCHEME.match(name) and not self.trust:
                message = f"'{name}' is not a file"
                self._refuse(message, element, path)
            spellings, folders = dict.fromkeys([name, re.split(r"[/\\]", name)[-1]]), self._folders
            if etree.QName(element).localname == "include":
                spellings, folders = dict.fromkeys([name]), {""}
            for base in bases:
                for folder in sorted(folders):
                    for spelling in spellings:
                        candidate = Path(os.path.normpath(base / folder / spelling))
                        if spelling and "\0" not in spelling and candidate.exists():
                            self._check(candidate, element, path)
                            if candidate.is_file():
                                yield candidate

    def _check(self, candidate: Path, element: Any, path: Path) -> None:
        """Raise ConversionError if the robot may not read a file."""
        real = Path(os.path.realpath(candidate))
        for root in self._roots:
            if real.is_relative_to(root):
                parts = real.relative_to(root).parts
                if not any(part.startswith(".") for part in parts) and not real.is_dir():
                    return
        if self.trust or real.is_dir():
            return
        message = f"'{candidate.name}' is not read: {candidate} is outside of {self._roots[1]}"
        self._refuse(message, element, path, real.parent)

    def _refuse(self, message: str, element: Any, path: Path, folder: Path | None = None) -> None:
        """Raise ConversionError for a file that is not allowed."""
        hint = "" if folder is None else f"add its folder: `packages: {{NAME: {folder}}}`; or, "
        raise ConversionError(
            "mjcf-file", message, file=str(path), line=element.sourceline, hint=hint + _TRUST
        )


def find_model_folder(source: Path) -> Path:
    """Return the folder whose files an MJCF may read, without hidden ones.

    It is the workspace, as for xacro, or the outermost Python package above the MJCF: most models
    come in one.
    """
    folder = workspace(source)
    for above in source.parents:
        if (above / "__init__.py").is_file() and folder.is_relative_to(above):
            folder = above
    return folder
