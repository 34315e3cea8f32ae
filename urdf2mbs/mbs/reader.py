"""Read any .mbs file into the model.

Elements and attributes that the model has no place for are passed over, as Robotran does; each
object knows its element, so that the writer keeps them.  What makes Robotran itself go wrong,
mostly without a word, is an error here.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from math import isinf
from operator import attrgetter
from sys import intern
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from lxml import etree

from urdf2mbs.mbs.fields import BASE as BASE_TABLE
from urdf2mbs.mbs.fields import DRAWING, INSIDE, MBS, OBJECTS, REPEATED, VIEW, Table
from urdf2mbs.mbs.model import (
    BASE,
    CUTS,
    JOINT_TYPES,
    LINKS,
    NATURES,
    ORIGIN,
    SENSOR_MEASURES,
    XY,
    Base,
    Body,
    Drawing,
    Joint,
    Mbs,
    Origin,
    Point,
    Sensor,
    UserConstraint,
    View,
)
from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO, Sym, Vec
from urdf2mbs.xml import lines as xml_lines
from urdf2mbs.xml.errors import BLANK, check_conflict, check_entities, explain

if TYPE_CHECKING:
    from lxml.etree import _Element

    Children = dict[str, list[_Element]]

#: What must be the first child of an element: Robotran takes the first, whatever it is.
_FIRST = frozenset(["bodyname", "jointname", "pointname", "coordinates"])
#: What an element must have beside its name.
_REQUIRED = {
    "mbsDescR7": ("base", "bodytree"), "base": ("gravity",), "body": ("parent",),
    **dict.fromkeys((*CUTS, *LINKS), ("endpoint1", "endpoint2")),
}  # fmt: skip
_GRAPHICS = frozenset(["graphics", "x3D"])

_NUMBER = re.compile(r"\s*[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*").fullmatch
_TAG = attrgetter("tag")
_RGB = r"\s*[0-9]{1,3}\s*"


def read(data: bytes, file: str, *, mechanics_only: bool = False) -> Mbs:
    """The model of an .mbs file; ``file`` is its name, for messages.

    ``mechanics_only`` passes over all graphics, which takes a third of the time.

    Raises ConversionError, with the line: not XML, another root, no base or body tree, a
    body without a joint, an unknown parent, point or joint or one that stands later in the
    file, an unknown word, a number that is none, a name that is taken.
    """
    return _Reader(data, file, mechanics_only=mechanics_only).mbs(_parse(data, file))


def read_again(source: bytes) -> tuple[Mbs, list[_Element]]:
    """The model of a file that was read before, and the elements of its objects by the numbers of
    their origins; their tree has all that stands in the file."""
    reader = _Reader(source, "")
    return reader.mbs(_parse(source, "", remove_blank_text=False)), reader.elements


def _parse(data: bytes, file: str, *, remove_blank_text: bool = True) -> _Element:
    if not data.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    parser = xml_lines.parser(collect_ids=False, remove_blank_text=remove_blank_text)
    try:
        root: _Element = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        entries: Any = parser.error_log
        explain(data, file, error, list(entries), "an .mbs file begins with <?xml ...?>")
    check_conflict(data, file)  # Robotran reads what stands between the lines, from both versions
    check_entities(root, file)
    return root


Thing = TypeVar("Thing")


class _Reader:
    def __init__(self, data: bytes, file: str, *, mechanics_only: bool = False) -> None:
        self.data, self.file, self.mechanics_only = data, file, mechanics_only
        self.numbers: dict[str | None, float] = {}
        self.names: dict[tuple[str, str], str] = {
            ("body", BASE): "the ground", ("body", ORIGIN): "a body's own frame",
        }  # fmt: skip
        """The thing that has a name, in words, by kind and name."""
        self.elements: list[_Element] = []
        """Those of the objects, by the numbers of their origins."""
        self.owner: str | None = None
        """The body whose points are read; None is the base."""
        self.points: dict[str | None, set[str]] = {}
        """The points of each body read so far."""

    def mbs(self, root: _Element) -> Mbs:
        if root.tag != "mbsDescR7":
            self.fail(root, "not-mbs", f"the root of an .mbs file is <mbsDescR7>, not <{root.tag}>")
        kids = self.children(root, MBS, "the file")
        # what is referred to comes first
        kids = {tag: kids[tag] for tag in MBS if tag in kids}
        return self.fill(Mbs("", "", origin=self.origin(root)), kids, MBS)

    def base(self, element: _Element) -> Base:
        self.points[None] = set()
        base = self.fill(Base(""), self.children(element, BASE_TABLE, "the base"), BASE_TABLE)
        base.name = base.name or BASE
        self.names.setdefault(("body", base.name), "the base")
        return base

    def part(self, element: _Element) -> Any:
        """The object of an element, with all that stands in it."""
        make, table, what = OBJECTS[element.tag]
        part: Any = make(element.tag)
        kids = self.children(element, table)
        if what:
            tag = next(iter(table))
            part.name = self.name(element, kids, tag, what)
            del kids[tag]
            self.require(element, kids, f"{what} '{part.name}'")
        part.origin = self.origin(element)
        if what == "body":
            self.owner = part.name
        self.fill(part, kids, table)
        check = _CHECKS.get(what)
        if check is not None:
            check(self, part, element)
        return part

    def fill(self, thing: Thing, kids: Children, table: Table) -> Thing:
        """Give an object, or what belongs to it, the values of its elements."""
        for tag, found in kids.items():
            entry = table.get(tag)
            if entry is None or (self.mechanics_only and tag in _GRAPHICS):
                continue
            if not isinstance(entry, tuple):
                self.fill(thing, self.children(found[0], entry), entry)
                continue
            field, kind = entry
            read = _KINDS.get(kind)
            if read is not None:
                setattr(thing, field, read(self, found[0]))
            elif kind == "place":
                self.set_place(thing, field, found[0])
            elif kind == "parts":
                setattr(thing, field, list(map(self.part, found)))
            elif kind == "texts":
                setattr(thing, field, tuple(map(self.text, found)))
            elif isinstance(kind, frozenset):
                parts = [self.part(child) for child in found[0] if child.tag in kind]
                setattr(thing, field, parts)
        return thing

    # --- objects ---

    def check_body(self, body: Body, element: _Element) -> None:
        self.points.setdefault(body.name, set())
        if not body.joints:
            self.fail(
                element, "body-without-joint", f"body '{body.name}' has no joint",
                "Robotran would lose it: give it one, driven and at 0, if it is to be fixed",
            )  # fmt: skip

    def check_joint(self, joint: Joint, element: _Element) -> None:
        for tag, word, words, code, hint in (
            ("type", joint.type, JOINT_TYPES, "joint-type-unknown",
             "the types are T1 T2 T3 R1 R2 R3"),
            ("nature", joint.nature, NATURES, "joint-nature-unknown",
             "the natures are independent, dependent and driven"),
        ):  # fmt: skip
            if word not in words:
                at = element.find(tag)
                said = f"joint '{joint.name}' is of {tag} '{word}'"
                self.fail(element if at is None else at, code, said, hint)

    def check_point(self, point: Point, element: _Element) -> None:
        names = self.points.setdefault(self.owner, set())
        where = _where(self.owner)
        if point.name in names or (self.owner is None and point.name == ORIGIN):
            self.fail(element, "name-doubled", f"{where} has two points '{point.name}'")
        if point.name == ORIGIN and point.coordinates != ZERO:
            self.fail(
                element, "origin-moved", f"the point 'origin' of {where} is not at 0 0 0",
                "'origin' is the body's own frame: give the point another name",
            )  # fmt: skip
        if self.owner is None and (point.sensor is not None or point.extforce is not None):
            self.fail(
                element, "base-sensor",
                f"point '{point.name}' of the base has a sensor or an external force",
                "Robotran's C library overruns its memory: put it on a body",
            )  # fmt: skip
        names.add(point.name)

    def check_constraint(self, constraint: UserConstraint, element: _Element) -> None:
        for child, joint in zip(element.iter("jointname"), constraint.joints, strict=False):
            if ("joint", joint) not in self.names:
                self.fail(
                    child, "joint-unknown",
                    f"user constraint '{constraint.name}' is on '{joint}', and there is no such "
                    "joint",
                    nearest(joint, [name for kind, name in self.names if kind == "joint"]),
                )  # fmt: skip

    def set_place(self, thing: Any, field: str, element: _Element) -> None:
        if isinstance(thing, Body):
            what = f"the parent of body '{thing.name}'"
            thing.parent, thing.point = self.place(element, what, thing.name)
        else:
            what = f"{field} of {thing.kind} '{thing.name}'"
            setattr(thing, field, self.place(element, what))

    def place(
        self, element: _Element, what: str, of: str | None = None
    ) -> tuple[str | None, str | None]:
        """A body and one of its points, both known by now; ``of`` is the body that hangs on it."""
        parts = self.children(element, INSIDE["place"])
        body: str | None
        point: str | None
        body, point = [self.text(parts[tag][0]) if tag in parts else "" for tag in INSIDE["place"]]
        if of is None and "" in (body, point):
            return body, point  # a draft: who drew it has not chosen yet
        if body == BASE:
            body = None
        elif body not in self.points:
            if body == of:
                self.fail(element, "parent-unknown", f"body '{of}' is its own parent")
            later = [
                self.text(name) for name in element.getroottree().iterfind("bodytree/body/bodyname")
            ]
            if body in later:
                self.fail(
                    element, "parent-order", f"{what}, '{body}', stands later in the file",
                    "a body must stand after its parent",
                )  # fmt: skip
            self.fail(
                element, "parent-unknown", f"{what} is '{body}', and there is no such body",
                nearest(body or "", [BASE, *later]),
            )  # fmt: skip
        if point == ORIGIN:
            point = None
        elif point not in self.points[body]:
            self.fail(
                element, "point-unknown",
                f"{what} is point '{point}', and {_where(body)} has none such",
                nearest(point or "", [ORIGIN, *self.points[body]]),
            )  # fmt: skip
        return body, point

    def sensor(self, element: _Element) -> Sensor:
        name = element.get("name", "").strip()
        if not name:
            self.fail(element, "name-missing", f"this <{element.tag}> has no name")
        self.take(element, name, element.tag)
        measures = []
        attributes: Any = element.items()
        for measure, value in attributes:
            if measure not in SENSOR_MEASURES:
                continue
            if value != "true":
                self.fail(
                    element, "value-unknown", f"{measure} of {element.tag} '{name}' is '{value}'",
                    'it can be "true" or left out',
                )  # fmt: skip
            measures.append(measure)
        return Sensor(name, tuple(measures), origin=self.origin(element))

    # --- values ---

    def symbols(self, element: _Element) -> tuple[str, ...]:
        return tuple(tag for tag in self.children(element, INSIDE["symbols"])
                     if tag in INSIDE["symbols"])  # fmt: skip

    def color(self, element: _Element) -> tuple[int, int, int]:
        rgb = [element.get(part, "") for part in "RGB"]
        for text in rgb:
            if not re.fullmatch(_RGB, text) or int(text) > 255:
                self.fail(
                    element, "number-invalid", f"'{text}' is no part of a colour",
                    "R, G and B are whole numbers from 0 to 255",
                )  # fmt: skip
        return int(rgb[0]), int(rgb[1]), int(rgb[2])

    def inertia(self, element: _Element) -> Sym:
        parts = self.children(element, INSIDE["inertia"])
        xx, xy, xz, yy, yz, zz = [
            self.number(parts[tag][0]) if tag in parts else 0.0 for tag in INSIDE["inertia"]
        ]
        return (xx, xy, xz, yy, yz, zz)

    def coordinates(self, element: _Element) -> Vec:
        parts = self.children(element, INSIDE["coordinates"])
        if "coordinates" not in parts:
            self.fail(
                element, "mbs-incomplete", f"<{element.tag}> has no <coordinates>",
                "Robotran's C library cannot read it: give x, y and z, or leave the element out",
            )  # fmt: skip
        self.is_first(element, parts["coordinates"][0])
        return self.xyz(parts["coordinates"][0])

    def xyz(self, element: _Element) -> Vec:
        x, y, z = self.axes(element, _XYZ)
        return self.number(x), self.number(y), self.number(z)

    def xy(self, element: _Element) -> XY:
        x, y = self.axes(element, _XYZ[:2])
        return self.number(x), self.number(y)

    def axes(self, element: _Element, tags: list[str]) -> list[_Element]:
        """The elements x, y (and z) of a vector or position."""
        # Half of all elements come through here, nearly always just these and in order.
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        if list(map(_TAG, children)) == tags:
            return children
        kids = self.children(element, INSIDE["xyz"])
        for tag in tags:
            if tag not in kids:
                self.fail(element, "number-missing", f"<{element.tag}> has no <{tag}>")
        return [kids[tag][0] for tag in tags]

    def control_points(self, element: _Element) -> tuple[XY, ...]:
        return tuple(map(self.xy, element.iterchildren("control_point")))

    def number(self, element: _Element) -> float:
        value = None if len(element) else self.numbers.get(element.text)
        if value is None:
            text = self.text(element)
            if not _NUMBER(text):
                self.fail(
                    element, "number-invalid", f"'{text}' in <{element.tag}> is no number",
                    "write it as 0.5 or 5e-1",
                )  # fmt: skip
            value = float(text)
            if isinf(value):
                self.fail(
                    element, "number-invalid", f"'{text}' in <{element.tag}> is too large",
                    "a double goes up to 1.8e308",
                )  # fmt: skip
            self.numbers[element.text] = value
        return value

    def text(self, element: _Element) -> str:
        if len(element):
            self.fail(
                element, "mbs-not-plain", f"<{element.tag}> holds more than a text",
                "comments and elements do not belong within a name or a number",
            )  # fmt: skip
        return (element.text or "").strip()

    # --- names and elements ---

    def name(self, element: _Element, kids: Children, tag: str, what: str) -> str:
        """The name of an object, which no other of its name space has."""
        name = self.text(kids[tag][0]) if tag in kids else ""
        if not name:
            self.fail(element, "name-missing", f"this {what} has no name")
        if tag in _FIRST:
            self.is_first(element, kids[tag][0])
        if what in ("body", "joint"):
            self.take(element, name, what)
        return name

    def take(self, element: _Element, name: str, kind: str) -> None:
        """A name of its kind: Robotran's own CoMan has joints and bodies of one name."""
        if (kind, name) in self.names:
            self.fail(
                element, "name-doubled",
                f"the name '{name}' of this {kind} is taken: it is that of "
                f"{self.names[kind, name]}",
                "Robotran drops the second of two in silence: rename one",
            )  # fmt: skip
        self.names[kind, name] = f"a {kind} before"

    def origin(self, element: _Element) -> Origin | None:
        """None without graphics: what is not read cannot be kept."""
        if self.mechanics_only:
            return None
        self.elements.append(element)
        return Origin(self.data, len(self.elements) - 1)

    def is_first(self, parent: _Element, child: _Element) -> None:
        if parent[0] is not child:
            before = parent[0].tag
            what = f"<{before}>" if isinstance(before, str) else "a comment"
            self.fail(
                child, "mbs-not-first", f"{what} stands before <{child.tag}> in <{parent.tag}>",
                "Robotran's C library takes the first for it, and reads zeros or no name: "
                f"<{child.tag}> must be the first",
            )  # fmt: skip

    def children(self, element: _Element, known: Table, who: str = "") -> Children:
        """The children by tag.  Two of a known tag are an error, unless they belong to a list; and
        so is the lack of one that ``who`` must have."""
        kids: Children = {}
        # A slice is twice as fast as list().
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        for child in children:
            kids.setdefault(child.tag, []).append(child)
        if len(kids) < len(children):
            for tag, found in kids.items():
                entry = known.get(tag)
                repeated = entry is None or (isinstance(entry, tuple) and entry[1] in REPEATED)
                if len(found) > 1 and not repeated:
                    self.fail(found[1], "doubled-element", f"<{element.tag}> has two <{tag}>")
        if who:
            self.require(element, kids, who)
        return kids

    def require(self, element: _Element, kids: Children, who: str) -> None:
        """Fail if an element lacks what it must have."""
        for tag in _REQUIRED.get(element.tag, ()):
            if tag not in kids:
                code = "parent-missing" if tag == "parent" else "mbs-incomplete"
                self.fail(element, code, f"{who} has no <{tag}>")

    def fail(self, element: _Element, code: str, message: str, hint: str | None = None) -> NoReturn:
        line = xml_lines.line(element, self.data)
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)


def _where(body: str | None) -> str:
    return "the base" if body is None else f"body '{body}'"


_XYZ = ["x", "y", "z"]
#: What must hold for an object that is read.
_CHECKS: dict[str, Callable[[_Reader, Any, _Element], None]] = {
    "body": _Reader.check_body,
    "joint": _Reader.check_joint,
    "point": _Reader.check_point,
    "user constraint": _Reader.check_constraint,
}
#: What reads each kind of value.
_KINDS: dict[object, Callable[[_Reader, _Element], Any]] = {
    "text": _Reader.text,
    "title": _Reader.text,
    "word": lambda reader, element: intern(reader.text(element)),
    "number": _Reader.number,
    "xy": _Reader.xy,
    "xyz": _Reader.xyz,
    "coordinates": _Reader.coordinates,
    "inertia": _Reader.inertia,
    "control points": _Reader.control_points,
    "symbols": _Reader.symbols,
    "color": _Reader.color,
    "flag": lambda *_: True,
    "sensor": _Reader.sensor,
    "base": _Reader.base,
    "drawing": lambda reader, element: (
        reader.fill(Drawing(), reader.children(element, DRAWING), DRAWING) if len(element) else None
    ),
    "view": lambda reader, element: reader.fill(View(), reader.children(element, VIEW), VIEW),
}
