"""An inertia that no body can have is moved to the nearest that one can."""

import numpy as np
import pytest
from hypothesis import given

from support.examples import reproducible
from support.inertia import second_moment, tensors
from support.inertia import tensor_matrix as matrix
from urdf2mbs.spatial import Sym
from urdf2mbs.urdf.inertia import find_fault
from urdf2mbs.urdf.model import Inertial, Origin
from urdf2mbs_inertia.nearest import find_nearest_inertia


@reproducible
@given(tensors, tensors)
def test_the_nearest_is_possible_and_none_is_nearer(tensor: Sym, other: Sym) -> None:
    old = Inertial(1.0, tensor, Origin((1.0, 2.0, 3.0)))
    new, moved = find_nearest_inertia(old)
    size = max(*map(abs, tensor), 1e-12)
    wanted = second_moment(tensor)
    found = second_moment(new.inertia)
    assert (new.mass, new.origin) == (old.mass, old.origin)
    assert np.linalg.eigvalsh(found).min() >= -1e-13 * size
    assert abs(np.linalg.norm(found - wanted) - moved) <= 1e-13 * size
    # the projection on a convex cone: no member of it is in the direction of what was taken away
    factor = matrix(other)
    assert np.sum((wanted - found) * (factor @ factor.T - found)) <= 1e-11 * size * 1e3
    assert find_nearest_inertia(new)[1] <= 1e-13 * size
    assert find_fault(new.inertia, 1.0) is None or max(map(abs, new.inertia)) <= 1e-12 * size


def test_what_is_possible_stays() -> None:
    for tensor in ((2.0, 0.1, -0.2, 3.0, 0.3, 4.0), (1.0, 0.0, 0.0, 1.0, 0.0, 0.0), (0.0,) * 6):
        old = Inertial(1.0, tensor)
        new, moved = find_nearest_inertia(old)
        assert new.inertia == pytest.approx(tensor, abs=1e-14)
        assert moved <= 1e-15
    assert find_nearest_inertia(Inertial(-1.0))[0] == Inertial(0.0)
