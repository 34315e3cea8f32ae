"""Search the robot's files for the declaration of a name: the text that xacro made has no lines."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from urdf2mbs.disk import files

if TYPE_CHECKING:
    from collections.abc import Iterable

#: The reader adds this to the name of a file that xacro has expanded.
EXPANDED = " (expanded)"
NAME_ATTRIBUTE = re.compile(r"""(?<!\S)name\s*=\s*["']([^"']+)["']""")
#: The elements of an MJCF that become links and joints.
_MJCF_TAGS = {"link": "body|site", "joint": "joint|freejoint"}
#: An expression of xacro in a name.
_EXPRESSION = re.compile(r"\$\{[^}]*\}|\$\([^)]*\)")
#: Longer names, and names of more parts, take too long to be compared.
_MAX_LETTERS, _MAX_PARTS = 200, 4


def read_text(file: str) -> str:
    """Return the text of a file; an empty one if it cannot be read."""
    try:
        return files.read_bytes(Path(file)).decode("utf-8", "replace")
    except (OSError, ValueError):
        return ""


def find_declaration(
    element_tag: str, element_name: str, file_names: Iterable[str]
) -> tuple[str, int] | None:
    """Return the file and line of an element's declaration, if there is only one.

    A name with an expression, such as ``${side}_knee``, may be the name if no declaration has
    exactly the name.

    Args:
        element_tag: The tag of the element, such as ``link``.
        element_name: The value of its attribute ``name``.
        file_names: The files.
    """
    exact_matches, possible_matches = [], []
    for file_name in file_names if 0 < len(element_name) <= _MAX_LETTERS else ():
        file_text = read_text(file_name)
        is_mjcf = "<mujoco" in file_text and "<robot" not in file_text
        tags = _MJCF_TAGS.get(element_tag, element_tag) if is_mjcf else element_tag
        for tag_match in re.finditer(rf"<(?:{tags})\s[^<>]*", file_text):
            declared = NAME_ATTRIBUTE.search(tag_match[0])
            if declared is None or _is_reference(element_tag, tag_match[0], is_mjcf=is_mjcf):
                continue
            declaration = file_name, file_text.count("\n", 0, tag_match.start()) + 1
            fixed_parts = [re.escape(fixed_part) for fixed_part in _EXPRESSION.split(declared[1])]
            if declared[1] == element_name:
                exact_matches.append(declaration)
            elif len(fixed_parts) <= _MAX_PARTS and re.fullmatch(
                ".*".join(fixed_parts), element_name
            ):
                possible_matches.append(declaration)
    declarations = exact_matches or possible_matches
    return declarations[0] if len(declarations) == 1 else None


def _is_reference(element_tag: str, written_tag: str, *, is_mjcf: bool) -> bool:
    """Return True for a ``<joint>`` that only names one.

    That of a ``<transmission>`` has no type.  In an MJCF a joint need not have one, and that of an
    equality names two.
    """
    if element_tag != "joint":
        return False
    attribute = r"\sjoint1\s*=" if is_mjcf else r"\stype\s*="
    return (re.search(attribute, written_tag) is not None) == is_mjcf


def locate(
    element_tag: str, element_name: str, file_names: Iterable[str], file: str, line: int | None
) -> tuple[str, int | None]:
    """Return the file and line of an element, in the files that a user has written.

    Args:
        element_tag: The tag of the element.
        element_name: Its name.
        file_names: The files from which xacro has made the text that was read.
        file: The name of that text; it ends with ``EXPANDED`` if xacro has made it.
        line: The line of the element in that text.
    """
    if not file.endswith(EXPANDED):
        return file, line
    return find_declaration(element_tag, element_name, file_names) or (
        file.removesuffix(EXPANDED),
        None,
    )
