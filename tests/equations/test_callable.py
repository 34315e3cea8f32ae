"""``load_equations`` beside pinocchio, in C and Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from conftest import SHARED
from equations.test_derivatives import pinocchios_regressor
from robots import CONVERTIBLE
from runtime import Truth, error, pin, random_state

from urdf2mbs import Robot, load_equations
from urdf2mbs.mbs.model import BASE
from urdf2mbs.mbs.reader import read
from urdf2mbs.runtime.c_code import FLAGS

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.mbs.model import Mbs

TOLERANCE = 1e-10
NAMES = ("ur-ur10e", "cassie-cassie_v4")
ROBOTS = [p.values[0] for p in CONVERTIBLE if p.values[0].name in NAMES]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("urdf2mbs.runtime.c_code.FLAGS", (*FLAGS, "-O0"))


def loaded(path: Path, data: bytes, language: str) -> tuple[Mbs, Robot]:
    path.write_bytes(data)
    return read(data, path.name, mechanics_only=True), load_equations(path, language=language)


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
        (robot.energy(q, qd), [pin.computeKineticEnergy(model, data, v, w),
                               pin.computePotentialEnergy(model, data, v)]),
        (robot.centre_of_mass(q), pin.centerOfMass(model, data, v)),
        (robot.momentum(q, qd), pin.computeCentroidalMomentum(model, data, v, w)),
    ]  # fmt: skip
    for body in mbs.bodies:
        joint = truth.ids.index(truth.joint_of[body.name])
        for place, at in [
            (body.name, np.zeros(3)),
            *(((body.name, point.name), np.array(point.coordinates)) for point in body.points),
        ]:
            wanted = truth.sensor(s, joint, at)
            pairs.append((robot.position(place, q), wanted.P[1:]))
            pairs.append((robot.jacobian(place, q), wanted.J[1:, 1:]))
    for point in mbs.base.points:
        place = BASE, point.name
        pairs.append((robot.position(place, q), np.array(point.coordinates)))
        pairs.append((robot.jacobian(place, q), np.zeros((6, len(q)))))
    driven = [joint.nature == "driven" for body in mbs.bodies for joint in body.joints]
    s.qdd[1:][driven] = 0.0
    tau = truth.forces(s, accelerated=True)
    pairs.append((robot.forward_dynamics(q, qd, tau), s.qdd[1:]))
    for found, wanted in pairs:
        assert error(np.asarray(found), np.asarray(wanted)) <= TOLERANCE
    assert robot.joints == list(mbs.numbers())


@pytest.mark.parametrize("language", ["c", "python"])
@pytest.mark.parametrize("source", [pytest.param(robot, id=robot.name) for robot in ROBOTS])
def test_real_robots(source: Any, language: str, tmp_path: Path) -> None:
    data = source.convert(pipeline="compact").data
    mbs, robot = loaded(tmp_path / "robot.mbs", data, language)
    compare(robot, mbs)


def test_loops_are_closed() -> None:
    """Fingers that follow by user constraints: what is left of the forces does no work."""
    path = SHARED / "robots/robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf"
    if not path.is_file():
        pytest.skip("../shared is not here")
    in_c, robot = (load_equations(path, language=language) for language in ("c", "python"))
    data, n = robot.data, len(robot.joints)
    q, qd, tau = np.random.default_rng(3).uniform(-0.1, 0.1, (3, n))
    qdd = robot.forward_dynamics(q, qd, tau)
    assert error(in_c.forward_dynamics(q, qd, tau), qdd) <= TOLERANCE
    free, dependent = data.qu[1:] - 1, data.qv[1:] - 1
    assert len(dependent) == 5
    assert robot.code is not None
    jac = robot.code.jacobian()[1:, 1:]
    turn = np.zeros((n, len(free)))
    turn[free] = np.eye(len(free))
    turn[dependent] = -np.linalg.solve(jac[:, dependent], jac[:, free])
    needed = robot.inverse_dynamics(data.q[1:], data.qd[1:], qdd)
    assert error(turn.T @ needed, turn.T @ tau) <= TOLERANCE
    with pytest.raises(ValueError, match="dependent joints"):
        robot.forward_dynamics_derivatives(q, qd, tau)


@pytest.mark.parametrize("language", ["c", "python"])
def test_wrong_arrays_are_named(language: str, tmp_path: Path) -> None:
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    _, robot = loaded(tmp_path / "minimal.mbs", path.read_bytes(), language)
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


def test_many_states_at_once_have_the_same_bits(tmp_path: Path) -> None:
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    _, robot = loaded(tmp_path / "minimal.mbs", path.read_bytes(), "python")
    many = load_equations(tmp_path / "minimal.mbs", math=np)
    states = np.random.default_rng(2).uniform(-1, 1, (3, len(robot.joints), 4))
    for name, call in CALLS.items():
        found = call(many, *states)
        for k in range(4):
            wanted = call(robot, *states[:, :, k])
            # numpy's own sines of arrays may differ in the last bit
            assert error(found[..., k], wanted) <= 1e-14, name
    with pytest.raises(ValueError, match="joints"):
        many.mass_matrix(states[0, 1:])


def test_casadi(tmp_path: Path) -> None:
    casadi = pytest.importorskip("casadi", reason="casadi is not installed")
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    _, robot = loaded(tmp_path / "minimal.mbs", path.read_bytes(), "python")
    symbolic = load_equations(tmp_path / "minimal.mbs", math=casadi)
    n = len(robot.joints)
    state = np.random.default_rng(7).uniform(-1, 1, (3, n))
    symbols = [casadi.SX.sym(name, n) for name in ("q", "qd", "u")]
    for name, call in CALLS.items():
        made = casadi.vertcat(*call(symbolic, *symbols).ravel().tolist())
        found = np.array(casadi.Function("f", symbols, [made])(*state)).ravel()
        assert error(found, np.ravel(call(robot, *state))) <= 1e-13, name


@pytest.mark.slow
def test_jax(tmp_path: Path) -> None:
    """Compiled by JAX, and differentiated: the derivatives are ours."""
    jax = pytest.importorskip("jax", reason="jax is not installed")
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    _, robot = loaded(tmp_path / "minimal.mbs", path.read_bytes(), "python")
    traced = load_equations(tmp_path / "minimal.mbs", math=jax.numpy)
    state = np.random.default_rng(8).uniform(-1, 1, (3, len(robot.joints)))

    @jax.jit
    def force(*state: Any) -> Any:
        return jax.numpy.stack([1.0 * x for x in traced.inverse_dynamics(*state)])

    with jax.enable_x64(True):
        assert error(np.asarray(force(*state)), robot.inverse_dynamics(*state)) <= 1e-13
        by_q = np.asarray(jax.jacfwd(force)(*state))
        assert error(by_q, robot.inverse_dynamics_derivatives(*state)[0]) <= 1e-13


class Symbol:
    """As CasADi's: a float of it is nan."""

    def __float__(self) -> float:
        return float("nan")


def test_symbols_are_an_error_and_never_nan(tmp_path: Path) -> None:
    path = SHARED / "mbs-samples" / "minimal.mbs"
    if not path.is_file():
        pytest.skip("../shared is not here")
    _, robot = loaded(tmp_path / "minimal.mbs", path.read_bytes(), "python")
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
