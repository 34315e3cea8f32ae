"""The laws of the merge, on any models: one side alone wins, edits of both add up, none is lost."""

from itertools import combinations
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.edits import edited
from support.mbs_models import everything, few, models
from support.merges import SAMPLES, check_one_side_alone, differ, list_conflicts, three
from urdf2mbs.mbs import model as m
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_edits.diff.table import list_entities
from urdf2mbs_edits.merge.merge import Merged

PAIRS = [
    pair for pair in combinations(SAMPLES, 2) if len({f.name.split(".")[0] for f in pair}) == 1
]


def merge_or_refuse(base: bytes, ours: bytes, theirs: bytes) -> Merged | None:
    """Merge three versions; None if they do not fit together."""
    try:
        return three(base, ours, theirs)
    except ConversionError as error:
        if error.code == "merge-inconsistent":
            return None
        raise


def check_both(base: bytes, ours: bytes, theirs: bytes) -> None:
    """What a side added is in both results; without conflicts these are the same."""
    results = [merge_or_refuse(base, *sides) for sides in ((ours, theirs), (theirs, ours))]
    if results[0] is None or results[1] is None:
        # the side that is called ours wins a conflict, so that only one result may fit together
        assert all(done is None or list_conflicts(done) for done in results)
        return
    first, second = results
    before, *names = (
        {(entity.kind, entity.name) for entity in list_entities(read_mbs(data, "m"))}
        for data in (base, ours, theirs)
    )
    renamed = {
        change.edit.after
        for done in (first, second)
        for change in done.plan.conflicts
        if change.edit.change == "renamed"
    }
    for done in (first, second):
        merged = {(entity.kind, entity.name) for entity in list_entities(read_mbs(done.data, "m"))}
        for _, name in (names[0] | names[1]) - before - merged:
            assert name in renamed or list_conflicts(done), done.plan
    assert bool(list_conflicts(first)) == bool(list_conflicts(second)), (first.plan, second.plan)
    if list_conflicts(first):
        return
    moved, moved_too = (
        {(c.kind, c.name) for c in differ(base, side) if c.field == "position"}
        for side in (ours, theirs)
    )
    drawn = "position" if moved & moved_too else ""
    assert not [change for change in differ(first.data, second.data) if change.field != drawn]
    check_one_side_alone(theirs, first.data)


@settings(few, max_examples=4)
@given(models(), models(), st.integers(0, 10**6))
def test_the_laws_hold_whatever_the_models_are(base: m.Mbs, changed: m.Mbs, seed: int) -> None:
    check_one_side_alone(write(base), write(changed))
    random = Random(seed)
    ours, theirs = (edited(write(everything()), random, 4) for _ in range(2))
    check_one_side_alone(write(everything()), ours)
    check_both(write(everything()), ours, theirs)


@pytest.mark.slow
@pytest.mark.skipif(not SAMPLES, reason="the real files are not there")
@settings(few, max_examples=12)
@given(st.data(), st.integers(0, 10**6))
def test_the_laws_hold_for_edits_of_real_files(data: st.DataObject, seed: int) -> None:
    random = Random(seed)
    base = data.draw(st.sampled_from(SAMPLES)).read_bytes()
    ours, theirs = (edited(base, random, random.randrange(1, 6)) for _ in range(2))
    check_one_side_alone(base, ours)
    check_both(base, ours, theirs)


@pytest.mark.skipif(not PAIRS, reason="the real files are not there")
@pytest.mark.parametrize(
    "pair",
    [
        pytest.param(
            pair, id="-".join(f.stem for f in pair), marks=[pytest.mark.slow] * (k % 5 > 0)
        )
        for k, pair in enumerate(PAIRS)
    ],
)
def test_one_side_alone_wins_in_real_histories(pair: tuple[Path, Path]) -> None:
    check_one_side_alone(*(file.read_bytes() for file in pair))
