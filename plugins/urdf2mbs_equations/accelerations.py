"""Accelerations of a tree, without loops (forward dynamics).

The mass matrix M of the independent joints is factorized as L^T D L, which keeps the zeros between
branches of the tree (Featherstone, Rigid Body Dynamics Algorithms, 2008, 6.5).  In the equation

    M qdd = Q - c

the forces c include those that the accelerations of driven joints require.
"""

from __future__ import annotations

from urdf2mbs_equations.dynamics import UpperTriangle, compute_joint_forces, compute_mass_matrix
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.kinematics import list_chain
from urdf2mbs_equations.tree import Tree


class MasslessJointError(Exception):
    """No mass moves with an independent joint; the argument is the name of the joint."""


def compute_accelerations(tree: Tree) -> dict[int, Scalar]:
    """Compute qdd of the independent joints for the joint forces ``Qq``.

    Returns:
        qdd by joint number.

    Raises:
        MasslessJointError: M is singular.
    """
    driven = [frame.number for frame in tree.frames[1:] if frame.joint.nature == "driven"]
    independent = [frame.number for frame in tree.frames[1:] if frame.joint.nature != "driven"]
    bias, matrix = compute_joint_forces(tree, driven), compute_mass_matrix(tree)
    ancestors = {
        k: [frame.number for frame in list_chain(tree, k)[-2::-1] if frame.joint.nature != "driven"]
        for k in independent
    }
    """By joint number the independent ancestors of a joint, the nearest first."""
    factor, inverse_pivots = _factorize(tree, matrix, ancestors)
    x = {k: tree.graph.make_symbol(f"Qq[{k}]") - bias[k] for k in independent}
    for k in reversed(independent):  # x = L^-T x
        for i in ancestors[k]:
            x[i] -= factor[i, k] * x[k]
    for k in independent:  # x = L^-1 D^-1 x
        x[k] *= inverse_pivots[k]
        for i in ancestors[k]:
            x[k] -= factor[i, k] * x[i]
    return x


def _factorize(
    tree: Tree, matrix: UpperTriangle, ancestors: dict[int, list[int]]
) -> tuple[UpperTriangle, dict[int, Scalar]]:
    """Factorize M = L^T D L, from the leaves to the base; ``matrix`` is changed.

    For each joint k, with ancestors i and j::

        L_ki = M_ik / M_kk        M_ji = M_ji - L_ki M_jk

    Returns:
        L_ki as element (i, k), and 1 / D_k by joint number.
    """
    factor: UpperTriangle = {}
    inverse_pivots: dict[int, Scalar] = {}
    for k in reversed(ancestors):
        if not matrix.get((k, k)):
            raise MasslessJointError(tree.frames[k].joint.name)
        inverse_pivots[k] = 1 / matrix[k, k]
        for i in ancestors[k]:
            factor[i, k] = matrix.get((i, k), 0) * inverse_pivots[k]
            for j in (i, *ancestors[i]):
                matrix[j, i] = matrix.get((j, i), 0) - factor[i, k] * matrix.get((j, k), 0)
    return factor, inverse_pivots
