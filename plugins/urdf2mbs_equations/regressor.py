"""The joint forces as a table times the inertial parameters of all bodies.

(Khalil and Dombre, Modeling, Identification and Control of Robots, 2002, chapter 12.)
"""

from __future__ import annotations

from urdf2mbs_equations.dynamics import Moving, motions
from urdf2mbs_equations.graph import Scalar
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import NONE, UNITS, Spatial, outer

#: The elements of a tensor of inertia, as an .mbs has them.
ELEMENTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def regressor(tree: Tree) -> dict[tuple[int, int], Scalar]:
    """By the number of a joint and of a parameter; zeros are left out.

    Each body has ten parameters: mass, first moments (kg m), and the elements xx, xy, xz, yy, yz,
    zz of its inertia about the origin of its frame (kg m^2), in the order of the file.
    """
    moving, before = motions(tree, range(len(tree.frames))), 0
    seen: list[dict[int, Spatial]] = [{}]
    """By frame, the motion that each joint up to it gives it for a unit rate, in its axes."""
    out: dict[tuple[int, int], Scalar] = {}
    for frame in tree.frames[1:]:
        joints = {}
        for number, (linear, angular) in seen[frame.parent].items():
            arrives = linear + angular.cross(frame.offset)
            joints[number] = Spatial((frame.to_child(arrives), frame.to_child(angular)))
        joints[frame.number] = frame.motion
        seen.append(joints)
        if frame.body is None:
            continue
        for column, force in enumerate(_columns(moving[frame.number]), start=before + 1):
            for number, motion in joints.items():
                value = motion @ force
                if value:
                    out[number, column] = value
        before += 10
    return out


def _columns(moving: Moving) -> list[Spatial]:
    """Force and moment about a body's origin for a unit of each of its parameters."""
    omega, alpha = moving.omega, moving.alpha
    out = [Spatial((alpha, NONE))]
    out += [Spatial((moving.beta @ unit, unit.cross(alpha))) for unit in UNITS]
    for i, j in ELEMENTS:
        inertia = outer(UNITS[i], UNITS[j])
        if i != j:
            inertia += outer(UNITS[j], UNITS[i])
        moment = inertia @ moving.omega_dot + omega.cross(inertia @ omega)
        out.append(Spatial((NONE, moment)))
    return out
