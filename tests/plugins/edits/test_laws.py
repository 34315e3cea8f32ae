"""The laws of the merge, on any models: one side alone wins, edits of both add up, none is lost."""

from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import SHARED
from mbs.models import everything, few, models
from plugins.edits.edits import edited
from urdf2mbs.mbs import model as m
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.changes import differences
from urdf2mbs_edits.diff.flat import things
from urdf2mbs_edits.merge.merge import Merged, merge

SAMPLES = sorted((SHARED / "mbs-samples").glob("*.mbs"))


def three(base: bytes, ours: bytes, theirs: bytes) -> Merged:
    return merge(read_mbs(base, "base"), read_mbs(ours, "ours"), read_mbs(theirs, "theirs"), None)


def differ(one: bytes, two: bytes) -> list[Any]:
    return differences(read_mbs(one, "one"), read_mbs(two, "two")).changes


def said(done: Merged) -> list[Any]:
    return [*done.plan.conflicts, *done.plan.orphaned]


def check_one_side_alone(base: bytes, other: bytes) -> None:
    for ours, theirs in ((other, base), (base, other), (other, other)):
        done = three(base, ours, theirs)
        assert not said(done), done.plan.words()
        assert not differ(done.data, other)
        assert done.data == ours or ours == base
        assert done.orphans is None


def check_both(base: bytes, ours: bytes, theirs: bytes) -> None:
    """What a side added is there, and it is all one who is called ours, where nothing is said."""
    names = [{(t.kind, t.name) for t in things(read_mbs(d, "m"))} for d in (base, ours, theirs)]
    results = three(base, ours, theirs), three(base, theirs, ours)
    for done in results:
        there = {(thing.kind, thing.name) for thing in things(read_mbs(done.data, "m"))}
        for _, name in (names[1] | names[2]) - names[0] - there:
            fragments = (done.orphans or b"").decode()
            assert f">{name}<" in fragments or f'"{name}"' in fragments, done.plan.words()
    one, two = results
    assert bool(said(one)) == bool(said(two)), (one.plan.words(), two.plan.words())
    if said(one):
        return
    moved, moved_too = (
        {(c.kind, c.name) for c in differ(base, side) if c.field == "position"}
        for side in (ours, theirs)
    )
    drawn = "position" if moved & moved_too else ""
    assert not [change for change in differ(one.data, two.data) if change.field != drawn]
    check_one_side_alone(theirs, one.data)


@settings(few, max_examples=8)
@given(models(), models(), st.integers(0, 10**6))
def test_the_laws_hold_whatever_the_models_are(base: m.Mbs, other: m.Mbs, seed: int) -> None:
    check_one_side_alone(write(base), write(other))
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
