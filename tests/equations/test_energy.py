"""Energy, momentum and centre of mass beside Pinocchio's."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from conftest import SHARED
from equations.test_loops import slow, trees, written
from hypothesis import given
from hypothesis import strategies as st
from runtime import CEquations, PythonEquations, Truth, error, pin, random_state

from urdf2mbs.equations import generate
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs.mbs.reader import read

if TYPE_CHECKING:
    from pathlib import Path

TOLERANCE = 1e-12
WALKMAN = SHARED / "mbs-samples" / "walkman_robotran.mbs"


def fill(eq: PythonEquations, name: str, s: Any) -> Any:
    """What a function fills: E, P and L in a row, or P."""
    arrays = [
        np.full(3 if name == "energy" else 4, np.nan) for _ in range(1 + (name == "momentum"))
    ]
    if isinstance(eq, CEquations):
        rows = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in arrays]
        getattr(eq.library, f"mbs_{name}")(*rows, ctypes.byref(eq.data(s)))
    else:
        eq._of(name)(*arrays, s)
    return np.concatenate([array[1:] for array in arrays])


def compare(eq: PythonEquations, mbs: Mbs, seed: int) -> None:
    truth, s = Truth(mbs), random_state(mbs, np.random.default_rng(seed))
    model, data, q, v = truth.model, truth.data, truth.vector(s.q), truth.vector(s.qd)
    energies = [
        pin.computeKineticEnergy(model, data, q, v), pin.computePotentialEnergy(model, data, q)
    ]  # fmt: skip
    assert error(fill(eq, "energy", s), np.array(energies)) <= TOLERANCE
    if not sum(body.mass or 0.0 for body in mbs.bodies):
        return
    assert error(fill(eq, "com", s), pin.centerOfMass(model, data, q)) <= TOLERANCE
    momentum = pin.computeCentroidalMomentum(model, data, q, v)
    assert error(fill(eq, "momentum", s), np.array(momentum)) <= TOLERANCE


@slow
@given(trees(), st.booleans(), st.integers(0, 9))
def test_random_trees(mbs: Mbs, fold: bool, seed: int) -> None:
    compare(written(mbs, fold=fold, energy=True), mbs, seed)


@pytest.mark.parametrize("language", ["python", "c"])
def test_walkman(language: str, tmp_path: Path) -> None:
    if not WALKMAN.is_file():
        pytest.skip("../shared is not here")
    data = WALKMAN.read_bytes()
    mbs = read(data, WALKMAN.name, mechanics_only=True)
    made = generate(mbs, data, WALKMAN.name, language=language, energy=True)
    names = ("energy", "momentum", "com")
    made.files = {f: text for f, text in made.files.items() if f.split("_")[1] in names}
    made.counts = {name: made.counts[name] for name in names}
    compare((CEquations if language == "c" else PythonEquations)(made, mbs, tmp_path), mbs, 3)


def test_what_has_no_mass_has_no_centre() -> None:
    mbs = Mbs("nothing", bodies=[Body("b", None, None, [Joint("j", "R1")])])
    made = generate(mbs, b"<mbsDescR7/>", "nothing.mbs", energy=True)
    assert made.left_out["com"] == made.left_out["momentum"] == "no body has a mass"
    assert "energy" not in made.left_out
    assert not {"com", "energy"} & set(generate(mbs, b"<mbsDescR7/>", "nothing.mbs").counts)
