"""The values of URDF's attributes: names, numbers, vectors, origins."""

from __future__ import annotations

import re
from contextlib import suppress
from math import isfinite, nan
from typing import TYPE_CHECKING, Any, NoReturn

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.spatial import ZERO, from_quaternion, to_xyz_angles, transpose
from urdf2mbs.urdf.elements import (
    ATTRIBUTES,
    LEAVES,
    REQUIRED,
    Elements,
    is_drake,
    quote,
    split_tag,
    suggest_attributes,
)
from urdf2mbs.urdf.model import Origin

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


NO_ORIGIN = Origin()
#: Commas between numbers: a blank follows each, or the text has no blank.
_COMMAS = r"\s*[^\s,]+(?:(?:,\s+[^\s,]+)+|(?:,[^\s,]+)+)\s*"


class Reading(Elements):
    """One URDF file being read: its messages, its XML and its values."""

    def __init__(self, file: str, expanded: Sequence[str]) -> None:
        super().__init__(file, expanded)
        self.colourless: set[str] = set()
        """Materials whose colour could not be read; a warning has said so."""
        self.quaternions = False
        """True if the file's version has ``quat_xyzw``; urdfdom ignores it in older versions."""

    def name(self, element: Any, kind: str, taken: Mapping[str, Any]) -> str | None:
        """The ``name`` of a link or joint: there must be a name, and only once.

        None for an element that repeats another element of that name word for word.
        """
        name: str | None = element.get("name")
        bare = name.strip() if name else ""
        if not name or not bare:
            hint = f"every <{kind}> needs a name of its own"
            self.fail("name-missing", f"a {kind} without a name", element, hint)
        self.owner = (kind, name)
        if name != bare:
            what = "the name begins or ends with a blank, which is kept"
            self.warn("name-blank", what, element.sourceline)
        if name in taken:
            named = (
                one for one in element.getparent().iterchildren(kind) if one.get("name") == name
            )
            if _write_plainly(next(named)) == _write_plainly(element):
                self.warn_of_double("robot", element)
                return None
            what = f"two {kind}s are called '{name}'; the first is in line {taken[name].line}"
            self.fail("name-doubled", what, element, f"give one of the {kind}s another name")
        return name

    def text(self, element: Any, attribute: str, text: str) -> None:
        if "${" in text or "$(" in text:
            what = f"{attribute}={quote(text)} of {self.where} was left by xacro"
            self.fail("xacro-unexpanded", what, element)

    def values(self, element: Any, lenient: str = "") -> dict[str, Any]:
        """Return the attributes that an element states, by ``ATTRIBUTES``; report the others.

        Args:
            element: The element of lxml.
            lenient: What a message calls a number that cannot be read, whose value is None; if
                empty, such a number is an error.

        Raises:
            ConversionError: A number is missing, or cannot be read.
        """
        tag = element.tag
        known = ATTRIBUTES[tag]
        values: dict[str, Any] = {}
        stated: list[tuple[str, str]] = element.items()
        for attribute, text in stated:
            name, count = attribute, known.get(attribute)
            if count is None and is_drake(attribute):
                name = split_tag(attribute)[0]
                count = known.get(name)
            try:
                if count == 1:
                    values[name] = self.number(element, name, text)
                elif count:
                    values[name] = self.numbers(element, name, text, count)
                elif count is not None:
                    values[name] = text
            except ConversionError as error:
                if not lenient:
                    raise
                self.warn_of_left_out(element, lenient, error)
                values[name] = None
        if len(values) < len(stated):
            self.unknown_attributes(element)
        if len(element) and tag in LEAVES:
            self.unknown_children(tag, element, ())
        for name in REQUIRED.get(tag, ()):
            if name not in values:
                self.bad_number(element, name, None, known[name])
        return values

    def number(self, element: Any, attribute: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = nan
        if not (text.isascii() and isfinite(value)) or "_" in text:
            self.bad_number(element, attribute, text, 1)
        return value

    def numbers(self, element: Any, attribute: str, text: str, count: int) -> tuple[float, ...]:
        if text.isascii() and "_" not in text:
            try:
                values = tuple(map(float, text.split()))
            except ValueError:
                values = ()
            if len(values) == count and all(map(isfinite, values)):
                return values
            if attribute == "rpy" and len(values) > count and not any(values[count:]):
                what = "rpy has zeros behind its three numbers, which are left out, as Bullet does"
                self.warn("number-zeros", what, element.sourceline)
                return values[:count]
        if text.count(",") == count - 1 > 0 and re.fullmatch(_COMMAS, text):
            self.warn("number-commas", "numbers are parted by commas", element.sourceline)
            return self.numbers(element, attribute, text.replace(",", " "), count)
        return self.bad_number(element, attribute, text, count)

    def bad_number(self, element: Any, attribute: str, text: str | None, count: int) -> NoReturn:
        """Raise the error for an attribute that has not as many numbers as expected."""
        wanted = "a number" if count == 1 else f"{count} numbers"
        what = f"{self.where}: {attribute} of <{element.tag}>"
        if text is None or not text.strip():
            written = element.findtext(attribute) or element.text or ""
            hint = f"give {wanted}"
            if written.strip():  # as in SDF
                hint = suggest_attributes(element.tag, {attribute: written})
            self.fail("number-missing", f"{what} is missing", element, hint)
        self.text(element, attribute, text)
        for word in text.split() if text.isascii() else [text]:
            value = None
            with suppress(ValueError):
                value = float(word) if word.isascii() and "_" not in word else None
            if value is None:
                fault = f"{quote(word)} is not a number"
                hint = _comma_hint(text, count) or "write it as 1.5 or -2e-3"
            elif not isfinite(value):
                fault, hint = "numbers must be finite", f"give {wanted}"
            else:
                continue
            self.fail("number-invalid", f"{what} is {quote(text)}: {fault}", element, hint)
        self.fail(
            "number-count",
            f"{what} is {quote(text)}: {wanted} wanted, {len(text.split())} given",
            element,
            f"give {wanted}" + (", with blanks between them" if count > 1 else ""),
        )

    def warn_of_left_out(self, element: Any, what: str, error: ConversionError) -> None:
        """Warn that something is left out: it cannot be read, and the .mbs does not need it."""
        reason = error.message.partition(f"{self.where}: ")[2] or error.message
        self.warn(
            "number-left-out", f"{what} is left out, as it cannot be read", element.sourceline,
            detail=reason,
        )  # fmt: skip

    def origin(self, element: Any) -> Origin:
        """Return an ``<origin>`` (m, rad), where URDF 1.1 permits a quaternion, too.

        Raises:
            ConversionError: A number cannot be read, or the rotation is stated twice.
        """
        if element is None:
            return NO_ORIGIN
        quaternion = element.get("quat_xyzw") if self.quaternions else None
        if quaternion is None:
            stated = self.values(element)
            return Origin(stated.get("xyz", ZERO), stated.get("rpy", ZERO))
        self.unknown_attributes(element, also_read=("quat_xyzw",))
        self.unknown_children("origin", element, ())
        turn = self.numbers(element, "quat_xyzw", quaternion, 4)
        fault = "" if element.get("rpy") is None else "<origin> has both rpy and quat_xyzw"
        fault = fault if any(turn) else "quat_xyzw of <origin> is zero"
        if fault:
            hint = "give a rotation, and give it once"
            self.fail("number-invalid", f"{self.where}: {fault}", element, hint)
        # R = Rz Ry Rx is the inverse of Rx Ry Rz by the negative angles
        roll, pitch, yaw = to_xyz_angles(transpose(from_quaternion(*turn)))
        x, y, z = self.numbers(element, "xyz", element.get("xyz", "0 0 0"), 3)
        return Origin((x, y, z), (-roll, -pitch, -yaw))


def _write_plainly(element: Any) -> bytes:
    """An element in canonical XML, without comments and without blanks around texts."""
    options: dict[str, Any] = {"method": "c14n2", "strip_text": True, "with_comments": False}
    text: bytes = etree.tostring(element, with_tail=False, **options)
    return text


def _comma_hint(text: str, count: int) -> str | None:
    """A hint about commas in numbers."""
    if "," not in text:
        return None
    if count > 1 and len(text.replace(",", " ").split()) == count:
        return "numbers are separated by blanks, not commas"
    return "write decimals with a point"
