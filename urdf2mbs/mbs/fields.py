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

from urdf2mbs.mbs import model
from urdf2mbs.mbs.model import CUTS, LINKS, SHAPES
from urdf2mbs.spatial import ZERO

Kind = Literal[
    "text", "title", "word", "number", "xy", "xyz", "coordinates", "inertia", "color", "flag",
    "control_points", "symbols", "place", "sensor", "texts", "parts", "base", "drawing", "view",
]  # fmt: skip
#: The kinds whose elements may stand several times.
REPEATED = ("texts", "parts")
MARK = None
Field = tuple[str, Kind | frozenset[str]]
Table: TypeAlias = "Mapping[str, Field | Table | None]"


def _fields(**kinds: Kind | frozenset[str]) -> dict[str, Field]:
    """Children whose tags are the names of their fields, too."""
    return {tag: (tag, kind) for tag, kind in kinds.items()}


_NAME: dict[str, Field] = _fields(name="text")
_POSITION: Table = _fields(position="xy")
SHAPE: Table = _fields(
    name="text", position="xyz", scale="xyz", rotation="xyz", color="color",
    transparency="number", size="xyz", radius="number", height="number", url="text",
)  # fmt: skip
VIEWPOINT: Table = {
    **_fields(name="text", joint="text", position="xyz", target="xyz", up="xyz"),
    **_fields(projection="text", scale="number"),
    "fieldOfView": ("field_of_view", "number"),
    "frontClipDst": ("front_clip", "number"),
    "backClipDst": ("back_clip", "number"),
}
LIGHT: Table = _fields(name="text", joint="text", active="flag", direction="xyz")
DRAWING: Table = _fields(
    position="xy", name_pos="xy", shape="text", size="xy", control_points="control_points",
    angle="number",
)  # fmt: skip
JOINT: Table = {
    "jointname": ("name", "text"),
    "type": ("type", "word"),
    "nature": ("nature", "word"),
    "initialvalue": _fields(q="number", qd="number", qdd="number"),
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
    **_fields(mass="number", com="coordinates", inertia="inertia"),
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
CONNECTION: Table = _fields(name="text", endpoint1="place", endpoint2="place", length="number")
USER_CONSTRAINT: Table = {**_NAME, "joints": {"jointname": ("joints", "texts")}}
USER_MODEL: Table = {**_NAME, "parameter": ("parameters", "parts")}
PARAMETER: Table = {**_NAME, "type": ("type", "text"), "value": ("values", "texts")}
USER_VARIABLE: Table = {"varname": ("name", "text"), **_fields(type="text", size="text")}
VIEW: Table = {
    "background": {"color": ("background", "color")},
    "shapeScaleFactors": _fields(frame="number", joint="number", com="number", point="number"),
    **_fields(viewpoints=frozenset(["viewpoint"]), lights=frozenset(["directionalLight"])),
}
MBS: Table = {
    "mbsname": ("name", "title"),
    "mbsyspad_version": ("version", "title"),
    "base": ("base", "base"),
    "bodytree": ("bodies", frozenset(["body"])),
    **_fields(cuts=CUTS, links=LINKS, user_constraints=frozenset(["user_constraint"])),
    **_fields(user_models=frozenset(["user_model"]), user_variables=frozenset(["user_variable"])),
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
    "base": BASE, "drawing": DRAWING, "view": VIEW, "xy": _XY, "xyz": _XYZ,
    "coordinates": {"coordinates": ("", "xyz")},
    "control_points": {"control_point": ("", "xy")},
    "inertia": dict.fromkeys(["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"], _PART),
    "symbols": dict.fromkeys(["q", "qd", "qdd"], _PART),
    "place": dict.fromkeys(["bodyname", "pointname"], _PART),
}  # fmt: skip


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
    "mbs": Object(lambda _: model.Mbs("", ""), MBS, "the file"),
    "base": Object(lambda _: model.Base(""), BASE, "the base"),
    "drawing": Object(lambda _: model.Drawing(), DRAWING),
    "view": Object(lambda _: model.View(), VIEW, "the 3D view"),
    "body": _named(lambda _: model.Body(""), BODY, "body"),
    "joint": _named(lambda _: model.Joint("", "", ""), JOINT, "joint"),
    "point": _named(lambda _: model.Point(""), POINT, "point"),
    "user_constraint": _named(
        lambda _: model.UserConstraint(""), USER_CONSTRAINT, "user constraint"
    ),
    "user_model": _named(lambda _: model.UserModel(""), USER_MODEL, "user model"),
    "parameter": _named(lambda _: model.Parameter("", ""), PARAMETER, "parameter"),
    "user_variable": _named(
        lambda _: model.UserVariable("", "", ""), USER_VARIABLE, "user variable"
    ),
    "viewpoint": Object(lambda _: model.Viewpoint("", ZERO, ZERO), VIEWPOINT),
    "directionalLight": Object(lambda _: model.Light("", ZERO, active=False), LIGHT),
    **{shape: Object(lambda kind: model.Shape(kind, ""), SHAPE) for shape in SHAPES},
    **{
        kind: _named(lambda kind: model.Connection(kind, "", ("", ""), ("", "")), CONNECTION, kind)
        for kind in CUTS | LINKS
    },
}
