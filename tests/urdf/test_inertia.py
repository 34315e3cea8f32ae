"""Inertias that no body can have: found, and moved to the nearest that one can."""

import numpy as np
import pytest
from hypothesis import given

from support.examples import reproducible
from support.inertia import second_moment, tensor_matrix, tensors, two_links
from support.presets import PRESETS
from urdf2mbs.spatial import Sym
from urdf2mbs.testing import assert_same_robot, convert_text
from urdf2mbs.urdf.inertia import find_fault, moments, principal


@reproducible
@given(tensors)
def test_principal_moments_and_axes_are_those_of_numpy(tensor: Sym) -> None:
    values, axes = principal(tensor)
    size = max(map(abs, tensor)) or 1.0
    rows = np.array(axes)
    assert np.abs(rows.T @ rows - np.eye(3)).max() <= 1e-14
    assert np.abs(rows @ np.diag(values) @ rows.T - tensor_matrix(tensor)).max() <= 1e-14 * size
    assert np.abs(np.linalg.eigvalsh(tensor_matrix(tensor)) - moments(tensor)).max() <= 1e-14 * size


@reproducible
@given(tensors)
def test_a_fault_is_a_negative_second_moment(tensor: Sym) -> None:
    least = np.linalg.eigvalsh(second_moment(tensor)).min()
    if abs(least) > 0.01 * max(map(abs, tensor)):
        assert (find_fault(tensor, 0.0) is None) == (least > 0.0)


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
@pytest.mark.parametrize("mass", ["-0.5", "-2"])
def test_a_negative_mass_is_lumped_as_any_other(mass: str) -> None:
    text = two_links(mass, 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"')
    result = convert_text(text.replace("continuous", "fixed"), pipeline="compact")
    assert result.report.mass == 1.0 + float(mass)
    assert_same_robot(result)
