"""Coordinates are as short as a float32 can be."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from urdf2mbs_meshes.model import Part
from urdf2mbs_meshes.vrml import write_vrml

FLOATS = st.floats(width=32, allow_nan=False, allow_infinity=False)


def written(points: np.ndarray) -> list[list[str]]:
    """Return the points of a .wrl as text: of one triangle for each point, at the point."""
    index = np.repeat(np.arange(len(points)), 3).reshape(-1, 3)
    text = b"".join(write_vrml([Part(points, index)], (0, 0, 0), 0.0)).decode()
    lines = text.partition("point [\n")[2].partition("\n]")[0]
    return [line.split(" ") for line in lines.split("\n")]


def digits(text: str) -> int:
    """Count the significant digits of a decimal."""
    mantissa = text.lower().partition("e")[0].replace(".", "").lstrip("-")
    return len(mantissa.strip("0"))


@example([(0.0, 0.0, -999999986991104.0)])
@given(st.lists(st.tuples(FLOATS, FLOATS, FLOATS), min_size=1, max_size=20, unique=True))
def test_numbers_read_back_exactly_and_are_the_shortest(
    rows: list[tuple[float, float, float]],
) -> None:
    single = np.unique(np.array(rows, np.float32) + np.float32(0.0), axis=0)
    for words, point in zip(written(single), single, strict=True):
        for word, value in zip(words, point, strict=True):
            assert np.float32(word) == value
            assert digits(word) <= digits(str(value))


def test_many_of_them() -> None:
    """Enough that some need 9 digits, as hypothesis seldom finds."""
    single = np.random.default_rng(1).uniform(-10, 10, (1500, 3)).astype(np.float32)
    needed = [digits(str(value)) for value in single.ravel()]
    assert max(needed) == 9
    assert [digits(word) for words in written(single) for word in words] == needed


def test_round_numbers_have_no_decimals() -> None:
    rows = np.array([[1.0, 0.0, -20.0], [0.1, 1e-5, 100.0]], np.float32)
    assert written(rows) == [["1", "0", "-20"], ["0.1", "0.00001", "100"]]
