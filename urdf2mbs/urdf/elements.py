"""The elements and attributes of URDF that are read, in one table; all others are reported."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, NamedTuple

from urdf2mbs.urdf.model import (
    RATES,
    Box,
    Calibration,
    Capsule,
    Cylinder,
    Dynamics,
    Limit,
    Mesh,
    Mimic,
    SafetyController,
    Sphere,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

#: The count of an attribute that is a text.
TEXT = 0


class Element(NamedTuple):
    """An element of URDF: the attributes and children that are read."""

    attributes: dict[str, int]
    """The attributes, and how many numbers each has."""
    required: tuple[str, ...] = ()
    """The attributes that it must have."""
    children: frozenset[str] = frozenset()
    """The children.  An element without children here has none."""
    struct: type[Any] | None = None
    """The class of the model whose fields are the attributes."""


def _split_tags(tags: str) -> frozenset[str]:
    return frozenset(tags.split())


MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
#: The elements, by tag.
ELEMENTS: dict[str, Element] = {
    "robot": Element({"name": TEXT, "version": TEXT}, children=_split_tags("link joint material")),
    "link": Element({"name": TEXT}, children=_split_tags("visual collision inertial")),
    "inertial": Element({}, children=_split_tags("origin mass inertia")),
    "origin": Element({"xyz": 3, "rpy": 3}),
    "mass": Element({"value": 1}, ("value",)),
    "inertia": Element(dict.fromkeys(MOMENTS, 1), ("ixx", "iyy", "izz")),
    "visual": Element({"name": TEXT}, children=_split_tags("origin geometry material")),
    "collision": Element({"name": TEXT}, children=_split_tags("origin geometry")),
    "geometry": Element({}, children=_split_tags("box cylinder capsule sphere mesh")),
    "box": Element({"size": 3}, ("size",), struct=Box),
    "cylinder": Element({"radius": 1, "length": 1}, ("radius", "length"), struct=Cylinder),
    "capsule": Element({"radius": 1, "length": 1}, ("radius", "length"), struct=Capsule),
    "sphere": Element({"radius": 1}, ("radius",), struct=Sphere),
    # a scale is three numbers, or one for all directions
    "mesh": Element({"filename": TEXT, "scale": TEXT}, struct=Mesh),
    "material": Element({"name": TEXT}, children=_split_tags("color texture")),
    "color": Element({"rgba": 4}, ("rgba",)),
    "texture": Element({"filename": TEXT}),
    "joint": Element(
        {"name": TEXT, "type": TEXT},
        children=_split_tags(
            "origin parent child axis limit dynamics mimic calibration safety_controller"
        ),
    ),
    "parent": Element({"link": TEXT}),
    "child": Element({"link": TEXT}),
    "axis": Element({"xyz": 3}, ("xyz",)),
    "limit": Element(dict.fromkeys(("lower", "upper", "effort", *RATES), 1), struct=Limit),
    "dynamics": Element({"damping": 1, "friction": 1}, struct=Dynamics),
    "mimic": Element({"joint": TEXT, "multiplier": 1, "offset": 1}, struct=Mimic),
    "safety_controller": Element(
        {"k_velocity": 1, "soft_lower_limit": 1, "soft_upper_limit": 1, "k_position": 1},
        ("k_velocity",),
        struct=SafetyController,
    ),
    "calibration": Element({"rising": 1, "falling": 1}, struct=Calibration),
}
#: Elements of other programs that are usual in URDF files: kept, and read by plugins.
FOREIGN = frozenset(("gazebo", "transmission", "sensor", "ros2_control", "mujoco"))

#: Elements that xacro read without the prefix ``xacro:`` until 2014, and now copies.
LEGACY = frozenset(("property", "macro", "include", "if", "unless", "insert_block", "call"))
LEGACY_HINT = (
    'write <xacro:{tag} ...> and declare xmlns:xacro="http://www.ros.org/wiki/xacro" on <robot>'
)
#: The namespaces of Drake's extensions of URDF, and their prefix; Drake goes by the prefix.
DRAKE = ("{http://drake.mit.edu}", "{https://drake.mit.edu}", "drake:")

_BLANKS = re.compile(r"[ \t\r\n]+")
#: A longer text is quoted by its beginning.
_QUOTED_LETTERS = 60


def split_tag(tag: str) -> tuple[str, str]:
    """Return a tag or attribute without its namespace, and ``{namespace}`` or ``prefix:``."""
    if tag.startswith("{"):
        namespace, _, bare_name = tag.rpartition("}")
        return bare_name, namespace + "}"
    prefix, separator, bare_name = tag.rpartition(":")
    return bare_name, prefix + separator


def plain(tag: str) -> str:
    """Return a tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def is_drake(tag: str) -> bool:
    """Return True if a tag or attribute has the prefix of Drake."""
    return tag.startswith(DRAKE)


def is_xacro(element: Any) -> bool:
    """Return True if an element is one of xacro, by its namespace or its prefix."""
    tag = element.tag
    namespace = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (namespace != tag and "xacro" in namespace)


def quote(text: str) -> str:
    """Return a text of the file as a message quotes it: in one line, at most 60 letters."""
    text = _BLANKS.sub(" ", text).strip(" ")
    return repr(text if len(text) <= _QUOTED_LETTERS else text[: _QUOTED_LETTERS - 3] + "...")


def suggest_attributes(tag: str, texts: Mapping[str, str]) -> str:
    """Return a hint to write texts of an element as its attributes, as URDF does."""
    attribute_texts = "".join(
        f' {attribute_name}="{quote(text)[1:-1]}"' for attribute_name, text in texts.items()
    )
    return f"write {'an attribute' if len(texts) == 1 else 'attributes'}: <{tag}{attribute_texts}/>"
