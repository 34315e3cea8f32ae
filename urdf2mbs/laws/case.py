"""A project's code beside its robot: what the laws compare, and what they have found."""

from __future__ import annotations

from functools import cached_property
from math import floor, isfinite, log10
from typing import Any, Protocol

import numpy as np

from urdf2mbs.conversion import Conversion
from urdf2mbs.laws.motion import Motion, Place
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.proof.coordinates import coordinates
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.urdf_side import urdf_side
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.spatial import Vec

#: The largest deviation that is no difference, relative to the largest number it is compared with.
TOLERANCE = 1e-8
#: A step (s) so short that numbers have given way to make it no shorter (the pass time-step).
SOFTENED = 2e-5


class Code(Protocol):
    """A project's user functions and equations in one language.  Arrays count from 1."""

    language: str
    has_equations: bool
    """True if the project has equations of its own."""
    start: Any
    """Positions at start."""

    def set(self, model: str, name: str, value: float) -> None:
        """Set a number of a user model."""

    def get(self, model: str, name: str) -> float | None: ...
    def joint_forces(self, q: Any, qd: Any) -> Any: ...
    def external(self, force: str, at: Any, speed: Any, time: float) -> Any:
        """Force and torque, and where they act (m, in the body): nine numbers."""

    def spring(self, link: str, length: float, rate: float) -> float: ...
    def constraints(self, q: Any, qd: Any) -> tuple[Any, Any, Any]:
        """h, its derivatives by q, and the time derivative of these times qd."""

    def follow(self, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any, Any]: ...
    def imu(self, name: str, point: str, at: Place) -> Any:
        """Specific force and angular velocity, of a sensor that moves as ``at``."""

    def force_torque(self, name: str, forces: Any) -> Any | None:
        """Force and torque, from the forces that hold driven joints."""

    def measure(self, point: str, q: Any, qd: Any, qdd: Any) -> tuple[Any, ...]:
        """P, V, A, OM, OMP, R and J of a sensor, by the equations."""

    def inverse(self, q: Any, qd: Any, qdd: Any) -> Any:
        """The forces of the joints, without those that the user functions give joints."""

    def forward(self, q: Any, qd: Any) -> tuple[Any, Any, Any, Any] | None:
        """q, qd, qdd and Qq with closed loops; None where these cannot be closed."""


class Case:
    """A project's code, the robot that it is of, and the differences of the two."""

    def __init__(self, conversion: Conversion, mbs: Mbs, code: Code) -> None:
        self.conversion, self.mbs, self.code = conversion, mbs, code
        self.simulation, self.asked = conversion.simulation, conversion.asked
        self.found: list[Difference] = []
        self.unproven: dict[str, str] = {}
        self.robot = robot = conversion.robot.with_flipped(conversion.names.flipped)
        driven = [coupling.follower.name for coupling in self.simulation.driven]
        names = conversion.names.coordinates
        known = coordinates(robot, mbs, names, conversion.frozen, {}, driven)
        self.numbers = mbs.numbers()
        #: Robotran's number of each coordinate of the URDF that moves.
        self.moving = {own: self.numbers[name] for own, name in known.names.items()}
        #: The URDF's joints that move by one coordinate, and their names in the .mbs.
        self.single = {
            name: names[name][0]
            for name, joint in robot.joints.items()
            if joint.moves and name not in conversion.frozen and len(names.get(name, ())) == 1
        }
        joints = mbs.joints()
        self.natures = {self.numbers[name]: joint.nature for name, joint in joints.items()}
        self.ours = Motion(urdf_side(robot, known.names, known.held, {}), self.moving, len(joints) + 1)
        theirs = mbs_side(mbs, set(known.names.values()), framed=joints)
        self.theirs = Motion(theirs, self.numbers, len(joints) + 1)
        self._states: dict[int, Any] = {}
        self.random = np.random.default_rng(20)
        self.points = {
            thing.name: (body, point)
            for body, owner in mbs.owners()
            for point in owner.points
            for thing in (point.extforce, point.sensor)
            if thing is not None
        }

    def state(self, reach: float = np.pi) -> tuple[Any, Any, Any]:
        """Random q, qd and qdd of what moves; what is held stays at its start."""
        out = np.array([self.code.start, 0.0 * self.code.start, 0.0 * self.code.start])
        moving = list(self.moving.values())
        out[:, moving] += self.random.uniform(-1.0, 1.0, (3, len(moving))) * [[reach], [1.0], [1.0]]
        return out[0], out[1], out[2]

    # --- where things are ---

    def on_link(self, link: str, at: Vec, qdd: Any = None) -> Place:
        """A place of a link at the present state (m, in its frame), by the URDF."""
        return self.ours.on(link, at, np.zeros(self.ours.size) if qdd is None else qdd)

    def in_mbs(self, body: str | None, at: Vec, qdd: Any = None) -> Place:
        """A place of a body at the present state (m, in its frame), by the .mbs."""
        return self.theirs.on(body, at, np.zeros(self.theirs.size) if qdd is None else qdd)

    def move(self, q: Any, qd: Any) -> None:
        self.ours, self.theirs = self.ours.moved(q, qd), self.theirs.moved(q, qd)

    def go(self, state: int) -> tuple[Any, Any, Any]:
        """Go to a state that laws share: 0 is the start, others are random.  Gives q, qd, qdd."""
        if state not in self._states:
            still = np.zeros((3, self.ours.size))
            still[0] = self.code.start
            q, qd, qdd = self.state() if state else still
            self.move(q, qd)
            self._states[state] = (q, qd, qdd), self.ours, self.theirs
        motion, self.ours, self.theirs = self._states[state]
        return motion

    def on_its_link(self, thing: str, link: str) -> Any:
        """Where the point of a force or sensor is on a link (m); None: it does not move with it."""
        body, point = self.points[thing]
        found = []
        for state in (1, 2):
            self.go(state)
            at, there = self.on_link(link, (0.0, 0.0, 0.0)), self.in_mbs(body, point.coordinates)
            found.append(at.axes.T @ (there.at - at.at))
        return found[0] if self.near(*found, self.size) else None

    def is_there(self, what: str, body: str | None, at: Vec, link: str, meant: Vec) -> None:
        """A place of a body must be a place of a link."""
        self.go(1)
        self.compare(what, self.on_link(link, meant).at, self.in_mbs(body, at).at, self.size, "m")

    @cached_property
    def size(self) -> float:
        """m"""
        return max(group.reach for group in self.ours.side.groups) or 1.0

    @cached_property
    def reduction(self) -> Any:
        """The velocities of all joints by those of the independent joints, at the start."""
        self.go(0)
        rows = self.constraints()
        free, bound = (
            [k for k, nature in self.natures.items() if nature == kind]
            for kind in ("independent", "dependent")
        )
        out = np.zeros((self.ours.size, len(free)))
        out[free] = np.eye(len(free))
        if bound:
            out[bound] = -np.linalg.pinv(rows[:, bound]) @ rows[:, free]
        return out

    def constraints(self) -> Any:
        """The derivatives of all constraints by the joints, at the present state."""
        from urdf2mbs.laws import equations, followers

        rows = [row for row, _ in followers.rules(self, "dependent").values()]
        rows += [row for cut in self.mbs.cuts for row in equations.gap(self, cut)[1]]
        return np.array(rows).reshape(-1, self.ours.size)

    @cached_property
    def inertias(self) -> tuple[Any, Any]:
        """What each joint carries with all that follows it, and what it feels while all other
        joints are free (kg m^2, kg), at the start."""
        turn = self.reduction
        self.go(0)
        matrix = turn.T @ self.ours.equations((0.0, 0.0, 0.0))[0] @ turn
        mobility = ((turn @ np.linalg.pinv(matrix, 1e-13, True)) * turn).sum(axis=1)
        felt = np.divide(1.0, mobility, where=mobility > 0.0, out=np.zeros(len(turn)))
        return ((turn @ matrix) * turn).sum(axis=1), felt

    # --- what is found ---

    def differ(self, what: str, message: str, size: float = 1.0, kind: str = "code") -> None:
        said = f"{what}: {message}" + f" ({self.code.language})" * (kind == "code")
        self.found.append(Difference(kind, said, min(size, 1.0)))

    def near(self, should: Any, value: Any, scale: float = 0.0) -> bool:
        return self._off(should, value, scale) <= TOLERANCE

    def _off(self, should: Any, value: Any, scale: float) -> float:
        should, value = np.asarray(should, float), np.asarray(value, float)
        largest = max(float(np.abs(should).max(initial=0.0)), scale)
        off = float(np.abs(value - should).max(initial=0.0))
        off = off / largest if largest else off
        return off if isfinite(off) else 1.0

    def compare(
        self, what: str, should: Any, value: Any, scale: float = 0.0, unit: str = "",
        kind: str = "code",
    ) -> None:  # fmt: skip
        """Numbers that must be equal, relative to the largest of them and to ``scale``."""
        off = self._off(should, value, scale)
        if off > TOLERANCE:
            should, value = np.broadcast_arrays(np.asarray(should, float), np.asarray(value, float))
            worst = int(np.abs(value - should).argmax())
            if should.size > 6:
                should, value = should.ravel()[worst], value.ravel()[worst]
            said = f"is {_short(value)}, and should be {_short(should)} {unit}".rstrip()
            self.differ(what, said, off, kind)

    def compare_joints(
        self, term: str, should: Any, value: Any, unit: str = "N m or N", scale: Any = None
    ) -> None:
        """A number of each joint."""
        scale = 1e-6 * np.abs(should).max(initial=0.0) + (np.abs(should) if scale is None else scale)
        wrong = ~(np.abs(value - should) <= TOLERANCE * scale)
        for name, number in self.numbers.items():
            if wrong[number]:
                what = f"joint '{name}': {term}"
                self.compare(what, should[number], value[number], scale[number], unit)

    def choice(self, what: str, value: float | None, should: float, soft: int = 0) -> None:
        """A number that urdf2mbs chose, to two digits; ``soft``: 1 if it may be smaller where
        numbers have given way to the time step, -1 if larger."""
        if value is None or not (
            abs(value - should) <= 0.5000001 * 10.0 ** (floor(log10(abs(should) or 1.0)) - 1)
            or (soft * (should - value) > 0.0 and self.simulation.time_step < SOFTENED)
        ):
            said = "is missing" if value is None else f"is {value:.9g}"
            self.differ(what, f"{said}, and should be {should:.2g}", kind="forces")


def _short(value: Any) -> str:
    numbers = np.asarray(value, float).ravel()
    text = ", ".join(f"{number:.6g}" for number in numbers)
    return text if len(numbers) == 1 else f"({text})"
