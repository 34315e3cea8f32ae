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
    # a name is not misspelt if the readable name like it is stated, too
    absent_attributes = readable - set(element.keys())
    names_by_meaning: dict[Meaning, list[str]] = {}
    for attribute, attribute_text in element.items():
        bare_name, namespace = split_tag(attribute)
        if attribute in readable or (is_drake(attribute) and bare_name in readable):
            continue
        is_harmless = harmless.is_harmless_attribute(
            tag, bare_name, namespace.strip("{}:"), attribute_text
        )
        if is_harmless or (
            bare_name in TRANSPOSED and attribute_text == element.get(TRANSPOSED[bare_name])
        ):
            meaning: Meaning = "harmless"
        elif _is_misspelt(bare_name, tuple(sorted(absent_attributes))):
            meaning = "misspelt"
        else:
            meaning = "harmless" if harmless.is_default(bare_name, attribute_text) else "mechanics"
        names_by_meaning.setdefault(meaning, []).append(_write_name(element, attribute))
    for meaning, attribute_names in names_by_meaning.items():
        quoted_names = some(f"'{bare_name}'" for bare_name in attribute_names)
        message = f"the attribute {quoted_names} of <{tag}> is not read, and has no effect"
        if len(attribute_names) > 1:
            message = f"the attributes {quoted_names} of <{tag}> are not read, and have no effect"
        unread = Unread(
            "unknown-attribute", message, attribute_names, absent_attributes, element, tag
        )
        _report_unread(messages, meaning, unread)


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
        written_tags = list(dict.fromkeys(_write_name(child, child.tag) for child in elements))
        verb_phrase = "is not read, and has" if len(written_tags) == 1 else "are not read, and have"
        quoted_tags = some(f"<{written_tag}>" for written_tag in written_tags)
        message = f"{quoted_tags} in <{parent}> {verb_phrase} no effect"
        unread = Unread("unknown-element", message, written_tags, readable, elements[0], parent)
        _report_unread(messages, meaning, unread)


def _report_unread(messages: Messages, meaning: Meaning, unread: Unread) -> None:
    """Report elements or attributes: as a warning, or as a note if they are harmless."""
    line = unread.element.sourceline
    if meaning == "misspelt":
        like = (unread.names[0].lower(), unread.readable)
        messages.warn("misspelt", unread.message, line, like=like)
    elif meaning == "harmless":
        messages.warn(unread.code, unread.message, line, level="note")
    else:
        hint = _suggest_remedy(unread.names, unread.parent)
        messages.warn("mechanics-unread", unread.message, line, hint=hint)


def report_stray_texts(messages: Messages, root: Any) -> None:
    """Report text between the elements of links, joints and materials, which is not read."""
    for stray_text in root.xpath(STRAY_TEXTS):
        element = stray_text.getparent()
        parent_element = element.getparent() if stray_text.is_tail else element
        ancestors = [parent_element, *parent_element.iterancestors()]
        if any(ancestor.tag not in ELEMENTS for ancestor in ancestors):
            continue  # an element that is not read is reported with all that is in it
        owner_element = next(
            (
                named_ancestor
                for named_ancestor in ancestors
                if named_ancestor.tag in OWNERS and named_ancestor.get("name")
            ),
            root,
        )
        messages.owner = (
            ("robot", "")
            if owner_element is root
            else (owner_element.tag, owner_element.get("name"))
        )
        quoted_text = quote(str(stray_text))
        parent_tag = plain(parent_element.tag)
        message = f"the text {quoted_text} in <{parent_tag}> is not read, and has no effect"
        hint = HINT_PLACE if parent_element.tag == "origin" else None
        attributes = list(ELEMENTS[parent_element.tag].attributes)
        if len(attributes) == 1:
            hint = suggest_attributes(parent_element.tag, {attributes[0]: str(stray_text)})
        messages.warn("mechanics-unread", message, element.sourceline, hint=hint)
    messages.owner = ("robot", "")


def report_xacro(messages: Messages, element: Any) -> bool:
    """Return True, after a message, if an element is one of xacro that was not expanded."""
    tag, line = element.tag, element.sourceline
    if is_xacro(element):
        instruction = plain(tag).rpartition(":")[2]
        message = f"xacro did not expand <xacro:{instruction}>, which is left out"
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
    bare_tag, namespace = split_tag(child.tag)
    if harmless.is_harmless_child(parent, bare_tag, namespace.strip("{}:")):
        return "harmless"
    if not namespace and _is_misspelt(bare_tag, tuple(sorted(readable))):
        return "misspelt"
    return "harmless" if _is_default(child) else "mechanics"


def _is_default(element: Any) -> bool:
    """Return True if all that an element and its children say holds without them."""
    bare_tag = split_tag(element.tag)[0]
    children = list(element.iterchildren("*"))
    element_text = " ".join(element.xpath("text()")).strip()
    statements = [
        (bare_tag if attribute_name == "value" else attribute_name, attribute_text)
        for attribute_name, attribute_text in element.items()
    ]
    statements += [(bare_tag, element_text)] if element_text else []
    if not statements and not children:
        return False
    return all(harmless.is_default(*statement) for statement in statements) and all(
        map(_is_default, children)
    )


@cache  # a name that is not read is in most elements of its kind
def _is_misspelt(unknown_name: str, readable_names: tuple[str, ...]) -> bool:
    """Return True if a name is nearly a readable one."""
    if unknown_name.lower() in PLACES:
        return False
    if unknown_name.lower() in readable_names:  # in capital letters
        return True
    from difflib import get_close_matches

    return bool(get_close_matches(unknown_name, readable_names, n=1, cutoff=SIMILARITY))


def _suggest_remedy(unread_names: list[str], parent: str) -> str | None:
    """Return a hint: what to write in place of names that are not read."""
    if "quat_xyzw" in unread_names:
        return 'quat_xyzw is read if the file says <robot version="1.1">; else write rpy'
    lower_names = {split_tag(unread_name)[0].lower() for unread_name in unread_names}
    if not PLACES.isdisjoint(lower_names) and parent in HAVE_ORIGIN:
        return HINT_PLACE
    if not {"unit", "units"}.isdisjoint(lower_names):
        return HINT_UNIT
    if parent not in ELEMENTS:
        return None
    attributes = [
        unread_name for unread_name in unread_names if unread_name in ELEMENTS[parent].attributes
    ]
    return suggest_attributes(parent, dict.fromkeys(attributes, "...")) if attributes else None


def _write_name(element: Any, qualified_name: str) -> str:
    """Return a tag or attribute as the file writes it, with its prefix."""
    bare_name, namespace = split_tag(qualified_name)
    if not namespace.startswith("{"):
        return qualified_name
    prefixes = (
        prefix
        for prefix, namespace_uri in element.nsmap.items()
        if namespace_uri == namespace[1:-1]
    )
    prefix = next(filter(None, prefixes), None)
    return f"{prefix}:{bare_name}" if prefix else bare_name
