"""Energy, momentum and centre of mass of the whole model, by recursion over the tree."""

from __future__ import annotations

from urdf2mbs.equations.dynamics import multiply
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import NONE, Tree, Vector, along


def kinetic(tree: Tree) -> tuple[Expr, Vector, Vector]:
    """The kinetic energy (J), the linear momentum (kg m/s) and the angular momentum about the
    base's origin (kg m^2/s), both in the axes of the base.

    Outwards go spin (rad/s) and velocity (m/s) of each frame, inwards the momenta of all that it
    carries, about its origin and in its axes.  Twice the energy is the sum of each joint's rate
    times its momentum, as ``qd' M qd``.
    """
    graph, frames = tree.graph, tree.frames
    spin: list[Vector] = [NONE]
    velocity: list[Vector] = [NONE]
    for frame in frames[1:]:
        before = spin[frame.parent]
        arrives = tree.plus(velocity[frame.parent], tree.cross(before, frame.offset))
        w, v = tree.outward(frame, before), tree.outward(frame, arrives)
        own = along(frame.axis, frame.qd)
        spin.append(tree.plus(w, own) if frame.turns else w)
        velocity.append(v if frame.turns else tree.plus(v, own))
    twice = 0
    linear: list[Vector] = [NONE] * len(frames)
    angular: list[Vector] = [NONE] * len(frames)
    for frame in reversed(frames[1:]):
        k, parent, w = frame.number, frame.parent, spin[frame.number]
        centre = tree.centre(frame)
        p = tree.times(tree.mass(frame), tree.plus(velocity[k], tree.cross(w, centre)))
        turning = tree.plus(multiply(tree, tree.inertia(frame), w), tree.cross(centre, p))
        p, turning = tree.plus(linear[k], p), tree.plus(angular[k], turning)
        along_axis = (turning if frame.turns else p)[frame.axis]
        twice = graph.add(twice, graph.mul(frame.qd, along_axis))
        p, turning = tree.inward(frame, p), tree.inward(frame, turning)
        turning = tree.plus(turning, tree.cross(frame.offset, p))
        linear[parent] = tree.plus(linear[parent], p)
        angular[parent] = tree.plus(angular[parent], turning)
    return graph.mul(graph.constant(0.5), twice), linear[0], angular[0]


def first_moment(tree: Tree) -> tuple[Expr, Vector]:
    """The mass (kg) of the model, and its first moment about the base's origin, in the axes of the
    base (kg m)."""
    mass = [tree.mass(frame) for frame in tree.frames]
    first = [tree.times(m, tree.centre(f)) for m, f in zip(mass, tree.frames, strict=True)]
    for frame in reversed(tree.frames[1:]):
        k, parent = frame.number, frame.parent
        moved = tree.plus(tree.inward(frame, first[k]), tree.times(mass[k], frame.offset))
        first[parent] = tree.plus(first[parent], moved)
        mass[parent] = tree.graph.add(mass[parent], mass[k])
    return mass[0], first[0]
