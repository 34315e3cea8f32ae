"""``load_equations`` and derivatives beside pinocchio, in C and Python; other kinds of numbers."""

import cmath
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.equations import few, trees, write_equations
from support.folders import CONFIGS, SHARED
from support.loops import FOLLOWS, FREE, four_bar
from support.oracle.generated import Data, error, random_state
from support.oracle.pin import Truth, pin
from support.real_robots import REAL_ROBOTS
from urdf2mbs import Robot, load_equations
from urdf2mbs.mbs.model import BASE, Mbs
from urdf2mbs.mbs.reader import read_mbs

TOLERANCE = 1e-10
#: Robots, and the languages of their equations; Cassie's in C are in pieces.
NAMES = {"ur-ur10e": ("c", "python"), "cassie-cassie_v4": ("c",)}
ROBOTS = [
    pytest.param(
        robot,
        language,
        id=f"{robot.name}-{language}",
        marks=pytest.mark.slow if "cassie" in robot.name else (),
    )
    for robot in REAL_ROBOTS
    for language in NAMES.get(robot.name, ())
]


@pytest.fixture
def minimal(tmp_path: Path) -> Path:
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    (tmp_path / "minimal.mbs").write_bytes(path.read_bytes())
    return tmp_path / "minimal.mbs"


def loaded(path: Path, data: bytes, language: str) -> tuple[Mbs, Robot]:
    path.write_bytes(data)
    return read_mbs(data, path.name, mechanics_only=True), load_equations(path, language=language)


def pinocchios_regressor(truth: Truth, s: Data) -> Any:
    """Pinocchio has the inertia in another order: xx, xy, yy, xz, yz, zz."""
    state = [truth.vector(x) for x in (s.q, s.qd, s.qdd)]
    all_joints = pin.computeJointTorqueRegressor(truth.model, truth.data, *state)[truth.column]
    order = np.array([0, 1, 2, 3, 4, 5, 7, 6, 8, 9])
    joints = [truth.joint_of[body.name] for body in truth.mbs.bodies]
    return np.hstack([all_joints[:, 10 * (joint - 1) + order] for joint in joints])


def compare(robot: Robot, mbs: Mbs) -> None:
    truth, s = Truth(mbs), random_state(mbs, np.random.default_rng(5), loads=False)
    model, data = truth.model, truth.data
    q, qd, qdd = s.q[1:].copy(), s.qd[1:].copy(), s.qdd[1:].copy()
    v, w = truth.vector(s.q), truth.vector(s.qd)
    pairs: list[tuple[Any, Any]] = [
        (robot.mass_matrix(q), truth.matrix(s)),
        (robot.bias(q, qd), truth.forces(s, accelerated=False)),
        (robot.inverse_dynamics(q, qd, qdd), truth.forces(s, accelerated=True)),
        (robot.regressor(q, qd, qdd), pinocchios_regressor(truth, s)),
        (robot.regressor(q, qd, qdd) @ robot.parameters(), truth.forces(s, accelerated=True)),
        (
            robot.energy(q, qd),
            [
                pin.computeKineticEnergy(model, data, v, w),
                pin.computePotentialEnergy(model, data, v),
            ],
        ),
        (robot.centre_of_mass(q), pin.centerOfMass(model, data, v)),
        (robot.momentum(q, qd), pin.computeCentroidalMomentum(model, data, v, w)),
    ]
    for body in mbs.bodies:
        joint = truth.number(body.name)
        for label, at in [
            (body.name, np.zeros(3)),
            *(((body.name, point.name), np.array(point.coordinates)) for point in body.points),
        ]:
            expected = truth.sensor(s, joint, at)
            pairs.append((robot.position(label, q), expected.P[1:]))
            pairs.append((robot.jacobian(label, q), expected.J[1:, 1:]))
    for point in mbs.base.points:
        label = BASE, point.name
        pairs.append((robot.position(label, q), np.array(point.coordinates)))
        pairs.append((robot.jacobian(label, q), np.zeros((6, len(q)))))
    driven = [joint.nature == "driven" for body in mbs.bodies for joint in body.joints]
    s.qdd[1:][driven] = 0.0
    tau = truth.forces(s, accelerated=True)
    pairs.append((robot.forward_dynamics(q, qd, tau), s.qdd[1:]))
    for actual, expected in pairs:
        assert error(np.asarray(actual), np.asarray(expected)) <= TOLERANCE
    assert robot.joints == list(mbs.numbers())


class Complex:
    """A module of functions for complex numbers."""

    sin, cos, sqrt = staticmethod(cmath.sin), staticmethod(cmath.cos), staticmethod(cmath.sqrt)


@few
@given(trees(), st.booleans(), st.integers(0, 9))
def test_called_equations_of_random_trees_are_as_pinocchio(mbs: Mbs, fold: bool, seed: int) -> None:
    """All kinds of joints, driven ones too, with forces on the bodies."""
    functions = ["invdyna", "derivatives", "regressor"]
    eq = write_equations(mbs, fold=fold, functions=functions)
    s: Any = random_state(mbs, np.random.default_rng(seed))
    n = s.njoint + 1
    tables, actual = np.zeros((3, n, n)), np.zeros((n, 10 * len(mbs.bodies) + 1))
    eq.fill("derivatives", s, *tables)
    eq.fill("regressor", s, actual)
    assert error(actual[1:, 1:], pinocchios_regressor(Truth(mbs), s)) <= 1e-12
    joints = [joint for body in mbs.bodies for joint in body.joints]
    state = [s.q.astype(object), s.qd.astype(object), s.qdd.astype(object)]
    s.math = Complex
    by_step = np.zeros_like(tables)
    for table, name in zip(by_step, ("q", "qd", "qdd"), strict=True):
        for k, joint in enumerate(joints, start=1):
            fixed = joint.nature == "driven" and joint.symbols == ("q",)
            s.q, s.qd, s.qdd = (x.copy() for x in state)
            if not fixed:
                getattr(s, name)[k] += 1e-30j
            phi = np.full(n, 0.0, object)
            eq.fill("invdyna", s, phi)
            table[:, k] = phi.astype(complex).imag / 1e-30
    assert error(tables, by_step) <= 1e-12


def pinocchios(truth: Truth, tables: Any) -> list[Any]:
    """Return derivatives of Pinocchio in the order of our joints."""
    at = np.ix_(truth.column, truth.column)
    return [np.asarray(table)[at] for table in tables]


@pytest.mark.parametrize(("source", "language"), ROBOTS)
def test_called_equations_of_real_robots_are_as_pinocchio(
    source: Any, language: str, tmp_path: Path
) -> None:
    mbs, robot = loaded(tmp_path / "robot.mbs", source.convert(pipeline="compact").data, language)
    compare(robot, mbs)
    truth, s = Truth(mbs), random_state(mbs, np.random.default_rng(6), loads=False)
    joints = [joint for body in mbs.bodies for joint in body.joints]
    moving = np.array([joint.nature != "driven" for joint in joints])
    s.qdd[1:][~moving] = 0.0
    state = [truth.vector(x) for x in (s.q, s.qd, s.qdd)]
    given = [x[1:].copy() for x in (s.q, s.qd, s.qdd)]
    model, free = truth.model, np.ix_(moving, moving)
    actual = robot.inverse_dynamics_derivatives(*given)
    by_q, by_qd, _ = pin.computeRNEADerivatives(model, truth.data, *state)
    expected = pinocchios(truth, (by_q, by_qd))
    for a, b in zip(actual, [*expected, truth.matrix(s)], strict=True):
        assert error(a[free], b[free]) <= 1e-9
    tau = truth.forces(s, accelerated=True)
    actual = robot.forward_dynamics_derivatives(*given[:2], tau)
    if moving.all():
        force = np.zeros(model.nv)
        force[truth.column] = tau
        tables = pin.computeABADerivatives(model, truth.data, *state[:2], force)
        inverse = np.triu(tables[2]) + np.triu(tables[2], 1).T
        for a, b in zip(actual, pinocchios(truth, (*tables[:2], inverse)), strict=True):
            assert error(a, b) <= 1e-9
    for a, b in zip(actual, expected, strict=False):
        assert error((truth.matrix(s) @ a)[free], -b[free]) <= 1e-9


def test_loops_are_closed(tmp_path: Path) -> None:
    """A crank and two bars: what is left of the forces does no work."""
    file = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0)
    in_c, robot = (load_equations(file, language=language) for language in ("c", "python"))
    data, n = robot.data, len(robot.joints)
    qd, tau = np.random.default_rng(3).uniform(-0.1, 0.1, (2, n))
    q = data.q0[1:].copy()
    qdd = robot.forward_dynamics(q, qd, tau)
    assert error(in_c.forward_dynamics(q, qd, tau), qdd) <= TOLERANCE
    states = [np.array([q, q]), np.array([qd, 0 * qd]), np.array([tau, tau])]
    assert np.array_equal(in_c.forward_dynamics(*states)[0], in_c.forward_dynamics(q, qd, tau))
    robot.forward_dynamics(q, qd, tau)
    free, dependent = data.qu[1:] - 1, data.qv[1:] - 1
    assert len(dependent) == 2
    assert robot.code is not None
    jac = robot.code.compute_constraints()[1][:, 1:]
    turn = np.zeros((n, len(free)))
    turn[free] = np.eye(len(free))
    turn[dependent] = -np.linalg.solve(jac[:, dependent], jac[:, free])
    needed = robot.inverse_dynamics(data.q[1:], data.qd[1:], qdd)
    assert error(turn.T @ needed, turn.T @ tau) <= TOLERANCE
    loop = "ball 'cut_1' closes a loop with joints '"
    with pytest.raises(ValueError, match=f"{loop}.*take differences of forward_dynamics"):
        robot.forward_dynamics_derivatives(q, qd, tau)
    with pytest.raises(TypeError, match=f"{loop}.*leave math out"):
        load_equations(file, math=np).forward_dynamics(q, qd, tau)


@pytest.mark.parametrize("language", ["c", "python"])
def test_a_batch_is_its_states_one_by_one(language: str, minimal: Path) -> None:
    robot = load_equations(minimal, language=language)
    states = np.random.default_rng(4).uniform(-1, 1, (3, 7, len(robot.joints)))
    calls = CALLS | {"bodies": lambda r, q, qd, u: r.forward_dynamics_derivatives(q, qd, u)[1]}
    for name, call in calls.items():
        actual = call(robot, *states)
        expected = [call(robot, *state) for state in zip(*states, strict=True)]
        assert np.array_equal(actual, expected), name
        assert np.array_equal(call(robot, *states[:, 0].astype(np.float32)).shape, actual.shape[1:])
    one = states[0, 0]
    many = robot.inverse_dynamics(states[0], one, [0] * len(one))
    assert np.array_equal(many[1], robot.inverse_dynamics(states[0, 1], one, 0.0 * one))
    with pytest.raises(ValueError, match="bias got 3 and 7 states"):
        robot.bias(states[0, :3], states[1])


@pytest.mark.parametrize("language", ["c", "python"])
def test_wrong_arrays_are_named(language: str, minimal: Path) -> None:
    robot = load_equations(minimal, language=language)
    n = len(robot.joints)
    right = np.zeros(n)
    for call in (
        lambda: robot.mass_matrix(np.zeros(n + 1)),
        lambda: robot.mass_matrix(np.zeros((n, 1))),
        lambda: robot.mass_matrix(1.0),
        lambda: robot.bias(right, [0.0] * (n + 1)),
        lambda: robot.forward_dynamics(right, right, np.zeros(n + 1)),
        lambda: robot.position("nowhere", right),
    ):
        with pytest.raises(ValueError, match=rf"the model has ({n} joints|no body)"):
            call()
    with pytest.raises(TypeError, match="q must be real numbers"):
        robot.mass_matrix(right + 1j)


Call = Callable[[Robot, Any, Any, Any], Any]
#: All that takes any kind of number.
CALLS: dict[str, Call] = {
    "mass_matrix": lambda r, q, qd, u: r.mass_matrix(q),
    "bias": lambda r, q, qd, u: r.bias(q, qd),
    "inverse": lambda r, q, qd, u: r.inverse_dynamics(q, qd, u),
    "forward": lambda r, q, qd, u: r.forward_dynamics(q, qd, u),
    "by_q": lambda r, q, qd, u: r.inverse_dynamics_derivatives(q, qd, u)[0],
    "regressor": lambda r, q, qd, u: r.regressor(q, qd, u),
    "position": lambda r, q, qd, u: r.position(r.bodies[-1], q),
    "jacobian": lambda r, q, qd, u: r.jacobian(r.bodies[-1], q),
    "energy": lambda r, q, qd, u: r.energy(q, qd),
    "centre": lambda r, q, qd, u: r.centre_of_mass(q),
    "momentum": lambda r, q, qd, u: r.momentum(q, qd),
}


def test_many_states_at_once_have_the_same_bits(minimal: Path) -> None:
    robot = load_equations(minimal, language="python")
    many = load_equations(minimal, math=np)
    states = np.random.default_rng(2).uniform(-1, 1, (3, len(robot.joints), 4))
    for name, call in CALLS.items():
        actual = call(many, *states)
        for k in range(4):
            expected = call(robot, *states[:, :, k])
            # numpy's own sines of arrays may differ in the last bit
            assert error(actual[..., k], expected) <= 1e-14, name
    with pytest.raises(ValueError, match="joints"):
        many.mass_matrix(states[0, 1:])


@pytest.mark.parametrize("math", [None, np])
def test_joints_that_never_move_may_be_left_out(math: Any) -> None:
    """An arm of six joints and a gripper is 7 by 7, whatever the .mbs turns its axes with."""
    all_joints, moving_joints = (
        load_equations(CONFIGS / "arm.urdf.xacro", language="python", math=math, moving=moving)
        for moving in (False, True)
    )
    counts = "16 joints, of which 7 move, and 1 that follows; 9 bodies"
    assert repr(all_joints) == f"<Robot arm: {counts}>"
    assert [all_joints.joints[k] for k in all_joints.moving] == moving_joints.joints
    state = np.random.default_rng(9).uniform(-1, 1, (3, 7))
    full = np.zeros((3, 16))
    full[0] = all_joints.data.q0[all_joints.selection.numbers]
    full[:, moving_joints.moving] = state
    of_joints = {
        "mass_matrix": (0, 1),
        "bias": (0,),
        "inverse": (0,),
        "by_q": (0, 1),
        "regressor": (0,),
        "jacobian": (1,),
    }
    for name, call in CALLS.items():
        if name == "forward":
            continue
        actual, expected = call(moving_joints, *state), call(all_joints, *full)
        for axis in of_joints.get(name, ()):
            expected = np.take(expected, moving_joints.moving, axis)
        assert actual.shape == expected.shape, name
        assert error(actual, expected) <= 1e-13, name
    if math is None:
        expected = all_joints.forward_dynamics(*full)[moving_joints.moving]
        assert error(moving_joints.forward_dynamics(*state), expected) <= 1e-13


def test_casadi_takes_our_functions(minimal: Path) -> None:
    casadi = pytest.importorskip("casadi", reason="casadi is not installed")
    robot = load_equations(minimal, language="python")
    symbolic = load_equations(minimal, math=casadi)
    n = len(robot.joints)
    state = np.random.default_rng(7).uniform(-1, 1, (3, n))
    symbols = [casadi.SX.sym(name, n) for name in ("q", "qd", "u")]
    for name, call in CALLS.items():
        actual = np.array(casadi.Function("f", symbols, [call(symbolic, *symbols)])(*state))
        expected = call(robot, *state)
        assert error(actual.reshape(expected.shape), expected) <= 1e-13, name


@pytest.mark.slow
def test_jax_compiles_and_differentiates_our_functions(minimal: Path) -> None:
    """Compiled by JAX, and differentiated: the derivatives are ours."""
    jax = pytest.importorskip("jax", reason="jax is not installed")
    robot = load_equations(minimal, language="python")
    traced = load_equations(minimal, math=jax.numpy)
    state = np.random.default_rng(8).uniform(-1, 1, (3, len(robot.joints)))

    @jax.jit
    def force(*state: Any) -> Any:
        return traced.inverse_dynamics(*state)

    with jax.enable_x64(True):
        assert error(np.asarray(force(*state)), robot.inverse_dynamics(*state)) <= 1e-13
        by_q = np.asarray(jax.jacfwd(force)(*state))
        assert error(by_q, robot.inverse_dynamics_derivatives(*state)[0]) <= 1e-13


class Symbol:
    """As CasADi's: a float of it is nan."""

    def __float__(self) -> float:
        return float("nan")


def test_symbols_are_an_error_and_never_nan(minimal: Path) -> None:
    robot = load_equations(minimal, language="python")
    n = len(robot.joints)
    with pytest.raises(TypeError, match="q must be real numbers"):
        robot.mass_matrix([Symbol()] * n)
    data = robot.data
    m, c = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    data.q = np.array([Symbol()] * (n + 1))
    with pytest.raises(TypeError, match=r"set s\.math"):
        data.mbs_dirdyna(m, c, data, 0.0)
    data.math = np
    with pytest.raises(TypeError, match=r"set s\.math"):
        data.mbs_dirdyna(m, c, data, 0.0)
