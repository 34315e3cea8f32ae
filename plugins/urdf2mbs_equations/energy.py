"""Energy, momentum and centre of mass of the whole model, by recursion over the tree."""

from __future__ import annotations

from typing import NamedTuple

from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import ZERO_SPATIAL, Spatial, Vector


class KineticState(NamedTuple):
    """Kinetic energy and momentum of the whole model, in base axes."""

    energy: Scalar
    """J."""
    linear_momentum: Vector
    """kg m/s."""
    angular_momentum: Vector
    """About the origin of the base (kg m^2/s)."""


def compute_kinetic_state(tree: Tree) -> KineticState:
    """Compute kinetic energy and momentum.

    Velocities v, w are computed from the base to the leaves, momenta h from the leaves to the base;
    h_k is the momentum of everything that joint k carries, about the origin of its frame::

        2 E = sum over joints of qd_k S_k^T h_k
    """
    velocities = [ZERO_SPATIAL]
    for frame in tree.frames[1:]:
        v, w = velocities[frame.parent]
        at_frame = v + w.cross(frame.offset)
        transformed = Spatial((frame.rotate_to_child(at_frame), frame.rotate_to_child(w)))
        velocities.append(transformed + frame.qd * frame.motion_subspace)
    twice_energy: Scalar = 0
    momenta = [ZERO_SPATIAL] * len(tree.frames)
    for frame in reversed(tree.frames[1:]):
        k, centre = frame.number, tree.get_centre(frame)
        v, w = velocities[k]
        linear = tree.get_mass(frame) * (v + w.cross(centre))
        angular = tree.get_inertia(frame) @ w + centre.cross(linear)
        momentum = Spatial((linear, angular)) + momenta[k]
        twice_energy += frame.qd * frame.project_on_joint(momentum)
        momenta[frame.parent] += frame.transform_force_to_parent(momentum)
    return KineticState(0.5 * twice_energy, *momenta[0])


def compute_centre_of_mass(tree: Tree) -> Vector | None:
    """Return the centre of mass of the model in base axes (m); None if no body has a mass."""
    mass, first_moment = compute_first_moment(tree)
    return 1 / mass * first_moment if mass else None


def compute_first_moment(tree: Tree) -> tuple[Scalar, Vector]:
    """Return the mass (kg) and the first moment of mass (kg m) of the model.

    The first moment is about the origin of the base, in base axes.
    """
    masses = [tree.get_mass(frame) for frame in tree.frames]
    moments = [
        mass * tree.get_centre(frame) for mass, frame in zip(masses, tree.frames, strict=True)
    ]
    for frame in reversed(tree.frames[1:]):
        k, parent = frame.number, frame.parent
        moments[parent] += frame.rotate_to_parent(moments[k]) + masses[k] * frame.offset
        masses[parent] += masses[k]
    return masses[0], moments[0]
