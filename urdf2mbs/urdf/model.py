"""A robot as its URDF states it: the same elements, names, units and frames."""

from __future__ import annotations

import msgspec

from urdf2mbs.spatial import HERE, NO_INERTIA, ZERO, Pose, Sym, Vec, compose, from_rpy

#: The ``type`` of each joint, and the number of its coordinates.
JOINT_TYPES = {
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "fixed": 0,
    "floating": 6,
    "planar": 3,
}


class Origin(msgspec.Struct, frozen=True, gc=False):
    """``<origin>``: xyz in m, fixed-frame roll, pitch, yaw in rad."""

    xyz: Vec = ZERO
    rpy: Vec = ZERO

    @property
    def pose(self) -> Pose:
        """The same as a position (m) and a rotation matrix."""
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
    """A cylinder along the axis z, centred (m)."""

    radius: float
    length: float


class Capsule(msgspec.Struct, tag="capsule", gc=False):
    """A cylinder along z with a hemisphere at each end, centred (m); part of URDF since 1.2."""

    radius: float
    length: float
    """The length of the cylinder between the hemispheres."""


class Sphere(msgspec.Struct, tag="sphere", gc=False):
    """A sphere, centred (m)."""

    radius: float


class Mesh(msgspec.Struct, tag="mesh", gc=False):
    """A mesh in a file, which may be scaled."""

    filename: str
    """As the URDF states it: ``package://``, ``file://``, or a path."""
    scale: Vec = (1.0, 1.0, 1.0)


Geometry = Box | Cylinder | Capsule | Sphere | Mesh


class Material(msgspec.Struct, gc=False):
    """``<material>``: colour r g b a, each 0 to 1, and texture file, where given."""

    name: str = ""
    color: tuple[float, float, float, float] | None = None
    texture: str | None = None


class Visual(msgspec.Struct, gc=False):
    """``<visual>``; a material without colour and texture is the robot's of the same name."""

    geometry: Geometry
    origin: Origin = Origin()
    material: Material | None = None
    name: str | None = None
    line: int | None = None


class Collision(msgspec.Struct, gc=False):
    """``<collision>``: a shape and its origin in the frame of its link (m, rad)."""

    geometry: Geometry
    origin: Origin = Origin()
    name: str | None = None
    line: int | None = None


class Link(msgspec.Struct, gc=False):
    """``<link>``: a frame, with the mass and the shapes that are fixed to it."""

    name: str
    inertial: Inertial | None = None
    visuals: list[Visual] = []
    collisions: list[Collision] = []
    line: int | None = None

    @property
    def massless(self) -> bool:
        """Whether the link has neither mass nor inertia."""
        inertial = self.inertial
        return inertial is None or (inertial.mass == 0.0 and inertial.inertia == NO_INERTIA)


#: The rates that a ``<limit>`` bounds beside position and effort, by URDF 1.2 and Drake.
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
        """Whether both limits are equal: by URDF the joint is locked, in many files unlimited."""
        return self.lower is not None and self.lower == self.upper


class Dynamics(msgspec.Struct, gc=False):
    """``<dynamics>``, and the spring that ``<gazebo>`` states for the joint."""

    damping: float = 0.0
    """N m s/rad, or N s/m."""
    friction: float = 0.0
    """N m, or N."""
    spring_stiffness: float = 0.0
    """N m/rad, or N/m."""
    spring_reference: float = 0.0
    """The position (rad, or m) at which the spring is at rest."""


class Mimic(msgspec.Struct, gc=False):
    """``<mimic>``: position = ``multiplier`` * position of ``joint`` + ``offset`` (rad, or m)."""

    joint: str = ""
    multiplier: float = 1.0
    offset: float = 0.0

    def __str__(self) -> str:
        """Return the rule, as short as it can be: ``-knee + 0.3``."""
        factor_text = {1.0: "", -1.0: "-"}.get(self.multiplier, f"{self.multiplier!r} * ")
        offset_text = (
            f" {'-' if self.offset < 0 else '+'} {abs(self.offset)!r}" if self.offset else ""
        )
        return f"{factor_text}{self.joint}{offset_text}"


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

    A fixed or floating joint has no axis: that of the file is not read.
    """

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
        """Whether the joint has coordinates."""
        return self.type != "fixed"


class Sensor(msgspec.Struct, gc=False):
    """A ``<sensor>`` of motion, or of force and torque, of the URDF or of ``<gazebo>``."""

    name: str
    type: str
    on: str
    """Its link; its joint if it measures force and torque."""
    pose: Pose = HERE
    """Its pose in the frame of its link (m), if it measures motion."""
    line: int | None = None


class ClosingJoint(msgspec.Struct, gc=False):
    """An SDF ``<joint>`` inside ``<gazebo>``, which closes a loop between two links of the tree."""

    name: str
    type: str
    """One of SDF's: ``ball``, ``revolute``, ``fixed``, ..."""
    parent: str
    child: str
    pose: Pose = HERE
    """In the frame of its child link (m), with all joints of the tree at zero."""
    axes: list[Vec] = []
    """Directions in the child link's frame."""
    line: int | None = None


class Extension(msgspec.Struct, gc=False):
    """An element of another program (``<gazebo>``, ``<transmission>``, ...), and its meaning."""

    tag: str
    xml: str
    """The element as it is written."""
    reference: str | None = None
    """The link or joint that it is about."""
    line: int | None = None
    sensors: list[Sensor] = []
    joints: list[ClosingJoint] = []
    motors: list[str] = []
    """The joints that have a motor."""
    rotors: dict[str, float] = {}
    """The inertia of each joint's rotor, reflected to the joint: kg m^2, or kg if prismatic."""
    starts: dict[str, float] = {}
    """The initial position (rad or m) of each joint."""
    numbers: dict[str, float] = {}
    """The numbers of ``<gazebo reference="...">`` about a link or a joint, by their tags; the
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
    """The element of another program that fixes the root link to the world, as a message names it;
    empty if the root link is free."""

    def root(self) -> str:
        """Return the one link that is no joint's child; the reader checks that there is one."""
        children = {joint.child for joint in self.joints.values()}
        return next(link_name for link_name in self.links if link_name not in children)

    def children(self) -> dict[str, list[Joint]]:
        """Return the joints of which each link is the parent, in the order of the file."""
        children: dict[str, list[Joint]] = {link_name: [] for link_name in self.links}
        for joint in self.joints.values():
            children[joint.parent].append(joint)
        return children

    def depth_first(self) -> list[Joint]:
        """Return all joints, each before its descendants, one branch after the other."""
        children = self.children()
        ordered_joints: list[Joint] = []
        stack = children[self.root()][::-1]
        while stack:
            joint = stack.pop()
            ordered_joints.append(joint)
            stack.extend(reversed(children[joint.child]))
        return ordered_joints

    def poses(self) -> dict[str, Pose]:
        """Return each link's pose in the frame of the root link, all joints at zero."""
        poses = {self.root(): HERE}
        for joint in self.depth_first():
            poses[joint.child] = compose(poses[joint.parent], joint.origin.pose)
        return poses
