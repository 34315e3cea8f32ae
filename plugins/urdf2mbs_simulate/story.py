"""Summary of the motion of a robot on its feet: whether, when and in which direction it fell.

It also names a body that went through the ground, as it has no contacts.

The ground pushes at the centre of pressure.  While a robot stands, its centre of mass is above this
point, up to the sway of the robot.  When a robot tips over the edge of its feet, the centre of
pressure stays at the edge.  The horizontal offset from there to the centre of mass says how far the
robot is beside its feet::

      stands             tips over

        o                     o   centre of mass
        |                    /:
        |                   / :
        |                  /  :
    ____|____         ____/   :
        ^                 ^---:   offset
        centre of pressure
"""

from __future__ import annotations

import re
from math import acos, atan2, cos, pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import compute_placement
from urdf2mbs_project.places import find_floating_body

if TYPE_CHECKING:
    from urdf2mbs_simulate.results import Results

#: The external forces that are those of the ground, as ``contacts`` names them.
GROUND_FORCE = re.compile(r"_contact(_\d+)?_force$")
#: A body on which the robot stands is loaded in this time (s), by this part of the weight.
SETTLING_TIME, MIN_LOAD = 0.2, 0.02
#: A robot is beside its feet from this offset on, relative to the height of its centre of mass.
MAX_OFFSET = 0.03
#: A robot that has been beside its feet for this time (s), and moves on, is tipping.
TIPPING_TIME = 0.1
#: A fallen robot's centre of mass is lower than this part of its height at the start, or its base
#: has tilted by more (rad).
FALLEN_HEIGHT, FALLEN_TILT = 0.7, 0.6
#: By quarter turns from the x axis of the base.
DIRECTIONS = ("forward", "to the left", "backward", "to the right")


class Event(NamedTuple):
    """Something that happened to a robot."""

    time: float
    """s"""
    what: str
    """``left-feet``, of the centre of mass; ``hit-ground``, or ``under-ground``, of a body."""
    words: str


class Story(NamedTuple):
    """What happened to a robot that stood at the start."""

    fell: bool
    events: list[Event]
    words: str


class Departure(NamedTuple):
    """Since when the centre of mass of a robot is beside its feet."""

    frame: int
    """The last one that was looked at, if it is above them there."""
    direction: Any
    """The horizontal direction in which the centre of mass has moved; (3)."""


class BodyPose(NamedTuple):
    """The pose of a body in the axes of the base."""

    position: Any
    """(3), m"""
    rotation: Any
    """(3, 3); its columns are the axes of the body."""


Poses = dict[str | None, BodyPose]


def summarize_motion(results: Results) -> Story | None:
    """Summarize the motion of a robot on its feet.

    Returns:
        None for a model that is fixed to the ground, has no ground, or does not stand on it at the
        start.
    """
    motion, name, time = RobotMotion(results), results.data.mbs_name, results.time
    root = find_floating_body(motion.mbs)
    loaded = {body: force > motion.min_load for body, force in motion.ground_forces().items()}
    is_start = time <= max(SETTLING_TIME, time[1])  # two frames, however few there are
    standing = {body for body, frames in loaded.items() if frames[is_start].any()}
    if root is None or not standing:
        return None
    if motion.has_fallen(root.name, 0):
        words = "does not stand at the equilibrium: its base is not as it was drawn"
        return Story(True, [], f"{name} {words}")
    last = len(time) - 1
    if not motion.has_fallen(root.name, last):
        events = motion.find_sunk_bodies()
        departure = motion.find_departure(last)
        if motion.is_tipping(departure, last):
            events = [motion.describe_tipping(root.name, departure), *events]
            words = f"{name} is tipping when the run ends, and may fall (--time): "
            return Story(False, events, words + "; ".join(_format_events(events)))
        words = f"{name} stands: {motion.describe_base(root.name)}"
        return Story(False, events, "; ".join([words, *_format_events(events)]))
    # of each body on which the robot did not stand: the first frame that it touches the ground in
    hits = {
        body: int(np.argmax(frames))
        for body, frames in loaded.items()
        if body not in standing and frames.any()
    }
    first_body = min(hits, key=lambda body: hits[body], default="")
    fallen = next(k for k in range(len(time)) if motion.has_fallen(root.name, k))
    last_upright = min(fallen, hits.get(first_body, fallen))
    events = [motion.describe_tipping(root.name, motion.find_departure(last_upright))]
    for body in dict.fromkeys([first_body, root.name]):
        if body in hits:
            hit_time = float(time[hits[body]])
            events.append(Event(hit_time, "hit-ground", f"'{body}' hit the ground"))
    events += motion.find_sunk_bodies()
    return Story(True, events, f"{name} fell: {'; '.join(_format_events(events))}")


def _format_events(events: list[Event]) -> list[str]:
    return [f"at {event.time:.2g} s {event.words}" for event in events]


class RobotMotion:
    """The motion of a robot above the ground, frame by frame."""

    def __init__(self, results: Results) -> None:
        self.results, self.mbs = results, results.data._run.mbs
        gravity = np.array(self.mbs.base.gravity)
        size = float(np.linalg.norm(gravity))
        self.up = -gravity / size if size else np.array([0.0, 0.0, 1.0])
        self.ground = float(results.data.user_model.get("contact", {}).get("ground", 0.0))
        """The height of the ground (m)."""
        self.mass = sum(body.mass or 0.0 for body in self.mbs.bodies)
        self.min_load = MIN_LOAD * size * self.mass
        """The least force (N) on a body on which the robot stands."""
        self.start_poses = self.get_poses(0)
        if results.equilibrium is not None:  # a robot that lies may be in equilibrium, too
            self.start_poses = self.compute_poses(results.equilibrium.start_q)
        self.wrenches = [
            (body.name, results.external[point.extforce.name])
            for body in self.mbs.bodies
            for point in body.points
            if point.extforce is not None and GROUND_FORCE.search(point.extforce.name)
        ]
        """Of the ground on a body, in each frame: see ``WRENCH`` of results."""

    def ground_forces(self) -> dict[str, Any]:
        """Return the upward force (N) of the ground on each body, in each frame."""
        forces: dict[str, Any] = {}
        for body, wrenches in self.wrenches:
            forces[body] = forces.get(body, 0.0) + wrenches[:, :3] @ self.up
        return forces

    def get_poses(self, k: int) -> Poses:
        """Return the pose of each body in a frame."""
        return self.compute_poses(self.results.q[k])

    def compute_poses(self, q: Any) -> Poses:
        """Return the pose of each body, for positions of the joints from index 1."""
        joints = self.results.data.joint_id
        positions = {name: float(q[number]) for name, number in joints.items()}
        poses = compute_placement(self.mbs, positions).bodies
        return {
            body: BodyPose(np.array(position), np.reshape(rotation, (3, 3)))
            for body, (position, rotation) in poses.items()
        }

    def centre_of_mass(self, poses: Poses) -> Any:
        """Return the centre of mass (m), with the height above the ground."""
        moment = sum(
            (body.mass or 0.0) * self._body_centre(body, poses) for body in self.mbs.bodies
        )
        return moment / self.mass - self.ground * self.up

    def _body_centre(self, body: Any, poses: Poses) -> Any:
        pose = poses[body.name]
        return pose.position + pose.rotation @ (body.com or np.zeros(3))

    def compute_offset(self, k: int) -> tuple[Any, float]:
        """Compute how far a robot is beside the centre of pressure, in a frame.

        Returns:
            The horizontal offset (3, m) of the centre of mass from the centre of pressure, NaN
            where the ground does not push; and the height of the centre of mass (m).
        """
        poses = self.get_poses(k)
        centre, (total_force, moment) = self.centre_of_mass(poses), np.zeros((2, 3))
        for body, wrenches in self.wrenches:
            pose = poses[body]
            total_force += wrenches[k, :3]
            lever = pose.position + pose.rotation @ wrenches[k, 6:] - self.ground * self.up
            moment += wrenches[k, 3:6] + np.cross(lever, wrenches[k, :3])
        height, load = float(self.up @ centre), float(self.up @ total_force)
        if load <= self.min_load:
            return np.full(3, np.nan), height
        return centre - height * self.up - np.cross(self.up, moment) / load, height

    def describe_base(self, root: str) -> str:
        """Describe how the base has moved from the first to the last frame."""
        first, last = self.get_poses(0)[root], self.get_poses(-1)[root]
        rise = float(self.up @ (last.position - first.position)) * 1e3
        cosine = self.up @ last.rotation @ first.rotation.T @ self.up
        tilt = acos(min(1.0, cosine))
        direction = "lower" if rise < 0.0 else "higher"
        return f"its base is {abs(rise):.2g} mm {direction}, and has tilted by {tilt:.2g} rad"

    def find_sunk_bodies(self) -> list[Event]:
        """Find the deepest body without contacts, and when it went under the ground, if it did."""
        touching = {body for body, _ in self.wrenches}
        bodies = [body for body in self.mbs.bodies if body.mass and body.name not in touching]

        def compute_depths(k: int) -> dict[str, float]:
            poses = self.get_poses(k)
            return {
                body.name: self.ground - float(self.up @ self._body_centre(body, poses))
                for body in bodies
            }

        depths = compute_depths(-1)
        deepest = max(depths, key=lambda body: depths[body], default="")
        if depths.get(deepest, 0.0) <= 0.0:
            return []
        n_frames = len(self.results.time)
        first = next(k for k in range(n_frames) if compute_depths(k)[deepest] > 0.0)
        words = f"'{deepest}' went under the ground, since 'contacts' leaves it out"
        return [Event(float(self.results.time[first]), "under-ground", words)]

    def has_fallen(self, root: str, k: int) -> bool:
        """Return True if the base has tilted, or the centre of mass is low, in a frame."""
        start, poses = self.start_poses, self.get_poses(k)
        cosine = self.up @ poses[root].rotation @ start[root].rotation.T @ self.up
        height = self.up @ self.centre_of_mass(poses)
        start_height = self.up @ self.centre_of_mass(start)
        return bool(cosine < cos(FALLEN_TILT) or height < FALLEN_HEIGHT * start_height)

    def is_tipping(self, departure: Departure, last: int) -> bool:
        """Return True if the centre of mass has long been beside the feet, and moved away.

        A push, or a foot that touches the ground again, moves the centre of pressure of a robot
        that stands, too, but then the centre of mass stays or comes back.
        """
        k, direction = departure
        offset, height = self.compute_offset(k)
        moved = self.centre_of_mass(self.get_poses(last)) - self.centre_of_mass(self.get_poses(k))
        return bool(
            self.results.time[last] - self.results.time[k] >= TIPPING_TIME
            and offset @ direction >= MAX_OFFSET * height  # NaN in the air
            and moved @ direction >= MAX_OFFSET * height
        )

    def find_departure(self, last: int) -> Departure:
        """Find when the centre of mass left the feet and did not come back, until a frame."""
        direction = self.centre_of_mass(self.get_poses(last))
        direction = direction - self.centre_of_mass(self.get_poses(0))
        direction -= self.up * (self.up @ direction)
        direction /= np.linalg.norm(direction) or 1.0
        departure = last
        for k in range(last - 1, -1, -1):
            offset, height = self.compute_offset(k)
            if offset @ direction < MAX_OFFSET * height:
                break
            departure = departure if np.isnan(offset).any() else k
        return Departure(departure, direction)

    def describe_tipping(self, root: str, departure: Departure) -> Event:
        """Describe when and in which direction the centre of mass left the feet."""
        k, direction = departure
        offset, height = self.compute_offset(k)
        time, distance = float(self.results.time[k]), float(offset @ direction)
        if np.isnan(distance):
            return Event(time, "left-feet", "its feet left the ground")
        if distance < MAX_OFFSET * height:
            return Event(time, "left-feet", "it tipped over")
        ahead = self.get_poses(k)[root].rotation[:, 0]
        left = np.cross(ahead, direction)
        quarters = round(atan2(self.up @ left, ahead @ direction) * 2 / pi)
        words = f"the centre of mass left the feet, {distance * 1e3:.0f} mm "
        return Event(time, "left-feet", words + DIRECTIONS[quarters % 4])
