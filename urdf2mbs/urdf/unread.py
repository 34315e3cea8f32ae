"""Reports of all that is not read of a file: elements, attributes, texts, and xacro.

Each is a warning, unless it says nothing of the mechanics of a robot (``harmless``): then it is a
note.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from urdf2mbs.messages.diagnostics import some
from urdf2mbs.urdf import harmless
from urdf2mbs.urdf.elements import (
    ELEMENTS,
    LEGACY,
    LEGACY_HINT,
    is_drake,
    is_xacro,
    plain,
    quote,
    split_tag,
    suggest_attributes,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from urdf2mbs.urdf.messages import Messages

#: Text between the elements of links, joints and materials, and beside them.
STRAY_TEXTS = " | ".join(
    f"/robot/{path}text()[normalize-space()]" for path in ("", "link//", "joint//", "material//")
)
#: The elements of an inertia below its diagonal, and those above, of which URDF reads these.
TRANSPOSED = {"iyx": "ixy", "izx": "ixz", "izy": "iyz"}
#: Elements with a name, which messages are about.
OWNERS = ("link", "joint", "material")
#: A name that is so like a readable one is misspelt (``jiont``); the measure is difflib's.
SIMILARITY = 0.75
#: Words for a position or a rotation; in URDF, only ``<origin>`` states them.
PLACES = frozenset(
    (
        *("pose", "position", "orientation", "rotation", "translation", "xyz", "rpy", "pos"),
        *("quat", "x", "y", "z", "roll", "pitch", "yaw", "quat_xyzw", "origin", "rrpy", "ypr"),
        "com",
    )
)
#: Elements in which, or beside which, an ``<origin>`` may be.
HAVE_ORIGIN = ("joint", "inertial", "visual", "collision", "origin", "link", "geometry")
HINT_PLACE = 'state a place as <origin xyz="x y z" rpy="roll pitch yaw"/>, in m and rad'
HINT_UNIT = "URDF is in m, kg, rad, s and N: convert the number"

#: A name that is not read is a misspelt one, may say something of the mechanics, or does not.
Meaning = Literal["misspelt", "mechanics", "harmless"]


class Unread(msgspec.Struct):
    """Elements or attributes of one meaning that are not read."""

    code: str
    """The code of a note about them."""
    message: str
    names: list[str]
    readable: Iterable[str]
    """The names that are read in their place."""
    element: Any
    """The element of lxml, or the first of them."""
    parent: str = ""
    """The tag of the element that they belong to."""


def report_unknown_attributes(
    messages: Messages, element: Any, also_read: Iterable[str] = ()
) -> None:
    """Report the attributes that are not read, in one message for all of a meaning.

    Args:
        messages: The messages about the file.
        element: The element of lxml.
        also_read: Attributes that are read beside those of ``ELEMENTS``.
    """
    tag = plain(element.tag)
    readable = {*ELEMENTS[tag].attributes, *also_read}
    missing = readable - set(element.keys())  # a name whose like is stated, too, is not misspelt
    names_by_meaning: dict[Meaning, list[str]] = {}
    for attribute, text in element.items():
        name, namespace = split_tag(attribute)
        if attribute in readable or (is_drake(attribute) and name in readable):
            continue
        is_harmless = harmless.is_harmless_attribute(tag, name, namespace.strip("{}:"), text)
        if is_harmless or (name in TRANSPOSED and text == element.get(TRANSPOSED[name])):
            meaning: Meaning = "harmless"
        elif _is_misspelt(name, tuple(sorted(missing))):
            meaning = "misspelt"
        else:
            meaning = "harmless" if harmless.is_default(name, text) else "mechanics"
        names_by_meaning.setdefault(meaning, []).append(_write_name(element, attribute))
    for meaning, names in names_by_meaning.items():
        listed = some(f"'{name}'" for name in names)
        message = f"the attribute {listed} of <{tag}> is not read, and has no effect"
        if len(names) > 1:
            message = f"the attributes {listed} of <{tag}> are not read, and have no effect"
        unread = Unread("unknown-attribute", message, names, missing, element, tag)
        _report(messages, meaning, unread)


def report_unknown_children(
    messages: Messages, parent: str, children: Iterable[Any], readable: Iterable[str]
) -> None:
    """Report the children of an element that are not read, in one message for all of a meaning.

    Args:
        messages: The messages about the file.
        parent: The tag of their parent.
        children: The elements of lxml; comments are passed over.
        readable: The tags that are read in this parent.
    """
    children_by_meaning: dict[Meaning, list[Any]] = {}
    for child in children:
        # The tag of a comment or of a processing instruction is a function.
        if not isinstance(child.tag, str):
            continue
        if not (report_xacro(messages, child) if parent in ELEMENTS else is_xacro(child)):
            meaning = _find_meaning(parent, child, readable)
            children_by_meaning.setdefault(meaning, []).append(child)
    for meaning, elements in children_by_meaning.items():
        names = list(dict.fromkeys(_write_name(child, child.tag) for child in elements))
        have = "is not read, and has" if len(names) == 1 else "are not read, and have"
        listed = some(f"<{name}>" for name in names)
        message = f"{listed} in <{parent}> {have} no effect"
        unread = Unread("unknown-element", message, names, readable, elements[0], parent)
        _report(messages, meaning, unread)


def _report(messages: Messages, meaning: Meaning, unread: Unread) -> None:
    """Report elements or attributes: as a warning, or as a note if they are harmless."""
    line = unread.element.sourceline
    if meaning == "misspelt":
        like = (unread.names[0].lower(), unread.readable)
        messages.warn("misspelt", unread.message, line, like=like)
    elif meaning == "harmless":
        messages.warn(unread.code, unread.message, line, level="note")
    else:
        hint = _suggest(unread.names, unread.parent)
        messages.warn("mechanics-unread", unread.message, line, hint=hint)


def report_stray_texts(messages: Messages, root: Any) -> None:
    """Report text between the elements of links, joints and materials, which is not read."""
    for text in root.xpath(STRAY_TEXTS):
        element = text.getparent()
        parent = element.getparent() if text.is_tail else element
        ancestors = [parent, *parent.iterancestors()]
        if any(ancestor.tag not in ELEMENTS for ancestor in ancestors):
            continue  # an element that is not read is reported with all that is in it
        owner = next((a for a in ancestors if a.tag in OWNERS and a.get("name")), root)
        messages.owner = ("robot", "") if owner is root else (owner.tag, owner.get("name"))
        quoted = quote(str(text))
        message = f"the text {quoted} in <{plain(parent.tag)}> is not read, and has no effect"
        hint = HINT_PLACE if parent.tag == "origin" else None
        attributes = list(ELEMENTS[parent.tag].attributes)
        if len(attributes) == 1:
            hint = suggest_attributes(parent.tag, {attributes[0]: str(text)})
        messages.warn("mechanics-unread", message, element.sourceline, hint=hint)
    messages.owner = ("robot", "")


def report_xacro(messages: Messages, element: Any) -> bool:
    """Return True, after a message, if an element is one of xacro that was not expanded."""
    tag, line = element.tag, element.sourceline
    if is_xacro(element):
        name = plain(tag).rpartition(":")[2]
        message = f"xacro did not expand <xacro:{name}>, which is left out"
        messages.warn("xacro-left", message, line)
        return True
    if tag == "property":
        owner = ("property", element.get("name") or "")
        message = "<property> without the prefix xacro: has no effect, and is not used"
        messages.warn("property-unused", message, line, owner=owner)
    elif tag in LEGACY:
        message = f"<{tag}> without the prefix xacro: is not read by xacro any more"
        hint = LEGACY_HINT.format(tag=tag)
        messages.warn("xacro-legacy", message, line, hint=hint, level="error")
    return tag in LEGACY


def _find_meaning(parent: str, child: Any, readable: Iterable[str]) -> Meaning:
    """Return the likely meaning of a child that is not read."""
    name, namespace = split_tag(child.tag)
    if harmless.is_harmless_child(parent, name, namespace.strip("{}:")):
        return "harmless"
    if not namespace and _is_misspelt(name, tuple(sorted(readable))):
        return "misspelt"
    return "harmless" if _is_default(child) else "mechanics"


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


@cache  # a name that is not read is in most elements of its kind
def _is_misspelt(name: str, readable: tuple[str, ...]) -> bool:
    """Return True if a name is nearly a readable one."""
    if name.lower() in PLACES:
        return False
    if name.lower() in readable:  # in capital letters
        return True
    from difflib import get_close_matches

    return bool(get_close_matches(name, readable, n=1, cutoff=SIMILARITY))


def _suggest(names: list[str], parent: str) -> str | None:
    """Return a hint: what to write in place of names that are not read."""
    if "quat_xyzw" in names:
        return 'quat_xyzw is read if the file says <robot version="1.1">; else write rpy'
    words = {split_tag(name)[0].lower() for name in names}
    if not PLACES.isdisjoint(words) and parent in HAVE_ORIGIN:
        return HINT_PLACE
    if not {"unit", "units"}.isdisjoint(words):
        return HINT_UNIT
    if parent not in ELEMENTS:
        return None
    attributes = [name for name in names if name in ELEMENTS[parent].attributes]
    return suggest_attributes(parent, dict.fromkeys(attributes, "...")) if attributes else None


def _write_name(element: Any, tag: str) -> str:
    """Return a tag or attribute as the file writes it, with its prefix."""
    name, namespace = split_tag(tag)
    if not namespace.startswith("{"):
        return tag
    prefixes = (prefix for prefix, uri in element.nsmap.items() if uri == namespace[1:-1])
    prefix = next(filter(None, prefixes), None)
    return f"{prefix}:{name}" if prefix else name
