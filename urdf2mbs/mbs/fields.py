"""A table for each element of an .mbs file.  Reader, writer and ``unknown`` use these tables.

A table has an element's children by their tags, in the order of the file.  Each child is

* a field of the model's object, with the kind of its value: a word, or the tags of the objects
  in a list;
* a table, where the child holds more of the same object;
* ``MARK``, an empty element that MBSysPad writes and nobody reads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

from urdf2mbs.mbs.model import (
    CUTS,
    LINKS,
    SHAPES,
    Base,
    Body,
    Connection,
    Drawing,
    Joint,
    Light,
    Mbs,
    Parameter,
    Point,
    Shape,
    UserConstraint,
    UserModel,
    UserVariable,
    View,
    Viewpoint,
)
from urdf2mbs.spatial import ZERO

Kind = Literal[
    "text", "title", "word", "number", "xy", "xyz", "coordinates", "inertia", "color", "flag",
    "control points", "symbols", "place", "sensor", "texts", "parts", "base", "drawing", "view",
]  # fmt: skip
#: The kinds whose elements may stand several times, and how the model keeps their values.
REPEATED = {"texts": tuple, "parts": list}
MARK = None
Field = tuple[str, Kind | frozenset[str]]
Table: TypeAlias = "Mapping[str, Field | Table | None]"

_POSITION: Table = {"position": ("position", "xy")}
SHAPE: Table = {
    "name": ("name", "text"),
    "position": ("position", "xyz"),
    "scale": ("scale", "xyz"),
    "rotation": ("rotation", "xyz"),
    "color": ("color", "color"),
    "transparency": ("transparency", "number"),
    "size": ("size", "xyz"),
    "radius": ("radius", "number"),
    "height": ("height", "number"),
    "url": ("url", "text"),
}
VIEWPOINT: Table = {
    "name": ("name", "text"),
    "joint": ("joint", "text"),
    "position": ("position", "xyz"),
    "target": ("target", "xyz"),
    "up": ("up", "xyz"),
    "projection": ("projection", "text"),
    "scale": ("scale", "number"),
    "fieldOfView": ("field_of_view", "number"),
    "frontClipDst": ("front_clip", "number"),
    "backClipDst": ("back_clip", "number"),
}
LIGHT: Table = {
    "name": ("name", "text"),
    "joint": ("joint", "text"),
    "active": ("active", "flag"),
    "direction": ("direction", "xyz"),
}
DRAWING: Table = {
    "position": ("position", "xy"),
    "name_pos": ("name_pos", "xy"),
    "shape": ("shape", "text"),
    "size": ("size", "xy"),
    "control_points": ("control_points", "control points"),
    "angle": ("angle", "number"),
}
JOINT: Table = {
    "jointname": ("name", "text"),
    "type": ("type", "word"),
    "nature": ("nature", "word"),
    "initialvalue": {"q": ("q", "number"), "qd": ("qd", "number"), "qdd": ("qdd", "number")},
    "actuated": ("actuated", "flag"),
    "symbols": ("symbols", "symbols"),
    "graphics": {"x2D": _POSITION, "x3D": {"x3D_joint": MARK, "x3D_frame": MARK}},
}
POINT: Table = {
    "pointname": ("name", "text"),
    "coordinates": ("coordinates", "xyz"),
    "graphics": {"x2D": _POSITION, "x3D": {}},
    "sensor": ("sensor", "sensor"),
    "extforce": ("extforce", "sensor"),
}
BODY: Table = {
    "bodyname": ("name", "text"),
    "parent": ("place", "place"),
    "joint": ("joints", "parts"),
    "mass": ("mass", "number"),
    "com": ("com", "coordinates"),
    "inertia": ("inertia", "inertia"),
    "point": ("points", "parts"),
    "graphics": {
        "x2D": ("drawing", "drawing"),
        "x3D": {
            "x3D_com": MARK, "x3D_points": MARK, "x3D_lines": MARK, "x3D_shapes": ("shapes", SHAPES)
        },
    },
}  # fmt: skip
BASE: Table = {
    "gravity": ("gravity", "coordinates"),
    "baseBodyName": ("name", "text"),
    "point": ("points", "parts"),
    "graphics": {
        "x2D": {**_POSITION, "base_body": ("drawing", "drawing")},
        "x3D": {
            "x3D_frame": MARK, "x3D_points": MARK, "x3D_lines": MARK,
            "x3D_shapes": ("shapes", SHAPES),
        },
    },
}  # fmt: skip
CONNECTION: Table = {
    "name": ("name", "text"),
    "endpoint1": ("endpoint1", "place"),
    "endpoint2": ("endpoint2", "place"),
    "length": ("length", "number"),
}
USER_CONSTRAINT: Table = {"name": ("name", "text"), "joints": {"jointname": ("joints", "texts")}}
USER_MODEL: Table = {"name": ("name", "text"), "parameter": ("parameters", "parts")}
PARAMETER: Table = {
    "name": ("name", "text"),
    "type": ("type", "text"),
    "value": ("values", "texts"),
}
USER_VARIABLE: Table = {
    "varname": ("name", "text"),
    "type": ("type", "text"),
    "size": ("size", "text"),
}
VIEW: Table = {
    "background": {"color": ("background", "color")},
    "shapeScaleFactors": {tag: (tag, "number") for tag in ("frame", "joint", "com", "point")},
    "viewpoints": ("viewpoints", frozenset(["viewpoint"])),
    "lights": ("lights", frozenset(["directionalLight"])),
}
MBS: Table = {
    "mbsname": ("name", "title"),
    "mbsyspad_version": ("version", "title"),
    "base": ("base", "base"),
    "bodytree": ("bodies", frozenset(["body"])),
    "cuts": ("cuts", CUTS),
    "links": ("links", LINKS),
    "user_constraints": ("user_constraints", frozenset(["user_constraint"])),
    "user_models": ("user_models", frozenset(["user_model"])),
    "user_variables": ("user_variables", frozenset(["user_variable"])),
    "x3D": ("view", "view"),
}
#: Elements that are written also when they are empty.
KEPT = frozenset([
    "bodytree", "symbols", "control_points", "joints", "x3D", "x3D_shapes", "viewpoints", "lights",
])  # fmt: skip

#: An element that holds a part of a value.
_PART: Field = ("", "text")
_XY: Table = dict.fromkeys("xy", _PART)
_XYZ: Table = dict.fromkeys("xyz", _PART)
#: The children of an element, by the kind of the value that it holds.
INSIDE: dict[str, Table] = {
    "base": BASE,
    "drawing": DRAWING,
    "view": VIEW,
    "xy": _XY,
    "xyz": _XYZ,
    "coordinates": {"coordinates": ("", "xyz")},
    "control points": {"control_point": ("", "xy")},
    "inertia": dict.fromkeys(["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"], _PART),
    "symbols": dict.fromkeys(["q", "qd", "qdd"], _PART),
    "place": dict.fromkeys(["bodyname", "pointname"], _PART),
}


class Object(NamedTuple):
    """An object of the model, and the table of its element."""

    make: Callable[[str], Any]
    """Gives an empty object; its argument is the key in ``OBJECTS``."""
    table: Table
    what: str = ""
    """How messages call the object; empty where it needs no words."""
    named: bool = False
    """The first child must be there, and is a name that messages say, too."""

    def in_words(self, thing: Any) -> str:
        return f"{self.what} '{thing.name}'" if self.named else self.what


def _named(make: Callable[[str], Any], table: Table, what: str) -> Object:
    return Object(make, table, what, named=True)


#: The objects of the model, by the tags of their elements or by the kinds of values.
OBJECTS = {
    "mbs": Object(lambda _: Mbs("", ""), MBS, "the file"),
    "base": Object(lambda _: Base(""), BASE, "the base"),
    "drawing": Object(lambda _: Drawing(), DRAWING),
    "view": Object(lambda _: View(), VIEW, "the 3D view"),
    "body": _named(lambda _: Body(""), BODY, "body"),
    "joint": _named(lambda _: Joint("", "", ""), JOINT, "joint"),
    "point": _named(lambda _: Point(""), POINT, "point"),
    "user_constraint": _named(lambda _: UserConstraint(""), USER_CONSTRAINT, "user constraint"),
    "user_model": _named(lambda _: UserModel(""), USER_MODEL, "user model"),
    "parameter": _named(lambda _: Parameter("", ""), PARAMETER, "parameter"),
    "user_variable": _named(lambda _: UserVariable("", "", ""), USER_VARIABLE, "user variable"),
    "viewpoint": Object(lambda _: Viewpoint("", ZERO, ZERO), VIEWPOINT),
    "directionalLight": Object(lambda _: Light("", ZERO, active=False), LIGHT),
    **{shape: Object(lambda kind: Shape(kind, ""), SHAPE) for shape in SHAPES},
    **{
        kind: _named(lambda kind: Connection(kind, "", ("", ""), ("", "")), CONNECTION, kind)
        for kind in CUTS | LINKS
    },
}
