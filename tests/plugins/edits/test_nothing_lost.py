"""No edit is lost, and nothing is a conflict where only one side changed something."""

import re
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from support.edits import Edit, add, all_of, drop, move, put
from support.mbs_models import everything
from support.merges import (
    SAMPLES,
    canonical,
    check_one_side_alone,
    merged,
    new_body_takes_a_joint,
    nothing,
    three,
)
from urdf2mbs.mbs.model import Body, Connection, Drawing, Joint, Light, Mbs, Point, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_edits.diff.changes import find_differences
from urdf2mbs_edits.merge.merge import Merged

PAIRS = [
    pair for pair in combinations(SAMPLES, 2) if len({f.name.split(".")[0] for f in pair}) == 1
]


def check_says_nothing(done: Merged) -> None:
    assert not done.plan.conflicts, done.plan
    assert not done.plan.orphaned, done.plan


# --- sensors and forces that change places ---


def sensors(*names: str | None) -> Edit:
    """Give the points of the trunk and the arm sensors of these names."""

    def edit(mbs: Mbs) -> None:
        points = [*mbs.bodies[0].points, *mbs.bodies[1].points]
        existing = {point.sensor.name: point.sensor for point in points if point.sensor}
        for point, name in zip(points, names, strict=True):
            point.sensor = existing.get(name, Sensor(name)) if name else None

    return edit


@pytest.mark.parametrize(
    "names",
    [
        ("touch", "imu", None),
        (None, "imu", "touch"),
        ("touch", None, None),
        (None, "imu", None),
        ("touch", None, "imu"),
        ("new", "imu", "touch"),
        ("new", "touch", None),
        ("touch", "new", "imu"),
        (None, None, "imu"),
        (None, "new", "imu"),
    ],
)
@pytest.mark.parametrize("prefer", ["urdf", "edited", None])
def test_sensors_that_change_places_are_all_there(
    names: tuple[str | None, ...], prefer: Any
) -> None:
    expected = everything()
    sensors(*names)(expected)
    for mine, theirs in ((sensors(*names), nothing), (nothing, sensors(*names))):
        result, done = merged(mine, theirs, prefer)
        assert result == read_mbs(write(expected), "m.mbs")
        check_says_nothing(done)


def test_two_sensors_on_one_point_are_refused() -> None:
    with pytest.raises(ConversionError, match="each put a sensor on point 'tip'"):
        merged(sensors(None, "touch", "imu"), sensors("imu", "touch", "other"))


# --- what both sides added under one name ---


def both_add(parent: str, end: str, *more: Point, mass: float = 1.0) -> Edit:
    hook = Point("hook", (0.0, 0.0, 1.0))
    load = Body("load", parent, None, [Joint("swinging", "R2")], mass, points=[hook, *more])
    rope = Connection("link", "rope", ("arm", "tip"), (end, None))
    return all_of(add("bodies", load), add("links", rope))


@pytest.mark.parametrize("prefer", ["urdf", "edited", None])
def test_what_both_sides_added_is_one_or_refused(prefer: Any) -> None:
    theirs = both_add("trunk", "leg")
    result, done = merged(theirs, theirs, prefer)
    assert not done.plan.updated
    check_says_nothing(done)
    # the edit attached it elsewhere
    with pytest.raises(ConversionError, match="each gave a link the name 'rope'") as error:
        merged(both_add("leg", "cart"), theirs, prefer)
    assert any("a body the name 'load'" in problem.message for problem in error.value.earlier)
    # ours has more in it
    eye = Point("eye", (0.0, 0.0, 2.0), sensor=Sensor("looking", ("Pos",)))
    result, done = merged(both_add("trunk", "leg", eye), theirs, prefer)
    assert [[p.name for p in b.points] for b in result.bodies if b.name == "load"] == [
        ["hook", "eye"]
    ]
    assert b'"looking"' in done.data
    check_says_nothing(done)


# --- joints: no body is without ---


@pytest.mark.parametrize("prefer", ["urdf", "edited", None])
@pytest.mark.parametrize(
    ("mine", "theirs"),
    [
        (drop("bodies.0.joints", 0), all_of(*[drop("bodies.0.joints", 1)] * 3)),
        (move("bodies.0.joints", "bodies.1.joints"), all_of(*[drop("bodies.0.joints", 1)] * 3)),
        (drop("bodies.0.joints", 0), all_of(*[move("bodies.0.joints", "bodies.1.joints", 1)] * 3)),
    ],
)
def test_a_body_that_would_lose_all_joints_is_refused(
    mine: Edit, theirs: Edit, prefer: Any
) -> None:
    with pytest.raises(ConversionError, match="body 'trunk' lost all joints"):
        merged(mine, theirs, prefer)


def test_a_new_body_that_loses_its_joint_in_a_conflict_is_refused() -> None:
    theirs = move("bodies.0.joints", "bodies.1.joints")
    with pytest.raises(ConversionError, match="body 'foot' lost all joints"):
        merged(new_body_takes_a_joint, theirs, "urdf")
    result, done = merged(new_body_takes_a_joint, theirs, "edited")
    assert [joint.name for joint in result.bodies[-1].joints] == ["lift"]
    assert [conflict.wins for conflict in done.plan.conflicts] == ["edited"]


@pytest.mark.parametrize("prefer", ["urdf", "edited", None])
def test_bodies_that_would_be_attached_in_a_circle_are_refused(prefer: Any) -> None:
    arm_on_leg = all_of(
        put("bodies.1.parent", "leg"),
        put("bodies.1.point", None),
        lambda mbs: mbs.bodies.insert(2, mbs.bodies.pop(1)),
    )
    leg_on_arm = all_of(put("bodies.2.parent", "arm"), put("bodies.2.point", "tip"))
    for mine, theirs in ((arm_on_leg, leg_on_arm), (leg_on_arm, arm_on_leg)):
        with pytest.raises(ConversionError, match="bodies are attached in a circle: body '"):
            merged(mine, theirs, prefer)


# --- bodies on points that are new ---


def on_new_point(body: int) -> Edit:
    def edit(mbs: Mbs) -> None:
        on = mbs.bodies[body]
        on.points.append(Point("hook", (0.5, 0.0, 0.0)))
        mbs.bodies.append(Body("load", on.name, "hook", [Joint("swinging", "R2")]))
        mbs.bodies.append(Body("more", "load", None, [Joint("turning", "R2")]))
        mbs.links.append(Connection("link", "rope", ("more", None), (on.name, "hook")))
        mbs.bodies = mbs.depth_first()

    return edit


@pytest.mark.parametrize("body", [0, 1, 2, 3])
@pytest.mark.parametrize("prefer", ["urdf", None])
def test_a_body_on_a_new_point_of_a_body_that_was_there(body: int, prefer: Any) -> None:
    expected = everything()
    on_new_point(body)(expected)
    for mine, theirs in ((on_new_point(body), nothing), (nothing, on_new_point(body))):
        result, done = merged(mine, theirs, prefer)
        assert {b.name: b for b in result.bodies} == {
            b.name: b for b in read_mbs(write(expected), "m.mbs").bodies
        }
        check_says_nothing(done)


# --- what one side alone changed ---


def light_of_nothing(mbs: Mbs) -> None:
    """A joint goes; the light behind it stays, and names nothing."""
    assert mbs.view is not None
    mbs.view.lights.append(Light("other", (0.0, 0.0, 1.0), "still"))


ALONE: dict[str, tuple[Edit, Edit]] = {
    "an end is chosen": (
        put("cuts.0.endpoint1", ("", "origin")),
        put("cuts.0.endpoint1", ("arm", "tip")),
    ),
    "an end is chosen no more": (nothing, put("cuts.0.endpoint1", ("", "origin"))),
    "an end of a body and no point": (nothing, put("cuts.0.endpoint1", ("arm", ""))),
    "a joint goes, its light stays": (light_of_nothing, drop("bodies.0.joints", 3)),
    "a joint goes, and comes on another body": (
        nothing,
        move("bodies.0.joints", "bodies.1.joints", 3),
    ),
    "a light behind nothing": (nothing, put("view.lights.0.joint", "nobody")),
    "no drawing": (nothing, put("bodies.0.drawing", None)),
    "a drawing": (put("bodies.0.drawing", None), put("bodies.0.drawing", Drawing((3.0, 4.0)))),
    "no place": (nothing, put("bodies.0.joints.0.position", None)),
    "a place": (
        put("bodies.0.joints.0.position", None),
        put("bodies.0.joints.0.position", (4.0, 5.0)),
    ),
    "the base has no place": (
        nothing,
        all_of(put("base.position", None), put("base.drawing", None)),
    ),
    "the base has a place": (
        all_of(put("base.position", None), put("base.drawing", None)),
        all_of(put("base.position", (4.0, 5.0)), put("base.drawing", Drawing((3.0, 4.0)))),
    ),
    "a point on the base": (nothing, add("base.points", Point("new"))),
}


@pytest.mark.parametrize("case", ALONE)
def test_what_one_side_changed_is_no_conflict(case: str) -> None:
    before, change = ALONE[case]
    model = everything()
    before(model)
    base = write(model)
    change(model)
    changed = write(model)
    for ours, theirs in ((base, changed), (changed, base), (changed, changed)):
        done = three(base, ours, theirs)
        check_says_nothing(done)
        assert not find_differences(read_mbs(done.data, "m"), read_mbs(changed, "m")).changes
        if ours == changed:
            assert done.data == ours


UNKNOWN = [
    ("<x3D_points/>", ""),
    ("<x3D_com/>", ""),
    ("<x3D_com/>", "<x3D_com/>\n          <hide_inertial_frame/>"),
    ("<x3D_com/>", "<x3D_com size='2'/>"),
    ("<mass>", "<mass unit='g'>"),
    ("</joint>", "<brake><force>1.50</force></brake>\n      </joint>"),
    ("<user_models>", "<user_models>\n    <mine/>\n    <mine><b>2</b></mine>"),
    ("<base>", "<base note='1'>"),
]


@pytest.mark.parametrize(("old", "new"), UNKNOWN)
def test_what_nobody_knows_goes_along_if_ours_did_not_change_it(old: str, new: str) -> None:
    base = write(everything()).decode()
    assert old in base
    changed = base.replace(old, new, 1)
    for one, two in ((base, changed), (changed, base)):
        for ours, theirs in ((one, two), (two, one)):
            done = three(one.encode(), ours.encode(), theirs.encode())
            check_says_nothing(done)
            assert not find_differences(
                read_mbs(done.data, "m"), read_mbs(two.encode(), "m")
            ).changes
            assert canonical(etree.fromstring(done.data)) == canonical(etree.XML(two.encode()))
    # ours changes something beside it
    mine = changed.replace("<type>T3</type>", "<type>T1</type>", 1)
    done = three(changed.encode(), mine.encode(), base.encode())
    check_says_nothing(done)
    assert b"<type>T1</type>" in done.data
    assert not done.data.count(new.strip("<>").encode()) or not new


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


def test_what_nobody_knows_stays_in_a_value_that_the_other_side_changed() -> None:
    base = write(everything()).decode()
    ours = re.sub("<mass>(.*)</mass>", r'<mass unit="kg">\1</mass>', base, count=1)
    theirs = re.sub("<mass>.*</mass>", "<mass>9.0</mass>", base, count=1)
    for one, two in ((ours, theirs), (theirs, ours)):
        done = three(base.encode(), one.encode(), two.encode())
        check_says_nothing(done)
        assert b'<mass unit="kg">9.0</mass>' in done.data
