"""A multibody system as an .mbs file states it: the same elements, names and units."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from urdf2mbs.spatial import ZERO, Pose, Sym, Vec

#: How a file calls the ground as a parent, whatever ``Base.name`` says, and the point at
#: a body's own frame.  In the model both are None, so that no name can be mistaken for them.
BASE = "base"
ORIGIN = "origin"

#: The words that an .mbs has for each of these; with any other, Robotran goes wrong silently.
JOINT_TYPES = frozenset(["T1", "T2", "T3", "R1", "R2", "R3"])
NATURES = frozenset(["independent", "dependent", "driven"])
SYMBOLS = frozenset(["q", "qd", "qdd"])
SENSOR_MEASURES = frozenset(["Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"])
SHAPES = frozenset(["box", "cylinder", "cone", "sphere", "inline"])
CUTS = frozenset(["ball", "rod", "solid"])
LINKS = frozenset(["link", "link3D"])

#: Pixels in the 2D diagram, y down.
XY = tuple[float, float]
RGB = tuple[int, int, int]

GREY: RGB = (128, 128, 128)


class Origin:
    """The element of a file from which an object was read.

    Who writes into the file finds the element by the origin.  The origin is no part of what an
    object says: any two are equal.
    """

    __slots__ = ("number", "source")

    def __init__(self, source: bytes, number: int) -> None:
        self.source = source
        """The whole file."""
        self.number = number
        """The object's number in the order of reading; the file itself is 0."""

    def __eq__(self, other: object) -> bool:
        return other is None or isinstance(other, Origin)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Origin({self.number})"


def without_origin(value: object) -> None:
    """How msgspec makes an origin plain: what an object says is the same wherever it was read."""
    if not isinstance(value, Origin):
        raise NotImplementedError(f"{type(value).__name__} is not plain")


class Part(msgspec.Struct, kw_only=True):
    """An object that has an element of its own in the file."""

    origin: Origin | None = None


class Joint(Part):
    """One degree of freedom: a turn (R1 R2 R3) or a shift (T1 T2 T3) along a current axis."""

    name: str
    type: str
    nature: str = "independent"
    """``independent``, ``dependent`` or ``driven``."""
    q: float | None = None
    """Initial position, rad or m; where a ``driven`` joint stays unless user code moves it."""
    qd: float | None = None
    qdd: float | None = None
    actuated: bool = False
    symbols: tuple[str, ...] | None = None
    """Those of q, qd, qdd that stay in the generated equations; None is all of them."""
    position: XY | None = None


class Sensor(Part):
    """A sensor or an external force: what it measures (``Pos Rot Vit Om Acc Omp Jac``)."""

    name: str
    measures: tuple[str, ...] = ()


class Point(Part):
    """An anchor point: a translation (m) in the body frame; it has no rotation.

    A point called ``origin`` is the body's own frame, with a sensor or a force on it.
    """

    name: str
    coordinates: Vec = ZERO
    position: XY | None = None
    sensor: Sensor | None = None
    extforce: Sensor | None = None


class Shape(Part):
    """A 3D shape: ``T Rx Ry Rz S`` in the body frame; cylinders and cones have axis y."""

    kind: str
    """``box``, ``cylinder``, ``cone``, ``sphere`` or ``inline``."""
    name: str
    position: Vec = ZERO
    rotation: Vec = ZERO
    scale: Vec = (1.0, 1.0, 1.0)
    color: RGB = GREY
    transparency: float = 0.0
    size: Vec | None = None
    radius: float | None = None
    height: float | None = None
    url: str | None = None


class LinkFrame(msgspec.Struct):
    """Where a URDF link's frame is in the .mbs: constant in a body, or in the frame after
    one of the joints that lead to it."""

    body: str | None
    """Name in the .mbs; None is the base."""
    joint: str | None
    """Name in the .mbs of the joint after which the frame stands; None: the body frame."""
    pose: Pose


class Drawing(msgspec.Struct):
    """How a body is drawn in the 2D diagram.

    ``position`` and ``control_points`` count from the body's last joint, the base's from the base.
    """

    position: XY = (0.0, 0.0)
    size: XY = (0.0, 0.0)
    control_points: tuple[XY, ...] = ()
    shape: str = "rectangle"
    name_pos: XY = (0.0, 0.0)
    angle: float = 0.0


class Body(Part):
    """A rigid body, its frame being the one after its last joint."""

    name: str
    parent: str | None = None
    """The body it is attached to; None is the ground."""
    point: str | None = None
    """The parent's anchor point; None is the parent's own frame."""
    joints: list[Joint] = []
    mass: float | None = None
    com: Vec | None = None
    """Centre of mass in the body frame (m)."""
    inertia: Sym | None = None
    """About the centre of mass, in body axes (kg m^2)."""
    points: list[Point] = []
    shapes: list[Shape] = []
    drawing: Drawing | None = None

    @property
    def place(self) -> tuple[str | None, str | None]:
        """The body and the point that it is attached to."""
        return self.parent, self.point

    @place.setter
    def place(self, place: tuple[str | None, str | None]) -> None:
        self.parent, self.point = place


class Base(msgspec.Struct):
    """The ground. ``gravity`` is an acceleration in its axes (m/s^2)."""

    name: str = "ground"
    gravity: Vec = (0.0, 0.0, -9.81)
    points: list[Point] = []
    shapes: list[Shape] = []
    position: XY | None = None
    drawing: Drawing | None = None


class Viewpoint(Part):
    """A camera: position and target in m, clip distances in m, field of view in rad."""

    name: str
    position: Vec
    target: Vec
    up: Vec = (0.0, 0.0, 1.0)
    joint: str = BASE
    projection: str = "perspective"
    scale: float = 1.0
    field_of_view: float = 0.785
    front_clip: float = 0.01
    back_clip: float = 50.0


class Light(Part):
    """A light of the 3D viewer; ``direction`` in the axes behind ``joint``."""

    name: str
    direction: Vec
    joint: str = BASE
    active: bool = True


class View(msgspec.Struct):
    """The top-level ``x3D``: how the 3D viewer opens. The scale factors are m."""

    background: RGB = (153, 153, 255)
    frame: float = 0.1
    joint: float = 0.2
    com: float = 0.2
    point: float = 0.3
    viewpoints: list[Viewpoint] = []
    lights: list[Light] = []


class Connection(Part):
    """A cut (``ball``, ``rod``, ``solid``) or a force link (``link``, ``link3D``) between
    two points, each given as (body, point), None being the ground and the body's own frame.
    In a draft of MBSysPad a body or point may be empty: not chosen yet."""

    kind: str
    name: str
    endpoint1: tuple[str | None, str | None]
    endpoint2: tuple[str | None, str | None]
    length: float | None = None

    @property
    def is_draft(self) -> bool:
        """True if an end is not placed yet."""
        return "" in self.endpoint1 or "" in self.endpoint2


class UserConstraint(Part):
    """A constraint that the user's functions state, and the joints that it concerns."""

    name: str
    joints: tuple[str, ...] = ()


class Parameter(Part):
    """A value, or several, of a user model."""

    name: str
    type: str
    values: tuple[str, ...] = ()


class UserModel(Part):
    """Parameters that the user's functions read by their names."""

    name: str
    parameters: list[Parameter] = []

    @classmethod
    def of(cls, name: str, numbers: Mapping[str, float]) -> UserModel:
        """The user model whose parameters are these numbers."""
        return cls(
            name, [Parameter(key, "scalar", (repr(float(v)),)) for key, v in numbers.items()]
        )


class UserVariable(Part):
    """A variable that the user's functions share."""

    name: str
    type: str
    size: str


class Mbs(Part):
    """The whole file. ``bodies`` stand in the order of the file: parents before children."""

    name: str
    version: str = "1.0"
    base: Base = msgspec.field(default_factory=Base)
    bodies: list[Body] = []
    cuts: list[Connection] = []
    links: list[Connection] = []
    user_constraints: list[UserConstraint] = []
    user_models: list[UserModel] = []
    user_variables: list[UserVariable] = []
    view: View | None = None

    def base_and_bodies(self) -> list[tuple[str | None, Base | Body]]:
        """The base and the bodies, which have points and shapes, by name: None is the base."""
        return [(None, self.base), *((body.name, body) for body in self.bodies)]

    def points(self) -> dict[tuple[str | None, str | None], Point]:
        """The anchor points, by the names of their bodies and their own."""
        owners = self.base_and_bodies()
        return {(name, point.name): point for name, owner in owners for point in owner.points}

    def joints(self) -> dict[str, Joint]:
        """The joints by name, in the order of the file."""
        return {joint.name: joint for body in self.bodies for joint in body.joints}

    def numbers(self) -> dict[str, int]:
        """The number that Robotran gives each joint: 1, 2, ... in the order of the file."""
        return {name: number for number, name in enumerate(self.joints(), start=1)}

    def depth_first(self) -> list[Body]:
        """The bodies as MBSysPad renumbers them when it saves: depth first, children at
        ``origin`` before the others, those in the order of their parent's points."""
        children: dict[str | None, list[Body]] = {}
        for body in self.bodies:
            children.setdefault(body.parent, []).append(body)
        for name, owner in self.base_and_bodies():
            rank: dict[str | None, int] = {point.name: n for n, point in enumerate(owner.points)}
            children.get(name, []).sort(key=lambda body: rank.get(body.point, -1))
        order: list[Body] = []
        stack = children.get(None, [])[::-1]
        while stack:
            body = stack.pop()
            order.append(body)
            stack.extend(reversed(children.get(body.name, [])))
        return order
