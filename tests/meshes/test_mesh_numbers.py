"""Coordinates are as short as a float32 can be."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from urdf2mbs.meshes.vrml import _rows, shortest

FLOATS = st.floats(width=32, allow_nan=False, allow_infinity=False)


def digits(text: str) -> int:
    """How many digits a decimal says something with."""
    mantissa = text.lower().partition("e")[0].replace(".", "").lstrip("-")
    return len(mantissa.strip("0"))


@given(st.lists(FLOATS, min_size=1, max_size=20))
def test_read_back_and_shortest(values: list[float]) -> None:
    single = np.array(values, np.float32)
    for given_, found in zip(single, shortest(single).tolist(), strict=True):
        assert np.float32(found) == given_
        assert digits(repr(found)) <= digits(str(given_))


def test_many_of_them() -> None:
    """Enough that some need 9 digits, as hypothesis seldom finds."""
    single = np.random.default_rng(1).uniform(-10, 10, 5000).astype(np.float32)
    needed = [digits(str(value)) for value in single]
    assert max(needed) == 9
    assert [digits(repr(value)) for value in shortest(single).tolist()] == needed


@given(st.lists(st.tuples(FLOATS, FLOATS, FLOATS), min_size=1, max_size=20))
def test_text_is_read_back(rows: list[tuple[float, float, float]]) -> None:
    single = np.array(rows, np.float32) + np.float32(0.0)
    lines = _rows(shortest(single)).decode().split("\n")
    found = np.array([[np.float32(word) for word in line.split(" ")] for line in lines])
    np.testing.assert_array_equal(found, single)


def test_round_numbers_have_no_decimals() -> None:
    rows = np.array([[1.0, 0.0, -20.0], [0.1, 1e-5, 100.0]], np.float32)
    assert _rows(shortest(rows)) == b"1 0 -20\n0.1 0.00001 100"
