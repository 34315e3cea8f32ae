"""The numbers that an option of forces and contacts may be, and where these act."""

from typing import Annotated

from msgspec import Meta, Struct

#: A coordinate (m, or rad of a joint), and a place or direction in three.
Coordinate = Annotated[float, Meta(ge=-1e6, le=1e6)]
Place = tuple[Coordinate, Coordinate, Coordinate]


class End(Struct, forbid_unknown_fields=True):
    """A point of a link, where a cut or a spring ends."""

    link: str
    """Where it ends."""
    at: Place = (0.0, 0.0, 0.0)
    """In the link's frame (m)."""


#: m.
Length = Annotated[float, Meta(ge=0.0, le=1e6)]
#: m/s, or rad/s of a joint.
Speed = Annotated[float, Meta(gt=0.0, le=1e3)]
#: s.
Time = Annotated[float, Meta(ge=-1e9, le=1e9)]
#: N, or N m, along an axis of the base.
Force = Annotated[float, Meta(ge=-1e9, le=1e9)]
#: N/m or N m/rad; N s/m or N m s/rad.
Gain = Annotated[float, Meta(ge=0.0, le=1e12)]
