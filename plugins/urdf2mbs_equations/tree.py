"""The joints and bodies of a model as a tree of frames, with symbolic data.

In Robotran each body has one or more joints in a row, and each joint has one coordinate.  So each
joint has a frame; the frame of a body's last joint is the frame of the body::

      parent frame ---------> frame at q = 0 ---------> frame
                     offset     (permuted      motion     (permuted axes)
                                   axes)      q of joint

``offset`` leads from the origin of the parent frame to the origin of the frame, in axes of the
parent frame.  Of a prismatic joint it includes the translation by q.  The axes of a frame are those
of the .mbs, or, in a limb that is computed together with its mirror image (``pairs``), the same
axes in another order.

Masses, centres of mass, inertias and anchor points are symbols, which the equations read from
Robotran's data.  Numbers that are zero in the .mbs, or a rounding of zero, are the number 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from urdf2mbs.plugin import Body, Mbs
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_equations.graph import Expr, Graph, Scalar, cosine, sine
from urdf2mbs_equations.vectors import (
    SAME_AXES,
    UNIT_VECTORS,
    ZERO_VECTOR,
    AxisPermutation,
    Matrix,
    Spatial,
    Vector,
)


@dataclass
class JointCoordinate:
    """Position (rad, m), velocity and acceleration of a joint: symbols, or numbers."""

    q: Scalar = 0
    qd: Scalar = 0
    qdd: Scalar = 0


@dataclass
class Frame:
    """A joint and its frame."""

    number: int
    """Number of the joint: 1, 2, ... as Robotran counts; 0 is the base."""
    joint: Joint
    parent: int
    """Number of the parent joint; 0 is the base."""
    axis: int
    """The coordinate axis of the joint (0, 1, 2), in axes of this frame."""
    is_revolute: bool
    coordinate: JointCoordinate
    axes_in_file: AxisPermutation
    """From the axes that the frame has in the .mbs to its axes here."""
    axes_in_parent: AxisPermutation
    """From the axes of the parent frame to the axes of this frame at q = 0."""
    offset: Vector
    """Origin of this frame in the parent frame (m)."""
    body: Body | None = None
    """The body whose frame this is."""

    def __post_init__(self) -> None:
        self.sine: Scalar = sine(self.q) if self.is_revolute else 0
        self.cosine: Scalar = cosine(self.q) if self.is_revolute else 1
        self.parent_axes = self.axes_in_parent.inverse
        """From the axes of this frame at q = 0 to the axes of the parent frame."""
        if not self.is_revolute:
            self.offset += self.permute_to_parent(self.joint_axis * self.q)

    @property
    def q(self) -> Scalar:
        """Position (rad, m)."""
        return self.coordinate.q

    @property
    def qd(self) -> Scalar:
        """Velocity (rad/s, m/s)."""
        return self.coordinate.qd

    @property
    def qdd(self) -> Scalar:
        """Acceleration (rad/s^2, m/s^2)."""
        return self.coordinate.qdd

    @property
    def joint_axis(self) -> Vector:
        """The unit vector along the axis of the joint."""
        return UNIT_VECTORS[self.axis]

    @property
    def motion_subspace(self) -> Spatial:
        """The velocity of the frame relative to its parent for qd = 1 (Featherstone's S)."""
        if self.is_revolute:
            return Spatial((ZERO_VECTOR, self.joint_axis))
        return Spatial((self.joint_axis, ZERO_VECTOR))

    @property
    def is_variable(self) -> bool:
        """False if the position of the joint is a number in the equations."""
        return isinstance(self.q, Expr)

    def project_on_joint(self, force: Spatial) -> Scalar:
        """Return S^T f: the component of a force and its moment that acts along the joint."""
        return (force.angular if self.is_revolute else force.linear)[self.axis]

    def permute_to_child(self, vector: Vector) -> Vector:
        """Transform a vector from parent axes to the axes of this frame at q = 0."""
        if self.axes_in_parent is SAME_AXES:
            return vector
        return self.axes_in_parent.permute(vector)

    def permute_to_parent(self, vector: Vector) -> Vector:
        """Transform a vector from the axes of this frame at q = 0 to parent axes."""
        return vector if self.axes_in_parent is SAME_AXES else self.parent_axes.permute(vector)

    def rotate_to_child(self, vector: Vector) -> Vector:
        """Transform a vector from parent axes to the axes of this frame."""
        vector = self.permute_to_child(vector)
        return vector.rotate(self.axis, self.cosine, -self.sine) if self.is_revolute else vector

    def rotate_to_parent(self, vector: Vector) -> Vector:
        """Transform a vector from the axes of this frame to parent axes."""
        return self.permute_to_parent(self.rotate_to_zero(vector))

    def rotate_to_zero(self, vector: Vector) -> Vector:
        """Transform a vector from the axes of this frame to those that it has at q = 0."""
        return vector.rotate(self.axis, self.cosine, self.sine) if self.is_revolute else vector

    def transform_force_to_parent(self, force: Spatial) -> Spatial:
        """Transform a force and its moment from this frame to the parent frame.

        With R the rotation to parent axes and p the offset (Featherstone, 2.8)::

            f_parent = R f        n_parent = R n + p x R f
        """
        f, n = self.rotate_to_parent(force.linear), self.rotate_to_parent(force.angular)
        return Spatial((f, n + self.offset.cross(f)))


class Tree:
    """All frames of a model in one graph; ``frames[0]`` is the frame of the base."""

    def __init__(
        self,
        mbs: Mbs,
        *,
        fold: bool = False,
        at_start: bool = False,
        axes_in_file: Mapping[int, AxisPermutation] | None = None,
    ) -> None:
        """Make the frames of a model.

        Args:
            mbs: The model.
            fold: Use the numbers of masses, points and so on, not symbols.
            at_start: Use numbers only: all joints are at the start position, without velocity.
            axes_in_file: By joint number, the axes of a frame if they are not those of the .mbs.
        """
        self.mbs = mbs
        self.graph = Graph()
        self.fold, self.at_start = fold or at_start, at_start
        self.last_joint: dict[str | None, int] = {None: 0}
        """The number of the last joint of each body."""
        points = mbs.points()
        self.point_numbers = {key: number for number, key in enumerate(points, start=1)}
        """The numbers of anchor points as Robotran counts: in order of the file, base first."""
        self.point_coordinates = {
            key: remove_rounding(point.coordinates) for key, point in points.items()
        }
        base = Frame(
            0,
            Joint("", "T1"),
            0,
            axis=0,
            is_revolute=False,
            coordinate=JointCoordinate(),
            axes_in_file=SAME_AXES,
            axes_in_parent=SAME_AXES,
            offset=ZERO_VECTOR,
        )
        self.frames = [base]
        for body in mbs.bodies:
            parent, offset = self.last_joint[body.parent], self.get_point(body.parent, body.point)
            for joint in body.joints:
                axes = (axes_in_file or {}).get(len(self.frames), SAME_AXES)
                parent = self._append_frame(joint, parent, offset, axes)
                offset = ZERO_VECTOR
            self.last_joint[body.name] = parent
            self.frames[parent].body = body

    def _append_frame(
        self, joint: Joint, parent: int, offset: Vector, axes: AxisPermutation
    ) -> int:
        """Append the frame of a joint, and return its number."""
        number = len(self.frames)
        frame = Frame(
            number,
            joint,
            parent,
            axis=[old for old, _ in axes].index(int(joint.type[1]) - 1),
            is_revolute=joint.type[0] == "R",
            coordinate=self._make_coordinate(joint, number),
            axes_in_file=axes,
            axes_in_parent=axes.compose(self.frames[parent].axes_in_file.inverse),
            offset=offset,
        )
        self.frames.append(frame)
        return number

    def _make_coordinate(self, joint: Joint, number: int) -> JointCoordinate:
        if self.at_start or is_fixed(joint):
            return JointCoordinate(joint.q or 0.0)
        present = ("q", "qd", "qdd") if joint.symbols is None else joint.symbols
        return JointCoordinate(
            *(
                self.graph.make_symbol(f"{name}[{number}]") if name in present else 0
                for name in ("q", "qd", "qdd")
            )
        )

    def get_parameter(self, value: float | None, name: str) -> Scalar:
        """Return a number of the .mbs: a symbol, or the number if it is zero or with ``fold``."""
        return self.graph.make_symbol(name) if value and not self.fold else value or 0

    def get_point(self, body: str | None, point: str | None) -> Vector:
        """Return the coordinates of an anchor point in the frame of its body (m)."""
        if point is None:
            return ZERO_VECTOR
        number = self.point_numbers[body, point]
        coordinates = Vector(
            self.get_parameter(value, f"dpt[{k}][{number}]")
            for k, value in enumerate(self.point_coordinates[body, point], start=1)
        )
        return self.frames[self.last_joint[body]].axes_in_file.permute(coordinates)

    def get_gravity(self) -> Vector:
        """Return gravity in base axes (m/s^2): three symbols, since its direction may change."""
        values = enumerate(self.mbs.base.gravity, start=1)
        return Vector(
            value if self.fold else self.graph.make_symbol(f"g[{k}]") for k, value in values
        )

    def get_mass(self, frame: Frame) -> Scalar:
        """Return the mass of the frame's body (kg)."""
        body = frame.body
        return 0 if body is None else self.get_parameter(body.mass, f"m[{frame.number}]")

    def get_centre(self, frame: Frame) -> Vector:
        """Return the centre of mass of the frame's body, in the frame (m)."""
        if frame.body is None or frame.body.com is None:
            return ZERO_VECTOR
        values = enumerate(remove_rounding(frame.body.com), start=1)
        return frame.axes_in_file.permute(
            Vector(self.get_parameter(value, f"l[{k}][{frame.number}]") for k, value in values)
        )

    def get_inertia(self, frame: Frame) -> Matrix:
        """Return the inertia of the frame's body about its centre of mass (kg m^2)."""
        inertia = frame.body and frame.body.inertia
        xx, xy, xz, yy, yz, zz = (
            self.get_parameter(value, f"In[{k}][{frame.number}]")
            for k, value in zip(
                (1, 2, 3, 5, 6, 9), remove_rounding(inertia or (0.0,) * 6), strict=True
            )
        )
        rows = Vector((xx, xy, xz)), Vector((xy, yy, yz)), Vector((xz, yz, zz))
        return frame.axes_in_file.permute_matrix(Matrix(rows))

    def get_external_force(self, frame: Frame) -> Spatial:
        """Return ``frc`` (N) and ``trq`` (Nm), which act on a body at its centre of mass."""
        force, torque = (
            Vector(self.graph.make_symbol(f"{name}[{k}][{frame.number}]") for k in (1, 2, 3))
            for name in ("frc", "trq")
        )
        return Spatial((frame.axes_in_file.permute(force), frame.axes_in_file.permute(torque)))


#: A number this many times smaller than the largest number beside it is a rounding of zero.
ROUNDING = 1e-15


def remove_rounding(numbers: Sequence[float]) -> list[float]:
    """Replace numbers that are only roundings of zero, beside the largest one, by zero.

    A frame that was rotated by 90 degrees leaves 1e-17 in place of zero.

    Args:
        numbers: Coordinates of a point, or elements of a tensor.
    """
    threshold = ROUNDING * max(abs(number) for number in numbers)
    return [number if abs(number) > threshold else 0.0 for number in numbers]


def is_fixed(joint: Joint) -> bool:
    """Return True if a joint never moves: it is driven, and its only symbol is ``q``."""
    return joint.nature == "driven" and joint.symbols == ("q",)
