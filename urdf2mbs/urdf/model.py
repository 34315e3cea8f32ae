"""A robot as its URDF states it: the same elements, names, units and frames."""

from __future__ import annotations

import msgspec

from urdf2mbs.spatial import HERE, NO_INERTIA, ZERO, Pose, Sym, Vec, compose, from_rpy

#: ``type`` of a joint, and how many coordinates it has.
JOINT_TYPES = {
    "revolute": 1, "continuous": 1, "prismatic": 1, "fixed": 0, "floating": 6, "planar": 3,
}  # fmt: skip


class Origin(msgspec.Struct, frozen=True, gc=False):
    """``<origin>``: xyz in m, fixed-frame roll, pitch, yaw in rad."""

    xyz: Vec = ZERO
    rpy: Vec = ZERO

    @property
    def pose(self) -> Pose:
        return Pose(self.xyz, from_rpy(self.rpy))


class Inertial(msgspec.Struct, gc=False):
    """``<inertial>``: mass (kg) and inertia (kg m^2, about ``origin.xyz``, in its axes)."""

    mass: float = 0.0
    inertia: Sym = NO_INERTIA
    origin: Origin = Origin()


class Box(msgspec.Struct, tag="box", gc=False):
    """A box, centred (m)."""

    size: Vec
    """Full lengths along x, y, z (m)."""


class Cylinder(msgspec.Struct, tag="cylinder", gc=False):
    """Axis z, centred (m)."""

    radius: float
    length: float


class Capsule(msgspec.Struct, tag="capsule", gc=False):
    """A cylinder with a hemisphere at each end, axis z, centred (m); URDF has it since 1.2."""

    radius: float
    length: float
    """Of the cylinder between the hemispheres."""


class Sphere(msgspec.Struct, tag="sphere", gc=False):
    """A sphere, centred (m)."""

    radius: float


class Mesh(msgspec.Struct, tag="mesh", gc=False):
    """``filename`` as the URDF states it: ``package://``, ``file://``, or a path."""

    filename: str
    scale: Vec = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Capsule | Sphere | Mesh


class Material(msgspec.Struct, gc=False):
    """``<material>``: colour r g b a, each 0 to 1, and texture file, where given."""

    name: str = ""
    color: tuple[float, float, float, float] | None = None
    texture: str | None = None


class Visual(msgspec.Struct, gc=False):
    """``<visual>``; its material is the global one of that name where it gives no own."""

    geometry: Geometry
    origin: Origin = Origin()
    material: Material | None = None
    name: str | None = None
    line: int | None = None


class Collision(msgspec.Struct, gc=False):
    """``<collision>``: a shape and where it is, seen from its link (m, rad)."""

    geometry: Geometry
    origin: Origin = Origin()
    name: str | None = None
    line: int | None = None


class Link(msgspec.Struct, gc=False):
    """``<link>``: what is fixed to one frame."""

    name: str
    inertial: Inertial | None = None
    visuals: list[Visual] = []
    collisions: list[Collision] = []
    line: int | None = None

    @property
    def massless(self) -> bool:
        """Neither mass nor inertia: a frame."""
        inertial = self.inertial
        return inertial is None or (inertial.mass == 0.0 and inertial.inertia == NO_INERTIA)


#: What a ``<limit>`` bounds beside the position and the effort, by URDF 1.2 and Drake.
RATES = ("velocity", "acceleration", "deceleration", "jerk")


class Limit(msgspec.Struct, gc=False):
    """``<limit>``, in rad or m; None: no limit."""

    lower: float | None = 0.0
    upper: float | None = 0.0
    effort: float | None = None
    """N m or N."""
    velocity: float | None = None
    """rad/s or m/s; the acceleration and the jerk per s and per s^2 of it."""
    acceleration: float | None = None
    deceleration: float | None = None
    jerk: float | None = None

    @property
    def is_single(self) -> bool:
        """True for one position: a locked joint by URDF, at 0 an unlimited one in many files."""
        return self.lower is not None and self.lower == self.upper


class Dynamics(msgspec.Struct, gc=False):
    """``<dynamics>``: damping (N m s/rad, or N s/m) and friction (N m, or N); and the spring that
    ``<gazebo>`` states of the joint."""

    damping: float = 0.0
    friction: float = 0.0
    spring_stiffness: float = 0.0
    """N m/rad, or N/m."""
    spring_reference: float = 0.0
    """The position (rad, or m) at which the spring is at rest."""


class Mimic(msgspec.Struct, gc=False):
    """This joint's position is ``multiplier`` times that of ``joint``, plus ``offset``."""

    joint: str = ""
    multiplier: float = 1.0
    offset: float = 0.0

    def __str__(self) -> str:
        """The rule, as short as it can be: ``-knee + 0.3``."""
        factor = {1.0: "", -1.0: "-"}.get(self.multiplier, f"{self.multiplier!r} * ")
        offset = f" {'-' if self.offset < 0 else '+'} {abs(self.offset)!r}" if self.offset else ""
        return f"{factor}{self.joint}{offset}"


class SafetyController(msgspec.Struct, gc=False):
    """``<safety_controller>``: its gains, and its limits (rad, or m)."""

    k_velocity: float
    k_position: float = 0.0
    soft_lower_limit: float = 0.0
    soft_upper_limit: float = 0.0


class Calibration(msgspec.Struct, gc=False):
    """``<calibration>``: positions (rad, or m) at which a reference edge rises or falls."""

    rising: float | None = None
    falling: float | None = None


class Joint(msgspec.Struct, gc=False):
    """``<joint>``; ``axis`` as written (not normalised), in the child link's frame.

    A fixed or floating joint has no axis: what a file states of it is not read."""

    name: str
    type: str
    parent: str
    child: str
    origin: Origin = Origin()
    axis: Vec = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    dynamics: Dynamics | None = None
    mimic: Mimic | None = None
    safety_controller: SafetyController | None = None
    calibration: Calibration | None = None
    line: int | None = None

    @property
    def moves(self) -> bool:
        return self.type != "fixed"


class Sensor(msgspec.Struct, gc=False):
    """A ``<sensor>`` of motion, or of force and torque, of the URDF or of ``<gazebo>``."""

    name: str
    type: str
    on: str
    """Its link; its joint if it measures force and torque."""
    pose: Pose = HERE
    """Where it is on its link (m), of a sensor of motion."""
    line: int | None = None


class ClosingJoint(msgspec.Struct, gc=False):
    """An SDF ``<joint>`` inside ``<gazebo>``: it ties two links of the tree to one another."""

    name: str
    type: str
    """One of SDF's: ``ball``, ``revolute``, ``fixed``, ..."""
    parent: str
    child: str
    pose: Pose = HERE
    """Seen from its child link (m), all joints of the tree at zero."""
    axes: list[Vec] = []
    """Directions in the child link's frame."""
    line: int | None = None


class Extension(msgspec.Struct, gc=False):
    """An element that belongs to other programs (``<gazebo>``, ``<transmission>``, ...), kept
    as it is written, and what of it is used."""

    tag: str
    xml: str
    reference: str | None = None
    line: int | None = None
    sensors: list[Sensor] = []
    joints: list[ClosingJoint] = []
    motors: list[str] = []
    """The joints that have a motor."""
    rotors: dict[str, float] = {}
    """The inertia of the motor's rotor as the joint feels it: kg m^2, or kg if it is prismatic."""
    starts: dict[str, float] = {}
    """The position (rad or m) that each joint starts from."""
    numbers: dict[str, float] = {}
    """What ``<gazebo reference="...">`` says of a link or a joint, by the elements' names; the
    ``lateral_friction`` of Bullet's ``<contact>`` in a link is ``mu1``."""


class Robot(msgspec.Struct):
    """``<robot>``: a tree of links and joints, both in the order of the file."""

    name: str
    links: dict[str, Link] = {}
    joints: dict[str, Joint] = {}
    materials: dict[str, Material] = {}
    extensions: list[Extension] = []
    file: str | None = None
    fixed_by: str = ""
    """The element of another program that ties the root link to the world, as a message names it;
    empty: there is none."""

    def root(self) -> str:
        """The one link that is no joint's child (the reader has seen to it that there is one)."""
        children = {joint.child for joint in self.joints.values()}
        return next(name for name in self.links if name not in children)

    def children(self) -> dict[str, list[Joint]]:
        """Every link's outgoing joints, in the order of the file."""
        out: dict[str, list[Joint]] = {name: [] for name in self.links}
        for joint in self.joints.values():
            out[joint.parent].append(joint)
        return out

    def depth_first(self) -> list[Joint]:
        """All joints, each before those behind it, one branch after the other."""
        children = self.children()
        order: list[Joint] = []
        stack = children[self.root()][::-1]
        while stack:
            joint = stack.pop()
            order.append(joint)
            stack.extend(reversed(children[joint.child]))
        return order

    def poses(self) -> dict[str, Pose]:
        """Each link's frame in that of the root link, all joints at zero."""
        poses = {self.root(): HERE}
        for joint in self.depth_first():
            poses[joint.child] = compose(poses[joint.parent], joint.origin.pose)
        return poses
