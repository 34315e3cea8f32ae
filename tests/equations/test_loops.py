"""Random trees with loops and forces: constraints, links and external forces, and energy."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from runtime import CEquations, Data, PythonEquations, Truth, error, random_state

from urdf2mbs.equations import equations
from urdf2mbs.mbs.model import Base, Body, Connection, Joint, Mbs, Point, Sensor

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TOLERANCE = 1e-12
SIGNALS = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")

#: Numbers as files have them: zero, a quarter turn written short or long, anything.
angles = st.sampled_from([0.0, 1.5708, np.pi / 2, -np.pi / 2, np.pi, 1.57079632679, 0.3])
lengths = st.sampled_from([0.0, 0.0, 0.1, -0.25, 1e-9, 0.7])
vectors = st.tuples(lengths, lengths, lengths)


@st.composite
def trees(draw: st.DrawFn, most: int = 4) -> Mbs:
    """A tree of bodies with one to three joints each, each body with two points."""
    mbs = Mbs("tree", base=Base(gravity=draw(st.sampled_from([(0, 0, -9.81), (1.0, 2.0, 3.0)]))))
    mbs.base.points = [Point("P", draw(vectors))]
    for i in range(draw(st.integers(2, most))):
        parent = draw(st.sampled_from([None, *(body.name for body in mbs.bodies)]))
        joints = []
        for j in range(draw(st.integers(1, 3))):
            kind = draw(st.sampled_from(["T1", "T2", "T3", "R1", "R2", "R3", "R1", "R2", "R3"]))
            joint = Joint(f"j{i}_{j}", kind)
            if draw(st.integers(0, 3)) == 0:
                joint.nature, joint.q = "driven", draw(angles)
                joint.symbols = draw(st.sampled_from([("q",), ("q", "qd", "qdd"), None]))
            joints.append(joint)
        body = Body(f"b{i}", parent, draw(st.sampled_from([None, "P"])), joints)
        if draw(st.integers(0, 4)):
            body.mass = draw(st.sampled_from([0.5, 2.0]))
            body.com = draw(vectors)
            body.inertia = draw(
                st.sampled_from([(0.1, 0.01, 0.02, 0.2, -0.03, 0.25), (0.1, 0, 0, 0.1, 0, 0.1)])
            )
        body.points = [Point("P", draw(vectors)), Point("Q", draw(vectors))]
        mbs.bodies.append(body)
    return mbs


def written(mbs: Mbs, *, c: bool = False, **options: Any) -> PythonEquations:
    made = equations(mbs, b"", "tree.mbs", language="c" if c else "python", **options)
    with tempfile.TemporaryDirectory() as folder:
        return (CEquations if c else PythonEquations)(made, mbs, Path(folder))


slow = settings(
    max_examples=10, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)


@slow
@given(trees(), st.booleans(), st.integers(0, 9))
def test_random_trees(mbs: Mbs, fold: bool, seed: int) -> None:
    eq, truth = written(mbs, fold=fold), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(seed))
    m, c = eq.dirdyna(s)
    assert error(m, truth.matrix(s)) <= TOLERANCE
    assert error(c, truth.forces(s, accelerated=False)) <= TOLERANCE
    assert error(eq.invdyna(s), truth.forces(s, accelerated=True)) <= TOLERANCE
    for number in range(1, s.njoint + 1):
        found, wanted = eq.sensor(s, number, "gensensor"), truth.sensor(s, number, np.zeros(3))
        for name in ("P", "R", "V", "OM", "A", "OMP", "J"):
            assert error(getattr(found, name), getattr(wanted, name)) <= TOLERANCE


def place(truth: Truth, s: Data, end: tuple[str | None, str | None]) -> Any:
    """The motion of the end of a cut or a link."""
    body, point = end
    if body is None:
        from runtime import Sensor as Still

        out = Still(s.njoint)
        out.P[1:] = truth.points[None, point] if point else 0.0
        out.R[1:, 1:] = np.eye(3)
        return out
    joint = truth.ids.index(truth.joint_of[body])
    return truth.sensor(s, joint, truth.points[body, point] if point else np.zeros(3))


def values(truth: Truth, s: Data) -> Array:
    """The constraints from their meaning, in the order balls, rods, solids."""
    out: list[float] = []
    order = ("ball", "rod", "solid")
    for cut in sorted(truth.mbs.cuts, key=lambda cut: order.index(cut.kind)):
        one, two = place(truth, s, cut.endpoint1), place(truth, s, cut.endpoint2)
        d = two.P[1:] - one.P[1:]
        if cut.kind == "rod":
            out.append(0.5 * (d @ d - (cut.length or 0.0) ** 2))
            continue
        out += list(d)
        if cut.kind == "solid":
            relative = one.R[1:, 1:] @ two.R[1:, 1:].T
            out += [relative[1, 2], relative[2, 0], relative[0, 1]]
    return np.array(out)


@slow
@given(trees(), st.data())
def test_constraints_by_differentiation(mbs: Mbs, data: st.DataObject) -> None:
    ends = st.tuples(
        st.sampled_from([None, *(body.name for body in mbs.bodies)]), st.sampled_from(["P", None])
    )
    for i in range(data.draw(st.integers(1, 3))):
        kind = data.draw(st.sampled_from(["ball", "rod", "solid"]))
        one = data.draw(ends)
        two = data.draw(ends.filter(lambda end: end[0] != one[0]))
        mbs.cuts.append(Connection(kind, f"c{i}", one, two, 0.4 if kind == "rod" else None))
    eq, truth = written(mbs), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(5))
    wanted = values(truth, s)
    h, jacobian, jdqd = eq.constraints(s, len(wanted))
    # h is in the axes of the frame from which the ways part: lengths are the same
    assert np.isfinite(jacobian).all()

    def at(q: Array) -> tuple[Array, Array]:
        there = random_state(mbs, np.random.default_rng(5))
        there.q[:] = q
        return eq.constraints(there, len(wanted))[:2]

    step = 1e-6
    for k in range(1, s.njoint + 1):
        q = s.q.copy()
        q[k] += step
        ahead = at(q)[0]
        q[k] -= 2 * step
        difference = (ahead - at(q)[0]) / (2 * step)
        if not (joints := [j for b in mbs.bodies for j in b.joints])[k - 1].symbols == ("q",):
            assert np.abs(jacobian[:, k - 1] - difference).max() <= 1e-8
        del joints
    ahead, behind = (at(s.q + sign * step * s.qd)[1] for sign in (1, -1))
    change = (ahead - behind) / (2 * step) @ s.qd[1:]
    assert np.abs(jdqd - change).max() <= 1e-7 * (1.0 + np.abs(change).max())
    # rods and the angles of solids do not depend on axes; balls by their length
    at_, by = 0, 0
    for kind in ("ball", "rod", "solid"):
        for cut in [cut for cut in mbs.cuts if cut.kind == kind]:
            if kind != "rod":
                assert abs(np.linalg.norm(h[at_ : at_ + 3]) - np.linalg.norm(wanted[by : by + 3])) <= 1e-12
                at_, by = at_ + 3, by + 3
            if kind != "ball":
                n = 1 if kind == "rod" else 3
                assert np.abs(h[at_ : at_ + n] - wanted[by : by + n]).max() <= 1e-12
                at_, by = at_ + n, by + n
            del cut
