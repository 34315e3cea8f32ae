"""The first inputs of the fuzzer: whatever is in a file, a result or an error of ours comes out.

``python tests/fuzz/fuzzer.py --minutes 60`` tries more.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz.fuzzer import KINDS, PATIENCE, Fuzzer, patience

pytestmark = pytest.mark.slow

#: Inputs of each kind, and the codes of which some must be met: else the fuzzer does nothing.
COUNT = 60


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_or_an_error_of_ours(kind: str, tmp_path: Path) -> None:
    fuzzer = Fuzzer(tmp_path)
    codes = set()
    for seed in range(COUNT):
        with patience():
            codes.add(fuzzer.try_(kind, seed))
    assert "" in codes, "some inputs are good still"
    assert len(codes) > 1, "and some are bad"


@pytest.mark.parametrize("kind", KINDS)
def test_the_good_ones_are_good(kind: str, tmp_path: Path) -> None:
    fuzzer = Fuzzer(tmp_path)
    for data in list(fuzzer.good[kind]):
        fuzzer.input = lambda *_, data=data: (data, fuzzer.good[kind].index(data))  # type: ignore
        assert fuzzer.try_(kind, 0) == ""


def test_the_same_seed_is_the_same_input(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one, other = Fuzzer(tmp_path / "a"), Fuzzer(tmp_path / "b")
    assert PATIENCE < 60
    for kind in KINDS:
        assert one.input(kind, 3) == other.input(kind, 3)
        assert one.input(kind, 3) != one.input(kind, 4)
