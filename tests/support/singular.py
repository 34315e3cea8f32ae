"""Random trees whose mass matrix may be singular, and pinocchio beside them."""

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from urdf2mbs.mbs.model import Body, Joint, Mbs, Point

pin = pytest.importorskip("pinocchio")


ROUND = st.sampled_from((0.0, 0.0, 0.5, -1.0))


ANY = st.sampled_from((0.3, -0.7, 0.45))


LENGTH = st.one_of(ROUND, ANY)


ANGLE = st.sampled_from((0.0, pi / 2, -pi / 2, pi, 0.4, -1.1))


KINDS = ("R1", "R2", "R3", "R1", "R2", "R3", "T1", "T2", "T3")


@st.composite
def bodies(draw: Any, index: int) -> Body:
    point = None
    parent = None if index == 0 else draw(st.integers(-1, index - 1))
    if parent is not None:
        point = None if parent < 0 else draw(st.sampled_from((None, "p")))
        parent = None if parent < 0 else f"b{parent}"
    joints = []
    for number in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        kind = draw(st.sampled_from(KINDS))
        driven = draw(st.sampled_from((False, False, True)))
        value = draw(ANGLE) if driven else None
        joints.append(
            Joint(f"j{index}_{number}", kind, "driven" if driven else "independent", value)
        )
    body = Body(f"b{index}", parent, point, joints)
    body.points = [Point("p", (draw(LENGTH), draw(LENGTH), draw(LENGTH)))]
    kind = draw(st.sampled_from(("none", "none", "point", "point", "rod", "solid", "spin")))
    if kind != "none":
        body.com = (draw(LENGTH), draw(LENGTH), draw(LENGTH))
        if kind != "spin":  # inertia without mass
            body.mass = draw(st.sampled_from((1.0, 3.0)))
        moments = {"point": (0, 0, 0), "rod": (0, 1, 1), "solid": (1, 2, 2.5), "spin": (1, 0, 0)}
        turn = rotation_about_z_and_x(draw(ANGLE), draw(ANGLE))
        tensor = turn @ np.diag(moments[kind]) @ turn.T
        xx, xy, xz, yy, yz, zz = (float(tensor[i]) for i in zip(*np.triu_indices(3), strict=True))
        body.inertia = (xx, xy, xz, yy, yz, zz)
    return body


def rotation_about_z_and_x(a: float, b: float) -> Any:
    """Return the matrix of a rotation about z by a, then about the new x by b (rad)."""
    rotation = pin.AngleAxis(a, np.array([0.0, 0.0, 1.0])).toRotationMatrix()
    return rotation @ pin.AngleAxis(b, np.array([1.0, 0.0, 0.0])).toRotationMatrix()


@st.composite
def trees(draw: Any) -> Mbs:
    mbs = Mbs("tree", bodies=[draw(bodies(i)) for i in range(draw(st.integers(1, 5)))])
    mbs.bodies = mbs.depth_first()  # Pinocchio's crba is wrong for any other order
    return mbs


def mass_matrix(model: Any, q: Any) -> Any:
    matrix = pin.crba(model, model.createData(), q, pin.Convention.WORLD)
    return np.triu(matrix) + np.triu(matrix, 1).T
