"""Read any .mbs file into the model.

Elements and attributes that the model has no place for are passed over, as Robotran does; each
object knows its element, so that who writes into the file keeps them.
A fault that Robotran passes over without a word, to compute another robot, is an error here.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lxml import etree

from urdf2mbs.disk import files
from urdf2mbs.disk.xml import BLANK, check_conflict, check_entities, raise_syntax_error, safe_parser
from urdf2mbs.mbs import model
from urdf2mbs.mbs.fields import INSIDE, OBJECTS, Kind, Object, Table
from urdf2mbs.mbs.model import BASE, CUTS, LINKS, ORIGIN, Origin, Part
from urdf2mbs.mbs.values import Values
from urdf2mbs.messages.diagnostics import ConversionError, nearest
from urdf2mbs.spatial import ZERO

if TYPE_CHECKING:
    from lxml.etree import _Element

#: The children that an element must have beside its name.
_REQUIRED = {
    "mbs": ("base", "bodytree"), "base": ("gravity",), "body": ("parent",),
    **dict.fromkeys((*CUTS, *LINKS), ("endpoint1", "endpoint2")),
}  # fmt: skip
_GRAPHICS = frozenset(["graphics", "x3D"])
_PLACE = list(INSIDE["place"])


def read_mbs(data: bytes, file: str, *, mechanics_only: bool = False) -> model.Mbs:
    """The model of an .mbs file; ``file`` is its name, for messages.

    ``mechanics_only`` passes over all graphics, which take a third of the time.

    Raises ConversionError, with the line: not XML, another root, no base or body tree, a
    body without a joint, an unknown parent, point or joint or one that stands later in the
    file, an unknown word, a number that is none, a name that is taken.
    """
    return _Reader(data, file, mechanics_only=mechanics_only).mbs(_parse(data, file))


def read_mbs_file(file: Path) -> model.Mbs:
    """The model of an .mbs file; ``-`` is standard input.  Raises ConversionError."""
    return read_mbs(files.read_model(file), files.STDIN if str(file) == "-" else str(file))


def read_mbs_again(source: bytes) -> tuple[model.Mbs, list[_Element]]:
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
        raise_syntax_error(data, file, error, list(entries), "an .mbs file begins with <?xml ...?>")
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
        mbs: model.Mbs = self.object("mbs", root)
        return mbs

    def origin(self, element: _Element) -> Origin | None:
        """None without graphics: what is not read cannot be kept."""
        if self.mechanics_only:
            return None
        self.elements.append(element)
        return Origin(self.data, len(self.elements) - 1)

    # --- objects ---

    def object(self, key: str, element: _Element) -> Any:
        """One of the ``OBJECTS``, with all that stands in its element."""
        if key == "drawing" and not len(element):
            return None
        owner = OBJECTS[key]
        thing: Any = owner.make(key)
        if isinstance(thing, Part):
            thing.origin = self.origin(element)
        self.fill(thing, owner.table, element, owner, key)
        check = getattr(self, f"check_{key}", None)
        if check is not None:
            check(thing, element)
        return thing

    def fill(
        self, thing: Any, table: Table, element: _Element, owner: Object, key: str = ""
    ) -> None:
        """Give an object the values of an element's children, in the order of the table."""
        kids = self.children(element, table)
        first = next(iter(table), "") if key and owner.named else ""
        for tag, entry in table.items():
            found = kids.get(tag)
            if found is None:
                if tag == first or (key and tag in _REQUIRED.get(key, ())):
                    self.fail_missing(element, tag, owner, thing)
            elif tag == first:
                thing.name = self.name(found[0], owner.what)
            elif isinstance(entry, tuple):
                field, kind = entry
                setattr(thing, field, self.value(tag, kind, found))
            elif entry is not None and not (self.mechanics_only and tag in _GRAPHICS):
                self.fill(thing, entry, found[0], owner)

    def value(self, tag: str, kind: Kind | frozenset[str], found: list[_Element]) -> Any:
        """The value of a kind that the elements of a tag hold."""
        if not isinstance(kind, str):
            return [self.object(child.tag, child) for child in found[0] if child.tag in kind]
        if kind == "parts":
            return [self.object(tag, element) for element in found]
        if kind == "texts":
            return tuple(map(self.text, found))
        if kind in OBJECTS:
            return self.object(kind, found[0])
        return getattr(self, kind)(found[0])

    def name(self, element: _Element, what: str) -> str:
        """The name of an object, which no other of its name space has."""
        name, parent = self.text(element), element.getparent()
        if not name:
            self.fail_name(parent, what)
        if what in ("body", "joint", "point"):
            self.check_first(element)
        if what in ("body", "joint"):
            self.take(parent, name, what)
        if what == "body":
            self.owner = name
        return name

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
