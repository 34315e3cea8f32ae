"""A project's code beside its robot: what the laws compare, and what they have found."""

from __future__ import annotations

import sys
from functools import cached_property
from typing import Any

import numpy as np

from oracle.motion import Motion, Place
from urdf2mbs.proof.coordinates import coordinates
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.urdf_side import urdf_side
from urdf2mbs.proof.verdict import Difference
from urdf2mbs.spatial import ZERO, Vec

#: The largest deviation that is no difference, relative to the largest number it is compared with.
TOLERANCE = 1e-8


class Case:
    """A project's code, the robot that it is of, and the differences of the two.

    Arrays of joints count from 1, as Robotran's do.  Vectors are in the axes of the base.
    """

    has_equations = False
    """True if the project has equations of motion."""

    def __init__(self, conversion: Any, data: Any, code: Any) -> None:
        """``data`` and ``code``: the runtime's MbsData and PythonCode."""
        self.conversion, self.data, self.code, self.mbs = conversion, data, code, data.mbs
        self.simulation = conversion.simulation
        self.asked: Any = conversion.asked
        self.gravity = conversion.settings.config.gravity
        self.found: dict[str, Difference] = {}
        self.unproven: dict[str, str] = {}
        self.robot = robot = conversion.robot
        driven = [coupling.follower.name for coupling in self.simulation.driven]
        names, numbers = conversion.names.coordinates, data.joint_id
        known = coordinates(robot, self.mbs, names, conversion.frozen, {}, driven)
        moving = {own: numbers[name] for own, name in known.names.items()}
        #: Robotran's numbers of the joints that move.
        self.moving = list(moving.values())
        #: Robotran's number of each joint of the URDF that moves by one coordinate.
        self.single = {
            name: numbers[names[name][0]]
            for name, joint in robot.joints.items()
            if joint.moves and name not in conversion.frozen and len(names.get(name, ())) == 1
        }
        joints = self.mbs.joints()
        self.natures = ["", *(joint.nature for joint in joints.values())]
        theirs = mbs_side(self.mbs, set(known.names.values()), framed=joints)
        self.ours = Motion(urdf_side(robot, known.names, known.held, {}), moving, len(joints) + 1)
        self.theirs = Motion(theirs, numbers, len(joints) + 1)
        self.random = np.random.default_rng(20)
        self._states: dict[int, Any] = {}
        #: The body and the point of each external force and sensor.
        self.points = {
            thing.name: (body, point)
            for body, owner in self.mbs.owners()
            for point in owner.points
            for thing in (point.extforce, point.sensor)
            if thing is not None
        }

    # --- states ---

    def go(self, state: int) -> tuple[Any, Any, Any]:
        """Go to one of the states that laws share: 0 is the start, others are random.  Gives q,
        qd and qdd."""
        if state not in self._states:
            out = self.near_start(np.pi if state else 0.0)
            self.move(*out[:2])
            self._states[state] = out, self.ours, self.theirs
        (q, qd, qdd), self.ours, self.theirs = self._states[state]
        return q, qd, qdd

    def near_start(self, reach: float) -> tuple[Any, Any, Any]:
        """Random qd and qdd of what moves, and q at most ``reach`` (rad, m) from the start."""
        q, qd, qdd = np.array([self.data.q0, *np.zeros((2, self.ours.size))])
        out = self.random.uniform(-1.0, 1.0, (3, len(self.moving)))
        q[self.moving] += reach * out[0]
        qd[self.moving], qdd[self.moving] = out[1:]
        return q, qd, qdd

    def move(self, q: Any, qd: Any) -> None:
        self.ours, self.theirs = self.ours.moved(q, qd), self.theirs.moved(q, qd)

    def on_link(self, link: str, at: Vec = ZERO, qdd: Any = None) -> Place:
        """A place of a link at the present state (m, in its frame), by the URDF."""
        return self.ours.on(link, at, qdd)

    def in_mbs(self, thing: str, qdd: Any = None) -> Place:
        """Where an external force or a sensor is at the present state, by the .mbs."""
        body, point = self.points[thing]
        return self.theirs.on(body, point.coordinates, qdd)

    @cached_property
    def size(self) -> float:
        """m"""
        return max(group.reach for group in self.ours.side.groups) or 1.0

    # --- the code ---

    def get(self, model: str, name: str) -> float:
        """A number of a user model; 0 if there is none."""
        return float(self.data.user_model.get(model, {}).get(name, 0.0))

    def joint_forces(self, q: Any, qd: Any) -> Any:
        self.data.q[:], self.data.qd[:], self.data.Qq[:] = q, qd, 1e3  # what was there is no part
        self.data.user_JointForces(self.data, 0.0)
        return np.array([0.0, *self.data.Qq[1:]])

    def external(
        self, force: str, at: Any, speed: Any, time: float = 0.0, axes: Any = None, spin: Any = ZERO
    ) -> Any:
        """Force and torque, and where they act (m, in the body).  ``axes``: rows are the body's."""
        rot = np.eye(4)
        rot[1:, 1:] = np.eye(3) if axes is None else axes
        place = np.array([0.0, *at]), rot, np.array([0.0, *speed]), np.array([0.0, *spin])
        given = (*place, *np.zeros((2, 4)))
        number = self.data.extforce_id[force]
        return np.array(self.data.user_ExtForces(*given, self.data, time, number)[1:10])

    def imu(self, name: str, place: Place) -> Any:
        """What an IMU reads that is at this place: specific force, and angular velocity."""
        data, own = self.data, vars(self.data).pop("mbs_sensor", None)

        def fill(sensor: Any, *_: Any) -> None:
            for kind, value in place._asdict().items():
                getattr(sensor, kind)[-value.shape[0] :][..., -value.shape[-1] :] = value

        data.mbs_sensor = fill
        found = sys.modules[f"{data.mbs_name}_robot"].imu(data, name)
        del data.mbs_sensor
        if own is not None:
            data.mbs_sensor = own
        return found

    # --- what is found ---

    def differ(self, what: str, message: str, size: float = 1.0) -> None:
        """Note a difference: of one thing, the largest."""
        if what not in self.found or self.found[what].size < size:
            self.found[what] = Difference("code", f"{what}: {message}", min(size, 1.0))

    def compare(self, what: str, should: Any, value: Any, unit: str, scale: float = 0.0) -> None:
        """Numbers that must be equal, relative to the largest of them and to ``scale``."""
        should, value = np.broadcast_arrays(np.array(should, float), np.array(value, float))
        if not should.size:
            return
        apart = np.nan_to_num(np.abs(value - should), nan=np.inf)
        off = float(apart.max()) / (max(float(np.abs(should).max()), scale) or 1.0)
        if off > TOLERANCE:
            if should.size > 6:  # the worst of them
                should, value = should[apart == apart.max()][:1], value[apart == apart.max()][:1]
            self.differ(what, f"is {_short(value)}, and should be {_short(should)} {unit}", off)

    def compare_joints(
        self, term: str, should: Any, value: Any, scale: Any = 0.0, unit: str = "N m or N"
    ) -> None:
        """A number of each joint."""
        largest = max(np.abs(should).max(), np.max(scale))
        scale = np.broadcast_to(scale + 1e-6 * largest, np.shape(should))
        for name, number in self.data.joint_id.items():
            what = f"joint '{name}': {term}"
            if value[number] != should[number]:
                self.compare(what, should[number], value[number], unit, scale[number])

    def compare_place(self, what: str, end: tuple[str | None, Any], link: str, at: Vec) -> None:
        """A point of a body, by their names, must be a place of a link (m, in its frame)."""
        self.go(1)
        place = self.theirs.end(self.mbs, end).P
        self.compare(what, self.on_link(link, at).P, place, "m", self.size)


def _short(values: Any) -> str:
    text = ", ".join(f"{number:.6g}" for number in values.ravel())
    return f"({text})" if values.size > 1 else text
