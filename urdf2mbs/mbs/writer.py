"""Write an .mbs file: the tree of elements and the order that MBSysPad itself writes.

Text is put together directly: a tree of 20,000 elements, built only to be serialised,
would cost several times as much.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from math import isfinite
from typing import TYPE_CHECKING

from lxml import etree

from urdf2mbs.mbs.fields import DRAWING, FACTORS, LIGHT, SHAPE, VIEWPOINT, Fields
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
    Joint,
    Mbs,
    Part,
    Point,
    Sensor,
    Shape,
    UserModel,
    View,
)
from urdf2mbs.mbs.reader import INERTIA, read_again
from urdf2mbs.mbs.rewrite import AT, FROM, rewrite
from urdf2mbs.spatial import Vec

if TYPE_CHECKING:
    from lxml.etree import _Element


class _Numbers(dict[float, str]):
    """Each number as text, to its last digit; minus zero is zero."""

    where = ""
    """The element that is being written."""

    def __missing__(self, value: float) -> str:
        number = float(value)
        if not isfinite(number):
            raise ValueError(f"{self.where} has the number {number}, which no .mbs file can hold")
        text = self[value] = repr(number + 0.0)
        return text

    def of_text(self, text: str) -> None:
        """Raises ValueError for a number that is text already, and not finite."""
        try:
            number = float(text)
        except ValueError:
            return
        if not isfinite(number):
            self[number]


class _Texts(dict[str, str]):
    """Each text with the characters escaped that XML needs itself."""

    def __missing__(self, value: str) -> str:
        text = value
        if not (value.isidentifier() or _PLAIN(value)):
            if re.search(_NOT_XML, value):
                raise ValueError(f"an .mbs file cannot hold the name {value!r}")
            text = value.translate(_ESCAPED)
        self[value] = text
        return text


_ESCAPED = str.maketrans(
    {
        "&": "&amp;",
        "<": "&lt;",
        ">": "&gt;",
        '"': "&quot;",
        "'": "&#x27;",
        "\r": "&#13;",
        "\n": "&#10;",
    }
)
_PLAIN = re.compile(r"[A-Za-z0-9_./ -]*").fullmatch
_NOT_XML = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"


def write(mbs: Mbs, *, other: bytes | None = None) -> bytes:
    """The file as bytes: the same bytes for the same model.

    Bodies, joints and points are written in the order of the model.  Numbers are written to
    the last digit.  What is None is left out; MBSysPad wants every body's ``drawing``, the
    3D viewer wants ``view``.  A model that was read is written into its file: only what has
    changed in the model changes there.  Objects may come from one ``other`` file, with all that
    stands in their elements.

    Raises ValueError for what no .mbs can hold: a number that is not finite, a character
    that is not XML's, a word that the format does not have, a body without a joint, a sensor
    or force on a point of the base.
    """
    if mbs.origin is None:
        return "".join(_Writer().mbs(mbs)).encode()
    source = mbs.origin.source
    before, elements = read_again(source)
    was, now = _marked(before, source), _marked(mbs, source, other)
    if was == now:
        return source
    others = None
    if other is not None:
        theirs, their_elements = read_again(other)
        others = their_elements, etree.fromstring(_marked(theirs, other))
    rewrite(elements, etree.fromstring(was), etree.fromstring(now), others)
    return _spelled(elements[0], source)


def _marked(mbs: Mbs, source: bytes, other: bytes | None = None) -> bytes:
    """What is written of a model, with marks at the elements of objects that were read."""
    return "".join(_Writer(source, other).mbs(mbs)).encode()


def _spelled(root: _Element, source: bytes) -> bytes:
    """A tree as bytes, with the encoding, the first line and the line ends of its file."""
    tree = root.getroottree()
    text = etree.tostring(tree, encoding="unicode") + source[len(source.rstrip()) :].decode()
    if b" />" in source:  # as MBSysPad has it
        text = re.sub(r"(?s)(<!--.*?-->|<\?.*?\?>)|/>", lambda found: found[1] or " />", text)
    if b"\r\n" in source:
        text = text.replace("\r\n", "\n")
        text = text.replace("\n", "\r\n")
    head = re.match(rb"(\xef\xbb\xbf)?<\?xml[^>]*\?>\s*", source)
    data = text.encode(tree.docinfo.encoding or "UTF-8", "xmlcharrefreplace")
    return (head[0] if head else b"") + data


class _Writer:
    def __init__(self, source: bytes | None = None, other: bytes | None = None) -> None:
        self.source, self.other = source, other
        """The files to which the origins belong that are marked."""
        self.marked: set[int] = set()
        self.number = _Numbers()
        self.text = _Texts()

    def mbs(self, mbs: Mbs) -> Iterator[str]:
        t = self.text
        _only([cut.kind for cut in mbs.cuts], CUTS, "a cut")
        _only([link.kind for link in mbs.links], LINKS, "a link")
        name = f"  <mbsname>{t[mbs.name]}</mbsname>\n" if mbs.name else ""
        version = (
            f"  <mbsyspad_version>{t[mbs.version]}</mbsyspad_version>\n" if mbs.version else ""
        )
        yield '<?xml version="1.0" encoding="UTF-8"?>\n<mbsDescR7>\n'
        yield f"{name}{version}{self.base(mbs.base)}  <bodytree>\n"
        for body in mbs.bodies:
            yield self.body(body)
        yield "  </bodytree>\n"
        yield from _block("cuts", map(self.connection, mbs.cuts))
        yield from _block("links", map(self.connection, mbs.links))
        yield from self.user_constraints(mbs)
        yield from _block("user_models", map(self.user_model, mbs.user_models))
        yield from self.user_variables(mbs)
        yield "" if mbs.view is None else self.view(mbs.view)
        yield "</mbsDescR7>\n"

    def at(self, part: Part) -> str:
        """The mark of an object that was read; a copy of one is new."""
        origin = part.origin
        if self.source is None or origin is None:
            return ""
        if self.other is not None and origin.source is self.other:
            return f' {FROM}="{origin.number}"'
        if origin.source is not self.source:
            return ""
        if origin.number in self.marked:
            return ""
        self.marked.add(origin.number)
        return f' {AT}="{origin.number}"'

    def base(self, base: Base) -> str:
        self.number.where = "the base"
        for point in base.points:
            if point.sensor is not None or point.extforce is not None:
                raise ValueError(
                    f"point '{point.name}' of the base has a sensor or an external force: "
                    "Robotran's C library cannot read that"
                )
        x2d = ""
        if base.position is not None:
            x2d = self.vector("position", base.position, "        ")
        if base.drawing is not None:
            drawing = self.fields(base.drawing, DRAWING, "          ")
            x2d += f"        <base_body>\n{drawing}        </base_body>\n"
        if x2d:
            x2d = f"      <x2D>\n{x2d}      </x2D>\n"
        return (
            "  <base>\n    <gravity>\n"
            f"{self.vector('coordinates', base.gravity, '      ')}"
            "    </gravity>\n"
            f"    <baseBodyName>{self.text[base.name]}</baseBodyName>\n"
            f"{_outdented(self.points(base.points))}"
            f"    <graphics>\n{x2d}"
            "      <x3D>\n"
            "        <x3D_frame/>\n"
            "        <x3D_points/>\n"
            "        <x3D_lines/>\n"
            f"{_outdented(self.shapes(base.shapes))}"
            "      </x3D>\n"
            "    </graphics>\n"
            "  </base>\n"
        )

    def body(self, body: Body) -> str:
        n, t = self.number, self.text
        if not body.joints:
            raise ValueError(f"body '{body.name}' has no joint: Robotran would lose it")
        joints = "".join([self.joint(joint) for joint in body.joints])
        n.where = f"body '{body.name}'"
        mass = com = inertia = x2d = ""
        if body.mass is not None:
            mass = f"      <mass>{n[body.mass]}</mass>\n"
        if body.com is not None:
            com = (
                f"      <com>\n{self.vector('coordinates', body.com, '        ')}"
                "      </com>\n"
            )  # fmt: skip
        if body.inertia is not None:
            moments = zip(INERTIA, body.inertia, strict=True)
            parts = "".join([f"        <{tag}>{n[moment]}</{tag}>\n" for tag, moment in moments])
            inertia = f"      <inertia>\n{parts}      </inertia>\n"
        if body.drawing is not None:
            drawing = self.fields(body.drawing, DRAWING, "          ")
            x2d = f"        <x2D>\n{drawing}        </x2D>\n"
        return (
            f"    <body{self.at(body)}>\n"
            f"      <bodyname>{t[body.name]}</bodyname>\n"
            "      <parent>\n"
            f"        <bodyname>{BASE if body.parent is None else t[body.parent]}</bodyname>\n"
            f"        <pointname>{ORIGIN if body.point is None else t[body.point]}</pointname>\n"
            "      </parent>\n"
            f"{joints}{mass}{com}{inertia}"
            f"{self.points(body.points)}"
            f"      <graphics>\n{x2d}"
            "        <x3D>\n"
            "          <x3D_com/>\n"
            "          <x3D_points/>\n"
            "          <x3D_lines/>\n"
            f"{self.shapes(body.shapes)}"
            "        </x3D>\n"
            "      </graphics>\n"
            "    </body>\n"
        )

    def joint(self, joint: Joint) -> str:
        n = self.number
        n.where = f"joint '{joint.name}'"
        initial = symbols = x2d = ""
        if joint.q is not None:
            initial = f"          <q>{n[joint.q]}</q>\n"
        if joint.qd is not None:
            initial += f"          <qd>{n[joint.qd]}</qd>\n"
        if joint.qdd is not None:
            initial += f"          <qdd>{n[joint.qdd]}</qdd>\n"
        if initial:
            initial = f"        <initialvalue>\n{initial}        </initialvalue>\n"
        actuated = "        <actuated/>\n" if joint.actuated else ""
        if joint.symbols:
            _only(joint.symbols, SYMBOLS, f"joint '{joint.name}'")
            listed = "".join([f"          <{symbol}/>\n" for symbol in joint.symbols])
            symbols = f"        <symbols>\n{listed}        </symbols>\n"
        elif joint.symbols is not None:
            symbols = "        <symbols/>\n"
        if joint.position is not None:
            position = self.vector("position", joint.position, "            ")
            x2d = f"          <x2D>\n{position}          </x2D>\n"
        if joint.type not in JOINT_TYPES or joint.nature not in NATURES:
            raise ValueError(
                f"joint '{joint.name}' is '{joint.type}', '{joint.nature}': .mbs has no such joint"
            )
        return (
            f"      <joint{self.at(joint)}>\n"
            f"        <jointname>{self.text[joint.name]}</jointname>\n"
            f"        <type>{joint.type}</type>\n"
            f"        <nature>{joint.nature}</nature>\n"
            f"{initial}{actuated}{symbols}"
            f"        <graphics>\n{x2d}"
            "          <x3D>\n"
            "            <x3D_joint/>\n"
            "            <x3D_frame/>\n"
            "          </x3D>\n"
            "        </graphics>\n"
            "      </joint>\n"
        )

    def points(self, points: list[Point]) -> str:
        """The points of a body."""
        t = self.text
        out: list[str] = []
        for point in points:
            x2d = more = graphics = ""
            if point.position is not None:
                position = self.vector("position", point.position, "            ")
                x2d = f"          <x2D>\n{position}          </x2D>\n"
            if point.sensor is not None:
                sensor = self.sensor("sensor", point.sensor)
                more = f"        {sensor}\n"
            if point.extforce is not None:
                force = self.sensor("extforce", point.extforce)
                more += f"        {force}\n"
            if point.name != ORIGIN:
                graphics = f"        <graphics>\n{x2d}          <x3D/>\n        </graphics>\n"
            out.append(
                f"      <point{self.at(point)}>\n"
                f"        <pointname>{t[point.name]}</pointname>\n"
                f"{self.vector('coordinates', point.coordinates, '        ')}"
                f"{graphics}{more}"
                "      </point>\n"
            )
        return "".join(out)

    def sensor(self, tag: str, sensor: Sensor) -> str:
        _only(sensor.measures, SENSOR_MEASURES, f"{tag} '{sensor.name}'")
        measures = "".join([f' {measure}="true"' for measure in sensor.measures])
        return f'<{tag}{self.at(sensor)} name="{self.text[sensor.name]}"{measures}/>'

    def shapes(self, shapes: list[Shape]) -> str:
        """The shapes of a body."""
        if not shapes:
            return "          <x3D_shapes/>\n"
        out = ["          <x3D_shapes>\n"]
        _only([shape.kind for shape in shapes], SHAPES, "a shape")
        for shape in shapes:
            out.append(f"            <{shape.kind}{self.at(shape)}>\n")
            out.append(self.fields(shape, SHAPE, "              "))
            out.append(f"            </{shape.kind}>\n")
        out.append("          </x3D_shapes>\n")
        return "".join(out)

    def connection(self, connection: Connection) -> str:
        t = self.text
        ends = "".join(
            f"      <{tag}>\n"
            f"        <bodyname>{BASE if body is None else t[body]}</bodyname>\n"
            f"        <pointname>{ORIGIN if point is None else t[point]}</pointname>\n"
            f"      </{tag}>\n"
            for tag, (body, point) in (
                ("endpoint1", connection.endpoint1),
                ("endpoint2", connection.endpoint2),
            )
        )
        length = ""
        if connection.length is not None:
            self.number.where = f"{connection.kind} '{connection.name}'"
            length = f"      <length>{self.number[connection.length]}</length>\n"
        return (
            f"    <{connection.kind}{self.at(connection)}>\n"
            f"      <name>{t[connection.name]}</name>\n"
            f"{ends}{length}"
            f"    </{connection.kind}>\n"
        )

    def user_constraints(self, mbs: Mbs) -> Iterator[str]:
        t = self.text
        return _block(
            "user_constraints",
            (
                f"    <user_constraint{self.at(constraint)}>\n"
                f"      <name>{t[constraint.name]}</name>\n"
                "      <joints>\n"
                + "".join(
                    f"        <jointname>{t[name]}</jointname>\n" for name in constraint.joints
                )
                + "      </joints>\n"
                "    </user_constraint>\n"
                for constraint in mbs.user_constraints
            ),
        )

    def user_model(self, model: UserModel) -> str:
        t = self.text
        for parameter in model.parameters:
            self.number.where = f"parameter '{parameter.name}' of user model '{model.name}'"
            for value in parameter.values if parameter.type != "structure" else ():
                self.number.of_text(value)
        parameters = "".join(
            f"      <parameter{self.at(parameter)}>\n"
            f"        <name>{t[parameter.name]}</name>\n"
            f"        <type>{t[parameter.type]}</type>\n"
            + "".join([f"        <value>{t[v]}</value>\n" for v in parameter.values])
            + "      </parameter>\n"
            for parameter in model.parameters
        )
        return (
            f"    <user_model{self.at(model)}>\n      <name>{t[model.name]}</name>\n{parameters}"
            "    </user_model>\n"
        )

    def user_variables(self, mbs: Mbs) -> Iterator[str]:
        t = self.text
        return _block(
            "user_variables",
            (
                f"    <user_variable{self.at(variable)}>\n"
                f"      <varname>{t[variable.name]}</varname>\n"
                f"      <type>{t[variable.type]}</type>\n"
                f"      <size>{t[variable.size]}</size>\n"
                "    </user_variable>\n"
                for variable in mbs.user_variables
            ),
        )

    def view(self, view: View) -> str:
        n = self.number
        n.where = "the 3D view"
        red, green, blue = view.background
        viewpoints = "".join(
            f"      <viewpoint{self.at(viewpoint)}>\n"
            f"{self.fields(viewpoint, VIEWPOINT, '        ')}"
            "      </viewpoint>\n"
            for viewpoint in view.viewpoints
        )
        lights = "".join(
            f"      <directionalLight{self.at(light)}>\n"
            f"{self.fields(light, LIGHT, '        ')}"
            "      </directionalLight>\n"
            for light in view.lights
        )
        return (
            "  <x3D>\n"
            "    <background>\n"
            f'      <color R="{red:d}" G="{green:d}" B="{blue:d}"/>\n'
            "    </background>\n"
            "    <shapeScaleFactors>\n"
            f"{self.fields(view, FACTORS, '      ')}"
            "    </shapeScaleFactors>\n"
            f"    <viewpoints>\n{viewpoints}    </viewpoints>\n"
            f"    <lights>\n{lights}    </lights>\n"
            "  </x3D>\n"
        )

    def fields(self, written: object, fields: Fields, pad: str) -> str:
        """The elements of a table, without those whose value is None."""
        out: list[str] = []
        for tag, (name, kind) in fields.items():
            value = getattr(written, name)
            if value is None:
                continue
            if kind in ("xy", "xyz"):
                out.append(self.vector(tag, value, pad))
            elif kind == "color":
                red, green, blue = value
                out.append(f'{pad}<{tag} R="{red:d}" G="{green:d}" B="{blue:d}"/>\n')
            elif kind == "flag":
                out.append(f"{pad}<{tag}/>\n" if value else "")
            elif kind == "points":
                points = "".join(self.vector("control_point", xy, f"{pad}  ") for xy in value)
                out.append(
                    f"{pad}<{tag}>\n{points}{pad}</{tag}>\n" if value else f"{pad}<{tag}/>\n"
                )
            else:
                text = self.number[value] if kind == "number" else self.text[value]
                out.append(f"{pad}<{tag}>{text}</{tag}>\n")
        return "".join(out)

    def vector(self, tag: str, vector: XY | Vec, pad: str) -> str:
        values = zip("xyz", vector, strict=False)
        parts = "".join([f"{pad}  <{x}>{self.number[value]}</{x}>\n" for x, value in values])
        return f"{pad}<{tag}>\n{parts}{pad}</{tag}>\n"


def _outdented(text: str) -> str:
    """Elements of the base, which stand one level higher than those of a body."""
    return text.replace("\n  ", "\n").removeprefix("  ")


def _only(words: Iterable[str], known: frozenset[str], what: str) -> None:
    for word in words:
        if word not in known:
            raise ValueError(f"{what} is or has '{word}': .mbs has no such word")


def _block(tag: str, items: Iterable[str]) -> Iterator[str]:
    """A list of elements; none at all without any."""
    empty = True
    for item in items:
        if empty:
            yield f"  <{tag}>\n"
            empty = False
        yield item
    if not empty:
        yield f"  </{tag}>\n"
