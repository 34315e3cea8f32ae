"""Energy, momentum and centre of mass of the whole model, by recursion over the tree."""

from __future__ import annotations

from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import STILL, Spatial, Vector


def kinetic(tree: Tree) -> tuple[Scalar, Vector, Vector]:
    """The kinetic energy (J), the linear momentum (kg m/s) and the angular momentum about the
    base's origin (kg m^2/s), both in the axes of the base.

    Outwards go velocity (m/s) and angular velocity (rad/s) of each frame, inwards the momenta of
    all that it carries, about its origin and in its axes.  Twice the energy is the sum of each
    joint's rate times its momentum, as ``qd' M qd``.
    """
    velocity = [STILL]
    for frame in tree.frames[1:]:
        v, w = velocity[frame.parent]
        arrives = Spatial((frame.to_child(v + w.cross(frame.offset)), frame.to_child(w)))
        velocity.append(arrives + frame.qd * frame.motion)
    twice: Scalar = 0
    momentum = [STILL] * len(tree.frames)
    for frame in reversed(tree.frames[1:]):
        k, centre = frame.number, tree.centre(frame)
        v, w = velocity[k]
        p = tree.mass(frame) * (v + w.cross(centre))
        whole = Spatial((p, tree.inertia(frame) @ w + centre.cross(p))) + momentum[k]
        twice += frame.qd * frame.along(whole)
        momentum[frame.parent] += frame.inward(whole)
    linear, angular = momentum[0]
    return 0.5 * twice, linear, angular


def centre_of_mass(tree: Tree) -> Vector | None:
    """Of the whole model, in the axes of the base (m); None if no body has a mass."""
    mass, first = first_moment(tree)
    return 1 / mass * first if mass else None


def first_moment(tree: Tree) -> tuple[Scalar, Vector]:
    """The mass (kg) of the model, and its first moment about the base's origin, in the axes of the
    base (kg m)."""
    mass = [tree.mass(frame) for frame in tree.frames]
    first = [m * tree.centre(frame) for m, frame in zip(mass, tree.frames, strict=True)]
    for frame in reversed(tree.frames[1:]):
        k, parent = frame.number, frame.parent
        first[parent] += frame.to_parent(first[k]) + mass[k] * frame.offset
        mass[parent] += mass[k]
    return mass[0], first[0]
