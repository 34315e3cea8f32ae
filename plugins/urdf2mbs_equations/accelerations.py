"""The accelerations of a tree, without a mass matrix that anybody sees.

The matrix of the independent joints is factored as L^T D L, which fills no zero that the tree
leaves in it (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.5).  The driven
joints' accelerations are in the forces already.
"""

from __future__ import annotations

from urdf2mbs_equations.dynamics import joint_forces, mass_matrix
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.kinematics import chain
from urdf2mbs_equations.tree import Tree


class Massless(Exception):  # noqa: N818
    """No matter moves with an independent joint; its name is all that is said."""


def accelerations(tree: Tree) -> dict[int, Scalar]:
    """qdd of the independent joints by joint number, for the joint forces ``Qq``.

    Raises Massless.
    """
    driven = [f.number for f in tree.frames[1:] if f.joint.nature == "driven"]
    free = [f.number for f in tree.frames[1:] if f.joint.nature != "driven"]
    needed, matrix = joint_forces(tree, driven), mass_matrix(tree)
    before = {
        k: [f.number for f in chain(tree, k)[-2::-1] if f.joint.nature != "driven"] for k in free
    }
    """The joints further in, the nearest first."""
    factor, inverse = dict[tuple[int, int], Scalar](), dict[int, Scalar]()
    for k in reversed(free):
        if not matrix.get((k, k)):
            raise Massless(tree.frames[k].joint.name)
        inverse[k] = 1 / matrix[k, k]
        for i in before[k]:
            a = factor[i, k] = matrix.get((i, k), 0) * inverse[k]
            for j in (i, *before[i]):
                matrix[j, i] = matrix.get((j, i), 0) - a * matrix.get((j, k), 0)
    x = {k: tree.graph.symbol(f"Qq[{k}]") - needed[k] for k in free}
    for k in reversed(free):
        for i in before[k]:
            x[i] -= factor[i, k] * x[k]
    for k in free:
        x[k] *= inverse[k]
        for i in before[k]:
            x[k] -= factor[i, k] * x[i]
    return x
