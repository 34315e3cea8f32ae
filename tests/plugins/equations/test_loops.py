"""Constraints, links, external forces and energy of random trees, beside Pinocchio."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from support.equations import few, trees, write_equations
from support.examples import reproducible
from support.mbs_models import everything
from support.oracle.generated import Data, PythonEquations, error, random_state
from support.oracle.generated import Sensor as Measured
from support.oracle.pin import TOLERANCE, Truth, pin
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Point, Sensor
from urdf2mbs.mbs.writer import write
from urdf2mbs_equations.constraints import iterate_constraints
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.tree import Tree

Array = NDArray[np.float64]

SIGNALS = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")


def call_and_join(eq: PythonEquations, name: str, s: Data, *sizes: int) -> Array:
    """Return all arrays that a function fills, as one array."""
    arrays = [np.full(size + 1, np.nan) for size in sizes]
    eq.fill(name, s, *arrays)
    return np.concatenate([array[1:] for array in arrays])


@few
@given(trees(), st.booleans(), st.integers(0, 9))
def test_the_equations_of_random_trees_are_as_pinocchio(mbs: Mbs, fold: bool, seed: int) -> None:
    eq, truth = write_equations(mbs, fold=fold, energy=True), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(seed))
    model, data, q, v = truth.model, truth.data, truth.vector(s.q), truth.vector(s.qd)
    energies = (
        pin.computeKineticEnergy(model, data, q, v),
        pin.computePotentialEnergy(model, data, q),
    )
    assert error(call_and_join(eq, "energy", s, 2), np.array(energies)) <= TOLERANCE
    if sum(body.mass or 0.0 for body in mbs.bodies):
        assert error(call_and_join(eq, "com", s, 3), pin.centerOfMass(model, data, q)) <= TOLERANCE
        momentum = pin.computeCentroidalMomentum(model, data, q, v)
        assert error(call_and_join(eq, "momentum", s, 3, 3), np.array(momentum)) <= TOLERANCE
    truth.check_forces(eq, s)
    truth.check_sensors(eq, s)


def compute_motion(truth: Truth, s: Data, end: tuple[str | None, str | None]) -> Any:
    """Return the motion of an end of a cut or a link."""
    body, point = end
    if body is None:
        out = Measured(s.njoint)
        out.P[1:] = truth.points[None, point] if point else 0.0
        out.R[1:, 1:] = np.eye(3)
        return out
    return truth.sensor(s, truth.number(body), truth.points[body, point] if point else np.zeros(3))


def list_chain(mbs: Mbs, name: str | None) -> list[int]:
    """Return the numbers of the joints from the base to a body."""
    out: list[int] = []
    numbers, bodies = mbs.numbers(), {body.name: body for body in mbs.bodies}
    while name is not None:
        body = bodies[name]
        out[:0] = [numbers[joint.name] for joint in body.joints]
        name = body.parent
    return out


def rows(truth: Truth, s: Data) -> tuple[Array, Array]:
    """Compute all constraints and their Jacobian by definition: balls, rods, then solids, in
    axes of the last frame that is on both chains."""
    values: list[Array] = []
    jacobians: list[Array] = []
    order = ("ball", "rod", "solid")
    for cut in sorted(truth.mbs.cuts, key=lambda cut: order.index(cut.kind)):
        a, b = compute_motion(truth, s, cut.endpoint1), compute_motion(truth, s, cut.endpoint2)
        chains = [list_chain(truth.mbs, end[0]) for end in (cut.endpoint1, cut.endpoint2)]
        shared = [k for k in chains[0] if k in chains[1]]
        start = truth.sensor(s, shared[-1], np.zeros(3)).R[1:, 1:] if shared else np.eye(3)
        d, difference = a.P[1:] - b.P[1:], (a.J - b.J)[1:, 1:]
        difference[:, [k - 1 for k in shared]] = 0.0
        if cut.kind == "rod":
            values.append(np.array([0.5 * (d @ d - (cut.length or 0.0) ** 2)]))
            jacobians.append((d @ difference[:3])[None])
            continue
        values.append(start @ d)
        jacobians.append(start @ difference[:3])
        if cut.kind == "solid":  # R has the axes of the body as rows
            relative = start @ a.R[1:, 1:].T @ b.R[1:, 1:] @ start.T
            values.append(np.array([relative[2, 1], relative[0, 2], relative[1, 0]]))
            jacobians.append(start @ difference[3:])
    return np.concatenate(values), np.concatenate(jacobians)


@few
@given(trees(), st.data())
def test_constraints_of_random_loops_are_as_by_definition(mbs: Mbs, data: st.DataObject) -> None:
    """Values and Jacobians by definition, ``jdqd`` by differentiation; rows are left out
    only if no joint moves them."""
    ends = st.tuples(
        st.sampled_from([None, *(body.name for body in mbs.bodies)]), st.sampled_from(["P", None])
    )
    for i in range(data.draw(st.integers(1, 3))):
        kind = data.draw(st.sampled_from(["ball", "rod", "solid"]))
        end1 = data.draw(ends)
        end2 = data.draw(ends.filter(lambda end, first=end1: end[0] != first[0]))
        mbs.cuts.append(Connection(kind, f"c{i}", end1, end2, 0.4 if kind == "rod" else None))
    eq, truth = write_equations(mbs), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(5))
    moving = [j.symbols != ("q",) for body in mbs.bodies for j in body.joints]
    expected, expected_jacobian = rows(truth, s)
    h, jacobian, jdqd = eq.constraints(s, len(expected))
    movable = [constraint.is_movable for constraint in iterate_constraints(Tree(mbs))]
    count = sum(movable)
    assert not h[count:].any()
    assert np.abs(expected_jacobian[~np.array(movable)][:, moving]).max(initial=0.0) <= 1e-12
    assert np.abs(h[:count] - expected[movable]).max(initial=0.0) <= 1e-12
    assert np.abs(jacobian[:count] - expected_jacobian[movable]).max(initial=0.0) <= 1e-12

    def at(q: Array) -> Array:
        state = random_state(mbs, np.random.default_rng(5))
        state.q[:] = q
        return eq.constraints(state, len(expected))[1]

    step = 1e-6
    ahead, behind = (at(s.q + sign * step * s.qd) for sign in (1, -1))
    change = (ahead - behind) / (2 * step) @ s.qd[1:]
    assert np.abs(jdqd - change).max() <= 1e-7 * (1.0 + np.abs(change).max())


Wrench = tuple[str | None, Array, Array, Array]


def check_loads(
    s: Data, wrenches: list[Wrench], truth: Truth, tolerance: float = 10 * TOLERANCE
) -> None:
    """Compare frc and trq with forces and torques (ground axes) at points (ground axes) on bodies,
    and set them back to zero."""
    expected = np.zeros((2, *s.frc.shape))
    bodies = {body.name: body for body in truth.mbs.bodies}
    for name, force, torque, at in wrenches:
        if name is None:
            continue
        number = truth.number(name)
        centre = truth.sensor(s, number, np.array(bodies[name].com or (0.0, 0.0, 0.0)))
        turn = centre.R[1:, 1:]
        expected[0, 1:, number] += turn @ force
        expected[1, 1:, number] += turn @ (torque + np.cross(at - centre.P[1:], force))
    assert error(np.array([s.frc, s.trq]), expected) <= tolerance
    s.frc[:], s.trq[:] = 0.0, 0.0


#: What the user's functions were told of a motion: P, R, V, OM, A and OMP.
Received = list[tuple[Array, ...]]


def check_external_forces(eq: PythonEquations, truth: Truth, s: Data, received: Received) -> None:
    eq.loads(s, "extforces")
    wrenches: list[Wrench] = []
    forced = [body for body in truth.mbs.bodies if body.points[0].extforce]
    for i, body in enumerate(forced, start=1):
        at = compute_motion(truth, s, (body.name, "P"))
        for actual, name in zip(received[i - 1], ("P", "R", "V", "OM", "A", "OMP"), strict=True):
            assert error(actual, getattr(at, name)) <= TOLERANCE
        body_motion = compute_motion(truth, s, (body.name, None))
        point = body_motion.P[1:] + body_motion.R[1:, 1:].T @ [0.1, -0.2, 0.3]
        force, torque = np.array([1.0, 2, 3]) * i, np.array([4.0, 5, 6]) * i
        wrenches.append((body.name, force, torque, point))
    check_loads(s, wrenches, truth, TOLERANCE)


def check_links(eq: PythonEquations, truth: Truth, s: Data) -> None:
    eq.loads(s, "link")
    wrenches: list[Wrench] = []
    links = [link for link in truth.mbs.links if link.kind == "link"]
    for number, link in enumerate(links, start=1):
        first, second = (
            compute_motion(truth, s, link.endpoint1),
            compute_motion(truth, s, link.endpoint2),
        )
        d, v = second.P[1:] - first.P[1:], second.V[1:] - first.V[1:]
        z = np.linalg.norm(d)
        zd = d @ v / z
        assert error(s.Z[number : number + 1], np.array([z])) <= TOLERANCE
        assert abs(s.Zd[number] - zd) <= TOLERANCE * (1 + np.abs(v).max())
        pull = (3 * z + 2 * zd) * d / z
        wrenches.append((link.endpoint1[0], pull, np.zeros(3), first.P[1:]))
        wrenches.append((link.endpoint2[0], -pull, np.zeros(3), second.P[1:]))
    check_loads(s, wrenches, truth)


def check_link_3d(eq: PythonEquations, truth: Truth, s: Data, received: Received) -> None:
    received.clear()
    eq.loads(s, "link3D")
    link = truth.mbs.links[-1]
    first, second = (
        compute_motion(truth, s, link.endpoint1),
        compute_motion(truth, s, link.endpoint2),
    )
    turn, d = first.R[1:, 1:], second.P[1:] - first.P[1:]
    w, v = first.OM[1:], second.V[1:] - first.V[1:]
    seen, spin = v - np.cross(w, d), second.OM[1:] - w
    a = second.A[1:] - first.A[1:] - np.cross(first.OMP[1:], d) - np.cross(w, np.cross(w, d))
    rate = second.OMP[1:] - first.OMP[1:] - np.cross(w, spin)
    for x, y in ((0, d), (2, seen), (3, spin), (4, a - 2 * np.cross(w, seen)), (5, rate)):
        assert error(received[0][x][1:], turn @ y) <= 10 * TOLERANCE or np.abs(y).max() < 1e-9
    assert error(received[0][1][1:, 1:], second.R[1:, 1:] @ turn.T) <= TOLERANCE
    force, torque = turn.T @ [1.0, 2, 3], turn.T @ [4.0, 5, 6]
    wrenches = [
        (link.endpoint1[0], force, torque, second.P[1:]),
        (link.endpoint2[0], -force, -torque, second.P[1:]),
    ]
    check_loads(s, wrenches, truth)


@settings(reproducible, max_examples=6)
@given(trees(3), st.data())
def test_links_and_external_forces(mbs: Mbs, data: st.DataObject) -> None:
    """In Python, and for the first example also in C."""
    ends = st.tuples(st.sampled_from([None, *(body.name for body in mbs.bodies)]), st.just("Q"))
    mbs.base.points.append(Point("Q", (3.0, 2.0, 1.0)))
    for i, kind in enumerate(["link", "link", "link3D"]):
        first = data.draw(ends)
        second = data.draw(ends.filter(lambda end, first=first: end[0] != first[0]))
        mbs.links.append(Connection(kind, f"l{i}", first, second))
    for i, body in enumerate([mbs.bodies[0], mbs.bodies[-1]]):
        body.points[0].extforce = Sensor(f"f{i}", SIGNALS)
    truth = Truth(mbs)
    received: Received = []

    def push(*words: Any) -> Array:
        received.append(tuple(np.array(x) for x in words[:6]))
        return np.array([0.0, *(np.arange(1.0, 7.0) * words[-1]), 0.1, -0.2, 0.3])

    for c in (False, True)[: 1 + (len(mbs.bodies) == 2)]:
        eq, s = write_equations(mbs, c=c), random_state(mbs, np.random.default_rng(6), loads=False)
        received.clear()
        s.user_ExtForces = s.user_Link3DForces = push
        s.user_LinkForces = lambda z, zd, *_: 3.0 * z + 2.0 * zd
        check_external_forces(eq, truth, s, received)
        check_links(eq, truth, s)
        check_link_3d(eq, truth, s, received)


def make_four_bar() -> Mbs:
    """Make three bars in a row, and a rod from the last one to the base."""
    bar = (0.01, 0.0, 0.0, 0.02, 0.0, 0.02)
    mbs = Mbs("bars")
    mbs.base.points = [Point("far", (1.2, 0.0, 0.1))]
    for i, nature in enumerate(["independent", "independent", "dependent"]):
        parent = f"bar{i - 1}" if i else None
        mbs.bodies.append(
            Body(
                f"bar{i}",
                parent,
                "end" if i else None,
                [Joint(f"j{i}", "R2", nature)],
                1.0,
                (0.25, 0.0, 0.05),
                bar,
                [Point("end", (0.5, 0.0, 0.0))],
            )
        )
    mbs.bodies[-1].joints[0].q = 0.4
    mbs.cuts = [Connection("rod", "rod", ("bar2", "end"), (None, "far"), 0.3)]
    return mbs


def check_motion(truth: Truth, s: Data, rows: Array, bias: Array) -> None:
    """Accelerations keep the constraints closed (``rows qdd + rest = 0``), and the forces that they
    need, less those that are given, do no work along any motion that the constraints allow."""
    joints = truth.mbs.joints().values()
    free = np.array([joint.nature != "driven" for joint in joints])
    for sum_of, left in ((rows * s.qd[1:], 0.0 * bias), (rows * s.qdd[1:], bias)):
        assert np.abs(sum_of).max() > 0.1
        assert np.abs(sum_of.sum(axis=1) + left).max() <= 1e-9 * np.abs(sum_of).max()
    null_space = np.linalg.svd(rows[:, free])[2][len(rows) :]
    needed = truth.forces(s, accelerated=True)[free]
    assert np.abs(null_space @ (needed - s.Qq[1:][free])).max() <= 1e-9 * np.abs(needed).max()


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_driven_joint_that_accelerates_moves_the_dependent_joint(c: bool) -> None:
    mbs = make_four_bar()
    mbs.bodies[0].joints[0].nature = "driven"
    eq, truth, s = write_equations(mbs, c=c), Truth(mbs), Data(mbs)
    s.q[1:3], s.qd[1:3], s.qdd[1] = (0.2, 0.3), (0.4, -0.7), 5.0
    assert eq.accelred(s) == 0
    assert s.qdd[1] == 5.0
    check_motion(truth, s, *eq.constraints(s, 1)[1:])


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_user_constraints_beside_a_cut(c: bool) -> None:
    """A fourth bar follows the first by a rule that is not linear: the rows of user constraints
    come after those of cuts, in Python and in C.  Nothing else is asked of the user:
    ``user_cons_J_accelred`` is not called."""
    mbs = make_four_bar()
    bar = (0.01, 0.0, 0.0, 0.02, 0.0, 0.02)
    joints = [Joint("follower", "R2", "dependent")]
    mbs.bodies.append(Body("lever", None, None, joints, 0.5, (0.0, 0.1, 0.2), bar))

    def rule(h: Array, jac: Array, s: Data, _: float) -> None:
        h[1] = s.q[4] - np.sin(s.q[1]) - 0.3
        jac[1, 4], jac[1, 1] = 1.0, -np.cos(s.q[1])

    def derivative(jdqd: Array, s: Data) -> None:
        jdqd[1] = np.sin(s.q[1]) * s.qd[1] ** 2

    eq, truth, s = write_equations(mbs, c=c), Truth(mbs), Data(mbs)
    s.user_cons_hJ, s.user_cons_jdqd, s.user_constraints = rule, derivative, 1
    s.q[1:3], s.qd[1:3], s.Qq[1:] = (0.2, 0.3), (0.9, -0.4), (1.0, 2.0, 3.0, 4.0)
    assert eq.accelred(s) == 0
    gaps, rows, bias = np.zeros(2), np.zeros((2, 4)), np.zeros(2)
    gaps[:1], rows[:1], bias[:1] = eq.constraints(s, 1)
    user_h, user_jacobian, user_jdqd = np.zeros(2), np.zeros((2, 5)), np.zeros(2)
    rule(user_h, user_jacobian, s, 0.0)
    derivative(user_jdqd, s)
    gaps[1], rows[1], bias[1] = user_h[1], user_jacobian[1, 1:], user_jdqd[1]
    assert np.abs(gaps).max() <= 1e-9
    check_motion(truth, s, rows, bias)


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_light_or_small_loop_moves_as_a_large_one(c: bool) -> None:
    """Tolerances of pivots and gaps do not depend on the units of mass and length."""
    actual = []
    for mass, length in ((1.0, 1.0), (2.0**-50, 1.0), (1.0, 2.0**-30), (1.0, 2.0**30)):
        mbs = make_four_bar()
        x, y, z = mbs.base.gravity
        mbs.base.gravity = (x * length, y * length, z * length)
        mbs.cuts[0].length = (mbs.cuts[0].length or 0.0) * length
        for body in mbs.bodies:
            body.mass = (body.mass or 0.0) * mass
            body.com = tuple(x * length for x in body.com or ())  # type: ignore[assignment]
            body.inertia = tuple(  # type: ignore[assignment]
                x * mass * length**2 for x in body.inertia or ()
            )
        for point in (*mbs.base.points, *(point for body in mbs.bodies for point in body.points)):
            point.coordinates = tuple(  # type: ignore[assignment]
                x * length for x in point.coordinates
            )
        eq, s = write_equations(mbs, c=c), Data(mbs)
        s.q[1:3] = 0.2, 0.3
        assert eq.accelred(s) == 0
        actual.append([s.q, s.qdd])
    assert all(np.allclose(values, actual[0], rtol=1e-12, atol=0) for values in actual)
    assert np.abs(np.array(actual[0])[:, 1:]).min() > 0.1


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_loop_at_its_dead_point_is_refused(c: bool) -> None:
    """The rod goes on where the dependent bar ends, so this joint cannot change its length.  What
    was factored there is not used elsewhere."""
    mbs, angles = make_four_bar(), np.cumsum([0.7, -0.3, 0.2])
    lengths = np.array([0.5, 0.5, 0.8])
    far = (float(lengths @ np.cos(angles)), 0.0, float(-lengths @ np.sin(angles)))
    mbs.base.points[0].coordinates = far
    eq, s = write_equations(mbs, c=c), Data(mbs)
    s.q[1:] = 0.57, 0.0, 0.3
    assert eq.accelred(s) == 0
    convert_closed, before = s.q.copy(), s.qdd.copy()
    s.q[1:] = 0.7, -0.3, 0.2
    assert abs(eq.constraints(s, 1)[0][0]) <= 1e-15
    assert eq.accelred(s) == -1
    s.q[:] = convert_closed
    assert eq.accelred(s) == 0
    assert error(s.qdd, before) <= TOLERANCE


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_joint_that_never_moves_is_a_number(c: bool) -> None:
    """So is a driven joint with the symbol q alone: the data's q is not read."""
    mbs = make_four_bar()
    mbs.cuts, mbs.bodies[-1].joints[0].nature = [], "independent"
    mbs.bodies[1].joints.insert(0, Joint("turn", "R1", "driven", q=0.5, symbols=("q",)))
    eq, truth, s = write_equations(mbs, c=c), Truth(mbs), Data(mbs)
    s.q[1:], s.qd[1:] = (0.2, 1.1, 0.3, -0.4), (1.0, 0.0, -2.0, 0.5)
    actual = eq.dirdyna(s)[0].copy()
    assert error(actual, truth.matrix(s)) > 1e-3
    s.q[2] = 0.5
    assert error(actual, truth.matrix(s)) <= TOLERANCE
    assert error(eq.dirdyna(s)[0], truth.matrix(s)) <= TOLERANCE


def test_what_is_not_generated_says_why() -> None:
    mbs = make_four_bar()
    mbs.cuts[0].kind = "ball"
    made = generate(mbs, b"<mbsDescR7/>", "bars.mbs", EquationOptions(language="python"))
    assert "2 equations, and 1 joints are dependent" in made.left_out["accelred"]
    assert b"Not generated: the cuts make 2" in made.files["mbs_accelred_bars.py"]
    mbs.cuts[0].kind = "rod"
    mbs.bodies.append(Body("lever", None, None, [Joint("follower", "R2", "dependent")]))
    for language, file in (("python", "mbs_accelred_bars.py"), ("c", "mbs_accelred_bars.c")):
        made = generate(mbs, b"<mbsDescR7/>", "bars.mbs", EquationOptions(language=language))
        assert b"user_cons_J_accelred is not called" in made.files[file].partition(b"\n\n")[0]
    mbs.cuts = []
    mbs.bodies = mbs.bodies[:2]
    mbs.bodies[-1].mass = mbs.bodies[-1].inertia = None
    made = generate(mbs, b"<mbsDescR7/>", "bars.mbs", EquationOptions(language="python"))
    assert "no matter moves with joint 'j1'" in made.left_out["accelred"]
    made = generate(
        mbs, b"<mbsDescR7/>", "bars.mbs", EquationOptions(language="python", energy=True)
    )
    assert made.left_out.keys() == {"accelred"}
    for body in mbs.bodies:
        body.mass = None
    made = generate(
        mbs, b"<mbsDescR7/>", "bars.mbs", EquationOptions(language="python", energy=True)
    )
    assert made.left_out["com"] == made.left_out["momentum"] == "no body has a mass"


def test_functions_that_need_a_cut_that_is_not_placed_yet_are_left_out_and_it_is_named() -> None:
    mbs = everything()
    mbs.cuts[0].endpoint1 = ("", None)
    found = generate(mbs, write(mbs), "m.mbs", EquationOptions(language="python"))
    assert {"cons_hJ", "cons_jdqd"} <= set(found.left_out)
    assert "'a_ball'" in found.left_out["cons_hJ"]
    assert {"dirdyna", "invdyna", "link", "extforces", "sensor"}.isdisjoint(found.left_out)
