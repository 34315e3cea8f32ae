"""The three-way merge, edit by edit: the merged values, conflicts and refusals; no edit is lost."""

import re
from typing import Any

import pytest
from lxml import etree

from support.edits import Edit, add, all_of, drop, get, move, put
from support.mbs_models import everything
from support.merges import (
    canonical,
    check_one_side_alone,
    list_conflicts,
    merged,
    new_body_takes_a_joint,
    nothing,
    three,
)
from urdf2mbs.mbs.model import (
    Body,
    Connection,
    Drawing,
    Joint,
    Light,
    Mbs,
    Parameter,
    Point,
    Sensor,
    Shape,
    UserConstraint,
    UserModel,
)
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_edits.diff.changes import find_differences
from urdf2mbs_edits.merge.merge import merge

# a path, what people set, what the URDF sets, and who wins by "urdf", "edited" and None
FIELDS = [
    ("bodies.0.mass", 7.0, 9.0, "uee", True),
    ("bodies.0.com", (7.0, 0.0, 0.0), (9.0, 0.0, 0.0), "uee", True),
    ("bodies.0.joints.0.type", "T1", "T2", "uee", True),
    ("bodies.0.joints.0.q", 7.0, 9.0, "eee", False),
    ("bodies.0.joints.0.nature", "driven", "dependent", "eee", False),
    ("bodies.0.joints.1.symbols", ("qd",), ("qdd",), "eee", False),
    ("bodies.0.shapes.0.color", (7, 7, 7), (9, 9, 9), "eee", False),
    ("bodies.0.shapes.0.transparency", 0.75, 0.5, "eee", False),
    ("bodies.0.shapes.0.size", (7.0, 7.0, 7.0), (9.0, 9.0, 9.0), "uee", True),
    ("bodies.0.points.0.coordinates", (7.0, 0.0, 0.0), (9.0, 0.0, 0.0), "uee", True),
    ("bodies.0.points.0.sensor.measures", ("Pos",), ("Rot",), "eee", False),
    ("bodies.0.points.1.extforce.measures", ("Pos",), ("Rot",), "eee", False),
    ("view.background", (7, 7, 7), (9, 9, 9), "eee", False),
    ("view.frame", 7.0, 9.0, "eee", False),
    ("view.viewpoints.0.scale", 7.0, 9.0, "eee", False),
    ("view.lights.0.direction", (7.0, 0.0, 0.0), (9.0, 0.0, 0.0), "eee", False),
    ("user_variables.0.size", "7", "9", "eee", False),
    ("user_models.0.parameters.0.values", ("7.0",), ("9.0",), "uee", True),
    ("cuts.1.length", 7.0, 9.0, "uee", True),
    ("base.gravity", (0.0, 0.0, -7.0), (0.0, 0.0, -9.0), "uee", True),
    ("bodies.2.parent", "arm", None, "uee", True),
    ("bodies.1.point", None, "handle", "uee", True),
    ("cuts.0.endpoint1", ("leg", None), ("cart", None), "uee", True),
    ("links.0.endpoint2", ("leg", None), ("trunk", "handle"), "uee", True),
    ("user_constraints.0.joints", ("kick", "roll"), ("roll", "swing"), "uee", True),
    ("view.viewpoints.0.joint", "roll", "kick", "eee", False),
]


@pytest.mark.parametrize(("path", "mine", "theirs", "wins", "is_conflict"), FIELDS)
def test_who_wins_where_both_changed_a_value(
    path: str, mine: Any, theirs: Any, wins: str, is_conflict: bool
) -> None:
    """A change of one side is used; changes of both are a conflict, unless people set the field."""

    for side, value, edits in (
        ("kept", mine, (put(path, mine), nothing)),
        ("updated", theirs, (nothing, put(path, theirs))),
    ):
        result, plan = merged(*edits)
        assert get(result, path) == value
        assert not plan.plan.conflicts
        assert not plan.plan.orphaned
        changes = plan.plan.kept if side == "kept" else plan.plan.updated
        assert [change.field for change in changes] == [path.split(".")[-1]]
        assert not (plan.plan.updated if side == "kept" else plan.plan.kept)
    for prefer, winner in zip(("urdf", "edited", None), wins, strict=True):
        result, plan = merged(put(path, mine), put(path, theirs), prefer)
        assert get(result, path) == (mine if winner == "e" else theirs), prefer
        conflicts = plan.plan.conflicts
        assert [c.wins for c in conflicts] == (
            [{"u": "urdf", "e": "edited"}[winner]] if is_conflict or prefer is None else []
        )
    same, plan = merged(put(path, mine), put(path, mine))
    assert get(same, path) == mine
    assert not plan.plan.conflicts
    assert not plan.plan.kept
    assert not plan.plan.updated


def rename(old: str, new: str) -> Edit:
    """Rename a body, joint or point wherever it is named."""

    def edit(mbs: Mbs) -> None:
        text = write(mbs).decode().replace(f">{old}<", f">{new}<")
        again = read_mbs(text.encode(), "m.mbs")
        for field in mbs.__struct_fields__:
            setattr(mbs, field, getattr(again, field) if field != "origin" else mbs.origin)

    return edit


def no_leg(mbs: Mbs) -> None:
    """Remove the leg, and what needs it."""
    del mbs.bodies[2], mbs.cuts[1], mbs.links[1]
    mbs.user_constraints[0].joints = ("swing",)


ROPE = Connection("link", "rope", ("leg", None), (None, None))
EYE = Sensor("eye", ("Pos",))
BOX = Shape("box", "a_box", size=(7.0, 7.0, 7.0))
FOOT = Body("foot", "leg", None, [Joint("twist", "R3")])


def last(path: str) -> Edit:
    return lambda mbs: get(mbs, path).append(get(mbs, path).pop(0))


def swap(first: int, second: int) -> Edit:
    def edit(mbs: Mbs) -> None:
        joints = mbs.bodies[0].joints
        joints[first], joints[second] = joints[second], joints[first]

    return edit


def flip(mbs: Mbs) -> None:
    mbs.bodies[0].joints.reverse()


def sorted_anew(mbs: Mbs) -> None:
    mbs.bodies = mbs.depth_first()


def new_points(*names: str, x: float = 0.0, position: tuple[float, float] | None = None) -> Edit:
    return all_of(*(add("bodies.0.points", Point(name, (x, 0.0, 0.0), position)) for name in names))


def sensors(*names: str | None) -> Edit:
    """Give the points of the trunk and the arm sensors of these names."""

    def edit(mbs: Mbs) -> None:
        points = [*mbs.bodies[0].points, *mbs.bodies[1].points]
        existing = {point.sensor.name: point.sensor for point in points if point.sensor}
        for point, name in zip(points, names, strict=True):
            point.sensor = existing.get(name, Sensor(name)) if name else None

    return edit


def on_new_point(body: int) -> Edit:
    def edit(mbs: Mbs) -> None:
        on = mbs.bodies[body]
        on.points.append(Point("hook", (0.5, 0.0, 0.0)))
        mbs.bodies.append(Body("load", on.name, "hook", [Joint("swinging", "R2")]))
        mbs.bodies.append(Body("more", "load", None, [Joint("turning", "R2")]))
        mbs.links.append(Connection("link", "rope", ("more", None), (on.name, "hook")))
        mbs.bodies = mbs.depth_first()

    return edit


def light_of_nothing(mbs: Mbs) -> None:
    """A joint goes; the light behind it stays, and names nothing."""
    assert mbs.view is not None
    mbs.view.lights.append(Light("other", (0.0, 0.0, 1.0), "still"))


ARM_ON_LEG = all_of(
    put("bodies.1.parent", "leg"),
    put("bodies.1.point", None),
    lambda mbs: mbs.bodies.insert(2, mbs.bodies.pop(1)),
)
LEG_ON_ARM = all_of(put("bodies.2.parent", "arm"), put("bodies.2.point", "tip"))

# --- one side alone changed something ---

#: An edit of all versions, and the change of one side.
ONE_SIDE: dict[str, tuple[Edit, Edit]] = {
    "a sensor": (nothing, put("bodies.1.points.0.sensor", EYE)),
    "a sensor goes to another point": (
        nothing,
        all_of(
            lambda m: put("bodies.1.points.0.sensor", m.bodies[0].points[0].sensor)(m),
            put("bodies.0.points.0.sensor", None),
        ),
    ),
    "a link to what people renamed": (
        nothing,
        all_of(
            rename("leg", "stilt"),
            add("links", Connection("link", "rope", ("stilt", None), (None, None))),
        ),
    ),
    "a point is called as that of another body": (nothing, rename("handle", "tip")),
    "a joint is called as a body": (nothing, rename("kick", "leg")),
    "a point with its sensor, between others": (
        nothing,
        add("bodies.0.points", Point("new", sensor=EYE), 1),
    ),
    "a body": (nothing, add("bodies", FOOT)),
    "a body hangs elsewhere": (
        nothing,
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None)),
    ),
    "a joint goes to another body": (nothing, move("bodies.0.joints", "bodies.1.joints")),
    "another order": (nothing, flip),
    "another order and name": (nothing, all_of(rename("tilt", "lean"), flip)),
    "another order of points": (nothing, lambda m: m.bodies[0].points.reverse()),
    "a shape goes": (nothing, drop("bodies.0.shapes")),
    "a body goes with what needs it": (nothing, no_leg),
    "a parameter goes, and one comes": (
        nothing,
        lambda m: m.user_models[0].parameters.__setitem__(0, Parameter("new", "scalar", ("1",))),
    ),
    "the view goes": (nothing, put("view", None)),
    **{
        f"the sensors {names}": (nothing, sensors(*names))
        for names in (
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
        )
    },
    **{f"bodies on a new point of body {body}": (nothing, on_new_point(body)) for body in range(4)},
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


@pytest.mark.parametrize("case", ONE_SIDE)
def test_what_one_side_alone_changed_is_used_whichever_it_is(case: str) -> None:
    before, change = ONE_SIDE[case]
    model = everything()
    before(model)
    base = write(model)
    change(model)
    check_one_side_alone(base, write(model))
    if before is nothing:
        for sides in ((change, nothing), (nothing, change)):
            result, done = merged(*sides)
            assert result == read_mbs(write(model), "m.mbs")
            assert not list_conflicts(done)


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
            assert not list_conflicts(done)
            assert not find_differences(
                read_mbs(done.data, "m"), read_mbs(two.encode(), "m")
            ).changes
            assert canonical(etree.fromstring(done.data)) == canonical(etree.XML(two.encode()))
    # ours changes something beside it
    mine = changed.replace("<type>T3</type>", "<type>T1</type>", 1)
    done = three(changed.encode(), mine.encode(), base.encode())
    assert not list_conflicts(done)
    assert b"<type>T1</type>" in done.data
    assert not done.data.count(new.strip("<>").encode()) or not new


def test_what_nobody_knows_stays_in_a_value_that_the_other_side_changed() -> None:
    base = write(everything()).decode()
    ours = re.sub("<mass>(.*)</mass>", r'<mass unit="kg">\1</mass>', base, count=1)
    theirs = re.sub("<mass>.*</mass>", "<mass>9.0</mass>", base, count=1)
    for one, two in ((ours, theirs), (theirs, ours)):
        done = three(base.encode(), one.encode(), two.encode())
        assert not list_conflicts(done)
        assert b'<mass unit="kg">9.0</mass>' in done.data


# --- both sides changed something ---

#: What people do, what the URDF does; the outcome (?: the preferred side wins), and the merged
#: model if it is not that of the winner, or both changes, the URDF's first.
BOTH_SIDES: dict[str, tuple[Edit, Edit, str, Edit | None]] = {
    "two sensors of one point": (
        put("bodies.1.points.0.sensor", EYE),
        put("bodies.1.points.0.sensor", Sensor("other")),
        "refused: each put a sensor on point 'tip'",
        None,
    ),
    "two forces on one point": (
        put("bodies.1.points.0.extforce", EYE),
        put("bodies.1.points.0.extforce", Sensor("other")),
        "refused: each put a force on point 'tip'",
        None,
    ),
    "a link to what goes": (add("links", ROPE), no_leg, "refused: body 'leg'", None),
    "a link to a point that goes": (
        add("links", Connection("link", "rope", ("trunk", "handle"), (None, None))),
        drop("bodies.0.points", 1),
        "refused: point 'handle'",
        None,
    ),
    "a link to a point of the base that goes": (
        add("links", Connection("link", "rope", ("leg", None), (None, "rail"))),
        all_of(put("bodies.3.point", None), drop("cuts"), drop("base.points")),
        "refused: point 'rail'",
        None,
    ),
    "a constraint on what goes": (
        put("user_constraints.1.joints", ("kick",)),
        no_leg,
        "refused: joint 'kick'",
        None,
    ),
    "a light behind what goes": (
        add("view.lights", Light("mine", (0.0, 0.0, 1.0), "kick")),
        no_leg,
        "refused: joint 'kick'",
        None,
    ),
    "a value of what goes": (put("bodies.2.mass", 7.0), no_leg, "orphaned: body 'leg'", None),
    "a link to what the URDF renamed": (
        add("links", ROPE),
        rename("leg", "stilt"),
        "",
        all_of(add("links", ROPE), rename("leg", "stilt")),
    ),
    "names of both": (rename("leg", "mine"), rename("leg", "theirs"), "?", None),
    "one name for both": (rename("leg", "same"), rename("leg", "same"), "", None),
    "a name that the URDF gave another": (
        rename("kick", "taken"),
        rename("roll", "taken"),
        "refused: a joint the name 'taken'",
        None,
    ),
    "a point is called as another": (
        rename("handle", "new"),
        new_points("new"),
        "refused: a point the name 'new' in body 'trunk'",
        None,
    ),
    "a point of a name that the URDF took": (
        new_points("new", x=7.0),
        new_points("new", x=9.0),
        "refused: a point the name 'new' in body 'trunk'",
        None,
    ),
    "a point whose sensor has a name that the URDF took": (
        add("bodies.0.points", Point("new", sensor=EYE)),
        put("bodies.1.points.0.sensor", Sensor("eye")),
        "refused: a sensor the name 'eye'",
        None,
    ),
    "two shapes that are alike, of both": (
        all_of(add("bodies.0.shapes", BOX), add("bodies.0.shapes", BOX)),
        all_of(add("bodies.0.shapes", BOX), add("bodies.0.shapes", BOX)),
        "",
        all_of(add("bodies.0.shapes", BOX), add("bodies.0.shapes", BOX)),
    ),
    "a point of a name that is in another body": (
        add("bodies.1.points", Point("new")),
        new_points("new"),
        "",
        None,
    ),
    "the same from both, drawn elsewhere": (
        new_points("new", "newer", position=(7.0, 7.0)),
        new_points("new", "newer", position=(9.0, 9.0)),
        "",
        new_points("new", "newer", position=(7.0, 7.0)),
    ),
    "shapes of one name": (
        add("bodies.0.shapes", BOX),
        add("bodies.0.shapes", Shape("box", "a_box")),
        "",
        all_of(add("bodies.0.shapes", BOX), add("bodies.0.shapes", Shape("box", "a_box"))),
    ),
    "a body hangs on what stands behind it now": (
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None)),
        lambda m: m.bodies.insert(0, m.bodies.pop()),
        "",
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None), sorted_anew),
    ),
    "a body hangs on another body's point": (
        all_of(put("bodies.3.parent", "arm"), put("bodies.3.point", "tip")),
        put("bodies.3.point", None),
        "?",
        None,
    ),
    "a body whose joint has a name that the URDF took": (
        add("bodies", FOOT),
        rename("roll", "twist"),
        "refused: a joint the name 'twist'",
        None,
    ),
    "a body on what goes": (add("bodies", FOOT), no_leg, "refused: body 'leg'", None),
    "a joint goes to a new body": (
        new_body_takes_a_joint,
        put("bodies.0.joints.0.qd", 9.0),
        "",
        all_of(put("bodies.0.joints.0.qd", 9.0), new_body_takes_a_joint),
    ),
    "a joint goes two ways": (
        move("bodies.0.joints", "bodies.1.joints"),
        move("bodies.0.joints", "bodies.2.joints"),
        "?",
        None,
    ),
    "a joint goes to what goes": (
        move("bodies.0.joints", "bodies.2.joints"),
        no_leg,
        "refused: body 'leg'",
        None,
    ),
    "one order of both": (flip, flip, "", flip),
    "orders of both": (swap(0, 1), swap(1, 2), "?", None),
    "orders of both that go together": (
        swap(0, 1),
        swap(2, 3),
        "",
        all_of(swap(0, 1), swap(2, 3)),
    ),
    "one order of both, and more": (last("bodies.0.joints"), flip, "", flip),
    "another order, and one more": (
        flip,
        add("bodies.0.joints", Joint("new", "R1"), 1),
        "",
        all_of(flip, add("bodies.0.joints", Joint("new", "R1"))),
    ),
    "a shape goes that the URDF changed": (
        drop("bodies.0.shapes"),
        put("bodies.0.shapes.0.rotation", (9.0, 9.0, 9.0)),
        "?",
        None,
    ),
    "a shape goes that the URDF moved": (
        drop("bodies.0.shapes"),
        put("bodies.0.shapes.0.position", (9.0, 9.0, 9.0)),
        "?",
        None,
    ),
    "a camera goes that is elsewhere": (
        drop("view.viewpoints"),
        put("view.viewpoints.0.position", (9.0, 9.0, 9.0)),
        "",
        None,
    ),
    "a point goes that is drawn elsewhere": (
        drop("bodies.0.points", 1),
        put("bodies.0.points.1.position", (9.0, 9.0)),
        "",
        None,
    ),
    "a point goes whose sensor changed": (
        drop("bodies.0.points", 1),
        put("bodies.0.points.1.sensor.measures", ("Pos",)),
        "?",
        None,
    ),
    "a joint goes that only a parameter is called as": (
        no_leg,
        add("user_models.0.parameters", Parameter("kick", "scalar", ("1",))),
        "",
        None,
    ),
    "a body goes that the URDF needs now": (
        no_leg,
        add("links", ROPE),
        "refused: link 'rope' refers to body 'leg', which the edit removed",
        None,
    ),
    "new things at the ends of lists": (
        all_of(
            add("user_models", UserModel("Mine", [Parameter("gain", "scalar", ("1",))])),
            add("user_constraints", UserConstraint("mine", ("swing",))),
            add("view.lights", Light("mine", (0.0, 0.0, 1.0), "swing"), 0),
        ),
        add("user_models", UserModel("Theirs", [Parameter("gain", "scalar", ("1",))]), 0),
        "",
        None,
    ),
    "the view comes": (put("view.joint", 7.0), put("view", None), "orphaned: the view", None),
    "two sensors that go to one point": (
        sensors(None, "touch", "imu"),
        sensors("imu", "touch", "other"),
        "refused: each put a sensor on point 'tip'",
        None,
    ),
    "joints go, one from the edit and the others from the URDF": (
        drop("bodies.0.joints", 0),
        all_of(*[drop("bodies.0.joints", 1)] * 3),
        "refused: body 'trunk' lost all joints",
        None,
    ),
    "a joint goes to another body, and the URDF removes the others": (
        move("bodies.0.joints", "bodies.1.joints"),
        all_of(*[drop("bodies.0.joints", 1)] * 3),
        "refused: body 'trunk' lost all joints",
        None,
    ),
    "a joint goes, and the URDF moves the others": (
        drop("bodies.0.joints", 0),
        all_of(*[move("bodies.0.joints", "bodies.1.joints", 1)] * 3),
        "refused: body 'trunk' lost all joints",
        None,
    ),
    "the arm on the leg, and the leg on the arm": (
        ARM_ON_LEG,
        LEG_ON_ARM,
        "refused: bodies are attached in a circle: body '",
        None,
    ),
    "the leg on the arm, and the arm on the leg": (
        LEG_ON_ARM,
        ARM_ON_LEG,
        "refused: bodies are attached in a circle: body '",
        None,
    ),
}


@pytest.mark.parametrize(
    ("case", "prefer"),
    [
        (case, prefer)
        for case, (_, _, outcome, _) in BOTH_SIDES.items()
        for prefer in (("urdf", "edited") if outcome == "?" else ("urdf",))
    ],
)
def test_what_both_sides_changed_is_merged_decided_or_refused(case: str, prefer: str) -> None:
    mine, theirs, outcome, result_edit = BOTH_SIDES[case]
    if outcome.startswith("refused: "):
        with pytest.raises(ConversionError, match=outcome.removeprefix("refused: ")) as error:
            merged(mine, theirs, prefer)
        assert error.value.code == "merge-inconsistent"
        return
    expected = everything()
    if result_edit is not None:
        edits = [result_edit]
    elif not outcome:
        edits = [theirs, mine]
    else:
        edits = [mine if (outcome, prefer) == ("?", "edited") else theirs]
    for edit in edits:
        edit(expected)
    result, done = merged(mine, theirs, prefer)
    assert result == read_mbs(write(expected), "m.mbs")
    assert [conflict.wins for conflict in done.plan.conflicts] == [prefer] * (outcome == "?")
    assert [f"orphaned: {orphan.why}" for orphan in done.plan.orphaned] == [
        f"{outcome} was removed by the URDF"
    ] * outcome.startswith("orphaned")


@pytest.mark.parametrize(("prefer", "order"), [("urdf", "am"), ("edited", "ma"), (None, "ma")])
def test_which_of_two_new_joints_moves_the_other_is_for_people(prefer: Any, order: str) -> None:
    mine, theirs = (add("bodies.0.joints", Joint(name, "R1"), 1) for name in "ma")
    result, done = merged(mine, theirs, prefer)
    assert [joint.name for joint in result.bodies[0].joints][1:3] == list(order)
    assert len(done.plan.conflicts) == 1


def test_what_both_sides_add_at_one_place_has_one_order_whoever_is_ours() -> None:
    first, second = (add("bodies.0.points", Point(name, (1.0, 0.0, 0.0))) for name in "ab")
    results = [merged(mine, theirs, None)[0] for mine, theirs in ((first, second), (second, first))]
    for result in results:
        assert [point.name for point in result.bodies[0].points][2:] == ["a", "b"]


def test_the_diagram_stays_as_people_have_it() -> None:
    """A new body is as far from the body that carries it as the new layout puts it."""

    def drawn(mbs: Mbs, x: float) -> Mbs:
        for joint in mbs.joints().values():
            joint.position = (x, 2.0 * x)
        return mbs

    base, edited, new = drawn(everything(), 30.0), drawn(everything(), 30.0), everything()
    edited.bodies[0].joints[3].position = (530.0, 60.0)
    twist = Joint("twist", "R3")
    new.bodies.append(Body("foot", "leg", None, [twist], drawing=Drawing()))
    sides = [read_mbs(write(mbs), "m.mbs") for mbs in (base, edited)]
    drawn(new, 130.0)
    twist.position = (190.0, 280.0)
    joints = read_mbs(merge(*sides, new).data, "m.mbs").joints()
    assert joints["kick"].position == (30.0, 60.0)
    assert joints["still"].position == (530.0, 60.0)
    assert joints["twist"].position == (90.0, 80.0)


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
    assert not list_conflicts(done)
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
    assert not list_conflicts(done)


def test_a_new_body_that_loses_its_joint_in_a_conflict_is_refused() -> None:
    theirs = move("bodies.0.joints", "bodies.1.joints")
    with pytest.raises(ConversionError, match="body 'foot' lost all joints"):
        merged(new_body_takes_a_joint, theirs, "urdf")
    result, done = merged(new_body_takes_a_joint, theirs, "edited")
    assert [joint.name for joint in result.bodies[-1].joints] == ["lift"]
    assert [conflict.wins for conflict in done.plan.conflicts] == ["edited"]
