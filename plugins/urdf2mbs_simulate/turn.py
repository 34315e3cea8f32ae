"""A free base in world axes that are turned by a quarter about the vertical.

The angles of a base have no solution where the second is 90 degrees.  Near there the state is that
in turned axes, x' = y and y' = -x, in which the second angle is small; gravity stays the same.
User functions and results see the model's own axes: ``turn.c`` does the same in C while forces are
computed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import asin, atan2, copysign, cos, pi, sin
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from urdf2mbs_simulate.data import MbsData
    from urdf2mbs_simulate.python_code import PythonCode

#: The cosine of the second angle from which the axes are turned, and the least that rates are
#: divided by.
NEAR, LEAST = 0.3, 1e-9
#: From the world's axes to the turned ones.
QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
TYPES = ["T1", "T2", "T3", "R1", "R2", "R3"]
POSITIONS, ANGLES = slice(1, 4), slice(4, 7)
SAID = "its base comes near 90 degrees, where Robotran itself cannot go on"


def can_turn(data: MbsData) -> bool:
    """True if the first six joints are those of a base that nothing ties to the ground, and gravity
    is along z."""
    first = [*data.mbs.joints().values()][:6]
    free = [joint.type for joint in first if joint.nature == "independent"] == TYPES
    ties = (*data.mbs.cuts, *data.mbs.links)
    tied = any(end[0] is None for tie in ties for end in (tie.endpoint1, tie.endpoint2))
    return free and not tied and not data.g[1:3].any()


def turn_if_near(code: PythonCode, at: tuple[float, Any] | None = None) -> bool:
    """Go on in other axes, if the second angle of the base is near its singular place; ``at``: the
    time and the state, which the data may not be at."""
    data = code.data
    turns = data.can_turn and abs(cos(data.q[5] if at is None else at[1][4])) < NEAR
    if turns:
        if at is not None:
            code.accelerate(*at)
        if data.turned:
            show(data)
        else:
            data.own_angles = data.q[ANGLES].copy()
            _change(data, QUARTER, np.zeros(3))
            tell_of_turn(data)
        data.turned = not data.turned
    if turns or at is None:
        code.take_axes()
    return turns


def tell_of_turn(data: MbsData) -> None:
    data.said += [SAID] * (SAID not in data.said)


def show(data: MbsData) -> None:
    """Put the model's own position, speed, acceleration and force of the base into the data."""
    if data.turned:
        _change(data, QUARTER.T, data.own_angles)
        data.own_angles = data.q[ANGLES].copy()


@contextmanager
def own_axes(data: MbsData) -> Iterator[None]:
    """While user code or the results look at the data, it has the model's own base."""
    rows = (data.q, data.qd, data.qdd, data.Qq)
    kept = [row[1:7].copy() for row in rows]
    show(data)
    try:
        yield
    finally:
        if data.turned:
            for row, before in zip(rows, kept, strict=True):
                row[1:7] = before


def functions_in_own_axes(data: MbsData) -> dict[str, Any]:
    """The user functions in Python, for equations in turned axes."""
    user = {name: getattr(data, name) for name in ("user_JointForces", "user_ExtForces")}
    same = ("user_DrivenJoints", "user_LinkForces", "user_Link3DForces", "user_derivatives")

    def joint_forces(mbs_data: MbsData, tsim: float) -> None:
        rows = (data.q, data.qd, data.qdd)
        kept = [row[1:7].copy() for row in rows]
        show(data)
        user["user_JointForces"](mbs_data, tsim)
        _change(data, QUARTER, np.zeros(3))
        for row, before in zip(rows, kept, strict=True):
            row[1:7] = before

    def external_forces(*words: Any) -> Any:
        """``words``: P, R, V, OM, A, OMP, mbs_data, tsim, ixF."""
        moved = [word.copy() for word in words[:6]]
        for word in moved:
            word[..., 1:] = word[..., 1:] @ QUARTER
        with own_axes(data):
            found = np.array(user["user_ExtForces"](*moved, *words[6:]))
        found[1:7] = (QUARTER @ found[1:7].reshape(2, 3).T).T.ravel()
        return found

    def looks(function: Any) -> Any:
        """What it is given and gives is the same in all axes, but it may look at the base."""

        def call(*words: Any) -> Any:
            with own_axes(data):
                return function(*words)

        return call

    return {
        "user_JointForces": joint_forces, "user_ExtForces": external_forces,
        **{name: looks(getattr(data, name)) for name in same},
    }  # fmt: skip


def _change(data: MbsData, way: Any, near: Any) -> None:
    """Take the base into other axes; its angles are those nearest to some."""
    q, qd, qdd, force = (row[ANGLES].copy() for row in (data.q, data.qd, data.qdd, data.Qq))
    before = _rates(q)
    spin, gain = before @ qd, before @ qdd + _drift(q, qd)
    torque = np.linalg.solve(before.T, force) if force.any() else force
    for row in (data.q, data.qd, data.qdd, data.Qq):
        row[POSITIONS] = way @ row[POSITIONS]
    q = data.q[ANGLES] = _angles(way @ _rotation(q), near)
    after = _rates(q)
    qd = data.qd[ANGLES] = np.linalg.solve(after, way @ spin)
    data.qdd[ANGLES] = np.linalg.solve(after, way @ gain - _drift(q, qd))
    data.Qq[ANGLES] = after.T @ (way @ torque)


def _rotation(q: Any) -> Any:
    """From the axes of a body behind three joints R1, R2, R3 (rad) to those before them."""
    (a, b, c), (u, v, w) = np.cos(q), np.sin(q)
    return np.array([
        [b * c, -b * w, v],
        [a * w + u * v * c, a * c - u * v * w, -u * b],
        [u * w - a * v * c, u * c + a * v * w, a * b],
    ])  # fmt: skip


def _rates(q: Any) -> Any:
    """The spin (columns) by the rates of the angles; what is singular is nearly so."""
    a, b, _ = q
    side = cos(b) if abs(cos(b)) > LEAST else copysign(LEAST, cos(b))
    return np.array([
        [1.0, 0.0, sin(b)], [0.0, cos(a), -sin(a) * side], [0.0, sin(a), cos(a) * side],
    ])  # fmt: skip


def _drift(q: Any, qd: Any) -> Any:
    """How the spin changes while the rates of the angles do not."""
    (a, b, _), (x, y, z) = q, qd
    return np.array([
        z * cos(b) * y,
        -y * x * sin(a) + z * (sin(a) * sin(b) * y - cos(a) * cos(b) * x),
        y * x * cos(a) - z * (cos(a) * sin(b) * y + sin(a) * cos(b) * x),
    ])  # fmt: skip


def _angles(rotation: Any, near: Any) -> Any:
    """The three angles of a rotation: of the two triples, and all turns, those nearest to some."""
    middle = asin(min(1.0, max(-1.0, rotation[0, 2])))
    first = atan2(-rotation[1, 2], rotation[2, 2])
    last = atan2(-rotation[0, 1], rotation[0, 0])
    triples = np.array([(first, middle, last), (first + pi, pi - middle, last + pi)])
    triples += 2 * pi * np.round((near - triples) / (2 * pi))
    return min(triples, key=lambda triple: float(abs(triple - near).sum()))
