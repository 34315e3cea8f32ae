"""What MuJoCo has compiled, as plain data: the element of each kind, as ``MjModel`` has it.

The fields have MuJoCo's names: ``Body.pos`` is ``MjModel.body_pos``, ``Geom.size`` ``geom_size``.
Types are words, such as ``hinge`` for ``mjJNT_HINGE``.  Lengths are in m, angles in rad, and
quaternions begin with w.
"""

from __future__ import annotations

import msgspec

Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Body(msgspec.Struct):
    """A body; the first is the world."""

    name: str
    parentid: int
    pos: Triple
    quat: Quaternion
    ipos: Triple
    iquat: Quaternion
    mass: float
    inertia: Triple
    jntadr: int
    jntnum: int
    mocapid: int


class Joint(msgspec.Struct):
    """A joint of a body."""

    name: str
    type: str
    """``free``, ``ball``, ``slide`` or ``hinge``."""
    pos: Triple
    axis: Triple
    limited: bool
    range: tuple[float, float]
    qposadr: int
    dofadr: int
    stiffness: float
    actfrclimited: bool
    actfrcrange: tuple[float, float]


class Dof(msgspec.Struct):
    """A coordinate of the velocity."""

    name: str
    damping: float
    frictionloss: float
    armature: float


class Geom(msgspec.Struct):
    """A shape on a body."""

    name: str
    type: str
    bodyid: int
    pos: Triple
    quat: Quaternion
    size: Triple
    contype: int
    conaffinity: int
    group: int
    dataid: int
    matid: int
    rgba: Quaternion
    """Red, green, blue and alpha."""
    friction: Triple


class Material(msgspec.Struct):
    """A colour."""

    name: str
    rgba: Quaternion


class Mesh(msgspec.Struct):
    """A mesh, which MuJoCo has moved to its centre and turned to its axes of inertia."""

    name: str
    pos: Triple
    quat: Quaternion
    scale: Triple
    file: str
    """Its path; empty if the MJCF has the vertices."""
    refpos: Triple
    refquat: Quaternion


class Site(msgspec.Struct):
    """A frame on a body."""

    name: str
    bodyid: int
    pos: Triple
    quat: Quaternion


class Sensor(msgspec.Struct):
    """A sensor on an object of the type ``objtype``."""

    name: str
    type: str
    objtype: str
    objid: int


class Equality(msgspec.Struct):
    """A constraint."""

    name: str
    type: str
    obj1id: int
    obj2id: int
    objtype: str
    active0: bool
    data: list[float]


class Actuator(msgspec.Struct):
    """An actuator."""

    name: str
    trntype: str
    trnid: tuple[int, int]
    gear: list[float]
    gaintype: str
    biastype: str
    dyntype: str
    gainprm: list[float]
    biasprm: list[float]
    forcelimited: bool
    forcerange: tuple[float, float]
    ctrllimited: bool
    ctrlrange: tuple[float, float]


class Tendon(msgspec.Struct):
    """A tendon, along ``num`` wraps from ``adr`` on."""

    name: str
    adr: int
    num: int
    length0: float


class Wrap(msgspec.Struct):
    """A point of a tendon."""

    name: str
    type: str
    objid: int


class Key(msgspec.Struct):
    """A keyframe."""

    name: str
    qpos: list[float]


class State(msgspec.Struct):
    """MuJoCo's own numbers of a random state, without armature.

    ``mass_matrix`` is (nv, nv), ``bias`` (nv,), the forces of gravity and inertia (N m, N).
    """

    angles: list[list[float]]
    """By joint: its coordinates from ``qpos0``; three angles x-y-z of a ball joint (rad); of a free
    joint, three positions (m) and three angles in the world."""
    velocity: list[float]
    """(nv,)"""
    mass_matrix: list[list[float]]
    bias: list[float]
    body_pos: list[Triple]
    """In the world (m)."""
    body_quat: list[Quaternion]


class Compiled(msgspec.Struct):
    """A compiled MJCF."""

    name: str
    version: str
    """That of MuJoCo."""
    bodies: list[Body]
    joints: list[Joint]
    dofs: list[Dof]
    geoms: list[Geom]
    materials: list[Material]
    meshes: list[Mesh]
    sites: list[Site]
    sensors: list[Sensor]
    equalities: list[Equality]
    actuators: list[Actuator]
    tendons: list[Tendon]
    wraps: list[Wrap]
    keys: list[Key]
    qpos0: list[float]
    qpos_spring: list[float]
    gravity: Triple
    """m/s^2; zero if a flag disables it."""
    disabled: list[str]
    """What a flag disables, such as ``contact``."""
    lost: dict[str, list[str]]
    """By a field of MuJoCo's model: the elements that have it, and no URDF can."""
    states: list[State]


class Written(msgspec.Struct):
    """A compiled MJCF, and the names that its URDF has."""

    model: Compiled
    links: list[str]
    """Of each body."""
    joints: list[str]
    """Of each joint; a ball joint becomes three, with the endings ``_R1`` to ``_R3``."""
    shifts: list[Triple]
    """Position of each link's frame in that of its body (m)."""


#: The kinds of elements of ``Compiled``: the prefix of the fields in MuJoCo's model, the type of
#: object that has a name, and the class.
KINDS: dict[str, tuple[str, str, type[msgspec.Struct]]] = {
    "bodies": ("body", "BODY", Body),
    "joints": ("jnt", "JOINT", Joint),
    "dofs": ("dof", "", Dof),
    "geoms": ("geom", "GEOM", Geom),
    "materials": ("mat", "MATERIAL", Material),
    "meshes": ("mesh", "MESH", Mesh),
    "sites": ("site", "SITE", Site),
    "sensors": ("sensor", "SENSOR", Sensor),
    "equalities": ("eq", "EQUALITY", Equality),
    "actuators": ("actuator", "ACTUATOR", Actuator),
    "tendons": ("tendon", "TENDON", Tendon),
    "wraps": ("wrap", "", Wrap),
    "keys": ("key", "KEY", Key),
}
#: Fields of a class that MuJoCo's model does not have under that name.
_COMPUTED = ("name", "file", "refpos", "refquat")


def list_fields(kind: str) -> list[str]:
    """Return the fields of MuJoCo's model that are read of each element of a kind."""
    return [name for name in KINDS[kind][2].__struct_fields__ if name not in _COMPUTED]
