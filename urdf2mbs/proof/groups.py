"""A robot as rigid groups.

All bodies that no moving joint separates are one *rigid group*: they move as one solid.  Group 0 is
the ground.  Each other group is attached to its parent group by one coordinate::

    parent group's frame
           |
           |  joint_frame     constant: the joint at zero
           v
      joint at zero
           |
           |  motion(q)       a rotation about, or a shift along, the axis
           v
     group's frame            in which its bodies are given
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import msgspec

from urdf2mbs.proof.rigid import IDENTITY, ORIGIN, Frame, Inertia, X, compose
from urdf2mbs.spatial import Vec


class PlacedFrame(NamedTuple):
    """A frame that is fixed in a rigid group."""

    group: int
    """Number of the group."""
    pose: Frame
    """In the frame of the group."""


class Group(msgspec.Struct):
    """A rigid group, and the joint by which it is attached to its parent group."""

    parent: int
    """Number of the parent group."""
    joint_frame: Frame
    """Pose of the group's frame in the parent group's frame, the joint at zero."""
    revolute: bool
    """True for a rotation, False for a shift."""
    axis: Vec
    """About or along which the joint moves; it is the same in both frames."""
    motion: Callable[[float], Frame]
    """J(q): the motion of the joint from zero to a position (rad or m)."""
    coordinate: str
    """Name of the coordinate."""
    joint: str
    """Name of the joint."""
    child: str
    """The link (URDF) or body (.mbs) to which the joint leads."""
    reach: float = 0.0
    """Largest absolute coordinate (m): of its joint in the parent group; of its children's joints
    and its centres of mass in this group.  It is the scale of deviations."""
    inertias: dict[str, Inertia] = {}
    """Of each link or body, in the frame of the group."""
    children: list[int] = []
    """Numbers of the groups that are attached to it."""
    driven_before: list[str] = []
    """The driven joints just before its joint in the body (.mbs), such as ``R3 1.57``."""


class Side(msgspec.Struct):
    """One of the two descriptions of a robot, as rigid groups."""

    groups: list[Group]
    """Parents before children; group 0 is the ground."""
    frames: dict[str, PlacedFrame]
    """Of each link (URDF) or body (.mbs); the base of an .mbs is ``""``."""
    group_of_coordinate: dict[str, int] = {}
    """Number of the group that each coordinate moves."""
    frames_after_joints: dict[str, PlacedFrame] = {}
    """Of some joints of an .mbs: the frame that the joint moves."""
    moving_mass: float = 0.0
    """kg, of all bodies that can move."""
    gravity: Vec = ORIGIN
    """m/s^2, in the axes of the ground."""

    def add_group(self, group: Group) -> int:
        """Attach a group to its parent group, and return its number."""
        parent, number = self.groups[group.parent], len(self.groups)
        x, y, z = group.joint_frame[9:]
        group.reach = max(abs(x), abs(y), abs(z))
        parent.reach = max(parent.reach, group.reach)
        parent.children.append(number)
        self.group_of_coordinate[group.coordinate] = number
        self.groups.append(group)
        return number

    def add_inertia(self, name: str, number: int, inertia: Inertia) -> None:
        """Add a link or body to a group, its inertia in the frame of the group."""
        x, y, z = inertia.centre
        group = self.groups[number]
        group.reach = max(group.reach, abs(x), abs(y), abs(z))
        group.inertias[name] = inertia

    def compute_poses(self, positions: Mapping[str, float] | None = None) -> list[Frame]:
        """Compute the pose of each group in the ground.

        Args:
            positions: The positions (rad or m) of coordinates that are not at zero.
        """
        poses = [IDENTITY]
        for group in self.groups[1:]:
            pose = compose(poses[group.parent], group.joint_frame)
            position = 0.0 if positions is None else positions.get(group.coordinate, 0.0)
            poses.append(compose(pose, group.motion(position)) if position else pose)
        return poses


def create_side(root: str) -> Side:
    """Create a side that has the ground alone, and the root link or base on it."""
    ground = Group(
        parent=0,
        joint_frame=IDENTITY,
        revolute=False,
        axis=X,
        motion=lambda _: IDENTITY,
        coordinate="",
        joint="",
        child="",
    )
    return Side([ground], {root: PlacedFrame(0, IDENTITY)})
