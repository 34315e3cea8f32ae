"""Data that a simulation needs beside the .mbs file.

The passes collect it in a ``Simulation``; the code of a Robotran project is generated from it.
It refers to the joints and points of the model themselves, not to their names: the pass ``emit``
may still rename them, and the generated code must have the new names.
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
    MbsJoint,
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

#: The quantities that Robotran can compute at a point.  One that is not listed there is not set.
MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
#: The components of a wrench (N and N m, in the axes of the base), by their names in a user model.
WRENCH_COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
#: The longest step (s) of a project whose forces allow any step.
LONGEST_STEP = 5e-4
#: The user models with the states of friction: one state of each joint with friction, three of
#: each body that may touch the ground.
JOINT_STATES, CONTACT_STATES = "friction_state", "contact_state"
#: The user models that are states: C finds them in ux, not in the struct of the user models.
STATE_MODELS = (JOINT_STATES, CONTACT_STATES)
#: The sine of the tilt up to which a rim is upright; the generated code has the same number.
UPRIGHT = 1e-9


def read_parameters(mbs: Mbs, model_names: Collection[str]) -> dict[str, dict[str, float]]:
    """Return the first number of each parameter of some user models.

    Args:
        mbs: The model.
        model_names: The names of the user models.  One that the robot does not have is ignored.

    Returns:
        For each user model, its numbers by the names of its parameters, in their units.
    """
    return {
        model.name: {parameter.name: float(parameter.values[0]) for parameter in model.parameters}
        for model in mbs.user_models
        if model.name in model_names
    }


def find_state_indices(mbs: Mbs, model_name: str) -> dict[str, int]:
    """Find where the states of a user model are in ``ux``.

    Returns:
        For each parameter of the user model, the index (from 1) of its first value.
    """
    indices: dict[str, int] = {}
    next_index = 1
    for model in mbs.user_models:
        for parameter in model.parameters:
            if parameter.type == "state":
                if model.name == model_name:
                    indices[parameter.name] = next_index
                next_index += len(parameter.values)
    return indices


def find_first_contact_state(mbs: Mbs) -> int:
    """Find the index in ``ux`` of the first state of the first contact; each contact has three.

    The states of a contact cannot be found by the name of its body, which ``emit`` may change.
    """
    return min(find_state_indices(mbs, CONTACT_STATES).values(), default=0)


def get_force_name(point: Point) -> str:
    """Return the name of the external force at a point."""
    assert point.extforce is not None
    return point.extforce.name


class Coupling(msgspec.Struct):
    """A ``<mimic>``: q of ``follower`` = ``multiplier`` * q of ``leader`` + ``offset``.

    Chains are resolved: no leader is a follower.
    """

    follower: MbsJoint
    leader: MbsJoint
    multiplier: float
    offset: float
    """rad or m."""

    def update_follower(self) -> None:
        """Set the initial position and velocity of the follower by those of its leader."""
        self.follower.q = self.multiplier * (self.leader.q or 0.0) + self.offset
        if self.leader.qd is not None:
            self.follower.qd = self.multiplier * self.leader.qd


class Spot(NamedTuple):
    r"""A part of a body that may touch the ground: a point, a sphere, or a point of a rim.

    A rim rolls smoothly, since its spots do not turn with the body: they keep their angles to its
    lowest point.  Seen along the axis of a cylinder::

            . - .
          /       \
         |    + centre
          \       o   spot, at rim_angle from the lowest point
            ` - o     lowest point
    """

    centre: Vec
    """The point, or the centre of the sphere or rim (m, body frame)."""
    radius: float = 0.0
    """m; zero for a point."""
    axis: Vec = ZERO
    """The direction of a rim's axis in the body; zero for a sphere."""
    rim_angle: float = 0.0
    """The angle along the rim from its lowest point to the spot (rad)."""

    def transform(self, pose: Pose) -> Spot:
        """Return the spot in another frame, in which its present frame has this pose."""
        centre = compose(pose, Pose(self.centre)).xyz
        return Spot(centre, self.radius, rotate(pose.rot, self.axis), self.rim_angle)

    def compute_position(self, pose: Pose, up: Vec, horizontal: Vec) -> Vec:
        """Compute where the spot touches a plane (m, in the base).

        With n the direction up and a the axis, the lowest point of a rim is in the direction
        ``(n . a) a - n``.  For a sphere a is zero, and the direction is -n.

        Args:
            pose: The pose of the body in the base.
            up: The direction against gravity, in the axes of the base.
            horizontal: A direction in the ground, in place of that of the lowest point of a rim
                that lies flat, whose points are all equally low.
        """
        centre, axis = compose(pose, Pose(self.centre)).xyz, rotate(pose.rot, self.axis)
        cosine = dot(up, axis)
        x, y, z = (n - cosine * a for n, a in zip(up, axis, strict=True))
        lowest = unit((-x, -y, -z)) if hypot(x, y, z) > UPRIGHT else horizontal
        tangent = cross(axis, lowest)
        down, aside = self.radius * cos(self.rim_angle), self.radius * sin(self.rim_angle)
        x, y, z = (down * d + aside * t for d, t in zip(lowest, tangent, strict=True))
        return add(centre, (x, y, z))


class Contact(msgspec.Struct):
    """The force of the ground on a body."""

    body: Body
    links: list[str]
    """The URDF links whose shapes touch."""
    point: Point
    """The point where the force acts: the body's origin."""
    spots: list[Spot]
    """The parts of the body that may touch, in its frame."""

    @property
    def bounding_radius(self) -> float:
        """The radius (m) of a sphere about the body's origin that contains all spots."""
        return max(hypot(*spot.centre) + spot.radius for spot in self.spots)

    def compute_positions(self, pose: Pose, up: Vec, horizontal: Vec) -> list[Vec]:
        """Compute the positions of all spots (m, in the base); see ``Spot.compute_position``."""
        return [spot.compute_position(pose, up, horizontal) for spot in self.spots]


class Wrench(msgspec.Struct):
    """An external force and torque at a point, in the axes of the base."""

    point: Point
    model: UserModel
    """The user model with its components, its start and its stop."""


class PointSensor(msgspec.Struct):
    """A sensor at a point."""

    name: str
    """As in the URDF or the config."""
    kind: str
    """``imu``, ``accelerometer``, ``gyroscope``, or ``frame``."""
    link: str
    point: Point
    rotation: Rot = IDENTITY
    """The sensor's axes in the body frame; a point of an .mbs has none."""


class ForceTorque(msgspec.Struct):
    """A force-torque sensor: six driven joints, whose ``Qc`` is the wrench."""

    name: str
    link: str
    """The link on which the measured wrench acts."""
    joints: list[MbsJoint]
    """Three prismatic and three revolute joints, driven at zero."""
    rotation: Rot = IDENTITY
    """The link's axes in the frame of these joints."""


class Held(msgspec.Struct):
    """A joint that a PD controller holds at its start position."""

    joint: MbsJoint
    stiffness: float | None
    """N m/rad or N/m; None to choose it by ``frequency`` and the inertia that the joint carries."""
    damping: float | None
    """N m s/rad or N s/m; None to choose it by ``damping_ratio`` and that inertia."""
    frequency: float
    """Hz."""
    damping_ratio: float


class Law(msgspec.Struct):
    """A force law of a plugin, as text of the generated code.

    A law of joints returns the force (N) or torque (N m) that is added to Qq.  ``joint`` is
    Robotran's number::

        def NAME(mbs_data, joint):
        static double NAME(const MbsData *mbs_data, int joint)

    A law of points returns a force (N) and a torque (N m) at an external force, in the axes of
    the base.  P and V are the position (m) and velocity (m/s) of the point, from index 1::

        def NAME(P, V, mbs_data, tsim, ixF):  # returns fx, fy, fz, mx, my, mz
        static void NAME(const double P[4], const double V[4], const MbsData *mbs_data,
            double tsim, int ixF, double force[7])  /* fills force[1] to force[6] */
    """

    name: str
    python: str
    """The text of the function; empty if the law is not written in Python."""
    c: str
    """The text of the function; empty if the law is not written in C."""
    joints: list[MbsJoint] = []
    points: list[Point] = []


class Simulation(msgspec.Struct):
    """Everything that the code of a project is generated from, and that is not in the .mbs."""

    couplings: list[Coupling] = []
    """Followers that a constraint couples to their leaders."""
    driven: list[Coupling] = []
    """Followers that user code moves, without a constraint."""
    contacts: list[Contact] = []
    stance: list[tuple[str, Vec]] = []
    """The spots that carry the robot at the start: body, and position (m, in the base)."""
    wrenches: list[Wrench] = []
    springs: list[Connection] = []
    """Springs and dampers between two points.  User models have their numbers."""
    sensors: list[PointSensor] = []
    force_torques: list[ForceTorque] = []
    hold: list[Held] = []
    laws: list[Law] = []
    """Force laws of plugins."""
    up: Vec = (0.0, 0.0, 1.0)
    """The direction against gravity, in the axes of the base."""
    time_step: float = LONGEST_STEP
    """A step (s) that a fixed-step integrator can take."""
    shortened_by: str = "no force"
    """The force that limits the step, such as "damping of joint 'wrist'"."""

    def sections(self) -> dict[str, Any]:
        """Return the data of each section that passes read and write."""
        forces: list[Any] = [
            len(forces) for forces in (self.contacts, self.wrenches, self.springs) if forces
        ]
        if self.time_step < LONGEST_STEP:
            forces.append({"time_step": self.time_step})
        couplings = [
            (coupling.leader.type, coupling.follower.type, coupling.multiplier, coupling.offset)
            for coupling in (*self.couplings, *self.driven)
        ]
        return {"couplings": couplings, "forces": forces}

    @property
    def horizontal_axes(self) -> tuple[Vec, Vec]:
        """Two directions in the ground, at right angles, in the axes of the base."""
        # The axis of the base that is furthest from vertical makes the product well conditioned.
        smallest = min(range(3), key=lambda k: abs(self.up[k]))
        x, y, z = (float(k == smallest) for k in range(3))
        second = unit(cross(self.up, (x, y, z)))
        return cross(second, self.up), second
