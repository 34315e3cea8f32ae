"""Read any .mbs file into the model.

Elements and attributes that the model does not have are ignored, as Robotran does; each object
refers to its element, so that a writer that changes the file keeps them.  A fault that Robotran
ignores silently, to compute another robot, is an error here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lxml import etree

from urdf2mbs.disk import files
from urdf2mbs.disk.xml import (
    BLANK,
    check_conflict,
    check_entities,
    raise_syntax_error,
    safe_parser,
)
from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, OBJECTS, Field, Kind, ObjectType, Table
from urdf2mbs.mbs.model import BASE, ORIGIN, Part, SourceElement
from urdf2mbs.mbs.values import ValueReader
from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO

if TYPE_CHECKING:
    from lxml.etree import _Element

_GRAPHICS = frozenset(["graphics", "x3D"])
_PLACE = list(INSIDE["place"])


def read_mbs(data: bytes, file: str, *, mechanics_only: bool = False) -> model.Mbs:
    """Read the content of an .mbs file.

    Args:
        data: The content.
        file: The name of the file, for messages.
        mechanics_only: True to ignore all graphics, which take a third of the time.

    Raises:
        ConversionError: With the line: the content is not XML, or has another root; it has no base
            or body tree; a body has no joint; a parent, point or joint is unknown, or comes later
            in the file; a word is unknown; a number is not one; a name is used twice.
    """
    return _Reader(data, file, mechanics_only=mechanics_only).read_model(_parse(data, file))


def read_mbs_file(file: Path) -> model.Mbs:
    """Read an .mbs file, or standard input for ``-``.

    Raises:
        ConversionError: The file cannot be read, or is not an .mbs; see ``read_mbs``.
    """
    file_name = files.STDIN if str(file) == "-" else str(file)
    return read_mbs(files.read_model(file), file_name)


def read_mbs_again(source: bytes) -> tuple[model.Mbs, list[_Element]]:
    """Read the content of a file that was read before, with its elements.

    Returns:
        The model, and the elements of its objects, by the numbers of their ``SourceElement``.
        Their tree is the whole file, white space included.
    """
    reader = _Reader(source, "")
    return reader.read_model(_parse(source, "", remove_blank_text=False)), reader.elements


def _parse(data: bytes, file: str, *, remove_blank_text: bool = True) -> _Element:
    """Parse the XML of an .mbs file, and return the root."""
    if not data.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    parser = safe_parser(collect_ids=False, remove_blank_text=remove_blank_text)
    try:
        root: _Element = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        error_log: Any = parser.error_log
        raise_syntax_error(
            data, file, error, list(error_log), "an .mbs file begins with <?xml ...?>"
        )
    check_conflict(data, file)  # Robotran would read the elements of both versions
    check_entities(root, file)
    return root


class _Reader(ValueReader):
    """Reads the objects of one file, in the order of the tables of ``fields``."""

    def __init__(self, data: bytes, file: str, *, mechanics_only: bool = False) -> None:
        super().__init__(data, file)
        self.mechanics_only = mechanics_only
        self.names: dict[tuple[str, str], str] = {
            ("body", BASE): "the ground",
            ("body", ORIGIN): "a body's own frame",
        }
        """A label for messages of each named object, by its kind and its name."""
        self.elements: list[_Element] = []
        """The elements of the objects, by the numbers of their ``SourceElement``."""
        self.owner: str | None = None
        """The body whose points are read; None for the base."""
        self.points: dict[str | None, set[str]] = {None: set()}
        """The names of the points of the base and of each body that was read."""

    def read_model(self, root: _Element) -> model.Mbs:
        """Return the model of a file, from its root."""
        if root.tag != "mbsDescR7":
            self.fail(root, "not-mbs", f"the root element is <{root.tag}>; expected <mbsDescR7>")
        mbs_model: model.Mbs = self.read_object("mbs", root)
        return mbs_model

    def make_origin(self, element: _Element) -> SourceElement | None:
        """Return the source of an object; None without graphics, which a writer could not keep."""
        if self.mechanics_only:
            return None
        self.elements.append(element)
        return SourceElement(self.data, len(self.elements) - 1)

    # --- objects ---

    def read_object(self, object_key: str, element: _Element) -> Any:
        """Return one of the ``OBJECTS``; None for a drawing of an empty element."""
        if object_key == "drawing" and not len(element):
            return None
        object_type = OBJECTS[object_key]
        mbs_object: Any = object_type.make(object_key)
        if isinstance(mbs_object, Part):
            mbs_object.origin = self.make_origin(element)
        self.read_children(mbs_object, object_type, object_type.table, element)
        if object_key in _CHECKS:
            _CHECKS[object_key](self, mbs_object, element)
        return mbs_object

    def read_children(
        self, mbs_object: Any, object_type: ObjectType, table: Table, element: _Element
    ) -> None:
        """Give an object the values of an element's children, in the order of the table.

        Args:
            mbs_object: The object.
            object_type: Its type.
            table: The table of the element; of the type, or inside of that.
            element: The element.
        """
        children = self.group_children(element, table)
        for tag, field_or_table in table.items():
            elements = children.get(tag)
            if elements is None:
                if tag == object_type.name_tag or tag in object_type.required:
                    self.fail_missing(element, tag, object_type, mbs_object)
            elif tag == object_type.name_tag:
                mbs_object.name = self.read_name(elements[0], object_type.noun)
            elif isinstance(field_or_table, Field):
                setattr(
                    mbs_object,
                    field_or_table.attribute,
                    self.read_field(tag, field_or_table.kind, elements),
                )
            elif field_or_table is not None and not (self.mechanics_only and tag in _GRAPHICS):
                self.read_children(mbs_object, object_type, field_or_table, elements[0])

    def read_field(self, tag: str, kind: Kind | frozenset[str], elements: list[_Element]) -> Any:
        """Return the value of a kind from the elements of a tag."""
        if not isinstance(kind, str):
            return [
                self.read_object(child.tag, child) for child in elements[0] if child.tag in kind
            ]
        if kind == "parts":
            return [self.read_object(tag, element) for element in elements]
        if kind == "texts":
            return tuple(map(self.read_text, elements))
        if kind in OBJECTS:
            return self.read_object(kind, elements[0])
        return _VALUE_READERS[kind](self, elements[0])

    def read_name(self, element: _Element, noun: str) -> str:
        """Return the name of an object, and claim it for names that must be unique."""
        name, parent = self.read_text(element), element.getparent()
        if not name:
            self.fail_name(parent, noun)
        if noun in ("body", "joint", "point"):
            self.check_first(element)
        if noun in ("body", "joint"):
            self.claim_name(parent, name, noun)
        if noun == "body":
            self.owner = name
        return name

    def claim_name(self, element: Any, name: str, name_kind: str) -> None:
        """Fail if an object of this kind has the name; else it is used from here on.

        Objects of different kinds may have one name: Robotran's own CoMan has such joints and
        bodies.
        """
        owner = self.names.get((name_kind, name))
        if owner is not None:
            self.fail(
                element,
                "name-doubled",
                f"the name '{name}' of this {name_kind} is already that of {owner}",
                "Robotran drops the second of two silently: rename one",
            )
        self.names[name_kind, name] = f"an earlier {name_kind}"

    def read_sensor(self, element: _Element) -> model.Sensor:
        """Return a sensor or an external force, from its attributes."""
        sensor_name = element.get("name", "").strip()
        if not sensor_name:
            self.fail_name(element, f"<{element.tag}>")
        self.claim_name(element, sensor_name, element.tag)
        attributes: Any = element.items()
        measures = []
        for measure, attribute_value in attributes:
            if measure in model.SENSOR_MEASURES:
                if attribute_value != "true":
                    message = (
                        f"{element.tag} '{sensor_name}': {measure} is '{attribute_value}'; "
                        "expected 'true'"
                    )
                    hint = f"write 'true', or leave {measure} out"
                    self.fail(element, "value-unknown", message, hint)
                measures.append(measure)
        return model.Sensor(sensor_name, tuple(measures), origin=self.make_origin(element))

    # --- checks of an object that was read ---

    def check_base(self, base: model.Base, _: _Element) -> None:
        """Name the base, and claim its name."""
        base.name = base.name or BASE
        self.names.setdefault(("body", base.name), "the base")

    def check_body(self, body: model.Body, element: _Element) -> None:
        """Fail if a body has no joint."""
        self.points.setdefault(body.name, set())
        if not body.joints:
            self.fail(
                element,
                "body-without-joint",
                f"body '{body.name}' has no joint",
                "Robotran would drop it: give it one, driven and at 0, if it is to be fixed",
            )

    def check_joint(self, joint: model.Joint, element: _Element) -> None:
        """Fail if the type or the nature of a joint is unknown."""
        for tag, stated_word, allowed_words, code in (
            ("type", joint.type, model.JOINT_TYPES, "joint-type-unknown"),
            ("nature", joint.nature, model.NATURES, "joint-nature-unknown"),
        ):
            if stated_word not in allowed_words:
                child = element.find(tag)
                expected = ", ".join(sorted(allowed_words))
                message = (
                    f"joint '{joint.name}': {tag} is '{stated_word}'; expected one of {expected}"
                )
                self.fail(element if child is None else child, code, message)

    def check_point(self, point: model.Point, element: _Element) -> None:
        """Fail if a point has the name of another, or is an impossible point of the base."""
        point_names = self.points.setdefault(self.owner, set())
        owner_label = _describe_owner(self.owner)
        if point.name in point_names or (self.owner is None and point.name == ORIGIN):
            self.fail(element, "name-doubled", f"{owner_label} has two points '{point.name}'")
        if point.name == ORIGIN and point.coordinates != ZERO:
            self.fail(
                element,
                "origin-moved",
                f"the point 'origin' of {owner_label} is not at 0 0 0",
                "'origin' is the body's own frame: give the point another name",
            )
        if self.owner is None and (point.sensor is not None or point.extforce is not None):
            self.fail(
                element,
                "base-sensor",
                f"point '{point.name}' of the base has a sensor or an external force",
                "Robotran's C library overruns its memory: put it on a body",
            )
        point_names.add(point.name)

    def check_user_constraint(self, constraint: model.UserConstraint, element: _Element) -> None:
        """Fail if a user constraint refers to a joint that does not exist."""
        for child, joint_name in zip(element.iter("jointname"), constraint.joints, strict=False):
            if ("joint", joint_name) not in self.names:
                joint_names = [
                    joint_candidate
                    for name_kind, joint_candidate in self.names
                    if name_kind == "joint"
                ]
                message = (
                    f"user constraint '{constraint.name}' refers to joint '{joint_name}', "
                    "which does not exist"
                )
                self.fail(child, "joint-unknown", message, nearest(joint_name, joint_names))

    # --- places ---

    def read_place(self, element: _Element) -> tuple[str | None, str | None]:
        """Return a body and one of its points, which both come earlier in the file."""
        body_name, point_name = [
            "" if child is None else self.read_text(child)
            for child in self.find_children(element, _PLACE)
        ]
        if element.tag != "parent" and "" in (body_name, point_name):
            return body_name, point_name  # a draft, in which one of the two is not chosen yet
        place_body = None if body_name == BASE else body_name
        place_point = None if point_name == ORIGIN else point_name
        if place_body is not None and place_body not in self.points:
            self.fail_body(element, place_body)
        if place_point is not None and place_point not in self.points[place_body]:
            place_label, _ = self.describe_place(element)
            owner_label = _describe_owner(place_body)
            self.fail(
                element,
                "point-unknown",
                f"{place_label} is point '{place_point}', which {owner_label} does not have",
                nearest(place_point, [ORIGIN, *self.points[place_body]]),
            )
        return place_body, place_point

    def fail_body(self, element: _Element, body_name: str) -> NoReturn:
        """Fail since no body before this element has this name."""
        place_label, owner_name = self.describe_place(element)
        if element.tag == "parent" and body_name == owner_name:
            self.fail(element, "parent-unknown", f"body '{owner_name}' is its own parent")
        elements = element.getroottree().iterfind("bodytree/body/bodyname")
        body_names = [self.read_text(name_element) for name_element in elements]
        if body_name in body_names:
            self.fail(
                element,
                "parent-order",
                f"{place_label}, '{body_name}', comes later in the file",
                "a body must come after its parent",
            )
        message = f"{place_label} is '{body_name}', which does not exist"
        self.fail(element, "parent-unknown", message, nearest(body_name, [BASE, *body_names]))

    def describe_place(self, element: _Element) -> tuple[str, str]:
        """Return what a place is, for messages, and the name of its body, cut or link."""
        owner: Any = element.getparent()
        owner_name = self.read_text(owner.find("bodyname" if owner.tag == "body" else "name"))
        article = "the " if owner.tag == "body" else ""
        return f"{article}{element.tag} of {owner.tag} '{owner_name}'", owner_name

    # --- errors ---

    def fail_missing(
        self, element: _Element, tag: str, object_type: ObjectType, mbs_object: Any
    ) -> NoReturn:
        """Fail since an element lacks a child that is required."""
        if object_type.name_tag and not mbs_object.name:
            self.fail_name(element, object_type.noun)
        code = "parent-missing" if tag == "parent" else "mbs-incomplete"
        self.fail(element, code, f"{object_type.describe(mbs_object)} has no <{tag}>")

    def fail_name(self, element: Any, noun: str) -> NoReturn:
        """Fail since an object has no name."""
        self.fail(element, "name-missing", f"this {noun} has no name")


def _describe_owner(body_name: str | None) -> str:
    """Return the body or the base, for messages."""
    return "the base" if body_name is None else f"body '{body_name}'"


#: The function that reads a value of each kind.
_VALUE_READERS: dict[str, Callable[[_Reader, _Element], Any]] = {
    "text": _Reader.read_text,
    "title": _Reader.read_text,
    "word": _Reader.read_word,
    "number": _Reader.read_number,
    "flag": _Reader.read_flag,
    "color": _Reader.read_color,
    "xy": _Reader.read_xy,
    "xyz": _Reader.read_xyz,
    "coordinates": _Reader.read_coordinates,
    "control_points": _Reader.read_control_points,
    "inertia": _Reader.read_inertia,
    "symbols": _Reader.read_symbols,
    "place": _Reader.read_place,
    "sensor": _Reader.read_sensor,
}
#: The function that checks an object of each type.
_CHECKS: dict[str, Callable[[_Reader, Any, _Element], None]] = {
    "base": _Reader.check_base,
    "body": _Reader.check_body,
    "joint": _Reader.check_joint,
    "point": _Reader.check_point,
    "user_constraint": _Reader.check_user_constraint,
}
