"""Read any .mbs file into the model.

The tables of ``fields`` become functions once.  Elements and attributes that the model has no place
for are passed over, as Robotran does; each object knows its element, so that who writes into the
file keeps them.
A fault that Robotran passes over without a word, to compute another robot, is an error here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lxml import etree

from urdf2mbs.disk import files
from urdf2mbs.disk.xml_errors import BLANK, check_conflict, check_entities, explain
from urdf2mbs.disk.xml_parser import safe_parser
from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, OBJECTS, REPEATED, Kind, Object, Table
from urdf2mbs.mbs.model import BASE, CUTS, LINKS, ORIGIN, Origin, Part
from urdf2mbs.mbs.values import Values
from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO

if TYPE_CHECKING:
    from lxml.etree import _Element

    #: Gives the value of an element, or the object in it.
    Read = Callable[["_Reader", _Element], Any]
    #: Gives an object the values of an element's children.
    Fill = Callable[["_Reader", Any, _Element], None]

#: The children that an element must have beside its name.
_REQUIRED = {
    "mbs": ("base", "bodytree"), "base": ("gravity",), "body": ("parent",),
    **dict.fromkeys((*CUTS, *LINKS), ("endpoint1", "endpoint2")),
}  # fmt: skip
_GRAPHICS = frozenset(["graphics", "x3D"])
_PLACE = list(INSIDE["place"])


def read(data: bytes, file: str, *, mechanics_only: bool = False) -> model.Mbs:
    """The model of an .mbs file; ``file`` is its name, for messages.

    ``mechanics_only`` passes over all graphics, which take a third of the time.

    Raises ConversionError, with the line: not XML, another root, no base or body tree, a
    body without a joint, an unknown parent, point or joint or one that stands later in the
    file, an unknown word, a number that is none, a name that is taken.
    """
    return _Reader(data, file, mechanics_only=mechanics_only).mbs(_parse(data, file))


def read_file(file: Path) -> model.Mbs:
    """The model of an .mbs file; ``-`` is standard input.  Raises ConversionError."""
    return read(files.read_model(file), files.STDIN if str(file) == "-" else str(file))


def read_again(source: bytes) -> tuple[model.Mbs, list[_Element]]:
    """The model of a file that was read before, and the elements of its objects by the numbers of
    their origins.  The tree of these elements is the whole file, white space included."""
    reader = _Reader(source, "")
    return reader.mbs(_parse(source, "", remove_blank_text=False)), reader.elements


def _parse(data: bytes, file: str, *, remove_blank_text: bool = True) -> _Element:
    if not data.strip(BLANK):
        raise ConversionError("file-empty", "the file is empty", file=file)
    parser = safe_parser(collect_ids=False, remove_blank_text=remove_blank_text)
    try:
        root: _Element = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        entries: Any = parser.error_log
        explain(data, file, error, list(entries), "an .mbs file begins with <?xml ...?>")
    check_conflict(data, file)  # Robotran reads what stands between the lines, from both versions
    check_entities(root, file)
    return root


class _Reader(Values):
    def __init__(self, data: bytes, file: str, *, mechanics_only: bool = False) -> None:
        super().__init__(data, file)
        self.mechanics_only = mechanics_only
        self.names: dict[tuple[str, str], str] = {
            ("body", BASE): "the ground", ("body", ORIGIN): "a body's own frame",
        }  # fmt: skip
        """The thing that has a name, in words, by kind and name."""
        self.elements: list[_Element] = []
        """Those of the objects, by the numbers of their origins."""
        self.owner: str | None = None
        """The body whose points are read; None is the base."""
        self.points: dict[str | None, set[str]] = {None: set()}
        """The points of each body read so far."""

    def mbs(self, root: _Element) -> model.Mbs:
        if root.tag != "mbsDescR7":
            self.fail(root, "not-mbs", f"the root of an .mbs file is <mbsDescR7>, not <{root.tag}>")
        mbs: model.Mbs = _object("mbs", self.mechanics_only)(self, root)
        return mbs

    def origin(self, element: _Element) -> Origin | None:
        """None without graphics: what is not read cannot be kept."""
        if self.mechanics_only:
            return None
        self.elements.append(element)
        return Origin(self.data, len(self.elements) - 1)

    # --- objects ---

    def check_base(self, base: model.Base, _: _Element) -> None:
        base.name = base.name or BASE
        self.names.setdefault(("body", base.name), "the base")

    def check_body(self, body: model.Body, element: _Element) -> None:
        self.points.setdefault(body.name, set())
        if not body.joints:
            self.fail(
                element, "body-without-joint", f"body '{body.name}' has no joint",
                "Robotran would lose it: give it one, driven and at 0, if it is to be fixed",
            )  # fmt: skip

    def check_joint(self, joint: model.Joint, element: _Element) -> None:
        for tag, word, known, code in (
            ("type", joint.type, model.JOINT_TYPES, "joint-type-unknown"),
            ("nature", joint.nature, model.NATURES, "joint-nature-unknown"),
        ):
            if word not in known:
                at = element.find(tag)
                self.fail(
                    element if at is None else at, code,
                    f"joint '{joint.name}' is of {tag} '{word}'",
                    f"the {tag}s are {', '.join(sorted(known))}",
                )  # fmt: skip

    def check_point(self, point: model.Point, element: _Element) -> None:
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

    def check_user_constraint(self, constraint: model.UserConstraint, element: _Element) -> None:
        for child, joint in zip(element.iter("jointname"), constraint.joints, strict=False):
            if ("joint", joint) not in self.names:
                self.fail(
                    child, "joint-unknown",
                    f"user constraint '{constraint.name}' is on '{joint}', and there is no such "
                    "joint",
                    nearest(joint, [name for kind, name in self.names if kind == "joint"]),
                )  # fmt: skip

    def place(self, element: _Element) -> tuple[str | None, str | None]:
        """A body and one of its points, both known by now."""
        names = ["" if name is None else self.text(name) for name in self.parts(element, _PLACE)]
        if element.tag != "parent" and "" in names:
            return names[0], names[1]  # a draft: its author has not chosen yet
        body = None if names[0] == BASE else names[0]
        point = None if names[1] == ORIGIN else names[1]
        if body is not None and body not in self.points:
            self.fail_body(element, body)
        if point is not None and point not in self.points[body]:
            self.fail(
                element, "point-unknown",
                f"{self.place_in_words(element)[0]} is point '{point}', "
                f"and {_where(body)} has none such",
                nearest(point, [ORIGIN, *self.points[body]]),
            )  # fmt: skip
        return body, point

    def fail_body(self, element: _Element, body: str) -> NoReturn:
        """Fail since no body before this element has this name."""
        what, owner = self.place_in_words(element)
        if element.tag == "parent" and body == owner:
            self.fail(element, "parent-unknown", f"body '{owner}' is its own parent")
        names = element.getroottree().iterfind("bodytree/body/bodyname")
        later = [self.text(name) for name in names]
        if body in later:
            self.fail(
                element, "parent-order", f"{what}, '{body}', stands later in the file",
                "a body must stand after its parent",
            )  # fmt: skip
        self.fail(
            element, "parent-unknown", f"{what} is '{body}', and there is no such body",
            nearest(body, [BASE, *later]),
        )  # fmt: skip

    def place_in_words(self, element: _Element) -> tuple[str, str]:
        """The meaning of a place in words, and the name of its body, cut or link."""
        owner: Any = element.getparent()
        name = self.text(owner.find("bodyname" if owner.tag == "body" else "name"))
        return f"{'the ' * (owner.tag == 'body')}{element.tag} of {owner.tag} '{name}'", name

    def sensor(self, element: _Element) -> model.Sensor:
        name = element.get("name", "").strip()
        if not name:
            self.fail_name(element, f"<{element.tag}>")
        self.take(element, name, element.tag)
        measures = []
        attributes: Any = element.items()
        for measure, value in attributes:
            if measure not in model.SENSOR_MEASURES:
                continue
            if value != "true":
                self.fail(
                    element, "value-unknown", f"{measure} of {element.tag} '{name}' is '{value}'",
                    'it can be "true" or left out',
                )  # fmt: skip
            measures.append(measure)
        return model.Sensor(name, tuple(measures), origin=self.origin(element))

    def take(self, element: Any, name: str, kind: str) -> None:
        """A name of its kind: Robotran's own CoMan has joints and bodies of one name."""
        if (kind, name) in self.names:
            self.fail(
                element, "name-doubled",
                f"the name '{name}' of this {kind} is taken: it is that of "
                f"{self.names[kind, name]}",
                "Robotran drops the second of two in silence: rename one",
            )  # fmt: skip
        self.names[kind, name] = f"a {kind} before"

    def fail_missing(self, element: _Element, tag: str, owner: Object, thing: Any) -> NoReturn:
        """Fail since an element lacks a child that it must have."""
        if owner.named and not thing.name:
            self.fail_name(element, owner.what)
        code = "parent-missing" if tag == "parent" else "mbs-incomplete"
        self.fail(element, code, f"{owner.in_words(thing)} has no <{tag}>")

    def fail_name(self, element: Any, what: str) -> NoReturn:
        self.fail(element, "name-missing", f"this {what} has no name")


def _where(body: str | None) -> str:
    return "the base" if body is None else f"body '{body}'"


@cache
def _object(key: str, mechanics_only: bool) -> Read:
    """Gives one of the ``OBJECTS``, with all that stands in its element."""
    owner = OBJECTS[key]
    fill = _filler(owner.table, mechanics_only, owner, _REQUIRED.get(key, ()))
    check = getattr(_Reader, f"check_{key}", None)
    is_part = isinstance(owner.make(key), Part)

    def read_object(reader: _Reader, element: _Element) -> Any:
        if key == "drawing" and not len(element):
            return None
        thing: Any = owner.make(key)
        if is_part:
            thing.origin = reader.origin(element)
        fill(reader, thing, element)
        if check is not None:
            check(reader, thing, element)
        return thing

    return read_object


def _filler(
    table: Table, mechanics_only: bool, owner: Object, required: Collection[str] = ()
) -> Fill:
    """Gives an object the values of an element's children, in the order of the table."""
    once = set(table)
    entries: list[tuple[str, str, Any, type | None, bool]] = []
    for tag, entry in table.items():
        if isinstance(entry, tuple):
            field, kind = entry
            collect = REPEATED.get(kind) if isinstance(kind, str) else None
            if collect is not None:
                once.remove(tag)
            named = owner.named and tag == next(iter(owner.table))
            read: Any = _name(owner.what) if named else _value(tag, kind, mechanics_only)
            entries.append((tag, field, read, collect, named or tag in required))
        elif entry is not None and not (mechanics_only and tag in _GRAPHICS):
            entries.append((tag, "", _filler(entry, mechanics_only, owner), None, False))

    def fill(reader: _Reader, thing: Any, element: _Element) -> None:
        kids = reader.children(element, once)
        for tag, field, read, collect, must in entries:
            found = kids.get(tag)
            if found is None:
                if must:
                    reader.fail_missing(element, tag, owner, thing)
            elif collect is not None:
                setattr(thing, field, collect([read(reader, child) for child in found]))
            elif field:
                setattr(thing, field, read(reader, found[0]))
            else:  # more of the same object
                read(reader, thing, found[0])

    return fill


def _value(tag: str, kind: Kind | frozenset[str], mechanics_only: bool) -> Read:
    if kind == "parts":
        return _object(tag, mechanics_only)
    if isinstance(kind, str):
        if kind in OBJECTS:
            return _object(kind, mechanics_only)
        read: Read = getattr(_Reader, kind.replace(" ", "_"))
        return read
    parts = {tag: _object(tag, mechanics_only) for tag in kind}
    return lambda reader, element: [
        parts[child.tag](reader, child) for child in element if child.tag in parts
    ]


def _name(what: str) -> Read:
    """Gives the name of an object, which no other of its name space has."""
    first, unique = what in ("body", "joint", "point"), what in ("body", "joint")

    def read_name(reader: _Reader, element: _Element) -> str:
        name = reader.text(element)
        if not name:
            reader.fail_name(element.getparent(), what)
        if first:
            reader.check_first(element)
        if unique:
            reader.take(element.getparent(), name, what)
        if what == "body":
            reader.owner = name
        return name

    return read_name
