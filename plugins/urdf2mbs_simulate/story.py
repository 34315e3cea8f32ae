"""What happened to a robot on its feet: if it fell, when, and which way; and what went under the
ground, since nothing of it touches.

The ground pushes at the centre of pressure.  While a robot stands, its centre of mass is above this
place, up to how the robot sways.  A robot that tips over its feet leaves this place behind at their
edge: from there to the centre of mass, seen from above, is how far the robot is beside its feet.
"""

from __future__ import annotations

import re
from math import acos, atan2, cos, pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import compute_placement as place
from urdf2mbs_project.places import find_floating_body

if TYPE_CHECKING:
    from urdf2mbs_simulate.results import Results

#: The external forces that are those of the ground, as ``contacts`` calls them.
GROUND = re.compile(r"_contact(_\d+)?_force$")
#: What a robot stands on has touched the ground by then (s), with this part of the weight.
SETTLED, LOADED = 0.2, 0.02
#: A centre of mass is beside the feet from this part of its height on.
BESIDE = 0.03
#: A fallen robot's centre of mass is lower than this part of its height, or its base has tilted by
#: more than this (rad).
LOW, TILTED = 0.7, 0.6
WAYS = ("forward", "to the left", "backward", "to the right")


class Event(NamedTuple):
    time: float
    """s"""
    what: str
    """``left-feet``, of the centre of mass; ``hit-ground``, or ``under-ground``, of a body."""
    words: str


class Story(NamedTuple):
    fell: bool
    events: list[Event]
    words: str


def tell(results: Results) -> Story | None:
    """None of what is bolted down, has no ground, or stands on nothing at the start."""
    motion, name, time = _Motion(results), results.data.mbs_name, results.time
    root = find_floating_body(motion.mbs)
    loaded = {body: push > motion.least for body, push in motion.pushes().items()}
    settled = time <= max(SETTLED, time[1])  # also of few frames
    standing = {body for body, when in loaded.items() if when[settled].any()}
    if root is None or not standing:
        return None
    if motion.has_fallen(root.name, 0):
        words = "does not stand at the equilibrium: its base is not as it was drawn"
        return Story(True, [], f"{name} {words}")
    if not motion.has_fallen(root.name, len(time) - 1):
        (at, rot), (at_last, rot_last) = (motion.bodies(k)[root.name] for k in (0, -1))
        rise = float(motion.up @ (at_last - at)) * 1e3
        tilted = acos(min(1.0, motion.up @ rot_last @ rot.T @ motion.up))
        way = f"{abs(rise):.2g} mm {'lower' if rise < 0.0 else 'higher'}"
        words = f"{name} stands: its base is {way}, and has tilted by {tilted:.2g} rad"
        return Story(False, events := motion.sunk(), "; ".join([words, *_told(events)]))
    hits = {
        body: int(np.argmax(when))
        for body, when in loaded.items()
        if body not in standing and when.any()
    }
    first = min(hits, key=lambda body: hits[body], default="")
    down = next(k for k in range(len(time)) if motion.has_fallen(root.name, k))
    events = [motion.leaves(root.name, min(down, hits.get(first, down)))]
    for body in dict.fromkeys([first, root.name]):
        if body in hits:
            when = float(time[hits[body]])
            events.append(Event(when, "hit-ground", f"'{body}' hit the ground"))
    events += motion.sunk()
    return Story(True, events, f"{name} fell: {'; '.join(_told(events))}")


def _told(events: list[Event]) -> list[str]:
    return [f"at {event.time:.2g} s {event.words}" for event in events]


class _Motion:
    """A robot above the ground, frame by frame."""

    def __init__(self, results: Results) -> None:
        self.results, self.mbs = results, results.data._run.mbs
        gravity = np.array(self.mbs.base.gravity)
        size = float(np.linalg.norm(gravity))
        self.up = -gravity / size if size else np.array([0.0, 0.0, 1.0])
        self.ground = float(results.data.user_model.get("contact", {}).get("ground", 0.0))
        self.mass = sum(body.mass or 0.0 for body in self.mbs.bodies)
        self.least = LOADED * size * self.mass
        self.start = self.bodies(0)
        if results.equilibrium is not None:  # which may be that of a robot that lies
            self.start = self.place(results.equilibrium.drawn)
        self.forces = [
            (body.name, results.external[point.extforce.name])
            for body in self.mbs.bodies
            for point in body.points
            if point.extforce is not None and GROUND.search(point.extforce.name)
        ]

    def pushes(self) -> dict[str, Any]:
        """How hard the ground pushes each body up, in each frame (N)."""
        found: dict[str, Any] = {}
        for body, rows in self.forces:
            found[body] = found.get(body, 0.0) + rows[:, :3] @ self.up
        return found

    def bodies(self, k: int) -> dict[str | None, tuple[Any, Any]]:
        """Place (m) and axes of each body in a frame."""
        return self.place(self.results.q[k])

    def place(self, row: Any) -> dict[str | None, tuple[Any, Any]]:
        """Place (m) and axes of each body, for positions of the joints from index 1."""
        values = {name: float(row[at]) for name, at in self.results.data.joint_id.items()}
        poses = place(self.mbs, values).bodies
        return {n: (np.array(at), np.reshape(rot, (3, 3))) for n, (at, rot) in poses.items()}

    def centre(self, bodies: dict[str | None, tuple[Any, Any]]) -> Any:
        """Of mass, above the ground (m)."""
        parts = ((bodies[body.name], body) for body in self.mbs.bodies)
        moment = sum(
            (body.mass or 0.0) * (at + rot @ (body.com or np.zeros(3))) for (at, rot), body in parts
        )
        return moment / self.mass - self.ground * self.up

    def beside(self, k: int) -> tuple[Any, float]:
        """From the centre of pressure to the centre of mass, along the ground, and how high this
        is (m); not a number where nothing pushes."""
        bodies = self.bodies(k)
        centre, (total, moment) = self.centre(bodies), np.zeros((2, 3))
        for name, rows in self.forces:
            at, rot = bodies[name]
            total += rows[k, :3]
            arm = at + rot @ rows[k, 6:] - self.ground * self.up
            moment += rows[k, 3:6] + np.cross(arm, rows[k, :3])
        height, push = float(self.up @ centre), float(self.up @ total)
        if push <= self.least:
            return np.full(3, np.nan), height
        return centre - height * self.up - np.cross(self.up, moment) / push, height

    def sunk(self) -> list[Event]:
        """When the deepest body of those that do not touch went under the ground, if one did."""
        touching = {name for name, _ in self.forces}

        def depths(k: int) -> dict[str, float]:
            return {
                body.name: self.ground - float(self.up @ (at + rot @ (body.com or np.zeros(3))))
                for body in self.mbs.bodies
                if body.mass and body.name not in touching
                for at, rot in [self.bodies(k)[body.name]]
            }

        last = depths(-1)
        deepest = max(last, key=lambda body: last[body], default="")
        if last.get(deepest, 0.0) <= 0.0:
            return []
        count = len(self.results.time)
        first = next(k for k in range(count) if depths(k)[deepest] > 0.0)
        said = f"'{deepest}' went under the ground, since 'contacts' leaves it out"
        return [Event(float(self.results.time[first]), "under-ground", said)]

    def has_fallen(self, trunk: str, k: int) -> bool:
        start, now = self.start, self.bodies(k)
        tilted = self.up @ now[trunk][1] @ start[trunk][1].T @ self.up < cos(TILTED)
        return bool(tilted or self.up @ self.centre(now) < LOW * (self.up @ self.centre(start)))

    def leaves(self, trunk: str, before: int) -> Event:
        """When the centre of mass has left the feet for good, before a frame."""
        fallen = self.centre(self.bodies(before)) - self.centre(self.bodies(0))
        fallen -= self.up * (self.up @ fallen)
        fallen /= np.linalg.norm(fallen) or 1.0
        left = before
        for k in range(before - 1, -1, -1):
            away, height = self.beside(k)
            if away @ fallen < BESIDE * height:
                break
            left = left if np.isnan(away).any() else k
        away, height = self.beside(left)
        time, far = float(self.results.time[left]), float(away @ fallen)
        if np.isnan(far):
            return Event(time, "left-feet", "its feet left the ground")
        if far < BESIDE * height:
            return Event(time, "left-feet", "it tipped over")
        ahead = self.bodies(left)[trunk][1][:, 0]
        way = WAYS[round(atan2(self.up @ np.cross(ahead, fallen), ahead @ fallen) * 2 / pi) % 4]
        said = f"the centre of mass left the feet, {far * 1e3:.0f} mm {way}"
        return Event(time, "left-feet", said)
