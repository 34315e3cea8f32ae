"""xacro without ROS, and robots by their name in the package ``robot_descriptions``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import hookimpl

if TYPE_CHECKING:
    from urdf2mbs.plugin import Expansion, Located, Packages

#: The beginning of the name of a robot of ``robot_descriptions``.
PREFIX = "robot_descriptions:"
#: The elements of xacro itself.
_INSTRUCTIONS = frozenset(
    (
        "arg",
        "attribute",
        "call",
        "element",
        "if",
        "include",
        "insert_block",
        "macro",
        "property",
        "robot",
        "unless",
    )
)
_COMMENT = rb"(?s)<!--.*?(?:-->|\Z)"


@hookimpl
def urdf2mbs_locate(source: str) -> Located | None:
    """Find a robot that has a name of ``robot_descriptions``."""
    if not source.startswith(PREFIX):
        return None
    from urdf2mbs_xacro.descriptions import locate

    return locate(source)


@hookimpl
def urdf2mbs_read(
    source: Path, data: bytes, packages: Packages, args: Mapping[str, str], trust: bool
) -> Expansion | None:
    """Expand a file of xacro, or a URDF with xacro in it."""
    if source.suffix.lower() != ".xacro" and not has_xacro(data, str(source)):
        return None
    from urdf2mbs_xacro.xacro import expand

    return expand(source, packages, args, trust=trust)


def has_xacro(data: bytes, file: str) -> bool:
    """Return True if xacro must expand elements of a URDF, or values of its links and joints.

    Args:
        data: The text of the URDF.
        file: The name of its file, for messages.

    Raises:
        ConversionError: The text is not XML.
    """
    # an expanded file still has a comment and a declaration of xacro
    text_without_comments = re.sub(
        rb"xmlns:xacro\s*=\s*(\"[^\"]*\"|'[^']*')", b"", re.sub(_COMMENT, b"", data)
    )
    if b"xacro" not in text_without_comments and b"$" not in text_without_comments:
        return False
    from lxml import etree

    from urdf2mbs.plugin import xml

    root, _ = xml.parse(data, file)
    return any(map(_is_instruction, root.iter(etree.Element))) or any(
        "${" in attribute_value or "$(" in attribute_value
        for child in root.iterchildren("{*}link", "{*}joint", "{*}material")
        for element in child.iter(etree.Element)
        for attribute_value in element.values()
    )


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the codes of this plugin's messages."""
    from urdf2mbs_xacro.codes import CODES

    return CODES


def _is_instruction(element: Any) -> bool:
    """Return True if an element is an instruction of xacro.

    The call of a macro does not count, since something else defines the macro; nor does a
    ``<macro>`` without a name.
    """
    from urdf2mbs.plugin import is_xacro, plain

    tag = plain(element.tag).rpartition(":")[2]
    nameless = tag == "macro" and not element.get("name")
    return is_xacro(element) and tag in _INSTRUCTIONS and not nameless
