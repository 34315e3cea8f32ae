"""The elements and attributes of URDF that are read; all others are reported."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from urdf2mbs.urdf import xml
from urdf2mbs.urdf.messages import Messages

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

#: What xacro read without the prefix ``xacro:`` until 2014, and now copies as it stands.
LEGACY = frozenset(("property", "macro", "include", "if", "unless", "insert_block", "call"))
LEGACY_HINT = (
    'write <xacro:{tag} ...> and declare xmlns:xacro="http://www.ros.org/wiki/xacro" on <robot>'
)

#: The attributes of each element that we read; any other is reported.
ATTRIBUTES: dict[str, frozenset[str]] = {
    "robot": frozenset(("name", "version")),
    "link": frozenset(("name",)),
    "inertial": frozenset(),
    "origin": frozenset(("xyz", "rpy")),
    "mass": frozenset(("value",)),
    "inertia": frozenset(("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    "visual": frozenset(("name",)),
    "collision": frozenset(("name",)),
    "geometry": frozenset(),
    "box": frozenset(("size",)),
    "cylinder": frozenset(("radius", "length")),
    "sphere": frozenset(("radius",)),
    "mesh": frozenset(("filename", "scale")),
    "material": frozenset(("name",)),
    "color": frozenset(("rgba",)),
    "texture": frozenset(("filename",)),
    "joint": frozenset(("name", "type")),
    "parent": frozenset(("link",)),
    "child": frozenset(("link",)),
    "axis": frozenset(("xyz",)),
    "limit": frozenset(("lower", "upper", "effort", "velocity")),
    "dynamics": frozenset(("damping", "friction")),
    "mimic": frozenset(("joint", "multiplier", "offset")),
    "safety_controller": frozenset(
        ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
    ),
    "calibration": frozenset(("rising", "falling")),
}
#: The children of each element that we read, at most one of each.
CHILDREN: dict[str, frozenset[str]] = {
    "inertial": frozenset(("origin", "mass", "inertia")),
    "visual": frozenset(("origin", "geometry", "material")),
    "collision": frozenset(("origin", "geometry")),
    "material": frozenset(("color", "texture")),
    "joint": frozenset(
        (
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        )
    ),
}
#: Elements of other programs that are usual in URDF files: kept, and no warning.
FOREIGN = frozenset(("gazebo", "transmission", "sensor", "ros2_control", "mujoco"))


class Elements(Messages):
    """The XML of one file: its elements' children and attributes."""

    def __init__(self, file: str, expanded: Sequence[str]) -> None:
        super().__init__(file, expanded)
        self.legacy: str | None = None
        """The first ``<property>`` that xacro does not read any more."""

    def xml(self, data: bytes) -> Any:
        root, slips = xml.parse(data, self.file)
        for slip in slips:
            self.warn(slip.code, slip.message, slip.line)
        return root

    def attributes(self, element: Any) -> dict[str, str]:
        """The attributes of an element that we know; others are reported."""
        known = ATTRIBUTES[element.tag]
        attributes: dict[str, str] = dict(element.items())
        if not known.issuperset(attributes):
            self.unknown_attributes(element)
            return {name: text for name, text in attributes.items() if name in known}
        return attributes

    def attribute(self, element: Any, name: str) -> str | None:
        """The value of the only attribute that an element may have; others are reported."""
        value: str | None = element.get(name)
        if len(element.attrib) != (value is not None):
            self.unknown_attributes(element)
        return value

    def unknown_attributes(self, element: Any) -> None:
        known = ATTRIBUTES[element.tag]
        for name in element.keys():  # noqa: SIM118 (an element iterates over its children)
            if name in known:
                continue
            if name.startswith("{") or ":" in name:
                continue
            self.warn(
                "unknown-attribute",
                f"the attribute '{name}' of <{element.tag}> is not known and has no effect",
                element.sourceline,
                like=(name, known),
            )

    def parts(self, element: Any) -> dict[str, Any]:
        """The children of an element by tag, the first of each; others are reported."""
        tag = element.tag
        known = CHILDREN[tag]
        parts: dict[str, Any] = {}
        for child in element[:]:  # faster than its iterator
            name = child.tag
            if name not in known:
                self.unknown_child(tag, child, known)
            elif name in parts:
                self.doubled(tag, child)
            else:
                parts[name] = child
        return parts

    def unknown_child(self, parent: str, child: Any, known: Iterable[str]) -> None:
        tag = child.tag
        if not isinstance(tag, str):  # a comment or processing instruction
            return
        if self.xacro_left(child):
            return
        self.warn(
            "unknown-element",
            f"<{plain(tag)}> in <{parent}> is not known and has no effect",
            child.sourceline,
            like=(tag, known),
        )

    def doubled(self, parent: str, child: Any) -> None:
        self.warn(
            "doubled-element",
            f"more than one <{child.tag}> in <{parent}>, the first one counts",
            child.sourceline,
        )

    def xacro_left(self, element: Any) -> bool:
        """Whether an element is xacro's, which should be gone by now; it is left out with a
        message."""
        tag = element.tag
        if is_xacro(element):
            self.warn(
                "xacro-macro-unknown",
                f"<xacro:{plain(tag).rpartition(':')[2]}> was left by xacro",
                element.sourceline,
                level="error",
            )
            return True
        if tag == "property":
            self.legacy = self.legacy or element.get("name") or "?"
            self.warn(
                "property-unused",
                "<property> without the prefix xacro: has no effect, and is not used",
                element.sourceline,
                owner=("property", element.get("name") or ""),
            )
            return True
        if tag in LEGACY:
            self.warn(
                "xacro-legacy",
                f"<{tag}> without the prefix xacro: is not read by xacro any more",
                element.sourceline,
                hint=LEGACY_HINT.format(tag=tag),
                level="error",
            )
            return True
        return False

    def unexpanded(self, what: str, line: int | None) -> NoReturn:
        if self.legacy is not None:
            self.fail(
                "xacro-legacy",
                f"{what}: '{self.legacy}' is given by <property> without the prefix xacro:, which "
                "is not read by xacro any more",
                line,
                LEGACY_HINT.format(tag="property"),
            )
        self.fail("xacro-unexpanded", f"{what} was left by xacro", line)


def plain(tag: str) -> str:
    """A tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def is_xacro(element: Any) -> bool:
    """Whether an element is xacro's, by its namespace or its prefix."""
    tag = element.tag
    space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (space != tag and "xacro" in space)
