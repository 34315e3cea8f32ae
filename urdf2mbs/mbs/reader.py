"""Read any .mbs file into the model, and check one against the format's schema.

Elements and attributes that the model has no place for are passed over, as Robotran does; each
object knows its element, so that the writer keeps them.  What makes Robotran itself go wrong,
mostly without a word, is an error here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Set
from functools import cache
from math import isinf
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from lxml import etree

from urdf2mbs.mbs.fields import DRAWING, FACTORS, LIGHT, SHAPE, VIEWPOINT, Fields, Kind
from urdf2mbs.mbs.model import (
    BASE,
    CUTS,
    JOINT_TYPES,
    LINKS,
    NATURES,
    ORIGIN,
    SENSOR_MEASURES,
    SHAPES,
    SYMBOLS,
    XY,
    Base,
    Body,
    Connection,
    Drawing,
    Joint,
    Light,
    Mbs,
    Origin,
    Parameter,
    Point,
    Sensor,
    Shape,
    UserConstraint,
    UserModel,
    UserVariable,
    View,
    Viewpoint,
)
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic, nearest
from urdf2mbs.spatial import ZERO, Vec
from urdf2mbs.xml import lines as xml_lines
from urdf2mbs.xml.errors import BLANK, check_conflict, check_entities, explain

if TYPE_CHECKING:
    from lxml.etree import _Element

    Children = dict[str, _Element]
    Lists = dict[str, list[_Element]]

#: The elements that the model has a place for, in each element.
ROOT = frozenset([
    "mbsname", "mbsyspad_version", "base", "bodytree", "cuts", "links", "user_constraints",
    "user_models", "user_variables", "x3D",
])  # fmt: skip
BASE_CHILDREN = frozenset(["gravity", "baseBodyName", "point", "graphics"])
BODY = frozenset(["bodyname", "parent", "joint", "mass", "com", "inertia", "point", "graphics"])
JOINT = frozenset(
    ["jointname", "type", "nature", "initialvalue", "actuated", "symbols", "graphics"]
)
POINT = frozenset(["pointname", "coordinates", "graphics", "sensor", "extforce"])
CONNECTION = frozenset(["name", "endpoint1", "endpoint2", "length"])
VIEW = frozenset(["background", "shapeScaleFactors", "viewpoints", "lights"])
X3D = frozenset(["x3D_shapes"])
ENDPOINT = frozenset(["bodyname", "pointname"])
INERTIA = ["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"]
XYZ = ["x", "y", "z"]
COORDINATES, GRAPHICS = frozenset(["coordinates"]), frozenset(["x2D", "x3D"])
X2D, BASE_X2D = frozenset(["position"]), frozenset(["position", "base_body"])
NOTHING: frozenset[str] = frozenset()
NO_LISTS: Lists = {}
#: What must be the first child of an element: Robotran takes the first, whatever it is.
_FIRST = frozenset(["bodyname", "jointname", "pointname", "coordinates"])
#: Words that each joint has, to keep each of them once.
_WORDS = {word: word for word in (*JOINT_TYPES, *NATURES)}

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


def validate(data: bytes, file: str) -> list[Diagnostic]:
    """Each place where a file departs from the format's schema (``mbs.rng``), none if it is
    as MBSysPad would have written it.

    Raises ConversionError if it is not XML at all.
    """
    schema = _schema()
    if schema.validate(_parse(data, file)):
        return []
    return [
        Diagnostic("warning", "mbs-schema", entry.message, file=file, line=entry.line)
        for entry in schema.error_log
    ]


@cache
def _schema() -> etree.RelaxNG:
    return etree.RelaxNG(etree.parse(str(Path(__file__).with_name("mbs.rng"))))


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


Object = TypeVar("Object")


class _Reader:
    def __init__(self, data: bytes, file: str, *, mechanics_only: bool = False) -> None:
        self.data, self.file, self.mechanics_only = data, file, mechanics_only
        self.numbers: dict[str | None, float] = {}
        self.names: dict[tuple[str, str], str] = {
            ("body", BASE): "the ground", ("body", ORIGIN): "a body's own frame",
        }  # fmt: skip
        """What is called so, by kind and name."""
        self.elements: list[_Element] = []
        """Those of the objects, by the numbers of their origins."""
        self.points: dict[str | None, Set[str]] = {}
        """The points of each body read so far."""

    def mbs(self, root: _Element) -> Mbs:
        if root.tag != "mbsDescR7":
            self.fail(root, "not-mbs", f"the root of an .mbs file is <mbsDescR7>, not <{root.tag}>")
        kids = self.children(root, ROOT)
        for tag in ("base", "bodytree"):
            if tag not in kids:
                self.fail(root, "mbs-incomplete", f"the file has no <{tag}>")
        mbs = Mbs(
            name=self.text(kids.get("mbsname")),
            version=self.text(kids.get("mbsyspad_version")),
            origin=self.origin(root),
            base=self.base(kids["base"]),
            bodies=[self.body(element) for element in self.listed(kids["bodytree"], "body")],
        )
        mbs.cuts = self.connections(kids.get("cuts"), CUTS)
        mbs.links = self.connections(kids.get("links"), LINKS)
        joints = {joint.name for body in mbs.bodies for joint in body.joints}
        mbs.user_constraints = [
            self.user_constraint(element, joints)
            for element in self.listed(kids.get("user_constraints"), "user_constraint")
        ]
        variables = self.listed(kids.get("user_variables"), "user_variable")
        mbs.user_variables = list(map(self.user_variable, variables))
        models = self.listed(kids.get("user_models"), "user_model")
        mbs.user_models = list(map(self.user_model, models))
        if "x3D" in kids and not self.mechanics_only:
            mbs.view = self.view(kids["x3D"])
        return mbs

    def base(self, element: _Element) -> Base:
        points: list[_Element] = []
        kids = self.children(element, BASE_CHILDREN, {"point": points})
        if "gravity" not in kids:
            self.fail(element, "mbs-incomplete", "the base has no <gravity>")
        base = Base(
            name=self.text(kids.get("baseBodyName")) or BASE, gravity=self.vector(kids["gravity"])
        )
        self.names.setdefault(("body", base.name), "the base")
        base.points = self.points_of(None, points)
        parts = self.graphics(kids)
        if "x2D" in parts:
            x2d = self.children(parts["x2D"], BASE_X2D)
            if "position" in x2d:
                base.position = self.xy(x2d["position"])
            if "base_body" in x2d:
                base.drawing = self.filled(Drawing(), x2d["base_body"], DRAWING)
        if "x3D" in parts:
            base.shapes = self.shapes(parts["x3D"])
        return base

    def body(self, element: _Element) -> Body:
        joints: list[_Element] = []
        points: list[_Element] = []
        kids = self.children(element, BODY, {"joint": joints, "point": points})
        name = self.name(element, kids, "bodyname", "body")
        origin = self.origin(element)
        if "parent" not in kids:
            self.fail(element, "parent-missing", f"body '{name}' has no <parent>")
        parent, point = self.place(kids["parent"], f"the parent of body '{name}'", name)
        body = Body(
            name, parent, point, [self.joint(child) for child in joints], origin=origin
        )  # fmt: skip
        if not joints:
            self.fail(
                element, "body-without-joint", f"body '{name}' has no joint",
                "Robotran would lose it: give it one, driven and at 0, if it is to be fixed",
            )  # fmt: skip
        if "mass" in kids:
            body.mass = self.number(kids["mass"])
        if "com" in kids:
            body.com = self.vector(kids["com"])
        if "inertia" in kids:
            parts = self.children(kids["inertia"], INERTIA)
            xx, xy, xz, yy, yz, zz = [
                self.number(parts[tag]) if tag in parts else 0.0 for tag in INERTIA
            ]
            body.inertia = (xx, xy, xz, yy, yz, zz)
        body.points = self.points_of(name, points)
        graphics = self.graphics(kids)
        if "x2D" in graphics and len(graphics["x2D"]):
            body.drawing = self.filled(Drawing(), graphics["x2D"], DRAWING)
        if "x3D" in graphics:
            body.shapes = self.shapes(graphics["x3D"])
        return body

    def place(
        self, element: _Element, what: str, of: str | None = None
    ) -> tuple[str | None, str | None]:
        """A body and one of its points, both known by now; ``of`` is the body that hangs on it."""
        parts = self.children(element, ENDPOINT)
        body: str | None = self.text(parts.get("bodyname"))
        point: str | None = self.text(parts.get("pointname"))
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
            where = "the base" if body is None else f"body '{body}'"
            self.fail(
                element, "point-unknown", f"{what} is point '{point}', and {where} has none such",
                nearest(point or "", [ORIGIN, *self.points[body]]),
            )  # fmt: skip
        return body, point

    def joint(self, element: _Element) -> Joint:
        kids = self.children(element, JOINT)
        name = self.name(element, kids, "jointname", "joint")
        kind, nature = self.text(kids.get("type")), self.text(kids.get("nature"))
        kind, nature = _WORDS.get(kind, kind), _WORDS.get(nature, nature)
        if kind not in JOINT_TYPES:
            self.fail(
                kids.get("type", element), "joint-type-unknown",
                f"joint '{name}' is of type '{kind}'", "the types are T1 T2 T3 R1 R2 R3",
            )  # fmt: skip
        if nature not in NATURES:
            self.fail(
                kids.get("nature", element), "joint-nature-unknown",
                f"joint '{name}' is of nature '{nature}'",
                "the natures are independent, dependent and driven",
            )  # fmt: skip
        joint = Joint(
            name, kind, nature, actuated="actuated" in kids, origin=self.origin(element)
        )  # fmt: skip
        if "initialvalue" in kids:
            for tag, value in self.children(kids["initialvalue"], SYMBOLS).items():
                if tag in SYMBOLS:
                    setattr(joint, tag, self.number(value))
        if "symbols" in kids:
            listed = self.children(kids["symbols"], SYMBOLS)
            joint.symbols = tuple(tag for tag in listed if tag in SYMBOLS)
        joint.position = self.position(kids)
        return joint

    def points_of(self, body: str | None, elements: list[_Element]) -> list[Point]:
        names: set[str] = set()
        points = []
        for child in elements:
            point = self.point(child)
            if point.name in names or (body is None and point.name == ORIGIN):
                where = "the base" if body is None else f"body '{body}'"
                self.fail(child, "name-doubled", f"{where} has two points '{point.name}'")
            if point.name == ORIGIN and point.coordinates != ZERO:
                self.fail(
                    child, "origin-moved", f"the point 'origin' of body '{body}' is not at 0 0 0",
                    "'origin' is the body's own frame: give the point another name",
                )  # fmt: skip
            if body is None and (point.sensor is not None or point.extforce is not None):
                self.fail(
                    child, "base-sensor",
                    f"point '{point.name}' of the base has a sensor or an external force",
                    "Robotran's C library overruns its memory: put it on a body",
                )  # fmt: skip
            names.add(point.name)
            points.append(point)
        self.points[body] = names or NOTHING  # most bodies of a large file have none
        return points

    def point(self, element: _Element) -> Point:
        kids = self.children(element, POINT)
        name = self.own_name(element, kids, "pointname", "point")
        point = Point(name, origin=self.origin(element))
        if "coordinates" in kids:
            point.coordinates = self.xyz(kids["coordinates"])
        point.position = self.position(kids)
        if "sensor" in kids:
            point.sensor = self.sensor(kids["sensor"])
        if "extforce" in kids:
            point.extforce = self.sensor(kids["extforce"])
        return point

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

    def graphics(self, kids: Children) -> Children:
        """``x2D`` and ``x3D``, if they are there and wanted."""
        if self.mechanics_only or "graphics" not in kids:
            return {}
        return self.children(kids["graphics"], GRAPHICS)

    def position(self, kids: Children) -> XY | None:
        graphics = self.graphics(kids)
        if "x2D" not in graphics:
            return None
        parts = self.children(graphics["x2D"], X2D)
        return self.xy(parts["position"]) if "position" in parts else None

    def shapes(self, x3d: _Element) -> list[Shape]:
        kids = self.children(x3d, X3D)
        if "x3D_shapes" not in kids:
            return []
        return [
            self.filled(Shape(child.tag, "", origin=self.origin(child)), child, SHAPE)
            for child in kids["x3D_shapes"]
            if child.tag in SHAPES
        ]

    def color(self, element: _Element) -> tuple[int, int, int]:
        rgb = [element.get(part, "") for part in "RGB"]
        for text in rgb:
            if not re.fullmatch(_RGB, text) or int(text) > 255:
                self.fail(
                    element, "number-invalid", f"'{text}' is no part of a colour",
                    "R, G and B are whole numbers from 0 to 255",
                )  # fmt: skip
        return int(rgb[0]), int(rgb[1]), int(rgb[2])

    def connections(self, element: _Element | None, kinds: frozenset[str]) -> list[Connection]:
        connections: list[Connection] = []
        if element is None:
            return connections
        for child in element:
            if child.tag not in kinds:
                continue
            kids = self.children(child, CONNECTION)
            name = self.own_name(child, kids, "name", child.tag)
            ends: list[tuple[str | None, str | None]] = []
            for tag in ("endpoint1", "endpoint2"):
                if tag not in kids:
                    self.fail(child, "mbs-incomplete", f"{child.tag} '{name}' has no <{tag}>")
                ends.append(self.place(kids[tag], f"{tag} of {child.tag} '{name}'"))
            connection = Connection(child.tag, name, ends[0], ends[1], origin=self.origin(child))
            if "length" in kids:
                connection.length = self.number(kids["length"])
            connections.append(connection)
        return connections

    def user_constraint(self, element: _Element, joints: set[str]) -> UserConstraint:
        kids = self.children(element, frozenset(["name", "joints"]))
        name = self.own_name(element, kids, "name", "user constraint")
        constrained = self.listed(kids.get("joints"), "jointname")
        for child in constrained:
            joint = self.text(child)
            if joint not in joints:
                self.fail(
                    child, "joint-unknown",
                    f"user constraint '{name}' is on '{joint}', and there is no such joint",
                    nearest(joint, joints),
                )  # fmt: skip
        return UserConstraint(name, tuple(map(self.text, constrained)), origin=self.origin(element))

    def user_model(self, element: _Element) -> UserModel:
        parameters: list[_Element] = []
        kids = self.children(element, frozenset(["name"]), {"parameter": parameters})
        return UserModel(
            self.own_name(element, kids, "name", "user model"),
            [self.parameter(child) for child in parameters],
            origin=self.origin(element),
        )

    def parameter(self, element: _Element) -> Parameter:
        values: list[_Element] = []
        kids = self.children(element, frozenset(["name", "type"]), {"value": values})
        return Parameter(
            self.own_name(element, kids, "name", "parameter"),
            self.text(kids.get("type")),
            tuple(self.text(value) for value in values),
            origin=self.origin(element),
        )

    def user_variable(self, element: _Element) -> UserVariable:
        kids = self.children(element, frozenset(["varname", "type", "size"]))
        return UserVariable(
            self.own_name(element, kids, "varname", "user variable"),
            self.text(kids.get("type")),
            self.text(kids.get("size")),
            origin=self.origin(element),
        )

    def view(self, element: _Element) -> View:
        kids = self.children(element, VIEW)
        view = View()
        if "background" in kids:
            parts = self.children(kids["background"], frozenset(["color"]))
            if "color" in parts:
                view.background = self.color(parts["color"])
        if "shapeScaleFactors" in kids:
            self.filled(view, kids["shapeScaleFactors"], FACTORS)
        view.viewpoints = [
            self.filled(Viewpoint("", ZERO, ZERO, origin=self.origin(child)), child, VIEWPOINT)
            for child in self.listed(kids.get("viewpoints"), "viewpoint")
        ]
        view.lights = [
            self.filled(Light("", ZERO, active=False, origin=self.origin(child)), child, LIGHT)
            for child in self.listed(kids.get("lights"), "directionalLight")
        ]
        return view

    def filled(self, made: Object, element: _Element, fields: Fields) -> Object:
        """An object with the fields set whose elements are there."""
        for tag, child in self.children(element, fields.keys()).items():
            if tag in fields:
                name, kind = fields[tag]
                setattr(made, name, _KINDS[kind](self, child))
        return made

    def vector(self, element: _Element) -> Vec:
        parts = self.children(element, COORDINATES)
        if "coordinates" not in parts:
            self.fail(
                element, "mbs-incomplete", f"<{element.tag}> has no <coordinates>",
                "Robotran's C library cannot read it: give x, y and z, or leave the element out",
            )  # fmt: skip
        self.is_first(element, parts["coordinates"])
        return self.xyz(parts["coordinates"])

    def xyz(self, element: _Element) -> Vec:
        x, y, z = self.axes(element, XYZ)
        return self.number(x), self.number(y), self.number(z)

    def xy(self, element: _Element) -> XY:
        x, y = self.axes(element, XYZ[:2])
        return self.number(x), self.number(y)

    def axes(self, element: _Element, tags: list[str]) -> list[_Element]:
        """The elements x, y (and z) of a vector or position."""
        # Half of all elements come through here, nearly always just these and in order.
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        if list(map(_TAG, children)) == tags:
            return children
        kids = self.children(element, tags)
        for tag in tags:
            if tag not in kids:
                self.fail(element, "number-missing", f"<{element.tag}> has no <{tag}>")
        return [kids[tag] for tag in tags]

    def number(self, element: _Element) -> float:
        text = element.text
        value = self.numbers.get(text)
        if value is None:
            if text is None or not _NUMBER(text) or len(element):
                self.fail(
                    element, "number-invalid", f"'{text or ''}' in <{element.tag}> is no number",
                    "write it as 0.5 or 5e-1",
                )  # fmt: skip
            value = float(text)
            if isinf(value):
                self.fail(
                    element, "number-invalid", f"'{text}' in <{element.tag}> is too large",
                    "a double goes up to 1.8e308",
                )  # fmt: skip
            self.numbers[text] = value
        return value

    def name(self, element: _Element, kids: Children, tag: str, kind: str) -> str:
        """A name of the name space that bodies, joints, sensors and forces share."""
        name = self.own_name(element, kids, tag, kind)
        self.take(element, name, kind)
        return name

    def own_name(self, element: _Element, kids: Children, tag: str, kind: str) -> str:
        name = self.text(kids.get(tag))
        if not name:
            self.fail(element, "name-missing", f"this {kind} has no name")
        if tag in _FIRST:
            self.is_first(element, kids[tag])
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

    def text(self, element: _Element | None) -> str:
        if element is None:
            return ""
        if len(element):
            self.fail(
                element, "mbs-not-plain", f"<{element.tag}> holds more than a text",
                "comments and elements do not belong within a name or a number",
            )  # fmt: skip
        return (element.text or "").strip()

    def listed(self, element: _Element | None, tag: str) -> list[_Element]:
        """The children of a list of one kind of element."""
        return [] if element is None else list(element.iterchildren(tag))

    def children(
        self, element: _Element, known: Container[str], many: Lists = NO_LISTS
    ) -> Children:
        """The children by tag.  A second known one is an error; those that may stand several
        times go into the lists of ``many``."""
        kids: Children = {}
        # A slice is twice as fast as list().
        children: list[_Element] = element[:]  # type: ignore[index,assignment]
        for child in children:
            tag = child.tag
            if tag in many:
                many[tag].append(child)
            elif tag in kids and tag in known:
                self.fail(child, "doubled-element", f"<{element.tag}> has two <{tag}>")
            else:
                kids[tag] = child
        return kids

    def fail(self, element: _Element, code: str, message: str, hint: str | None = None) -> NoReturn:
        line = xml_lines.line(element, self.data)
        raise ConversionError(code, message, file=self.file, line=line, hint=hint)


#: What reads each kind of value.
_KINDS: dict[Kind, Callable[[_Reader, _Element], Any]] = {
    "text": _Reader.text,
    "number": _Reader.number,
    "xy": _Reader.xy,
    "xyz": _Reader.xyz,
    "points": lambda reader, element: tuple(
        map(reader.xy, reader.listed(element, "control_point"))
    ),
    "color": _Reader.color,
    "flag": lambda *_: True,
}
