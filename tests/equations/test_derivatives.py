"""Derivatives and the regressor, by complex steps and beside pinocchio."""

from __future__ import annotations

import cmath
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from equations.test_loops import slow, trees, written
from hypothesis import given
from hypothesis import strategies as st
from robots import CONVERTIBLE
from runtime import Data, Truth, error, pin, random_state

from urdf2mbs import load_equations
from urdf2mbs.mbs.reader import read
from urdf2mbs.runtime.c_code import FLAGS

if TYPE_CHECKING:
    from pathlib import Path

    from urdf2mbs.mbs.model import Mbs

NAMES = ("ur-ur10e", "cassie-cassie_v4")
ROBOTS = [p.values[0] for p in CONVERTIBLE if p.values[0].name in NAMES]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("urdf2mbs.runtime.c_code.FLAGS", (*FLAGS, "-O0"))


def pinocchios_regressor(truth: Truth, s: Data) -> Any:
    """Pinocchio has the inertia in another order: xx, xy, yy, xz, yz, zz."""
    state = [truth.vector(x) for x in (s.q, s.qd, s.qdd)]
    every = pin.computeJointTorqueRegressor(truth.model, truth.data, *state)[truth.column]
    order = np.array([0, 1, 2, 3, 4, 5, 7, 6, 8, 9])
    joints = [truth.joint_of[body.name] for body in truth.mbs.bodies]
    return np.hstack([every[:, 10 * (joint - 1) + order] for joint in joints])


class Complex:
    """Functions for complex numbers."""

    sin, cos, sqrt = staticmethod(cmath.sin), staticmethod(cmath.cos), staticmethod(cmath.sqrt)


@slow
@given(trees(), st.booleans(), st.integers(0, 9))
def test_random_trees(mbs: Mbs, fold: bool, seed: int) -> None:
    """All kinds of joints, driven ones too, with forces on the bodies."""
    functions = ["invdyna", "derivatives", "regressor"]
    eq = written(mbs, fold=fold, functions=functions)
    s: Any = random_state(mbs, np.random.default_rng(seed))
    n = s.njoint + 1
    tables, found = np.zeros((3, n, n)), np.zeros((n, 10 * len(mbs.bodies) + 1))
    eq._of("derivatives")(*tables, s)
    eq._of("regressor")(found, s)
    assert error(found[1:, 1:], pinocchios_regressor(Truth(mbs), s)) <= 1e-12
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
            eq._of("invdyna")(phi, s, 0.0)
            table[:, k] = phi.astype(complex).imag / 1e-30
    assert error(tables, by_step) <= 1e-12


def pinocchios(truth: Truth, tables: Any) -> list[Any]:
    """Derivatives of pinocchio, by joint number."""
    at = np.ix_(truth.column, truth.column)
    return [np.asarray(table)[at] for table in tables]


@pytest.mark.parametrize("language", ["c", "python"])
@pytest.mark.parametrize("source", [pytest.param(robot, id=robot.name) for robot in ROBOTS])
def test_derivatives(source: Any, language: str, tmp_path: Path) -> None:
    data = source.convert(pipeline="compact").data
    (tmp_path / "robot.mbs").write_bytes(data)
    mbs = read(data, "robot.mbs", mechanics_only=True)
    robot = load_equations(tmp_path / "robot.mbs", language=language)
    truth, s = Truth(mbs), random_state(mbs, np.random.default_rng(6), loads=False)
    joints = [joint for body in mbs.bodies for joint in body.joints]
    moving = np.array([joint.nature != "driven" for joint in joints])
    s.qdd[1:][~moving] = 0.0
    state = [truth.vector(x) for x in (s.q, s.qd, s.qdd)]
    given = [x[1:].copy() for x in (s.q, s.qd, s.qdd)]
    model, free = truth.model, np.ix_(moving, moving)
    found = robot.inverse_dynamics_derivatives(*given)
    by_q, by_qd, _ = pin.computeRNEADerivatives(model, truth.data, *state)
    wanted = pinocchios(truth, (by_q, by_qd))
    for a, b in zip(found, [*wanted, truth.matrix(s)], strict=True):
        assert error(a[free], b[free]) <= 1e-9
    tau = truth.forces(s, accelerated=True)
    found = robot.forward_dynamics_derivatives(*given[:2], tau)
    if moving.all():
        force = np.zeros(model.nv)
        force[truth.column] = tau
        tables = pin.computeABADerivatives(model, truth.data, *state[:2], force)
        inverse = np.triu(tables[2]) + np.triu(tables[2], 1).T
        for a, b in zip(found, pinocchios(truth, (*tables[:2], inverse)), strict=True):
            assert error(a, b) <= 1e-9
    for a, b in zip(found, wanted, strict=False):
        assert error((truth.matrix(s) @ a)[free], -b[free]) <= 1e-9
