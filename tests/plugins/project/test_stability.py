"""The fastest motion of a joint, by which the time step is bounded, against theory."""

import numpy as np
import pytest

from urdf2mbs_project.stability import SpringDamper, compute_longest_steps, find_fastest_mode


@pytest.mark.parametrize(("mass", "rate"), [(1e-14, 100.0), (1.0, 0.1), (1e6, 100.0)])
def test_the_fastest_mode_of_a_joint_beside_light_and_heavy_ones(mass: float, rate: float) -> None:
    """A direction without mass has no mode."""
    matrix = np.diag([0.0, mass, 1e9])
    stiffnesses = (("none", 1.0), ("own", mass * rate**2), ("far", 1.0))
    forces = [
        SpringDamper("spring", name, np.eye(3)[k], stiffness, 0.0)
        for k, (name, stiffness) in enumerate(stiffnesses)
    ]
    mode = find_fastest_mode(matrix, forces)
    assert abs(mode.eigenvalue) == pytest.approx(rate, rel=1e-9)
    assert mode.step == pytest.approx(compute_longest_steps(np.array([rate * 1j]))[0], rel=1e-9)
    assert mode.shares == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_the_shares_of_a_mode_are_those_of_its_forces() -> None:
    row = np.ones(1)
    forces = [
        SpringDamper("hold", "a", row, 100.0, 2.0),
        SpringDamper("spring", "b", row, 50.0, 0.0),
    ]
    mode = find_fastest_mode(np.ones((1, 1)), forces)
    rate = np.roots([1.0, 2.0, 150.0])[0]
    assert abs(mode.eigenvalue) == pytest.approx(abs(rate), rel=1e-9)
    assert mode.eigenvalue.real == pytest.approx(-1.0, rel=1e-9)
    assert mode.shares == pytest.approx([1.0, 50.0 / abs(100.0 + 2.0 * rate)], rel=1e-9)
