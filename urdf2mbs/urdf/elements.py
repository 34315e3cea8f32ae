"""The elements and attributes of URDF that are read; all others are reported."""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

from urdf2mbs.messages.diagnostics import some
from urdf2mbs.urdf import harmless, xml
from urdf2mbs.urdf.messages import Messages
from urdf2mbs.urdf.model import RATES

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

#: What xacro read without the prefix ``xacro:`` until 2014, and now copies as it stands.
LEGACY = frozenset(("property", "macro", "include", "if", "unless", "insert_block", "call"))
LEGACY_HINT = (
    'write <xacro:{tag} ...> and declare xmlns:xacro="http://www.ros.org/wiki/xacro" on <robot>'
)

MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
#: The attributes of each element that are read, and how many numbers each is; 0 is a text.
ATTRIBUTES: dict[str, dict[str, int]] = {
    "robot": {"name": 0, "version": 0},
    "link": {"name": 0},
    "inertial": {},
    "origin": {"xyz": 3, "rpy": 3},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(MOMENTS, 1),
    "visual": {"name": 0},
    "collision": {"name": 0},
    "geometry": {},
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"filename": 0, "scale": 0},
    "material": {"name": 0},
    "color": {"rgba": 4},
    "texture": {"filename": 0},
    "joint": {"name": 0, "type": 0},
    "parent": {"link": 0},
    "child": {"link": 0},
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", *RATES), 1),
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"joint": 0, "multiplier": 1, "offset": 1},
    "safety_controller": dict.fromkeys(
        ("k_velocity", "soft_lower_limit", "soft_upper_limit", "k_position"), 1
    ),
    "calibration": {"rising": 1, "falling": 1},
}
#: The numbers that an element must have.
REQUIRED: dict[str, tuple[str, ...]] = {
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz"),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "color": ("rgba",),
    "axis": ("xyz",),
    "safety_controller": ("k_velocity",),
}
#: The children of each element that are read, at most one of each.
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
#: Elements that have no children.
LEAVES = ATTRIBUTES.keys() - CHILDREN.keys() - {"robot", "link", "geometry"}
#: Text between the elements of links, joints and materials, and beside them.
STRAY_TEXTS = " | ".join(
    f"/robot/{path}text()[normalize-space()]" for path in ("", "link//", "joint//", "material//")
)
#: The elements of an inertia below its diagonal, and those above, of which URDF reads these.
TRANSPOSED = {"iyx": "ixy", "izx": "ixz", "izy": "iyz"}
#: Elements that have a name, which messages tell.
OWNERS = ("link", "joint", "material")
_BLANKS = re.compile(r"[ \t\r\n]+")
#: A name that is so like a known one is a slip (``jiont``); the measure is difflib's.
SLIP = 0.75
#: Elements of other programs that are usual in URDF files: kept, and read by plugins.
FOREIGN = frozenset(("gazebo", "transmission", "sensor", "ros2_control", "mujoco"))
#: The namespaces of Drake's extensions of URDF, and their prefix; Drake goes by the prefix.
DRAKE = ("{http://drake.mit.edu}", "{https://drake.mit.edu}", "drake:")
#: Words for a place or a rotation; in URDF, only ``<origin>`` states them.
PLACES = frozenset(
    ("pose", "position", "orientation", "rotation", "translation", "xyz", "rpy", "pos", "quat",
     "x", "y", "z", "roll", "pitch", "yaw", "quat_xyzw", "origin", "rrpy", "ypr", "com")
)  # fmt: skip
#: Elements in which, or beside which, an ``<origin>`` may stand.
HAVE_ORIGIN = ("joint", "inertial", "visual", "collision", "origin", "link", "geometry")
HINT_PLACE = 'state a place as <origin xyz="x y z" rpy="roll pitch yaw"/>, in m and rad'
HINT_UNIT = "URDF is in m, kg, rad, s and N: convert the number"

Meaning = Literal["slip", "mechanics", "other"]


class Elements(Messages):
    """The XML of one file: its elements' children and attributes."""

    def xml(self, data: bytes) -> Any:
        """Return the root element of an XML text, and warn of what was repaired in it."""
        root, slips = xml.parse(data, self.file)
        for slip in slips:
            self.warn(slip.code, slip.message, slip.line)
        return root

    def unknown_attributes(self, element: Any, also_read: Iterable[str] = ()) -> None:
        """Report the attributes that are not read, in one message for all of a kind.

        Args:
            element: The element of lxml.
            also_read: Attributes that are read beside those of ``ATTRIBUTES``.
        """
        tag = plain(element.tag)
        known = {*ATTRIBUTES[tag], *also_read}
        missing = known - set(element.keys())  # a name whose like is stated, too, is no slip
        names_by_meaning: dict[Meaning, list[str]] = {}
        for attribute, text in element.items():
            name, namespace = split_tag(attribute)
            if attribute in known or (is_drake(attribute) and name in known):
                continue
            if harmless.is_harmless_attribute(tag, name, namespace.strip("{}:"), text):
                meaning: Meaning = "other"
            elif name in TRANSPOSED and text == element.get(TRANSPOSED[name]):
                meaning = "other"
            elif _is_slip(name, tuple(sorted(missing))):
                meaning = "slip"
            else:
                meaning = "other" if harmless.is_default(name, text) else "mechanics"
            names_by_meaning.setdefault(meaning, []).append(_write_name(element, attribute))
        for meaning, names in names_by_meaning.items():
            listed = some(f"'{name}'" for name in names)
            text = f"the attribute {listed} of <{tag}> is not read, and has no effect"
            if len(names) > 1:
                text = f"the attributes {listed} of <{tag}> are not read, and have no effect"
            self._report_unread("unknown-attribute", meaning, text, names, missing, element, tag)

    def unknown_child(self, parent: str, child: Any, known: Iterable[str]) -> None:
        """Report an element that is not read; comments are passed over."""
        self.unknown_children(parent, [child], known)

    def unknown_children(self, parent: str, children: Iterable[Any], known: Iterable[str]) -> None:
        """Report the children of an element that are not read, in one message for all of a kind.

        Args:
            parent: The tag of their parent.
            children: The elements of lxml; comments are passed over.
            known: The tags that are read in this parent.
        """
        children_by_meaning: dict[Meaning, list[Any]] = {}
        for child in children:
            # The tag of a comment or of a processing instruction is a function.
            if not isinstance(child.tag, str):
                continue
            if not (self.report_xacro(child) if parent in ATTRIBUTES else is_xacro(child)):
                meaning = _find_meaning(parent, child, known)
                children_by_meaning.setdefault(meaning, []).append(child)
        for meaning, unread in children_by_meaning.items():
            names = list(dict.fromkeys(_write_name(child, child.tag) for child in unread))
            have = "is not read, and has" if len(names) == 1 else "are not read, and have"
            listed = some(f"<{name}>" for name in names)
            text = f"{listed} in <{parent}> {have} no effect"
            self._report_unread("unknown-element", meaning, text, names, known, unread[0], parent)

    def _report_unread(
        self,
        note_code: str,
        meaning: Meaning,
        text: str,
        names: list[str],
        known: Iterable[str],
        element: Any,
        parent: str = "",
    ) -> None:
        """Report what is not read: a warning, or a note where it says nothing of mechanics."""
        line = element.sourceline
        if meaning == "slip":
            self.warn("misspelt", text, line, like=(names[0].lower(), known))
        elif meaning == "other":
            self.warn(note_code, text, line, level="note")
        else:
            self.warn("mechanics-unread", text, line, hint=_hint(names, parent))

    def report_stray_texts(self, root: Any) -> None:
        """Report text between the elements of links, joints and materials, which nothing reads."""
        texts = root.xpath(STRAY_TEXTS)
        for text in texts:
            element = text.getparent()
            parent = element.getparent() if text.is_tail else element
            ancestors = [parent, *parent.iterancestors()]
            if any(ancestor.tag not in ATTRIBUTES for ancestor in ancestors):
                continue  # what is not read is reported whole
            owner = next((e for e in ancestors if e.tag in OWNERS and e.get("name")), root)
            self.owner = ("robot", "") if owner is root else (owner.tag, owner.get("name"))
            quoted = quote(str(text))
            message = f"the text {quoted} in <{plain(parent.tag)}> is not read, and has no effect"
            hint = HINT_PLACE if parent.tag == "origin" else None
            if len(names := list(ATTRIBUTES.get(parent.tag, ()))) == 1:
                hint = suggest_attributes(parent.tag, {names[0]: str(text)})
            self.warn("mechanics-unread", message, element.sourceline, hint=hint)
        self.owner = ("robot", "")

    def parts(self, element: Any) -> dict[str, Any]:
        """Return the children of an element by tag, the first of each; report the others."""
        tag = element.tag
        known = CHILDREN[tag]
        parts: dict[str, Any] = {}
        unknown: list[Any] = []
        for child in element[:]:  # faster than its iterator
            name = child.tag
            if name not in known:
                unknown.append(child)
            elif name in parts:
                self.warn_of_double(tag, child)
            else:
                parts[name] = child
        if unknown:
            self.unknown_children(tag, unknown, known)
        return parts

    def warn_of_double(self, parent: str, child: Any) -> None:
        """Warn that an element is there twice, and only the first is used."""
        what = f"more than one <{child.tag}> in <{parent}>: only the first is used"
        self.warn("doubled-element", what, child.sourceline)

    def report_xacro(self, element: Any) -> bool:
        """Return True, after a message, if an element is one of xacro that was not expanded."""
        tag, line = element.tag, element.sourceline
        if is_xacro(element):
            name = plain(tag).rpartition(":")[2]
            what = f"xacro did not expand <xacro:{name}>, which is left out"
            self.warn("xacro-left", what, line)
        elif tag == "property":
            name = element.get("name") or ""
            what = "<property> without the prefix xacro: has no effect, and is not used"
            self.warn("property-unused", what, line, owner=("property", name))
        elif tag in LEGACY:
            what = f"<{tag}> without the prefix xacro: is not read by xacro any more"
            self.warn("xacro-legacy", what, line, hint=LEGACY_HINT.format(tag=tag), level="error")
        return is_xacro(element) or tag in LEGACY


def _find_meaning(parent: str, child: Any, known: Iterable[str]) -> Meaning:
    """Return what a child that is not read may be: a misspelt name, mechanics, or other."""
    name, namespace = split_tag(child.tag)
    if harmless.is_harmless_child(parent, name, namespace.strip("{}:")):
        return "other"
    if not namespace and _is_slip(name, tuple(sorted(known))):
        return "slip"
    return "other" if _is_default(child) else "mechanics"


def _is_default(element: Any) -> bool:
    """Return True if all that an element and its children say holds without them."""
    name = split_tag(element.tag)[0]
    children = list(element.iterchildren("*"))
    text = " ".join(element.xpath("text()")).strip()
    statements = [(name if key == "value" else key, value) for key, value in element.items()]
    statements += [(name, text)] if text else []
    if not statements and not children:
        return False
    return all(harmless.is_default(*statement) for statement in statements) and all(
        map(_is_default, children)
    )


@cache  # a name that is not known stands in most elements of its kind
def _is_slip(name: str, known: tuple[str, ...]) -> bool:
    """Return True if a name is nearly one that is known."""
    if name.lower() in PLACES:
        return False
    if name.lower() in known:  # in capital letters
        return True
    from difflib import get_close_matches

    return bool(get_close_matches(name, known, n=1, cutoff=SLIP))


def _hint(names: list[str], parent: str) -> str | None:
    """Return what to write in place of words that are not read."""
    if "quat_xyzw" in names:
        return 'quat_xyzw is read if the file says <robot version="1.1">; else write rpy'
    words = {split_tag(name)[0].lower() for name in names}
    if not PLACES.isdisjoint(words) and parent in HAVE_ORIGIN:
        return HINT_PLACE
    if not {"unit", "units"}.isdisjoint(words):
        return HINT_UNIT
    attributes = [name for name in names if name in ATTRIBUTES.get(parent, ())]
    return suggest_attributes(parent, dict.fromkeys(attributes, "...")) if attributes else None


def suggest_attributes(tag: str, texts: Mapping[str, str]) -> str:
    """Return how URDF states what an element has as texts: as attributes."""
    attributes = "".join(f' {name}="{quote(text)[1:-1]}"' for name, text in texts.items())
    return f"write {'an attribute' if len(texts) == 1 else 'attributes'}: <{tag}{attributes}/>"


def split_tag(tag: str) -> tuple[str, str]:
    """Return a tag or attribute without its namespace, and ``{namespace}`` or ``prefix:``."""
    if tag.startswith("{"):
        namespace, _, name = tag.rpartition("}")
        return name, namespace + "}"
    prefix, colon, name = tag.rpartition(":")
    return name, prefix + colon


def plain(tag: str) -> str:
    """Return a tag or attribute without its namespace."""
    return tag.rpartition("}")[2]


def _write_name(element: Any, tag: str) -> str:
    """Return a tag or attribute as the file writes it, with its prefix."""
    name, namespace = split_tag(tag)
    if not namespace.startswith("{"):
        return tag
    prefixes = (p for p, uri in element.nsmap.items() if p and uri == namespace[1:-1])
    prefix = next(prefixes, None)
    return f"{prefix}:{name}" if prefix else name


def is_drake(tag: str) -> bool:
    """Return True if a tag or attribute has the prefix of Drake."""
    return tag.startswith(DRAKE)


def is_xacro(element: Any) -> bool:
    """Return True if an element is one of xacro, by its namespace or its prefix."""
    tag = element.tag
    space = tag.partition("}")[0] if tag.startswith("{") else tag.partition(":")[0]
    return element.prefix == "xacro" or (space != tag and "xacro" in space)


def quote(text: str) -> str:
    """Return a text of the file as a message quotes it: in one line, at most 60 letters."""
    text = _BLANKS.sub(" ", text).strip(" ")
    return repr(text if len(text) <= 60 else text[:57] + "...")
