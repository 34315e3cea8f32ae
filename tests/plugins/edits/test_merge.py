"""The three-way merge: every edit is kept or named, and the plan is what happens."""

from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from support import edits as made
from support.edits import CHANGES, as_saved, no_leaf, renamed_joint
from support.folders import CONFIGS
from support.mbs_models import few
from urdf2mbs import convert
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read_mbs, read_mbs_again
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_edits.diff.changes import compare_tables, find_differences
from urdf2mbs_edits.diff.table import is_diagram_position, list_entities
from urdf2mbs_edits.merge.merge import Merged, make_tables, merge

ROBOTS = ("lamp.urdf", "biped.urdf.xacro", "arm.urdf.xacro", "hexapod.urdf.xacro")

BESIDE: list[Any] = [
    made.a_place,
    made.a_point,
    made.a_shape,
    made.a_model,
    made.sensor,
    made.link,
    renamed_joint,
    made.renamed_body,
]
#: The edits that make it another robot.
MECHANICS: list[Any] = [
    made.a_value,
    made.a_word,
    made.body_on_a_new_point,
    made.a_joint,
    made.a_cut,
    made.mass,
    made.sensors_change_places,
    no_leaf,
]


@cache
def urdf(robot: str) -> bytes:
    result = convert(CONFIGS / robot, pipeline=["expand"], output="r.mbs")
    return result.conversion.expanded or (CONFIGS / robot).read_bytes()


@cache
def fresh(text: bytes, preset: str, folder: Path) -> bytes:
    file = folder / "robot.urdf"
    file.write_bytes(text.replace(b"meshes/", f"{CONFIGS}/meshes/".encode()))
    return convert(file, pipeline=preset, output=folder / "out" / "r.mbs").data


def changed(text: bytes, changes: list[Any], random: Random) -> bytes:
    root = etree.fromstring(text)
    for change in changes:
        change(root, random)
    return etree.tostring(root)


def model(data: bytes) -> Mbs:
    mbs = read_mbs(data, "m.mbs")
    for entity in list_entities(mbs):
        if hasattr(entity.part, "origin"):
            entity.part.origin = None
    return mbs


def check_all_kept_or_named(base: Mbs, edited: Mbs, merged: Merged, new: Mbs) -> None:
    plan = merged.plan
    reported = [conflict.edit for conflict in plan.conflicts]
    reported += [edit for orphan in plan.orphaned for edit in orphan.edits]
    before, ours, theirs = make_tables(base, edited, new)
    for change, (number, field) in compare_tables(before, ours):
        kept = any(
            (c.change, c.kind, c.field, c.after)
            == (change.change, change.kind, change.field, change.after)
            for c in plan.kept
        )
        if change.change in ("added", "removed", "reordered"):
            kept = any(
                (c.change, c.kind, c.name) == (change.change, change.kind, change.name)
                for c in plan.kept
            )
        mine, new_values = (side.values.get(number) for side in (ours, theirs))
        alike = (
            mine == new_values
            if mine is None or new_values is None
            else mine.get(field) == new_values.get(field)
        )
        gone = number in before.values and number not in theirs.values
        is_drawing = is_diagram_position(change.kind, field) or change.change == "reordered"
        passes_with_it = gone and is_drawing
        passes_with_it |= gone and change.change == "removed"
        assert kept or alike or change in reported or passes_with_it, change


def check_physics(new: Mbs, merged: Mbs) -> None:
    """What the URDF defines is as in the new conversion, to the last digit."""
    for change in find_differences(new, merged, physics=True).changes:
        people = change.change in ("added", "renamed", "reordered") or change.field == "q"
        assert people or "graphics" in change.field or "x3D" in change.field, change


def own_text(data: bytes) -> dict[tuple[str, str, str], set[str]]:
    """What each object of a file says itself, without the objects in it."""
    mbs, elements = read_mbs_again(data)
    texts: dict[tuple[str, str, str], set[str]] = {}
    for entity in list_entities(mbs):
        origin = getattr(entity.part, "origin", None)
        if origin is not None and entity.kind != "model":
            owner = "" if entity.owner is None else entity.owner.qualified_label
            reported = words(elements[origin.number], set(elements))
            texts.setdefault((entity.kind, owner, entity.name), set()).add(" ".join(reported))
    return texts


def words(element: Any, objects: set[Any]) -> list[str]:
    """An element as text, without those of objects in it."""
    texts = [f"{element.tag}{sorted(element.items())}{(element.text or '').strip()}"]
    for child in element.iterchildren("*"):
        texts += words(child, objects) if child not in objects else []
    return texts


def check_plan_is_deed(edited: bytes, merged: Merged) -> None:
    before, after = own_text(edited), own_text(merged.data)
    updated = merged.plan.updated
    told = {f"{c.kind} '{c.name}'" for c in updated}
    told |= {f"{c.kind} '{c.after}'" for c in updated if c.change == "renamed"}
    for key in before.keys() | after.keys():
        kind, owner, name = key
        if before.get(key) != after.get(key):
            reason = f"{kind} '{name}'" in told or any(word in owner for word in told)
            # what refers to something by its name says the new name
            renamed = any(c.change == "renamed" for c in updated)
            assert reason or renamed, (key, before.get(key), after.get(key))
    if not updated:
        assert merged.data == edited


@pytest.mark.slow
@few
@given(
    st.sampled_from(ROBOTS),
    st.sampled_from(["faithful", "compact"]),
    st.integers(0, 10**6),
    st.lists(st.sampled_from(BESIDE + MECHANICS), unique=True, max_size=5),
    st.lists(st.sampled_from(CHANGES), unique=True, max_size=3),
    st.booleans(),
)
def test_each_edit_is_kept_or_named_and_the_plan_is_the_deed(
    tmp_path_factory: Any,
    robot: str,
    preset: str,
    seed: int,
    edits: list[Any],
    changes: list[Any],
    backwards: bool,
) -> None:
    folder = tmp_path_factory.getbasetemp()
    random = Random(seed)
    texts = [urdf(robot), changed(urdf(robot), changes, random)]
    data = [fresh(text, preset, folder) for text in (texts[::-1] if backwards else texts)]
    edited = read_mbs(data[0], "edited.mbs")
    for edit in edits:
        edit(edited, random)
    saved = as_saved(write(edited)).replace(b"<bodytree>", b"<bodytree><!-- mine -->")
    edited = read_mbs(saved, "edited.mbs")
    base, new = read_mbs(data[0], "base.mbs"), model(data[1])
    try:
        merged = merge(base, edited, new)
    except ConversionError as error:
        if error.code == "merge-inconsistent":
            return
        raise
    again = read_mbs(merged.data, "merged.mbs")
    assert b"<!-- mine -->" in merged.data
    if data[0] == data[1] and renamed_joint not in edits:  # whose parameters follow it
        assert merged.data == saved
    check_all_kept_or_named(base, read_mbs(saved, "edited.mbs"), merged, model(data[1]))
    check_plan_is_deed(saved, merged)
    if not set(edits) & set(MECHANICS):
        check_physics(model(data[1]), again)
    # a merge that is done again changes nothing
    second = merge(model(data[1]), again, model(data[1]))
    assert second.data == merged.data, second.plan
    # nor one whose base was not replaced any more, because the process was killed before
    if no_leaf in edits:
        return  # a twin of what was removed may look like it
    third = merge(read_mbs(data[0], "base.mbs"), read_mbs(merged.data, "m.mbs"), model(data[1]))
    assert third.data == merged.data, third.plan
