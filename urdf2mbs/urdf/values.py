"""The values of URDF's attributes: names, numbers, vectors, origins."""

from __future__ import annotations

import re
from contextlib import suppress
from math import isfinite, nan
from typing import TYPE_CHECKING, Any, NoReturn

from lxml import etree

from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.spatial import ZERO, from_quaternion, to_xyz_angles, transpose
from urdf2mbs.urdf import xml
from urdf2mbs.urdf.elements import (
    ELEMENTS,
    TEXT,
    is_drake,
    quote,
    split_tag,
    suggest_attributes,
)
from urdf2mbs.urdf.messages import Messages
from urdf2mbs.urdf.model import Origin
from urdf2mbs.urdf.unread import report_unknown_attributes, report_unknown_children

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

NO_ORIGIN = Origin()
#: Commas between numbers: a blank follows each, or the text has no blank.
_COMMAS = r"\s*[^\s,]+(?:(?:,\s+[^\s,]+)+|(?:,[^\s,]+)+)\s*"


class Reading(Messages):
    """One URDF file being read: its values, and the messages about it.

    In all methods, ``element`` is an element of lxml.
    """

    def __init__(self, file: str, expanded: Sequence[str]) -> None:
        super().__init__(file, expanded)
        self.colourless: set[str] = set()
        """Materials whose colour could not be read, for which there is a warning."""
        self.quaternions = False
        """True if the file's version has ``quat_xyzw``; urdfdom ignores it in older versions."""

    def xml(self, data: bytes) -> Any:
        """Return the root element of an XML text, and warn of the slips in it."""
        root_element, slips = xml.parse(data, self.file)
        for slip in slips:
            self.warn(slip.code, slip.message, slip.line)
        return root_element

    def name(self, element: Any, kind: str, taken: Mapping[str, Any]) -> str | None:
        """Return the ``name`` of a link or joint, which must be unique among its kind.

        Args:
            element: The ``<link>`` or ``<joint>``.
            kind: Its tag.
            taken: The links or joints that were read before, by name.

        Returns:
            None, after a warning, for an element that repeats another one word for word.

        Raises:
            ConversionError: ``name-missing`` or ``name-doubled``.
        """
        name: str | None = element.get("name")
        stripped_name = name.strip() if name else ""
        if not name or not stripped_name:
            hint = f"every <{kind}> needs a name of its own"
            self.fail("name-missing", f"a {kind} without a name", element, hint)
        self.owner = (kind, name)
        if name != stripped_name:
            message = "the name begins or ends with a blank, which is kept"
            self.warn("name-blank", message, element.sourceline)
        if name in taken:
            siblings = element.getparent().iterchildren(kind)
            first_sibling = next(sibling for sibling in siblings if sibling.get("name") == name)
            if _write_canonically(first_sibling) == _write_canonically(element):
                self.warn_of_double("robot", element)
                return None
            message = f"two {kind}s are called '{name}'; the first is in line {taken[name].line}"
            self.fail("name-doubled", message, element, f"give one of the {kind}s another name")
        return name

    def parts(self, element: Any) -> dict[str, Any]:
        """Return the children of an element by tag, the first of each; report the others."""
        tag = element.tag
        readable = ELEMENTS[tag].children
        children_by_tag: dict[str, Any] = {}
        unknown_children: list[Any] = []
        for child in element[:]:  # faster than its iterator
            child_tag = child.tag
            if child_tag not in readable:
                unknown_children.append(child)
            elif child_tag in children_by_tag:
                self.warn_of_double(tag, child)
            else:
                children_by_tag[child_tag] = child
        if unknown_children:
            self.unknown_children(tag, unknown_children, readable)
        return children_by_tag

    def values(self, element: Any, lenient: str = "") -> dict[str, Any]:
        """Return the attributes that an element states, by ``ELEMENTS``; report the others.

        Args:
            element: The element.
            lenient: What a message calls a number that cannot be read, whose value is None; if
                empty, such a number is an error.

        Raises:
            ConversionError: A number is missing, or cannot be read.
        """
        tag = element.tag
        counts_by_attribute, required, children, _ = ELEMENTS[tag]
        values: dict[str, Any] = {}
        stated_attributes: list[tuple[str, str]] = element.items()
        for attribute, attribute_text in stated_attributes:
            name = attribute
            if name not in counts_by_attribute:
                name = split_tag(name)[0]
                if not is_drake(attribute) or name not in counts_by_attribute:
                    continue
            try:
                values[name] = self._convert(
                    element, name, attribute_text, counts_by_attribute[name]
                )
            except ConversionError as error:
                if not lenient:
                    raise
                self.warn_of_left_out(element, lenient, error)
                values[name] = None
        if len(values) < len(stated_attributes):
            self.unknown_attributes(element)
        if len(element) and not children:
            self.unknown_children(tag, element, ())
        for name in required:
            if name not in values:
                self.fail_number(element, name, None, counts_by_attribute[name])
        return values

    def _convert(self, element: Any, attribute: str, attribute_text: str, n_numbers: int) -> Any:
        """Return the value of an attribute: a text, a number, or several."""
        if n_numbers == TEXT:
            return attribute_text
        if n_numbers == 1:
            return self.number(element, attribute, attribute_text)
        return self.numbers(element, attribute, attribute_text, n_numbers)

    def number(self, element: Any, attribute: str, attribute_text: str) -> float:
        """Return a finite number.

        Raises:
            ConversionError: ``number-missing``, ``number-invalid``, ``number-count`` or
                ``xacro-unexpanded``.
        """
        try:
            value = float(attribute_text)
        except ValueError:
            value = nan
        if not (attribute_text.isascii() and isfinite(value)) or "_" in attribute_text:
            self.fail_number(element, attribute, attribute_text, 1)
        return value

    def numbers(
        self, element: Any, attribute: str, attribute_text: str, n_numbers: int
    ) -> tuple[float, ...]:
        """Return ``n_numbers`` finite numbers; raise as ``number`` does."""
        if attribute_text.isascii() and "_" not in attribute_text:
            try:
                values = tuple(map(float, attribute_text.split()))
            except ValueError:
                values = ()
            if len(values) == n_numbers and all(map(isfinite, values)):
                return values
            if attribute == "rpy" and len(values) > n_numbers and not any(values[n_numbers:]):
                message = (
                    "rpy has zeros after its three numbers, which are left out, as Bullet does"
                )
                self.warn("number-zeros", message, element.sourceline)
                return values[:n_numbers]
        if attribute_text.count(",") == n_numbers - 1 > 0 and re.fullmatch(_COMMAS, attribute_text):
            message = "numbers are separated by commas, which are read as blanks"
            self.warn("number-commas", message, element.sourceline)
            return self.numbers(element, attribute, attribute_text.replace(",", " "), n_numbers)
        return self.fail_number(element, attribute, attribute_text, n_numbers)

    def fail_number(
        self, element: Any, attribute: str, attribute_text: str | None, n_numbers: int
    ) -> NoReturn:
        """Raise the error for an attribute that does not have ``n_numbers`` numbers."""
        expected = "a number" if n_numbers == 1 else f"{n_numbers} numbers"
        subject = f"{self.where}: {attribute} of <{element.tag}>"
        if attribute_text is None or not attribute_text.strip():
            text_in_element = element.findtext(attribute) or element.text or ""
            hint = f"give {expected}"
            if text_in_element.strip():  # as in SDF
                hint = suggest_attributes(element.tag, {attribute: text_in_element})
            self.fail("number-missing", f"{subject} is missing", element, hint)
        self.check_expanded(element, attribute, attribute_text)
        for word in attribute_text.split() if attribute_text.isascii() else [attribute_text]:
            value = None
            with suppress(ValueError):
                value = float(word) if word.isascii() and "_" not in word else None
            if value is None:
                fault = f"{quote(word)} is not a number"
                hint = (
                    _suggest_without_commas(attribute_text, n_numbers) or "write it as 1.5 or -2e-3"
                )
            elif not isfinite(value):
                fault, hint = "numbers must be finite", f"give {expected}"
            else:
                continue
            self.fail(
                "number-invalid",
                f"{subject} is {quote(attribute_text)}: {fault}",
                element,
                hint,
            )
        n_stated = len(attribute_text.split())
        message = f"{subject} is {quote(attribute_text)}: expected {expected}, got {n_stated}"
        hint = f"give {expected}" + (", with blanks between them" if n_numbers > 1 else "")
        self.fail("number-count", message, element, hint)

    def check_expanded(self, element: Any, attribute: str, attribute_text: str) -> None:
        """Raise ConversionError if xacro has left an expression in a text."""
        if "${" in attribute_text or "$(" in attribute_text:
            message = f"{attribute}={quote(attribute_text)} of {self.where} was left by xacro"
            self.fail("xacro-unexpanded", message, element)

    def origin(self, element: Any) -> Origin:
        """Return an ``<origin>`` (m, rad), where URDF 1.1 permits a quaternion, too.

        Raises:
            ConversionError: A number cannot be read, or the rotation is stated twice.
        """
        if element is None:
            return NO_ORIGIN
        quaternion = element.get("quat_xyzw") if self.quaternions else None
        if quaternion is None:
            stated_values = self.values(element)
            return Origin(stated_values.get("xyz", ZERO), stated_values.get("rpy", ZERO))
        self.unknown_attributes(element, also_read=("quat_xyzw",))
        self.unknown_children("origin", element, ())
        x, y, z, w = self.numbers(element, "quat_xyzw", quaternion, 4)
        fault = "" if element.get("rpy") is None else "<origin> has both rpy and quat_xyzw"
        fault = fault if any((x, y, z, w)) else "quat_xyzw of <origin> is zero"
        if fault:
            hint = "give a rotation, and give it once"
            self.fail("number-invalid", f"{self.where}: {fault}", element, hint)
        # R = Rz Ry Rx is the inverse of Rx Ry Rz by the negative angles
        roll, pitch, yaw = to_xyz_angles(transpose(from_quaternion(x, y, z, w)))
        x, y, z = self.numbers(element, "xyz", element.get("xyz", "0 0 0"), 3)
        return Origin((x, y, z), (-roll, -pitch, -yaw))

    def unknown_attributes(self, element: Any, also_read: Iterable[str] = ()) -> None:
        """Report the attributes of an element that are not read."""
        report_unknown_attributes(self, element, also_read)

    def unknown_children(
        self, parent: str, children: Iterable[Any], readable: Iterable[str]
    ) -> None:
        """Report the children of an element that are not read.

        Args:
            parent: The tag of their parent.
            children: The elements of lxml; comments are passed over.
            readable: The tags that are read in this parent.
        """
        report_unknown_children(self, parent, children, readable)

    def warn_of_double(self, parent: str, child: Any) -> None:
        """Warn that an element is there twice, and only the first is used."""
        message = f"more than one <{child.tag}> in <{parent}>: only the first is used"
        self.warn("doubled-element", message, child.sourceline)

    def warn_of_left_out(self, element: Any, subject: str, error: ConversionError) -> None:
        """Warn that something is left out: it cannot be read, and the .mbs does not need it."""
        detail = error.message.partition(f"{self.where}: ")[2] or error.message
        message = f"{subject} is left out, as it cannot be read"
        self.warn("number-left-out", message, element.sourceline, detail=detail)


def _write_canonically(element: Any) -> bytes:
    """Return an element in canonical XML, without comments and without blanks around texts."""
    options: dict[str, Any] = {"method": "c14n2", "strip_text": True, "with_comments": False}
    canonical_xml: bytes = etree.tostring(element, with_tail=False, **options)
    return canonical_xml


def _suggest_without_commas(attribute_text: str, n_numbers: int) -> str | None:
    """Return a hint about commas in numbers."""
    if "," not in attribute_text:
        return None
    if n_numbers > 1 and len(attribute_text.replace(",", " ").split()) == n_numbers:
        return "numbers are separated by blanks, not commas"
    return "write decimals with a point"
