"""A table for each element of an .mbs file, used by the reader, the writer and other tools.

A table has an element's children by their tags, in the order of the file.  Each child is

* a ``Field``: the attribute of the model's object, and the kind of its value;
* a table, if the child holds more of the same object;
* ``MARK``, an empty element that MBSysPad writes and nobody reads.

So ``<joint>`` is, with the children of ``<initialvalue>`` in a table of their own::

    JOINT = {
        "jointname":    Field("name", "text"),
        "initialvalue": {"q": Field("q", "number"), ...},
        ...
    }
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

from urdf2mbs.mbs import model
from urdf2mbs.mbs.model import CUTS, LINKS, SHAPES
from urdf2mbs.spatial import ZERO

Kind = Literal[
    "text",
    "title",  # a text that is left out if it is empty
    "word",  # one of a few texts
    "number",
    "flag",  # an empty element: True
    "color",
    "xy",
    "xyz",
    "coordinates",  # an xyz in an element <coordinates>
    "control_points",  # several xy
    "inertia",
    "symbols",  # empty elements, whose tags are the values
    "place",  # a body and one of its points
    "sensor",
    "texts",  # several elements with a text each
    "parts",  # several elements with an object each
    "base",
    "drawing",
    "view",
]
#: The kinds whose elements may be repeated.
REPEATED = ("texts", "parts")
MARK = None


class Field(NamedTuple):
    """An attribute of an object of the model, in an element of the file."""

    attribute: str
    kind: Kind | frozenset[str]
    """The kind of its value; for a list of objects, the tags of their elements."""


Table: TypeAlias = "Mapping[str, Field | Table | None]"


def _fields(**kinds: Kind | frozenset[str]) -> dict[str, Field]:
    """Return the fields whose attributes have the names of their tags."""
    return {tag: Field(tag, kind) for tag, kind in kinds.items()}


_NAME: dict[str, Field] = _fields(name="text")
_POSITION: Table = _fields(position="xy")
SHAPE: Table = _fields(
    name="text",
    position="xyz",
    scale="xyz",
    rotation="xyz",
    color="color",
    transparency="number",
    size="xyz",
    radius="number",
    height="number",
    url="text",
)
VIEWPOINT: Table = {
    **_fields(name="text", joint="text", position="xyz", target="xyz", up="xyz"),
    **_fields(projection="text", scale="number"),
    "fieldOfView": Field("field_of_view", "number"),
    "frontClipDst": Field("front_clip", "number"),
    "backClipDst": Field("back_clip", "number"),
}
LIGHT: Table = _fields(name="text", joint="text", active="flag", direction="xyz")
DRAWING: Table = _fields(
    position="xy",
    name_pos="xy",
    shape="text",
    size="xy",
    control_points="control_points",
    angle="number",
)
JOINT: Table = {
    "jointname": Field("name", "text"),
    "type": Field("type", "word"),
    "nature": Field("nature", "word"),
    "initialvalue": _fields(q="number", qd="number", qdd="number"),
    "actuated": Field("actuated", "flag"),
    "symbols": Field("symbols", "symbols"),
    "graphics": {"x2D": _POSITION, "x3D": {"x3D_joint": MARK, "x3D_frame": MARK}},
}
POINT: Table = {
    "pointname": Field("name", "text"),
    "coordinates": Field("coordinates", "xyz"),
    "graphics": {"x2D": _POSITION, "x3D": {}},
    "sensor": Field("sensor", "sensor"),
    "extforce": Field("extforce", "sensor"),
}
BODY: Table = {
    "bodyname": Field("name", "text"),
    "parent": Field("place", "place"),
    "joint": Field("joints", "parts"),
    **_fields(mass="number", com="coordinates", inertia="inertia"),
    "point": Field("points", "parts"),
    "graphics": {
        "x2D": Field("drawing", "drawing"),
        "x3D": {
            "x3D_com": MARK,
            "x3D_points": MARK,
            "x3D_lines": MARK,
            "x3D_shapes": Field("shapes", SHAPES),
        },
    },
}
BASE: Table = {
    "gravity": Field("gravity", "coordinates"),
    "baseBodyName": Field("name", "text"),
    "point": Field("points", "parts"),
    "graphics": {
        "x2D": {**_POSITION, "base_body": Field("drawing", "drawing")},
        "x3D": {
            "x3D_frame": MARK,
            "x3D_points": MARK,
            "x3D_lines": MARK,
            "x3D_shapes": Field("shapes", SHAPES),
        },
    },
}
CONNECTION: Table = _fields(name="text", endpoint1="place", endpoint2="place", length="number")
USER_CONSTRAINT: Table = {**_NAME, "joints": {"jointname": Field("joints", "texts")}}
USER_MODEL: Table = {**_NAME, "parameter": Field("parameters", "parts")}
PARAMETER: Table = {**_NAME, "type": Field("type", "text"), "value": Field("values", "texts")}
USER_VARIABLE: Table = {"varname": Field("name", "text"), **_fields(type="text", size="text")}
VIEW: Table = {
    "background": {"color": Field("background", "color")},
    "shapeScaleFactors": _fields(frame="number", joint="number", com="number", point="number"),
    **_fields(viewpoints=frozenset(["viewpoint"]), lights=frozenset(["directionalLight"])),
}
MBS: Table = {
    "mbsname": Field("name", "title"),
    "mbsyspad_version": Field("version", "title"),
    "base": Field("base", "base"),
    "bodytree": Field("bodies", frozenset(["body"])),
    **_fields(cuts=CUTS, links=LINKS, user_constraints=frozenset(["user_constraint"])),
    **_fields(user_models=frozenset(["user_model"]), user_variables=frozenset(["user_variable"])),
    "x3D": Field("view", "view"),
}
#: Elements that are written also when they are empty.
KEPT = frozenset(
    [
        "bodytree",
        "symbols",
        "control_points",
        "joints",
        "x3D",
        "x3D_shapes",
        "viewpoints",
        "lights",
    ]
)

#: An element that holds a part of a value.
_PART = Field("", "text")
_XY: Table = dict.fromkeys("xy", _PART)
_XYZ: Table = dict.fromkeys("xyz", _PART)
#: The children of an element, by the kind of the value that it holds.
INSIDE: dict[str, Table] = {
    "base": BASE,
    "drawing": DRAWING,
    "view": VIEW,
    "xy": _XY,
    "xyz": _XYZ,
    "coordinates": {"coordinates": Field("", "xyz")},
    "control_points": {"control_point": Field("", "xy")},
    "inertia": dict.fromkeys(["Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"], _PART),
    "symbols": dict.fromkeys(["q", "qd", "qdd"], _PART),
    "place": dict.fromkeys(["bodyname", "pointname"], _PART),
}


class ObjectType(NamedTuple):
    """A type of objects of the model, and the table of its element."""

    make: Callable[[str], Any]
    """Returns an empty object; its argument is the key in ``OBJECTS``."""
    table: Table
    noun: str = ""
    """How messages call such an object; empty if none is about it."""
    name_tag: str = ""
    """Tag of the first child, a name that is required; empty if the object needs no name."""
    required: tuple[str, ...] = ()
    """Tags of the other children that are required."""

    def describe(self, mbs_object: Any) -> str:
        """Return an object as messages call it, such as "joint 'knee'"."""
        return f"{self.noun} '{mbs_object.name}'" if self.name_tag else self.noun


def _make_connection(kind: str) -> model.Connection:
    """Return an empty cut or link."""
    return model.Connection(kind, "", ("", ""), ("", ""))


#: The types of objects, by the tags of their elements or by the kinds of values.
OBJECTS = {
    "mbs": ObjectType(lambda _: model.Mbs("", ""), MBS, "the file", required=("base", "bodytree")),
    "base": ObjectType(lambda _: model.Base(""), BASE, "the base", required=("gravity",)),
    "drawing": ObjectType(lambda _: model.Drawing(), DRAWING),
    "view": ObjectType(lambda _: model.View(), VIEW, "the 3D view"),
    "body": ObjectType(lambda _: model.Body(""), BODY, "body", "bodyname", ("parent",)),
    "joint": ObjectType(lambda _: model.Joint("", "", ""), JOINT, "joint", "jointname"),
    "point": ObjectType(lambda _: model.Point(""), POINT, "point", "pointname"),
    "user_constraint": ObjectType(
        lambda _: model.UserConstraint(""), USER_CONSTRAINT, "user constraint", "name"
    ),
    "user_model": ObjectType(lambda _: model.UserModel(""), USER_MODEL, "user model", "name"),
    "parameter": ObjectType(lambda _: model.Parameter("", ""), PARAMETER, "parameter", "name"),
    "user_variable": ObjectType(
        lambda _: model.UserVariable("", "", ""), USER_VARIABLE, "user variable", "varname"
    ),
    "viewpoint": ObjectType(lambda _: model.Viewpoint("", ZERO, ZERO), VIEWPOINT),
    "directionalLight": ObjectType(lambda _: model.Light("", ZERO, active=False), LIGHT),
    **{shape: ObjectType(lambda kind: model.Shape(kind, ""), SHAPE) for shape in SHAPES},
    **{
        kind: ObjectType(_make_connection, CONNECTION, kind, "name", ("endpoint1", "endpoint2"))
        for kind in CUTS | LINKS
    },
}
