"""Files of xacro that only define macros, and the robots that include them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import some

#: The root element of a robot.  In a file that only has macros, it has no name.
_ROBOT = re.compile(rb"<robot\s[^<>]*?\bname\s*=")
#: An include of xacro; the group is the name of the file, after its last slash.
_INCLUDE = re.compile(
    rb"""<xacro:include\s[^<>]*?filename\s*=\s*["'](?:[^"']*[/\\])?([^"'/\\]+)["']"""
)
_ROBOT_ENDINGS = (".urdf", ".xacro")
#: The most files of a folder that are looked at.
MAX_FILES = 2000
#: The folder of a package is at most so many levels above a file.
_MAX_LEVELS = 6


def is_robot_file(path: Path) -> bool:
    """Return whether a file is a robot: ``.urdf``, or ``.xacro`` where ``<robot>`` has a name.

    A file that cannot be read counts, since its reader reports why.
    """
    ending = path.suffix.lower()
    if ending != ".xacro":
        return ending == ".urdf"
    try:
        return _ROBOT.search(files.read_bytes(path)) is not None
    except OSError:
        return True


def list_uncalled_macros(xml_root: Any) -> list[str]:
    """Return the macros of a file of xacro; none if it calls one of them.

    Args:
        xml_root: The root element, before xacro expands it.
    """
    macro_names = [macro_element.get("name", "") for macro_element in xml_root.iter("{*}macro")]
    called_names = {
        element.tag.partition("}")[2] for element in xml_root.iter() if isinstance(element.tag, str)
    }
    return macro_names if called_names.isdisjoint(macro_names) else []


def propose_caller(source: Path, xml_root: Any) -> str:
    """Return what to do with a file that only defines macros: name a robot that calls them.

    Args:
        source: The file.
        xml_root: Its root element.
    """
    callers = _find_callers(source)
    if callers:
        return f"name the robot that includes it instead: {some(callers, 3)}"
    call = _write_call(next(xml_root.iter("{*}macro")))
    return (
        "name the robot that includes it; or write one:\n"
        '  <robot name="robot" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        f'    <xacro:include filename="{source.name}"/>\n'
        f"    {call}\n"
        "  </robot>"
    )


def _write_call(macro_element: Any) -> str:
    """Return the call of a macro, with the parameters that have no default."""
    parameters = re.sub(r"""[:]?=\s*("[^"]*"|'[^']*'|\S*)""", "=", macro_element.get("params", ""))
    required = [word for word in parameters.split() if not word.endswith("=")]
    attributes = "".join(f' {word}="VALUE"' for word in required if not word.startswith("*"))
    blocks = "<origin/>" * sum(word.startswith("*") for word in required)
    call = f"xacro:{macro_element.get('name')}"
    return f"<{call}{attributes}>{blocks}</{call}>" if blocks else f"<{call}{attributes}/>"


def _find_callers(source: Path) -> list[str]:
    """Return the robots that include a file, directly or by another file.

    They are searched in the package of the file; without one, beside it and in the folder above.
    """
    for folder in _list_folders(source):
        includes = {
            file: _list_includes(file)
            for file in files.list_files(folder, MAX_FILES)
            if file.suffix.lower() in _ROBOT_ENDINGS and file != source
        }
        callers: list[str] = []
        unvisited, visited = [source.name], {source.name}
        while unvisited:
            included_name = unvisited.pop(0)
            for file, included_names in includes.items():
                if included_name in included_names and file.name not in visited:
                    visited.add(file.name)
                    unvisited.append(file.name)
                    callers += [str(file)] if is_robot_file(file) else []
        if callers:
            return callers
    return []


def _list_folders(source: Path) -> list[Path]:
    """Return the folder of a file's package; without one, the two folders above the file."""
    for parent in list(source.parents)[:_MAX_LEVELS]:
        if files.is_file(parent / "package.xml"):
            return [parent]
    return list(source.parents)[:2]


def _list_includes(file: Path) -> set[str]:
    """Return the names, without their folders, of the files that a file of xacro includes."""
    try:
        names = _INCLUDE.findall(files.read_bytes(file))
    except OSError:
        return set()
    return {name.decode("utf-8", "replace") for name in names}
