"""The accelerations of a tree, without a mass matrix that anybody sees.

The matrix of the independent joints is factored as L^T D L, which fills no zero that the tree
leaves in it (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.5).  The driven
joints' accelerations are in the forces already.
"""

from __future__ import annotations

from urdf2mbs.equations.dynamics import joint_forces, mass_matrix
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.kinematics import chain
from urdf2mbs.equations.tree import Tree


class Massless(Exception):  # noqa: N818
    """No matter moves with an independent joint."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def accelerations(tree: Tree) -> dict[int, Expr]:
    """qdd of the independent joints by joint number, for the joint forces ``Qq``.

    Raises Massless.
    """
    graph = tree.graph
    driven = [f.number for f in tree.frames[1:] if f.joint.nature == "driven"]
    needed = joint_forces(tree, driven)
    matrix = mass_matrix(tree)
    free = [f.number for f in tree.frames[1:] if f.joint.nature != "driven"]
    before = {
        k: [f.number for f in chain(tree, k)[-2::-1] if f.joint.nature != "driven"] for k in free
    }
    """The joints further in, the nearest first."""
    factor, inverse = dict[tuple[int, int], Expr](), dict[int, Expr]()
    for k in reversed(free):
        if not matrix.get((k, k)):
            raise Massless(k)
        inverse[k] = graph.div(1, matrix[k, k])
        for i in before[k]:
            a = factor[i, k] = graph.mul(matrix.get((i, k), 0), inverse[k])
            for j in (i, *before[i]):
                rest = graph.sub(matrix.get((j, i), 0), graph.mul(a, matrix.get((j, k), 0)))
                matrix[j, i] = rest
    x = {k: graph.sub(graph.symbol(f"Qq[{k}]"), needed[k]) for k in free}
    for k in reversed(free):
        for i in before[k]:
            x[i] = graph.sub(x[i], graph.mul(factor[i, k], x[k]))
    for k in free:
        x[k] = graph.mul(x[k], inverse[k])
        for i in before[k]:
            x[k] = graph.sub(x[k], graph.mul(factor[i, k], x[i]))
    return x
