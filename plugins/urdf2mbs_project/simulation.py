"""What a simulation needs to know of a robot beside its .mbs file.

The passes gather it in a ``Simulation``; the code that is generated for a Robotran project is
made from it.  It holds the very joints and points of the model, not their names: ``emit`` may
still change a name, and then the new one is seen here.
"""

from __future__ import annotations

from collections.abc import Collection
from math import cos, hypot, sin
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.plugin import (
    IDENTITY,
    ZERO,
    Body,
    Connection,
    Mbs,
    Point,
    Pose,
    Rot,
    UserModel,
    Vec,
    add,
    compose,
    cross,
    dot,
    rotate,
    unit,
)
from urdf2mbs.plugin import MbsJoint as Joint

#: What Robotran can compute at a point.  What is not asked for is zero there, or not set.
MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
#: The parts of a wrench, by their names in its user model: N and N m, in the axes of the base.
WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
#: The longest step (s) of a project whose forces allow any.
LONGEST_STEP = 5e-4
#: The user models of the states of friction: one of each joint that rubs, three of each body that
#: may touch the ground.
JOINT_STATES, CONTACT_STATES = "friction_state", "contact_state"


def numbers_of(mbs: Mbs, names: Collection[str]) -> dict[str, dict[str, float]]:
    """Return the first number of each parameter of the user models that ``names`` lists.

    Returns:
        By the name of the user model, the numbers by the names of its parameters, in their units.
        A model that the robot does not have is left out.
    """
    return {
        model.name: {p.name: float(p.values[0]) for p in model.parameters}
        for model in mbs.user_models
        if model.name in names
    }


def state_numbers(mbs: Mbs, kind: str) -> dict[str, int]:
    """The index in ``ux`` of the first value of each parameter of the user model ``kind``."""
    found, number = {}, 1
    for model in mbs.user_models:
        for parameter in model.parameters:
            if parameter.type == "state":
                if model.name == kind:
                    found[parameter.name] = number
                number += len(parameter.values)
    return found


def contact_state(mbs: Mbs) -> int:
    """The index in ``ux`` of the first state of the first contact; each has three.

    A body's state cannot be found by its name: a body may have got another one.
    """
    return min(state_numbers(mbs, CONTACT_STATES).values(), default=0)


def force_of(point: Point) -> str:
    """The name of the external force at a point."""
    assert point.extforce is not None
    return point.extforce.name


class Coupling(msgspec.Struct):
    """A ``<mimic>``: q of ``follower`` = ``multiplier`` * q of ``leader`` + ``offset``.

    Chains are resolved: no leader is a follower itself.
    """

    follower: Joint
    leader: Joint
    multiplier: float
    offset: float
    """rad or m."""

    def follow(self) -> None:
        """Give the follower the initial position and velocity that the rule wants."""
        self.follower.q = self.multiplier * (self.leader.q or 0.0) + self.offset
        if self.leader.qd is not None:
            self.follower.qd = self.multiplier * self.leader.qd


class Spot(NamedTuple):
    """What of a body may touch the ground: a point, a sphere, or a point of a cylinder's rim."""

    at: Vec
    """The point, or the centre of the sphere or the rim (m, in the body's frame)."""
    radius: float = 0.0
    """m"""
    axis: Vec = ZERO
    """The direction of a rim's axis in the body; zero for a sphere."""
    turn: float = 0.0
    """How far along its rim the point is from the lowest one (rad)."""

    def moved(self, pose: Pose) -> Spot:
        """The same in the frame in which its own one is at ``pose``."""
        at, axis = compose(pose, Pose(self.at)).xyz, rotate(pose.rot, self.axis)
        return Spot(at, self.radius, axis, self.turn)

    def place(self, pose: Pose, up: Vec, level: Vec) -> Vec:
        """Where it touches (m, in the base) for a body at ``pose``; ``level`` is a direction in the
        ground, for an upright rim, which has no lowest point."""
        centre, axis = compose(pose, Pose(self.at)).xyz, rotate(pose.rot, self.axis)
        along = dot(up, axis)
        x, y, z = (part - along * own for part, own in zip(up, axis, strict=True))
        lowest = unit((-x, -y, -z)) if hypot(x, y, z) > UPRIGHT else level
        side = cross(axis, lowest)
        forth, aside = self.radius * cos(self.turn), self.radius * sin(self.turn)
        x, y, z = (forth * a + aside * b for a, b in zip(lowest, side, strict=True))
        return add(centre, (x, y, z))


#: The sine of the tilt up to which a rim is upright; the code of a project has the same.
UPRIGHT = 1e-9


class Contact(msgspec.Struct):
    """The force of the ground on a body."""

    body: Body
    links: list[str]
    """The URDF links whose shapes touch."""
    point: Point
    """Where the force acts: the body's origin."""
    spots: list[Spot]

    @property
    def bound(self) -> float:
        """No spot is further than this from the body's origin (m)."""
        return max(hypot(*spot.at) + spot.radius for spot in self.spots)

    def places(self, pose: Pose, up: Vec, level: Vec) -> list[Vec]:
        """Where the spots touch (m, in the base) for the body at ``pose``; see ``Spot.place``."""
        return [spot.place(pose, up, level) for spot in self.spots]


class Wrench(msgspec.Struct):
    """An external force and torque at a point, in the axes of the base."""

    point: Point
    model: UserModel
    """The user model that says how large they are."""


class PointSensor(msgspec.Struct):
    """A sensor at a point."""

    name: str
    """As the URDF or the config calls it."""
    kind: str
    """``imu``, ``accelerometer``, ``gyroscope``, or ``frame``."""
    link: str
    point: Point
    rotation: Rot = IDENTITY
    """The sensor's axes in the body frame, since a point has none."""


class ForceTorque(msgspec.Struct):
    """A force-torque sensor: six driven joints, whose ``Qc`` is the wrench."""

    name: str
    link: str
    """What is measured is what the sensor does to this link."""
    joints: list[Joint]
    """Three shifts and three turns, held at zero."""
    rotation: Rot = IDENTITY
    """The link's axes in the frame of these joints."""


class Held(msgspec.Struct):
    """A joint that a PD controller holds at its start position."""

    joint: Joint
    stiffness: float | None
    """N m/rad or N/m; None: what gives ``frequency`` with the inertia that the joint carries."""
    damping: float | None
    """N m s/rad or N s/m; None: what gives ``damping_ratio`` with it."""
    frequency: float
    """Hz."""
    damping_ratio: float


class Law(msgspec.Struct):
    """A force law of a plugin, as text of the generated code.

    A law of joints gives the force (N) or torque (N m) that is added to Qq.  ``joint`` is
    Robotran's number::

        def NAME(mbs_data, joint):
        static double NAME(const MbsData *mbs_data, int joint)

    A law of points gives, at their external forces, a force (N) and a torque (N m) in the axes of
    the base.  P and V are the position (m) and velocity (m/s) of the point, from index 1::

        def NAME(P, V, mbs_data, tsim, ixF):  # returns fx, fy, fz, mx, my, mz
        static void NAME(const double P[4], const double V[4], const MbsData *mbs_data,
            double tsim, int ixF, double force[7])  /* fills force[1] to force[6] */
    """

    name: str
    python: str
    """The text of the function; empty: the law is not there in Python."""
    c: str
    joints: list[Joint] = []
    points: list[Point] = []


class Simulation(msgspec.Struct):
    """Everything that a project's code is made from, and that is not in the .mbs."""

    couplings: list[Coupling] = []
    driven: list[Coupling] = []
    """Followers that are moved by user code instead of by a constraint."""
    contacts: list[Contact] = []
    stance: list[tuple[str, Vec]] = []
    """The bodies that the robot stands on at the start, and where (m, in the base)."""
    wrenches: list[Wrench] = []
    springs: list[Connection] = []
    """Springs and dampers between two points.  User models hold their laws."""
    sensors: list[PointSensor] = []
    force_torques: list[ForceTorque] = []
    hold: list[Held] = []
    laws: list[Law] = []
    """Forces of plugins."""
    up: Vec = (0.0, 0.0, 1.0)
    """Against gravity, in the axes of the base."""
    time_step: float = LONGEST_STEP
    """A step (s) that a fixed-step integrator can take."""
    shortened_by: str = "no force"
    """What makes the step as short as it is, such as "damping of joint 'wrist'"."""

    def sections(self) -> dict[str, Any]:
        """What of it belongs to sections that passes read and write."""
        return {
            "couplings": [
                (coupling.leader.type, coupling.follower.type, coupling.multiplier, coupling.offset)
                for coupling in (*self.couplings, *self.driven)
            ],
            "forces": [
                *(len(made) for made in (self.contacts, self.wrenches, self.springs) if made),
                *([{"time_step": self.time_step}] if self.time_step < LONGEST_STEP else []),
            ],
        }

    @property
    def across(self) -> tuple[Vec, Vec]:
        """Two directions in the ground, at right angles."""
        least = min(range(3), key=lambda k: abs(self.up[k]))
        x, y, z = (float(k == least) for k in range(3))
        second = unit(cross(self.up, (x, y, z)))
        return cross(second, self.up), second
