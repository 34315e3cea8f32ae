"""A robot as rigid groups: all that no moving joint separates."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from urdf2mbs.proof.rigid import HERE, Frame, Inertia, X, compose
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
    reach: float
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
    gravity: Vec | None = None
    """m/s^2, in the axes of the ground; a URDF has none."""

    def add(
        self,
        parent: int,
        before: Frame,
        turns: bool,
        axis: Vec,
        move: Callable[[float], Frame],
        coordinate: str,
        joint: str,
        child: str,
    ) -> int:
        reach = max(abs(before[9]), abs(before[10]), abs(before[11]))
        if reach > self.groups[parent].reach:
            self.groups[parent].reach = reach
        group = Group(parent, before, turns, axis, move, coordinate, joint, child, reach)
        number = self.created[coordinate] = len(self.groups)
        self.groups.append(group)
        self.groups[parent].carries.append(number)
        return number

    def put(self, name: str, group: int, inertia: Inertia) -> None:
        x, y, z = inertia[1]
        reach = max(abs(x), abs(y), abs(z))
        if reach > self.groups[group].reach:
            self.groups[group].reach = reach
        self.groups[group].inertias.append((name, inertia))

    def world(self) -> list[Frame]:
        """The pose of every group at zero."""
        out = [HERE]
        for group in self.groups[1:]:
            out.append(compose(out[group.parent], group.before))
        return out


def only_ground(root: str) -> Side:
    """A side that has the ground alone, with the root on it."""
    ground = Group(0, HERE, False, X, lambda _: HERE, "", "", "", 0.0)
    return Side([ground], {root: (0, HERE)}, {})
