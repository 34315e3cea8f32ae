"""What differs between two models: each edit is found, under its name, and nothing else."""

from collections.abc import Iterable
from copy import deepcopy
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from support.edits import Edit, add, all_of, call, drop, move, put
from support.folders import SHARED
from support.mbs_models import everything, few
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Parameter, Point, Sensor, Shape, View
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.changes import Change, Differences, find_differences
from urdf2mbs_edits.diff.wording import describe_change, describe_changes

SAMPLES = SHARED / "mbs-samples"
real = pytest.mark.skipif(not SHARED.exists(), reason=f"the real files are not here: {SHARED}")

#: What an edit must be found as: change, kind, name, field.
Found = set[tuple[str, str, str, str]]


def list_findings(changes: Differences) -> Found:
    assert len({describe_change(change) for change in changes.changes}) == len(changes.changes)
    return {(c.change, c.kind, c.name, c.field) for c in changes.changes}


def sensor_moved(mbs: Mbs) -> None:
    shoulder = mbs.bodies[0].points[0]
    mbs.bodies[3].points.append(Point("origin", sensor=shoulder.sensor))
    shoulder.sensor = None


HEAD = Body("head", "trunk", None, [Joint("nod", "R1")], mass=3.0)
DAMPER = Connection("link", "damper", ("leg", None), (None, None))
INERTIA = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
#: The edits, in an order in which any of them can be made one after the other.
EDITS: dict[str, tuple[Edit, Found]] = {
    "body added": (add("bodies", HEAD), {("added", "body", "head", "")}),
    "body heavier": (put("bodies.0.mass", 77.0), {("changed", "body", "trunk", "mass")}),
    "inertia": (put("bodies.2.inertia", INERTIA), {("changed", "body", "leg", "inertia")}),
    "body hung elsewhere": (
        put("bodies.2.point", "handle"),
        {("changed", "body", "leg", "point")},
    ),
    "body moved in the diagram": (
        put("bodies.0.drawing.control_points", ((1.0, 2.0),)),
        {("changed", "body", "trunk", "drawing.control_points")},
    ),
    "body renamed": (call("bodies.0", "torso"), {("renamed", "body", "trunk", "name")}),
    "leaf and its joint renamed": (
        all_of(call("bodies.1", "wing"), call("bodies.1.joints.0", "flap")),
        {("renamed", "body", "arm", "name"), ("renamed", "joint", "swing", "name")},
    ),
    "point renamed": (
        call("base.points.0", "track"),
        {("renamed", "point", "rail", "name")},
    ),
    "cut removed": (drop("cuts", 1), {("removed", "cut", "a_rod", "")}),
    "cuts reordered": (lambda mbs: mbs.cuts.reverse(), {("reordered", "cut", "", "order")}),
    "link renamed": (put("links.0.name", "coil"), {("renamed", "link", "a_spring", "name")}),
    "link added": (add("links", DAMPER), {("added", "link", "damper", "")}),
    "force renamed": (
        put("bodies.0.points.1.extforce.name", "shove"),
        {("renamed", "force", "push", "name")},
    ),
    "signal dropped": (
        put("bodies.0.points.1.extforce.measures", ("Rot", "Vit", "Om", "Acc", "Omp")),
        {("changed", "force", "push", "measures")},
    ),
    "gravity": (
        put("base.gravity", (0.0, 0.0, -1.62)),
        {("changed", "base", "workshop", "gravity")},
    ),
    "joint type": (put("bodies.0.joints.1.type", "R2"), {("changed", "joint", "turn", "type")}),
    "start": (put("bodies.0.joints.0.q", 0.0), {("changed", "joint", "lift", "q")}),
    "joint moved in the diagram": (
        put("bodies.0.joints.0.position", (500.0, 2.0)),
        {("changed", "joint", "lift", "position")},
    ),
    "joint added": (
        add("bodies.0.joints", Joint("more", "T2")),
        {("added", "joint", "more", "")},
    ),
    "joint moved": (
        move("bodies.0.joints", "bodies.2.joints", 2),
        {("moved", "joint", "tilt", "owner")},
    ),
    "parameter changed": (
        put("user_models.0.parameters.0.values", ("0.75",)),
        {("changed", "parameter", "gain", "values")},
    ),
    "parameter added": (
        add("user_models.0.parameters", Parameter("mine", "scalar", ("3",))),
        {("added", "parameter", "mine", "")},
    ),
    "variable removed": (
        drop("user_variables"),
        {("removed", "user variable", "q_ref", "")},
    ),
    "sensor moved": (
        sensor_moved,
        {("moved", "sensor", "imu", "owner"), ("added", "point", "origin", "")},
    ),
    "shape of a name there already": (
        add("base.shapes", Shape("box", "a_box", size=(9.0, 9.0, 9.0)), 0),
        {("added", "shape", "a_box", "")},
    ),
    "shape recoloured": (
        put("bodies.0.shapes.1.color", (200, 0, 0)),
        {("changed", "shape", "a_cylinder", "color")},
    ),
    "viewpoint moved": (
        put("view.viewpoints.0.position", (9.0, 9.0, 9.0)),
        {("changed", "viewpoint", "eye", "position")},
    ),
}


def edited(before: Mbs, names: Iterable[str]) -> tuple[Mbs, Found]:
    """A model with the edits of these names, and what they must be found as."""
    after, expected = deepcopy(before), set()
    for name, (edit, findings) in EDITS.items():
        if name in names:
            edit(after)
            expected |= findings
    return after, expected


@few
@given(st.lists(st.sampled_from(sorted(EDITS)), unique=True, max_size=6), st.booleans())
def test_random_edits_are_all_found_and_nothing_else(names: list[str], from_file: bool) -> None:
    before = everything()
    if from_file:
        before = read_mbs(write(before), "before.mbs")
    after, expected = edited(before, names)
    if from_file:
        after = read_mbs(write(after), "after.mbs")
    assert list_findings(find_differences(before, after)) == expected
    # the other way round, as many
    back = find_differences(after, before).changes
    assert len(back) == len(expected)
    physics = {
        (c.change, c.kind, c.name, c.field)
        for c in find_differences(before, after).changes
        if not c.drawing
    }
    assert list_findings(find_differences(before, after, physics=True)) == physics


@pytest.mark.parametrize("name", EDITS)
def test_each_edit_is_found_by_itself(name: str) -> None:
    before = everything()
    after, expected = edited(before, [name])
    assert list_findings(find_differences(before, after)) == expected
    pictures = {"shape", "viewpoint", "light", "view"}
    drawn = {c for c in expected if c[1] in pictures or c[3].startswith(("position", "drawing"))}
    assert list_findings(find_differences(before, after, physics=True)) == expected - drawn


def test_numbers_that_only_respell_are_no_difference() -> None:
    before = everything()
    before.bodies[2].com = None
    data = write(before)
    after = data.replace(b"<mass>", b"<mass> +").replace(b"<value>1.0<", b"<value>1e0<")
    after = after.replace(b"</mass>", b"00 </mass>")
    assert after != data
    model = read_mbs(after, "after.mbs")
    model.bodies[2].com = (0.0, -0.0, 0.0)
    model.bodies[0].joints[0].symbols = ("qdd", "q", "qd")
    assert find_differences(read_mbs(data, "before.mbs"), model).changes == []


def test_what_the_model_does_not_know_is_compared() -> None:
    root = etree.fromstring(write(everything()))
    [joint] = root.xpath("//joint[jointname='lift']")
    etree.SubElement(joint, "extforce", name="brake").text = " 1.50 "
    root.find("bodytree").set("age", "3")  # type: ignore[union-attr]
    before = read_mbs(etree.tostring(root), "before.mbs")
    assert find_differences(before, before).changes == []
    joint.find("extforce").text = "15e-1"
    joint.append(etree.Comment("nothing"))
    assert find_differences(before, read_mbs(etree.tostring(root), "m.mbs")).changes == []
    joint.find("extforce").text = "2.5"
    del root.find("bodytree").attrib["age"]  # type: ignore[union-attr]
    after = read_mbs(etree.tostring(root), "after.mbs")
    assert list_findings(find_differences(before, after)) == {
        ("changed", "joint", "lift", "extforce"),
        ("changed", "model", "machine", "bodytree/@age"),
    }
    # and against a model of which there is no file
    assert ("changed", "joint", "lift", "extforce") in list_findings(
        find_differences(before, everything())
    )


def test_what_belongs_to_a_removed_body_is_not_named_beside_it() -> None:
    before, after = everything(), everything()
    after.bodies = after.bodies[:3]
    after.cuts, after.links = after.cuts[:2], after.links[1:]
    assert list_findings(find_differences(before, after)) == {
        ("removed", "body", "cart", ""),
        ("removed", "cut", "a_solid", ""),
        ("removed", "link", "a_spring", ""),
    }


def test_bodies_in_another_order_are_said_once_and_joints_have_other_numbers() -> None:
    before, after = everything(), everything()
    after.bodies = [after.bodies[3], *after.bodies[:3]]
    differ = find_differences(before, after)
    assert list_findings(differ) == {("reordered", "body", "", "order")}
    assert differ.renumbered["lift"] == (1, 2)
    assert differ.renumbered["roll"] == (7, 1)
    assert find_differences(before, before).renumbered == {}


def test_two_sensors_without_a_view_and_with_one() -> None:
    before, after = everything(), everything()
    before.view, after.view = None, View()
    after.bodies[1].points[0].sensor = Sensor("eye")
    assert list_findings(find_differences(before, after)) == {
        ("added", "view", "", ""),
        ("added", "sensor", "eye", ""),
    }


# --- words ---


def test_the_words_of_changes() -> None:
    before = everything()
    names = ("body heavier", "joint moved", "body added", "body renamed", "link added")
    after, _ = edited(before, names)
    lines = describe_changes(find_differences(before, after))
    assert "body 'trunk' renamed to 'torso'" in lines
    assert any(
        text.startswith("body 'trunk': mass ") and text.endswith(" -> 77 kg") for text in lines
    )
    assert "joint 'tilt' moved from body 'trunk' to body 'leg'" in lines
    assert "link 'damper' added: link between body 'leg' (origin) and the base (origin)" in lines
    assert any(text.startswith("body 'head' added: on body 'torso'") for text in lines)


def test_changes_as_json_are_plain_and_the_same_every_time() -> None:
    before = everything()
    after, _ = edited(before, EDITS)
    texts = [msgspec.json.encode(find_differences(before, after)) for _ in range(2)]
    assert texts[0] == texts[1]
    again = msgspec.json.decode(texts[0], type=Differences)
    assert [(c.change, c.name) for c in again.changes] == [
        (c.change, c.name) for c in find_differences(before, after).changes
    ]
    assert isinstance(again.changes[0], Change)


# --- the real files ---


def real_differences(before: str, after: str, **options: Any) -> Differences:
    models = [read_mbs((SAMPLES / f"{name}.mbs").read_bytes(), name) for name in (before, after)]
    return find_differences(*models, **options)


@real
@pytest.mark.parametrize("year", ["2014", "2016"])
@pytest.mark.parametrize("robot", ["biped", "ur5", "nao", "cassie"])
def test_no_edit_is_found_in_what_mbsyspad_only_saved(robot: str, year: str) -> None:
    saved = real_differences(f"saved/{robot}.written", f"saved/{robot}.saved-{year}")
    assert saved.changes == []
    assert saved.renumbered == {}


@real
def test_edits_of_students_are_found() -> None:
    base = "emecdelam-suspension.base"
    ours = real_differences(base, "emecdelam-suspension.ours")
    assert list_findings(ours) == {("added", "point", "Point_6", "")}
    assert list_findings(real_differences(base, "emecdelam-suspension.theirs", physics=True)) == {
        ("changed", "joint", "Joint_3", "type"),
        ("changed", "joint", "Joint_5", "type"),
        ("added", "link", "Link_1", ""),
    }
    base = "ovankerm-Jeep.base"
    assert list_findings(real_differences(base, "ovankerm-Jeep.ours", physics=True)) == {
        ("added", "parameter", "Bumpy", "")
    }
    lost = real_differences("ovankerm-Jeep.ours", "ovankerm-Jeep.merged")
    assert ("removed", "shape", "New_Shape", "") in list_findings(lost)
    moved = list_findings(real_differences("emecdelam-Jpp.before", "emecdelam-Jpp.after"))
    assert {change for change in moved if change[0] == "moved"} == {
        ("moved", "joint", "Joint_10", "owner"),
        ("moved", "joint", "Joint_14", "owner"),
    }
    assert not {change for change in moved if change[1] == "body" and change[0] != "changed"}
