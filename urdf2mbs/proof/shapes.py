"""Compare where the .mbs shows the visuals of the URDF.

A shape has no mass, so a displaced shape is not a difference of the robots; the verdict names it.
Shapes are compared up to the symmetry of their geometry:

* a sphere is its centre;
* a capsule is a cylinder and two spheres, as an .mbs has no capsules;
* a cylinder is its centre and its axis, up to the sign (along z in URDF, along y in .mbs);
* a box is its centre and its three edges, up to their signs and order;
* a mesh is its origin and its three scaled axes.  Negative scales are treated as positive: a
  mirrored mesh may be a file of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import dist, isclose

import msgspec

from urdf2mbs.mbs.model import Shape
from urdf2mbs.proof.rigid import (
    AXES,
    IDENTITY,
    Frame,
    X,
    Y,
    Z,
    compose,
    compute_angle,
    compute_rotation,
    rotate,
    transform_point,
)
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Geometry, Sphere

#: A rotation (rad), or a shift relative to the reach of the group, that nobody sees.
INVISIBLE = 1e-6


class Solid(msgspec.Struct, frozen=True):
    """A shape in the frame of its group."""

    kind: str
    """``sphere``, ``cylinder``, ``box``, or ``inline`` (a mesh)."""
    sizes: tuple[float, ...]
    """m; the scale of a mesh."""
    centre: Vec
    """m."""
    axes: tuple[Vec, ...]
    """Unit vectors of the axes that the geometry distinguishes."""

    @property
    def edges(self) -> tuple[float, ...]:
        """The size along each axis, by which the axes of a box are distinguished."""
        return self.sizes if self.kind == "box" else (1.0,) * len(self.axes)

    def is_congruent(self, candidate: Solid) -> bool:
        """Return True for a shape of the same kind and size, wherever it is."""
        if self.kind != candidate.kind:
            return False
        sizes, candidate_sizes = self.sizes, candidate.sizes
        if self.kind == "box":
            sizes, candidate_sizes = tuple(sorted(sizes)), tuple(sorted(candidate_sizes))
        return all(
            isclose(a, b, rel_tol=INVISIBLE) for a, b in zip(sizes, candidate_sizes, strict=True)
        )

    def compute_angle_from(self, congruent: Solid) -> float:
        """Compute the largest angle (rad) between an axis and that of a congruent shape."""
        angles = (self._compute_axis_angle(index, congruent) for index in range(len(self.axes)))
        return max(angles, default=0.0)

    def _compute_axis_angle(self, index: int, congruent: Solid) -> float:
        """Compute the angle (rad) between an axis and its counterpart of a congruent shape."""
        axis = self.axes[index]
        if self.kind == "inline":  # no symmetry of a mesh is known
            return compute_angle(axis, congruent.axes[index])
        return min(
            compute_angle(axis, signed_axis)
            for edge, candidate in zip(congruent.edges, congruent.axes, strict=True)
            if isclose(edge, self.edges[index], rel_tol=INVISIBLE)
            for signed_axis in (candidate, _negate(candidate))
        )


def _negate(vector: Vec) -> Vec:
    """Return the opposite vector."""
    return (-vector[0], -vector[1], -vector[2])


def convert_visual(geometry: Geometry, frame: Frame) -> list[Solid]:
    """Return the solids by which an .mbs shows the geometry of a visual.

    Args:
        geometry: The geometry.
        frame: Its frame, in the frame of a group.
    """
    centre = frame[9:]
    if isinstance(geometry, Sphere):
        return [Solid("sphere", (geometry.radius,), centre, ())]
    if isinstance(geometry, Cylinder | Capsule):
        sizes = (geometry.radius, geometry.length)
        cylinder = Solid("cylinder", sizes, centre, (rotate(frame, Z),))
        if isinstance(geometry, Cylinder):
            return [cylinder]
        ends = ((0.0, 0.0, sign * geometry.length / 2) for sign in (-1, 1))
        spheres = (
            Solid("sphere", (geometry.radius,), transform_point(frame, end), ()) for end in ends
        )
        return [cylinder, *spheres]
    axes = tuple(rotate(frame, axis) for axis in AXES)
    if isinstance(geometry, Box):
        return [Solid("box", geometry.size, centre, axes)]
    x, y, z = geometry.scale
    return [Solid("inline", (abs(x), abs(y), abs(z)), centre, axes)]


def convert_shape(shape: Shape, body_frame: Frame) -> Solid | None:
    """Return a shape of an .mbs as a solid; None if URDF has no such geometry.

    The pose of the shape in its body is ``T Rx Ry Rz``, each rotation about a current axis.

    Args:
        shape: The shape.
        body_frame: The frame of its body, in the frame of a group.
    """
    frame: Frame = IDENTITY
    for axis, angle in zip((X, Y, Z), shape.rotation, strict=True):
        frame = compose(frame, compute_rotation(axis, angle))
    frame = compose(body_frame, (*frame[:9], *shape.position))
    centre = frame[9:]
    if shape.kind == "sphere" and shape.radius is not None:
        return Solid("sphere", (shape.radius,), centre, ())
    if shape.kind == "cylinder" and shape.radius is not None and shape.height is not None:
        return Solid("cylinder", (shape.radius, shape.height), centre, (rotate(frame, Y),))
    axes = tuple(rotate(frame, axis) for axis in AXES)
    if shape.kind == "box" and shape.size is not None:
        return Solid("box", shape.size, centre, axes)
    if shape.kind == "inline":
        x, y, z = shape.scale
        return Solid("inline", (abs(x), abs(y), abs(z)), centre, axes)
    return None


def find_nearest(solid: Solid, candidates: Sequence[Solid], scale: float) -> Solid | None:
    """Find the congruent solid with the least rotation and shift; None if none is congruent.

    Args:
        solid: The solid.
        candidates: Solids of the same group.
        scale: Length (m) to which a shift is relative.
    """

    def deviation(candidate: Solid) -> float:
        shift = dist(solid.centre, candidate.centre)
        return solid.compute_angle_from(candidate) + shift / scale

    return min(filter(solid.is_congruent, candidates), key=deviation, default=None)


def describe_deviation(solid: Solid, congruent: Solid, scale: float) -> str:
    """Return how a solid is rotated and shifted from a congruent one; empty if nobody sees it.

    Args:
        solid: The solid.
        congruent: A congruent solid in the same frame.
        scale: Length (m) to which a shift is relative.
    """
    angle, shift = solid.compute_angle_from(congruent), dist(solid.centre, congruent.centre)
    parts = [f"rotated by {angle:.3g} rad"] if not angle <= INVISIBLE else []
    parts += [f"shifted by {shift:.3g} m"] if not shift <= INVISIBLE * scale else []
    return " and ".join(parts)
