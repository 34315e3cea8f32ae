"""A robot as rigid groups: all that no moving joint separates."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from urdf2mbs.proof.rigid import HERE, ORIGIN, Frame, Inertia, X, compose
from urdf2mbs.spatial import Vec


class Group(msgspec.Struct):
    """A rigid group: how it hangs on its parent group, and what is in it."""

    parent: int
    before: Frame
    """Where its joint stands in the parent group; the group's own frame is the one after it."""
    turns: bool
    axis: Vec
    """Along or about which it moves, in both frames."""
    move: Callable[[float], Frame]
    coordinate: str
    joint: str
    child: str
    """The link or body that the joint leads to."""
    reach: float = 0.0
    """The largest distance (m) of its joint in the parent group, and of its parts in it."""
    inertias: list[tuple[str, Inertia]] = []
    """Of each link or body."""
    carries: list[int] = []
    """The groups that hang on it."""
    held: list[str] = []
    """The driven joints just before its joint in the body (.mbs), such as ``R3 1.57``."""


class Side(msgspec.Struct):
    """One of the two descriptions, as rigid groups; group 0 is the ground."""

    groups: list[Group]
    frames: dict[str, tuple[int, Frame]]
    """Of each link (URDF) or body (.mbs): its group, and its pose in the group."""
    created: dict[str, int]
    """The group that each coordinate moves."""
    after: dict[str, tuple[int, Frame]] = {}
    """The frames after joints (.mbs), which may be called as another body: groups and poses."""
    mass: float = 0.0
    """kg, of all that can move."""
    gravity: Vec = ORIGIN
    """m/s^2, in the axes of the ground."""

    def add(self, group: Group) -> int:
        """Hang a group on its parent group; gives its number."""
        parent, number = self.groups[group.parent], len(self.groups)
        x, y, z = group.before[9:]
        group.reach = max(abs(x), abs(y), abs(z))
        parent.reach = max(parent.reach, group.reach)
        parent.carries.append(number)
        self.created[group.coordinate] = number
        self.groups.append(group)
        return number

    def put(self, name: str, group: int, inertia: Inertia) -> None:
        """Put a link or body, seen from a group's frame, into the group."""
        x, y, z = inertia[1]
        owner = self.groups[group]
        owner.reach = max(owner.reach, abs(x), abs(y), abs(z))
        owner.inertias.append((name, inertia))

    def world(self) -> list[Frame]:
        """The pose of every group at zero."""
        out = [HERE]
        for group in self.groups[1:]:
            out.append(compose(out[group.parent], group.before))
        return out


def only_ground(root: str) -> Side:
    """A side that has the ground alone, with the root on it."""
    ground = Group(0, HERE, False, X, lambda _: HERE, "", "", "")
    return Side([ground], {root: (0, HERE)}, {})
