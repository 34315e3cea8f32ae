"""The joint forces as a matrix times the inertial parameters of all bodies: Q = Y p.

(Khalil and Dombre, Modeling, Identification and Control of Robots, 2002, chapter 12.)
"""

from __future__ import annotations

from urdf2mbs_equations.dynamics import BodyMotion, compute_body_motions
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import UNIT_VECTORS, ZERO_VECTOR, Spatial, outer

#: The elements xx, xy, xz, yy, yz, zz of an inertia tensor, in the order of an .mbs.
INERTIA_ELEMENTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
#: Inertial parameters of a body: mass, first moments, inertia about the origin of its frame.
N_PARAMETERS = 4 + len(INERTIA_ELEMENTS)


def compute_regressor(tree: Tree) -> dict[tuple[int, int], Scalar]:
    """Compute the regressor Y, from the base to the leaves.

    Column p of a body is the force f_p that a unit of parameter p requires, projected on the
    velocity J_k of the body for qd_k = 1 of each joint k that moves it::

        Y_kp = J_k^T f_p

    Returns:
        The elements by joint number and parameter number, both from 1; zeros are left out.  Each
        body has ten parameters: mass (kg), first moments (kg m), and the elements xx, xy, xz, yy,
        yz, zz of its inertia about the origin of its frame (kg m^2), in the order of the file.
    """
    motions = compute_body_motions(tree, range(len(tree.frames)))
    jacobians: list[dict[int, Spatial]] = [{}]
    """By frame, then by joint number: the velocity of the frame for qd = 1, in its axes."""
    regressor: dict[tuple[int, int], Scalar] = {}
    first_column = 1
    for frame in tree.frames[1:]:
        jacobian = _transform_to_child(jacobians[frame.parent], frame)
        jacobians.append(jacobian)
        if frame.body is None:
            continue
        forces = _compute_parameter_forces(motions[frame.number])
        for column, force in enumerate(forces, start=first_column):
            for joint, velocity in jacobian.items():
                value = velocity @ force
                if value:
                    regressor[joint, column] = value
        first_column += N_PARAMETERS
    return regressor


def _transform_to_child(parent_jacobian: dict[int, Spatial], frame: Frame) -> dict[int, Spatial]:
    """Return the Jacobian of a frame, from that of its parent."""
    jacobian = {}
    for joint, (linear, angular) in parent_jacobian.items():
        at_frame = linear + angular.cross(frame.offset)
        jacobian[joint] = Spatial((frame.rotate_to_child(at_frame), frame.rotate_to_child(angular)))
    jacobian[frame.number] = frame.motion_subspace
    return jacobian


def _compute_parameter_forces(motion: BodyMotion) -> list[Spatial]:
    """Return force and moment about a body's origin for a unit of each of its parameters.

    With E the inertia tensor that is 1 in one element::

        mass:          f = alpha       n = 0
        first moment:  f = beta e      n = e x alpha
        inertia:       f = 0           n = E dw/dt + w x E w
    """
    omega, alpha = motion.omega, motion.alpha
    forces = [Spatial((alpha, ZERO_VECTOR))]
    forces += [Spatial((motion.beta @ unit, unit.cross(alpha))) for unit in UNIT_VECTORS]
    for i, j in INERTIA_ELEMENTS:
        inertia = outer(UNIT_VECTORS[i], UNIT_VECTORS[j])
        if i != j:
            inertia += outer(UNIT_VECTORS[j], UNIT_VECTORS[i])
        moment = inertia @ motion.omega_dot + omega.cross(inertia @ omega)
        forces.append(Spatial((ZERO_VECTOR, moment)))
    return forces
