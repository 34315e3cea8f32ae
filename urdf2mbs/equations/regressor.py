"""The joint forces as a table times the inertial parameters of all bodies.

(Khalil and Dombre, Modeling, Identification and Control of Robots, 2002, chapter 12.)
"""

from __future__ import annotations

from urdf2mbs.equations.dynamics import Moving, motions, multiply
from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.tree import NONE, Matrix, Tree, Vector, along

#: The elements of a tensor of inertia, as an .mbs has them.
ELEMENTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def regressor(tree: Tree) -> dict[tuple[int, int], Expr]:
    """By the number of a joint and of a parameter; zeros are left out.

    Each body has ten parameters: mass, first moments (kg m), and the elements xx, xy, xz, yy, yz,
    zz of its inertia about the origin of its frame (kg m^2), in the order of the file.
    """
    moving, before = motions(tree, range(len(tree.frames))), 0
    seen: list[list[tuple[int, Vector, Vector]]] = [[]]
    """The joints up to each frame's own: linear and angular motion for a unit rate."""
    out: dict[tuple[int, int], Expr] = {}
    for frame in tree.frames[1:]:
        axes = []
        for number, linear, angular in seen[frame.parent]:
            linear = tree.plus(linear, tree.cross(angular, frame.offset))
            axes.append((number, tree.outward(frame, linear), tree.outward(frame, angular)))
        axis = along(frame.axis, 1)
        axes.append((frame.number, *((NONE, axis) if frame.turns else (axis, NONE))))
        seen.append(axes)
        if frame.body is None:
            continue
        for column, (f, n) in enumerate(_columns(tree, moving[frame.number]), start=before + 1):
            for number, linear, angular in axes:
                value = tree.graph.add(tree.dot(linear, f), tree.dot(angular, n))
                if value:
                    out[number, column] = value
        before += 10
    return out


def _columns(tree: Tree, moving: Moving) -> list[tuple[Vector, Vector]]:
    """Force and moment about a body's origin for a unit of each of its parameters."""
    pull, field, spin = moving.pull, moving.field, moving.spin
    out: list[tuple[Vector, Vector]] = [(pull, NONE)]
    for k in range(3):
        unit = along(k, 1)
        out.append((multiply(tree, field, unit), tree.cross(unit, pull)))
    for i, j in ELEMENTS:
        tensor: Matrix = [[0] * 3 for _ in "xyz"]
        tensor[i][j] = tensor[j][i] = 1
        turning = tree.cross(spin, multiply(tree, tensor, spin))
        out.append((NONE, tree.plus(multiply(tree, tensor, moving.spin_rate), turning)))
    return out
