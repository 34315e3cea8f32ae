"""Shapes of the two sides: where the .mbs shows each visual of the URDF.

A shape has no mass, so a shape elsewhere is no other robot; the verdict names it.  Shapes are the
same up to the symmetry of their geometry:

* a sphere is its centre;
* a capsule is a cylinder and two spheres, as an .mbs has no capsules;
* a cylinder is its centre and half of its axis, up to the sign (along z in URDF, along y in .mbs);
* a box is its centre and its three half edges, up to their signs and order;
* a mesh is its origin and its three scaled axes.  Negative scales count as positive: a mirrored
  mesh may be a file of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import dist, isclose

import msgspec

from urdf2mbs.mbs import model as mbs
from urdf2mbs.proof.rigid import AXES, HERE, Frame, X, Y, Z, angle, compose, moved, spin, turned
from urdf2mbs.spatial import Vec
from urdf2mbs.urdf.model import Box, Capsule, Cylinder, Geometry, Sphere

#: A turn (rad), or a shift relative to the reach of the group, that nobody sees.
UNSEEN = 1e-6


class Solid(msgspec.Struct, frozen=True):
    """A shape in the frame of its group."""

    kind: str
    sizes: tuple[float, ...]
    """m, but for a mesh, whose scale they are."""
    centre: Vec
    """m."""
    directions: tuple[Vec, ...]
    """Unit vectors of its axes, as far as the geometry tells them apart."""

    @property
    def edges(self) -> tuple[float, ...]:
        """The size along each direction, by which the axes of a box are told apart."""
        return self.sizes if self.kind == "box" else (1.0,) * len(self.directions)

    def is_like(self, other: Solid) -> bool:
        """Return True for a shape of the same kind and size, wherever it is."""
        if self.kind != other.kind:
            return False
        sizes = [self.sizes, other.sizes]
        if self.kind == "box":
            sizes = [tuple(sorted(edges)) for edges in sizes]
        return all(isclose(a, b, rel_tol=UNSEEN) for a, b in zip(*sizes, strict=True))

    def turn_from(self, other: Solid) -> float:
        """Return the largest angle (rad) between an axis and its counterpart in a like shape."""
        return max((self._turn(n, other) for n in range(len(self.directions))), default=0.0)

    def _turn(self, number: int, other: Solid) -> float:
        direction = self.directions[number]
        if self.kind == "inline":  # a mesh has no symmetry that is known
            return angle(direction, other.directions[number])
        return min(
            angle(direction, rival)
            for edge, axis in zip(other.edges, other.directions, strict=True)
            if isclose(edge, self.edges[number], rel_tol=UNSEEN)
            for rival in (axis, _negative(axis))
        )


def _negative(v: Vec) -> Vec:
    return (-v[0], -v[1], -v[2])


def solids_of_visual(geometry: Geometry, frame: Frame) -> list[Solid]:
    """Return the shapes by which an .mbs shows a visual's geometry that stands in a frame."""
    centre = frame[9:]
    if isinstance(geometry, Sphere):
        return [Solid("sphere", (geometry.radius,), centre, ())]
    if isinstance(geometry, Cylinder | Capsule):
        sizes = (geometry.radius, geometry.length)
        cylinder = Solid("cylinder", sizes, centre, (turned(frame, Z),))
        if isinstance(geometry, Cylinder):
            return [cylinder]
        ends = ((0.0, 0.0, side * geometry.length / 2) for side in (-1, 1))
        balls = (Solid("sphere", (geometry.radius,), moved(frame, end), ()) for end in ends)
        return [cylinder, *balls]
    directions = tuple(turned(frame, axis) for axis in AXES)
    if isinstance(geometry, Box):
        return [Solid("box", geometry.size, centre, directions)]
    x, y, z = geometry.scale
    return [Solid("inline", (abs(x), abs(y), abs(z)), centre, directions)]


def solid_of_shape(shape: mbs.Shape, body: Frame) -> Solid | None:
    """Return a shape of a body that stands in a frame; None if the URDF has no such geometry.

    The shape stands at T Rx Ry Rz in the body frame, each turn about a current axis.
    """
    frame: Frame = HERE
    for axis, amount in zip((X, Y, Z), shape.rotation, strict=True):
        frame = compose(frame, spin(axis, amount))
    frame = compose(body, (*frame[:9], *shape.position))
    centre = moved(body, shape.position)
    if shape.kind == "sphere" and shape.radius is not None:
        return Solid("sphere", (shape.radius,), centre, ())
    if shape.kind == "cylinder" and shape.radius is not None and shape.height is not None:
        return Solid("cylinder", (shape.radius, shape.height), centre, (turned(frame, Y),))
    directions = tuple(turned(frame, axis) for axis in AXES)
    if shape.kind == "box" and shape.size is not None:
        return Solid("box", shape.size, centre, directions)
    if shape.kind == "inline":
        x, y, z = shape.scale
        return Solid("inline", (abs(x), abs(y), abs(z)), centre, directions)
    return None


def find_nearest(solid: Solid, candidates: Sequence[Solid], scale: float) -> Solid | None:
    """Return the like shape that is nearest in place and turn; None if there is no like one."""
    like = [other for other in candidates if solid.is_like(other)]
    return min(like, key=lambda other: _deviation(solid, other, scale), default=None)


def describe_deviation(solid: Solid, other: Solid, scale: float) -> str:
    """Return how a shape is turned and shifted; empty if nobody sees it.  ``scale``: m."""
    turn, shift = solid.turn_from(other), dist(solid.centre, other.centre)
    parts = [f"turned by {turn:.3g} rad"] if not turn <= UNSEEN else []
    parts += [f"shifted by {shift:.3g} m"] if not shift <= UNSEEN * scale else []
    return " and ".join(parts)


def _deviation(solid: Solid, other: Solid, scale: float) -> float:
    return solid.turn_from(other) + dist(solid.centre, other.centre) / scale
