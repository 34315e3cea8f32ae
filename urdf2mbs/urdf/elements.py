"""The elements and attributes of URDF that are read; all others are reported."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from urdf2mbs.messages.diagnostics import some
from urdf2mbs.urdf import xml
from urdf2mbs.urdf.messages import Messages

if TYPE_CHECKING:
    from collections.abc import Iterable

#: What xacro read without the prefix ``xacro:`` until 2014, and now copies as it stands.
LEGACY = frozenset(("property", "macro", "include", "if", "unless", "insert_block", "call"))
LEGACY_HINT = (
    'write <xacro:{tag} ...> and declare xmlns:xacro="http://www.ros.org/wiki/xacro" on <robot>'
)

#: The attributes of each element that we read, and how many numbers each is; 0 is a text.
ATTRIBUTES: dict[str, dict[str, int]] = {
    "robot": {"name": 0, "version": 0},
    "link": {"name": 0},
    "inertial": {},
    "origin": {"xyz": 3, "rpy": 3},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "visual": {"name": 0},
    "collision": {"name": 0},
    "geometry": {},
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"filename": 0, "scale": 0},
    "material": {"name": 0},
    "color": {"rgba": 4},
    "texture": {"filename": 0},
    "joint": {"name": 0, "type": 0},
    "parent": {"link": 0},
    "child": {"link": 0},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"joint": 0, "multiplier": 1, "offset": 1},
    "safety_controller": {
        "k_velocity": 1, "soft_lower_limit": 1, "soft_upper_limit": 1, "k_position": 1,
    },
    "calibration": {"rising": 1, "falling": 1},
}  # fmt: skip
#: The numbers that an element must have.
REQUIRED: dict[str, tuple[str, ...]] = {
    "mass": ("value",), "inertia": ("ixx", "iyy", "izz"), "box": ("size",),
    "cylinder": ("radius", "length"), "sphere": ("radius",), "color": ("rgba",), "axis": ("xyz",),
    "safety_controller": ("k_velocity",),
}  # fmt: skip
#: The children of each element that we read, at most one of each.
CHILDREN = {
    tag: frozenset(names.split())
    for tag, names in {
        "inertial": "origin mass inertia",
        "visual": "origin geometry material",
        "collision": "origin geometry",
        "material": "color texture",
        "joint": "origin parent child axis limit dynamics mimic calibration safety_controller",
    }.items()
}
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

    def unknown_attributes(self, element: Any) -> None:
        """One message for all attributes of a kind: most joints of a file have the same ones."""
        known = ATTRIBUTES[element.tag]
        missing = known.keys() - element.keys()  # a name whose like is stated, too, is no slip
        kinds: dict[str, list[str]] = {}
        for name, text in element.items():
            if name not in known and ":" not in name and not name.startswith("{"):
                kinds.setdefault(_meaning(name, missing, text), []).append(name)
        for meaning, names in kinds.items():
            several, are = ("", "is") if len(names) == 1 else ("s", "are")
            listed = some(f"'{name}'" for name in names)
            what = f"the attribute{several} {listed} of <{element.tag}> {are}"
            self.unknown("attribute", meaning, what, names[0], missing, element)

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
        text, line = f"{what} unknown and without effect", element.sourceline
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
            what = f"xacro has left <xacro:{plain(tag).rpartition(':')[2]}>, which is left out"
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
    if name in MECHANICAL:
        return "other" if _is_zero(text) else "mechanics"
    return "slip" if _is_slip(name, tuple(known)) else "other"


@cache  # a name that is not known stands in most elements of its kind
def _is_slip(name: str, known: tuple[str, ...]) -> bool:
    from difflib import get_close_matches

    return bool(get_close_matches(name, known, n=1, cutoff=SLIP))


def _is_zero(text: str) -> bool:
    """True for ``0`` and ``0 0 0``, which say nothing."""
    try:
        return not any(map(float, text.split()))
    except ValueError:
        return False


def plain(tag: str) -> str:
    """A tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def is_xacro(element: Any) -> bool:
    """True if an element is xacro's, by its namespace or its prefix."""
    tag = element.tag
    space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (space != tag and "xacro" in space)
