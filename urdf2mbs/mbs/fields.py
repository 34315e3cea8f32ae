"""The elements of .mbs that hold one plain value: one table for reading and for writing.

Each table gives, in the order of the file, an element's tag, its field in the model and the kind
of its value.  The elements of bodies, joints and points are not here: they are most of a file,
and writing them by a table would take longer than by one template each.
"""

from __future__ import annotations

from typing import Literal

Kind = Literal["text", "number", "xy", "xyz", "color", "flag", "points"]
Fields = dict[str, tuple[str, Kind]]

SHAPE: Fields = {
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
VIEWPOINT: Fields = {
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
LIGHT: Fields = {
    "name": ("name", "text"),
    "joint": ("joint", "text"),
    "active": ("active", "flag"),
    "direction": ("direction", "xyz"),
}
DRAWING: Fields = {
    "position": ("position", "xy"),
    "name_pos": ("name_pos", "xy"),
    "shape": ("shape", "text"),
    "size": ("size", "xy"),
    "control_points": ("control_points", "points"),
    "angle": ("angle", "number"),
}
FACTORS: Fields = {tag: (tag, "number") for tag in ("frame", "joint", "com", "point")}
