"""The model of an .mbs file: a multibody system with the same elements, names and units."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from urdf2mbs.spatial import ZERO, Pose, Sym, Vec

#: Names that a file uses for the ground as a parent, whatever ``Base.name`` says, and for the point
#: at a body's own frame.  In the model both are None, so that they differ from every name.
BASE = "base"
ORIGIN = "origin"

#: The words of an .mbs for each of these; with any other word, Robotran goes wrong silently.
JOINT_TYPES = frozenset(["T1", "T2", "T3", "R1", "R2", "R3"])
NATURES = frozenset(["independent", "dependent", "driven"])
SYMBOLS = frozenset(["q", "qd", "qdd"])
SENSOR_MEASURES = frozenset(["Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"])
SHAPES = frozenset(["box", "cylinder", "cone", "sphere", "inline"])
CUTS = frozenset(["ball", "rod", "solid"])
LINKS = frozenset(["link", "link3D"])

#: A position in the 2D diagram (px), y down.
XY = tuple[float, float]
RGB = tuple[int, int, int]

GREY: RGB = (128, 128, 128)


class SourceElement:
    """The element of a file from which an object was read.

    A writer that changes the file finds the element by it.  It is not part of the model: any two
    are equal.
    """

    __slots__ = ("number", "source")

    def __init__(self, source: bytes, number: int) -> None:
        self.source = source
        """The content of the file."""
        self.number = number
        """The object's number in the order of reading; the model itself is 0."""

    def __eq__(self, other: object) -> bool:
        return other is None or isinstance(other, SourceElement)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"SourceElement({self.number})"


def without_origin(value: object) -> None:
    """Encode the source element of an object as nothing (``enc_hook`` of msgspec).

    So equal objects have equal encodings, wherever they were read.
    """
    if not isinstance(value, SourceElement):
        raise NotImplementedError(f"{type(value).__name__} cannot be encoded")


class Part(msgspec.Struct, kw_only=True):
    """An object that has an element of its own in the file."""

    origin: SourceElement | None = None
    """The element from which it was read; None if it was not."""


class Joint(Part):
    """One degree of freedom: a rotation about (R1 R2 R3) or a translation along (T1 T2 T3) an axis.

    The axes are those of the frame after the joint before.
    """

    name: str
    type: str
    nature: str = "independent"
    """``independent``, ``dependent`` or ``driven``."""
    q: float | None = None
    """Initial position (rad or m); a ``driven`` joint stays there unless user code moves it."""
    qd: float | None = None
    """Initial velocity (rad/s or m/s)."""
    qdd: float | None = None
    """Initial acceleration (rad/s^2 or m/s^2)."""
    actuated: bool = False
    symbols: tuple[str, ...] | None = None
    """Those of q, qd, qdd that are symbols in the generated equations; None for all of them."""
    position: XY | None = None
    """In the 2D diagram."""


class Sensor(Part):
    """A sensor or an external force."""

    name: str
    measures: tuple[str, ...] = ()
    """Those of ``Pos Rot Vit Om Acc Omp Jac`` that it measures."""


class Point(Part):
    """An anchor point, which has a position and no rotation.

    A point called ``origin`` is the body's own frame, with a sensor or a force on it.
    """

    name: str
    coordinates: Vec = ZERO
    """In the body frame (m)."""
    position: XY | None = None
    """In the 2D diagram."""
    sensor: Sensor | None = None
    extforce: Sensor | None = None


class Shape(Part):
    """A 3D shape of a body; cylinders and cones have the axis y."""

    kind: str
    """``box``, ``cylinder``, ``cone``, ``sphere`` or ``inline`` (a file)."""
    name: str
    position: Vec = ZERO
    """In the body frame (m)."""
    rotation: Vec = ZERO
    """Angles (rad) of ``Rx Ry Rz``."""
    scale: Vec = (1.0, 1.0, 1.0)
    color: RGB = GREY
    transparency: float = 0.0
    """From 0 (opaque) to 1."""
    size: Vec | None = None
    """Of a box (m)."""
    radius: float | None = None
    """m."""
    height: float | None = None
    """Of a cylinder or a cone (m)."""
    url: str | None = None
    """The file of an ``inline``."""


class LinkFrame(msgspec.Struct):
    """Where a URDF link's frame is in the .mbs.

    It is constant in a body, or in the frame after one of the joints that lead to the body.
    """

    body: str | None
    """Name in the .mbs; None for the base."""
    joint: str | None
    """Name in the .mbs of the joint in whose frame the pose is; None for the body frame."""
    pose: Pose


class Drawing(msgspec.Struct):
    """The box of a body or of the base in the 2D diagram (px).

    ``position`` and ``control_points`` are relative to the body's last joint, or to the base.
    """

    position: XY = (0.0, 0.0)
    size: XY = (0.0, 0.0)
    control_points: tuple[XY, ...] = ()
    shape: str = "rectangle"
    name_pos: XY = (0.0, 0.0)
    angle: float = 0.0


class Body(Part):
    """A rigid body; its frame is the one after its last joint."""

    name: str
    parent: str | None = None
    """The body that it is attached to; None for the ground."""
    point: str | None = None
    """The parent's anchor point; None for the parent's own frame."""
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
        """The body and the point that it is attached to, which are one element of the file."""
        return self.parent, self.point

    @place.setter
    def place(self, place: tuple[str | None, str | None]) -> None:
        self.parent, self.point = place


class Base(msgspec.Struct):
    """The ground."""

    name: str = "ground"
    gravity: Vec = (0.0, 0.0, -9.81)
    """Acceleration in the axes of the base (m/s^2)."""
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
    """A light of the 3D viewer."""

    name: str
    direction: Vec
    """In the axes of the frame after ``joint``."""
    joint: str = BASE
    active: bool = True


class View(msgspec.Struct):
    """The view with which the 3D viewer opens (the top-level ``x3D``)."""

    background: RGB = (153, 153, 255)
    frame: float = 0.1
    """Size (m) of the symbol of a frame; likewise of a joint, a centre of mass and a point."""
    joint: float = 0.2
    com: float = 0.2
    point: float = 0.3
    viewpoints: list[Viewpoint] = []
    lights: list[Light] = []


class Connection(Part):
    """A cut or a force link between two points."""

    kind: str
    """``ball``, ``rod`` or ``solid`` (a cut), ``link`` or ``link3D`` (a force link)."""
    name: str
    endpoint1: tuple[str | None, str | None]
    """Body and point; None for the ground and for the body's own frame.  In a draft of MBSysPad
    either may be empty, as it is not chosen yet."""
    endpoint2: tuple[str | None, str | None]
    length: float | None = None
    """Of a rod (m)."""

    @property
    def is_draft(self) -> bool:
        """True if a body or point is not chosen yet."""
        return "" in self.endpoint1 or "" in self.endpoint2


class UserConstraint(Part):
    """A constraint of the user's functions, and the joints that it concerns."""

    name: str
    joints: tuple[str, ...] = ()


class Parameter(Part):
    """A parameter of a user model, with one value or several."""

    name: str
    type: str
    values: tuple[str, ...] = ()


class UserModel(Part):
    """Parameters that the user's functions read by their names."""

    name: str
    parameters: list[Parameter] = []

    @classmethod
    def of(cls, name: str, numbers: Mapping[str, float]) -> UserModel:
        """Return a user model whose parameters are numbers, by their names."""
        parameters = [
            Parameter(key, "scalar", (repr(float(number)),)) for key, number in numbers.items()
        ]
        return cls(name, parameters)


class UserVariable(Part):
    """A variable that the functions of the user share."""

    name: str
    type: str
    size: str


class Mbs(Part):
    """The model of a file; its bodies are in the order of the file, parents before children."""

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
        """Return the base, whose name is None, and the bodies: all that have points and shapes."""
        return [(None, self.base), *((body.name, body) for body in self.bodies)]

    def points(self) -> dict[tuple[str | None, str | None], Point]:
        """Return the anchor points, by the name of the body (None: the base) and their own."""
        owners = self.base_and_bodies()
        return {(name, point.name): point for name, owner in owners for point in owner.points}

    def joints(self) -> dict[str, Joint]:
        """Return the joints by name, in the order of the file."""
        return {joint.name: joint for body in self.bodies for joint in body.joints}

    def numbers(self) -> dict[str, int]:
        """Return the number that Robotran gives each joint: 1, 2, ... in the order of the file."""
        return {name: number for number, name in enumerate(self.joints(), start=1)}

    def depth_first(self) -> list[Body]:
        """Return the bodies as MBSysPad numbers them when it saves.

        That is depth first; children at ``origin`` come before the others, and these in the order
        of their parent's points.
        """
        children: dict[str | None, list[Body]] = {}
        for body in self.bodies:
            children.setdefault(body.parent, []).append(body)
        for name, owner in self.base_and_bodies():
            ranks: dict[str | None, int] = {
                point.name: rank for rank, point in enumerate(owner.points)
            }
            children.get(name, []).sort(key=lambda body: ranks.get(body.point, -1))
        order: list[Body] = []
        stack = children.get(None, [])[::-1]
        while stack:
            body = stack.pop()
            order.append(body)
            stack.extend(reversed(children.get(body.name, [])))
        return order
