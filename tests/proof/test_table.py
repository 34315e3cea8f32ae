"""The table of docs/verify.md: each row names a fault that is planted and found, or a test."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from proof.test_planted import PLANTED
from proof.test_words import FOUND, SAID

TESTS = Path(__file__).parents[1]
PAGE = (TESTS.parent / "docs" / "verify.md").read_text("utf-8")
TABLE = PAGE.partition("## Who holds it")[2].partition("\n## ")[0]
ROWS = [line.strip("| ").split(" | ") for line in TABLE.splitlines() if line.startswith("| ")][1:]
FAULTS = {**PLANTED, **FOUND, **SAID}


def test_every_fault_that_is_planted_is_in_the_table() -> None:
    named = set(re.findall(r'"([^"]+)"', TABLE))
    assert named == set(FAULTS)
    assert len(FAULTS) == len(PLANTED) + len(FOUND) + len(SAID)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_a_row_names_what_shows_it(row: list[str]) -> None:
    """A fault that is found, or a test; or it says that nobody holds it."""
    shown = row[2] if len(row) > 2 else ""
    if row[1].startswith("nobody"):
        assert not shown
        return
    faults = re.findall(r'"([^"]+)"', shown)
    tests = re.findall(r"`([\w/]*test_\w+)\.py(?:::(test_\w+))?`", shown)
    assert faults or tests
    for file, name in tests:
        (path,) = TESTS.glob(f"**/{file}.py")
        assert f"def {name or 'test_'}" in path.read_text("utf-8")
    if row[1].startswith("each conversion"):
        # what a conversion proves is shown by a fault that check itself finds, or by its own test
        assert set(faults) & (set(PLANTED) | set(FOUND)) or tests
