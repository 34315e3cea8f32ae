"""A project's code beside its robot: what the laws compare, and what they have found."""

import sys
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from support.oracle.mbs import GROUND, Evaluator
from support.oracle.multibody import Multibody, Place, State, translation
from support.oracle.stated import Stated
from support.oracle.urdf import FLOATING_BASE, Reference, Urdf

#: The largest deviation that is no difference, relative to the largest number it is compared with.
TOLERANCE = 1e-8
#: The origin of a frame (m).
ZERO = (0.0, 0.0, 0.0)


class Side:
    """One of the two descriptions at a state, by Robotran's numbers of the joints."""

    def __init__(self, system: Multibody, numbers: Any, moving: Any, size: int) -> None:
        """``numbers``: Robotran's number of each node's joint, or 0; ``moving``: those that move;
        ``size``: one more than there are joints."""
        self.system, self.numbers, self.size = system, numbers, size
        self.nodes = [k for k, number in enumerate(numbers) if number in moving]
        self.q = self.qd = np.zeros(size)

    def place(self, node: int, at: Any, qdd: Any = None) -> Place:
        """Return a point (m) of a frame."""
        place = self.state(qdd).place(node, translation(at))
        jacobian = np.zeros((6, self.size))
        jacobian[:, self.numbers[self.nodes]] = place.J[:, self.nodes]
        return place._replace(J=jacobian)

    def state(self, qdd: Any = None) -> State:
        rest = 0.0 * self.q if qdd is None else qdd
        return State(self.system, *(values[self.numbers] for values in (self.q, self.qd, rest)))

    def equations(self) -> tuple[Any, Any]:
        """M (kg m^2, kg m, kg) and c (N m, N)."""
        own, here = self.state().equations(), self.numbers[self.nodes]
        matrix, bias = np.zeros((self.size, self.size)), np.zeros(self.size)
        matrix[np.ix_(here, here)] = own[0][np.ix_(self.nodes, self.nodes)]
        bias[here] = own[1][self.nodes]
        return matrix, bias


class Case:
    """A project's code, the robot that it is of, and the differences of the two.

    Arrays of joints count from 1, as Robotran's do.  Vectors are in the axes of the base.
    """

    has_equations = False
    """True if the project has equations of motion."""

    def __init__(self, conversion: Any, simulation: Any, data: Any, code: Any) -> None:
        """Take what the passes made, the runtime's MbsData and its PythonEquations."""
        self.conversion, self.data, self.code, self.mbs = conversion, data, code, data._run.mbs
        self.simulation, self.asked = simulation, conversion.asked
        self.gravity = conversion.settings.config.gravity
        self.found: dict[str, tuple[float, str]] = {}
        names, joints = conversion.names.coordinates, data.joint_id
        text = conversion.expanded or conversion.input.data
        urdf, self.stated = Urdf.parse(text), Stated(text)
        self.urdf = Reference(
            urdf,
            floating=conversion.base.inserted in names,
            frozen=[*conversion.frozen],
            gravity=self.gravity,
        )
        numbers = np.zeros(len(self.urdf.system.nodes), int)
        for joint, own in self.urdf.coordinates.items():
            theirs = names[conversion.base.inserted if joint == FLOATING_BASE else joint]
            numbers[[self.urdf.system.index[name] for name in own]] = [joints[n] for n in theirs]
        #: Robotran's numbers of the joints that move.
        self.moving = [number for number in numbers.tolist() if number]
        #: Robotran's number of each joint of the URDF that moves by one coordinate.
        self.single = {
            name: joints[names[name][0]]
            for name, own in self.urdf.coordinates.items()
            if len(own) == 1
        }
        self.natures = ["", *(joint.nature for joint in self.mbs.joints().values())]
        self.evaluator = Evaluator(data._run.source)
        size = len(joints) + 1
        self.ours = Side(self.urdf.system, numbers, self.moving, size)
        self.theirs = Side(self.evaluator.system, np.arange(size), self.moving, size)
        self.random = np.random.default_rng(20)
        self._states: dict[int, Any] = {}
        #: The body and the point of each external force and sensor.
        self.points = {
            thing.name: (body, point)
            for body, owner in self.mbs.base_and_bodies()
            for point in owner.points
            for thing in (point.extforce, point.sensor)
            if thing is not None
        }

    # --- states ---

    def go(self, state: int) -> tuple[Any, Any, Any]:
        """Go to one of the states that laws share: 0 is the start, others are random.  Gives q,
        qd and qdd."""
        if state not in self._states:
            self._states[state] = self.near_start(np.pi if state else 0.0)
        q, qd, qdd = self._states[state]
        self.move(q, qd)
        return q, qd, qdd

    def near_start(self, reach: float) -> tuple[Any, Any, Any]:
        """Random qd and qdd of what moves, and q at most ``reach`` (rad, m) from the start."""
        q, qd, qdd = np.array([self.data.q0, *np.zeros((2, self.ours.size))])
        out = self.random.uniform(-1.0, 1.0, (3, len(self.moving)))
        q[self.moving] += reach * out[0]
        qd[self.moving], qdd[self.moving] = out[1:]
        return q, qd, qdd

    def move(self, q: Any, qd: Any) -> None:
        for side in (self.ours, self.theirs):
            side.q, side.qd = q, qd

    def on_link(self, link: str, at: Sequence[float] = ZERO, qdd: Any = None) -> Place:
        """Return a point of a link (m, in its frame) at the present state, by the URDF."""
        return self.ours.place(self.urdf.node_of[link], at, qdd)

    def end(self, end: tuple[str | None, str | None], qdd: Any = None) -> Place:
        """Return a point of a body of the .mbs, by their names; None for the body's frame."""
        body = self.evaluator.bodies[end[0] or GROUND]
        return self.theirs.place(body.node, body.points[end[1]] if end[1] else ZERO, qdd)

    def in_mbs(self, thing: str, qdd: Any = None) -> Place:
        """Where an external force or a sensor is at the present state, by the .mbs."""
        body, point = self.points[thing]
        return self.end((body, point.name), qdd)

    @cached_property
    def size(self) -> float:
        """m"""
        return max(float(np.abs(at[:3, 3]).max()) for at in self.urdf.poses().values()) or 1.0

    # --- the code ---

    def get(self, model: str, name: str) -> float:
        """Return a number of a user model; 0 if it has none."""
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
        """Return specific force and angular velocity, as an IMU at this place reads them."""
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
        if what not in self.found or self.found[what][0] < size:
            self.found[what] = size, f"{what}: {message}"

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
        """Compare a number of each joint."""
        largest = max(np.abs(should).max(), np.max(scale))
        scale = np.broadcast_to(scale + 1e-6 * largest, np.shape(should))
        for name, number in self.data.joint_id.items():
            what = f"joint '{name}': {term}"
            if value[number] != should[number]:
                self.compare(what, should[number], value[number], unit, scale[number])

    def compare_place(
        self, what: str, end: tuple[str | None, Any], link: str, at: Sequence[float]
    ) -> None:
        """Compare a point of a body, by their names, with one of a link (m, in its frame)."""
        self.go(1)
        place = self.end(end).P
        self.compare(what, self.on_link(link, at).P, place, "m", self.size)


def _short(values: Any) -> str:
    text = ", ".join(f"{number:.6g}" for number in values.ravel())
    return f"({text})" if values.size > 1 else text
