"""The elements and attributes of URDF that are read; all others are reported."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import some
from urdf2mbs.urdf import xml
from urdf2mbs.urdf.messages import Messages

if TYPE_CHECKING:
    from collections.abc import Iterable

#: The elements of xacro itself.
INSTRUCTIONS = frozenset(
    ("arg", "attribute", "call", "element", "if", "include", "insert_block", "macro", "property",
     "robot", "unless")
)  # fmt: skip
#: What xacro read without the prefix ``xacro:`` until 2014, and now copies as it stands.
LEGACY = frozenset(("property", "macro", "include", "if", "unless", "insert_block", "call"))
LEGACY_HINT = (
    'write <xacro:{tag} ...> and declare xmlns:xacro="http://www.ros.org/wiki/xacro" on <robot>'
)


def _names(table: dict[str, str]) -> dict[str, frozenset[str]]:
    return {tag: frozenset(names.split()) for tag, names in table.items()}


#: The attributes of each element that we read; any other is reported.
ATTRIBUTES = _names({
    "robot": "name version",
    "link": "name",
    "inertial": "",
    "origin": "xyz rpy",
    "mass": "value",
    "inertia": "ixx ixy ixz iyy iyz izz",
    "visual": "name",
    "collision": "name",
    "geometry": "",
    "box": "size",
    "cylinder": "radius length",
    "sphere": "radius",
    "mesh": "filename scale",
    "material": "name",
    "color": "rgba",
    "texture": "filename",
    "joint": "name type",
    "parent": "link",
    "child": "link",
    "axis": "xyz",
    "limit": "lower upper effort velocity",
    "dynamics": "damping friction",
    "mimic": "joint multiplier offset",
    "safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity",
    "calibration": "rising falling",
})  # fmt: skip
#: The children of each element that we read, at most one of each.
CHILDREN = _names({
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry",
    "material": "color texture",
    "joint": "origin parent child axis limit dynamics mimic calibration safety_controller",
})  # fmt: skip
#: A name that is so like a known one is a slip (``jiont``); the measure is difflib's.
SLIP = 0.75
#: What states mechanics where URDF does not know it.
MECHANICAL = frozenset(
    ("origin", "com", "mass", "density", "inertia", "inertial", "joint", "loop_joint", "axis",
     "limit", "dynamics", "mimic", "spring", "stiffness", "damping", "friction", "armature",
     "rpy", "rrpy", "quat_xyzw", "K", "D", "spring_stiffness", "spring_reference", "mu_coulomb",
     "mu_viscous", "mu_static")
)  # fmt: skip
#: Elements of other programs that are usual in URDF files: kept, and no warning.
FOREIGN = frozenset(("gazebo", "transmission", "sensor", "ros2_control", "mujoco"))


class Elements(Messages):
    """The XML of one file: its elements' children and attributes."""

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
        """One message for all attributes of a kind: most joints of a file have the same ones."""
        known = ATTRIBUTES[element.tag]
        kinds: dict[str, list[str]] = {}
        for name, text in element.items():
            if name not in known and ":" not in name and not name.startswith("{"):
                kinds.setdefault(_meaning(name, known, text), []).append(name)
        for meaning, names in kinds.items():
            several, are = ("", "is") if len(names) == 1 else ("s", "are")
            listed = some(f"'{name}'" for name in names)
            what = f"the attribute{several} {listed} of <{element.tag}> {are}"
            self.unknown("attribute", meaning, what, names[0], known, element)

    def unknown_child(self, parent: str, child: Any, known: Iterable[str]) -> None:
        tag = child.tag  # that of a comment or processing instruction is a function
        if not isinstance(tag, str) or self.report_xacro(child):
            return
        # without an attribute, or with children, it says more than zeros
        text = "?" if len(child) or not child.attrib else " ".join(child.values())
        meaning = _meaning(tag, known, text)
        self.unknown("element", meaning, f"<{plain(tag)}> in <{parent}> is", tag, known, child)

    def unknown(
        self, kind: str, meaning: str, what: str, name: str, known: Iterable[str], element: Any
    ) -> None:
        """Report what URDF does not know, as loud as its meaning is."""
        text, line = f"{what} not known: without effect", element.sourceline
        if meaning == "slip":
            self.warn("misspelt", text, line, like=(name, known))
        elif meaning == "mechanics":
            self.warn("mechanics-unread", text, line)
        else:
            code = "unknown-element" if kind == "element" else "unknown-attribute"
            self.warn(code, text, line, level="note")

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
                self.warn_of_double(tag, child)
            else:
                parts[name] = child
        return parts

    def warn_of_double(self, parent: str, child: Any) -> None:
        what = f"more than one <{child.tag}> in <{parent}>, the first one counts"
        self.warn("doubled-element", what, child.sourceline)

    def report_xacro(self, element: Any) -> bool:
        """True, with a message, if an element is xacro's, which should be gone by now."""
        tag, line = element.tag, element.sourceline
        if is_xacro(element):
            what = f"<xacro:{plain(tag).rpartition(':')[2]}> was left by xacro: left out"
            self.warn("xacro-left", what, line)
        elif tag == "property":
            name = element.get("name") or ""
            what = "<property> without the prefix xacro: has no effect, and is not used"
            self.warn("property-unused", what, line, owner=("property", name))
        elif tag in LEGACY:
            what = f"<{tag}> without the prefix xacro: is not read by xacro any more"
            self.warn("xacro-legacy", what, line, hint=LEGACY_HINT.format(tag=tag), level="error")
        return is_xacro(element) or tag in LEGACY


def _meaning(name: str, known: Iterable[str], text: str) -> str:
    """What a name that URDF does not know may be: a ``slip``, ``mechanics`` or ``other``."""
    from difflib import get_close_matches

    if get_close_matches(name, list(known), n=1, cutoff=SLIP) and name not in MECHANICAL:
        return "slip"
    return "mechanics" if name in MECHANICAL and not _is_zero(text) else "other"


def _is_zero(text: str) -> bool:
    """True for ``0`` and ``0 0 0``, which say nothing."""
    try:
        return not any(map(float, text.split()))
    except ValueError:
        return False


def plain(tag: str) -> str:
    """A tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def is_instruction(element: Any) -> bool:
    """True if an element tells xacro what to do.

    A call of a macro by itself does not: no macro is defined.  Nor does a macro without a name.
    """
    tag = plain(element.tag).rpartition(":")[2]
    nameless = tag == "macro" and not element.get("name")
    return is_xacro(element) and tag in INSTRUCTIONS and not nameless


def is_xacro(element: Any) -> bool:
    """True if an element is xacro's, by its namespace or its prefix."""
    tag = element.tag
    space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (space != tag and "xacro" in space)
