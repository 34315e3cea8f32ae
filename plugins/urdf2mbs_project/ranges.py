"""The ranges of numbers in the options of forces and contacts, and the points of links."""

from typing import Annotated

from msgspec import Meta, Struct

#: A coordinate (m, or rad of a joint).
Coordinate = Annotated[float, Meta(ge=-1e6, le=1e6)]
#: A position or direction, as three coordinates.
Position = tuple[Coordinate, Coordinate, Coordinate]


class End(Struct, forbid_unknown_fields=True):
    """A point of a link, where a cut or a spring ends."""

    link: str
    """The link that has the point."""
    at: Position = (0.0, 0.0, 0.0)
    """Position in the link's frame (m)."""


#: A length (m).
Length = Annotated[float, Meta(ge=0.0, le=1e6)]
#: A speed (m/s, or rad/s of a joint).
Speed = Annotated[float, Meta(gt=0.0, le=1e3)]
#: A time (s).
Time = Annotated[float, Meta(ge=-1e9, le=1e9)]
#: A component of a force (N) or torque (N m) along an axis of the base.
Force = Annotated[float, Meta(ge=-1e9, le=1e9)]
#: A stiffness (N/m, N m/rad) or damping (N s/m, N m s/rad).
Gain = Annotated[float, Meta(ge=0.0, le=1e12)]
