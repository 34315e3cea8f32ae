"""The three-way merge, edit by edit: the merged values, conflicts and refusals."""

from typing import Any

import pytest

from support.edits import Edit, add, all_of, drop, get, move, put
from support.mbs_models import everything
from support.merges import merged, new_body_takes_a_joint, nothing
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


# what people do, what the URDF does; the outcome (?: the preferred side wins), and the merged model
# if it is not that of the winner, or both changes, the URDF's first
CASES: dict[str, tuple[Edit, Edit, str, Edit | None]] = {
    "a sensor": (put("bodies.1.points.0.sensor", EYE), nothing, "", None),
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
    "a sensor goes to another point": (
        all_of(
            lambda m: put("bodies.1.points.0.sensor", m.bodies[0].points[0].sensor)(m),
            put("bodies.0.points.0.sensor", None),
        ),
        nothing,
        "",
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
    "a link to what people renamed": (
        all_of(
            rename("leg", "stilt"),
            add("links", Connection("link", "rope", ("stilt", None), (None, None))),
        ),
        nothing,
        "",
        None,
    ),
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
    "a point is called as that of another body": (rename("handle", "tip"), nothing, "", None),
    "a point is called as another": (
        rename("handle", "new"),
        new_points("new"),
        "refused: a point the name 'new' in body 'trunk'",
        None,
    ),
    "a joint is called as a body": (rename("kick", "leg"), nothing, "", None),
    "a point with its sensor, between others": (
        add("bodies.0.points", Point("new", sensor=EYE), 1),
        nothing,
        "",
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
    "a body": (add("bodies", FOOT), nothing, "", None),
    "a body hangs on what stands behind it now": (
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None)),
        lambda m: m.bodies.insert(0, m.bodies.pop()),
        "",
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None), sorted_anew),
    ),
    "a body hangs elsewhere": (
        all_of(put("bodies.3.parent", "leg"), put("bodies.3.point", None)),
        nothing,
        "",
        None,
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
    "a joint goes to another body": (
        move("bodies.0.joints", "bodies.1.joints"),
        nothing,
        "",
        None,
    ),
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
    "another order": (flip, nothing, "", None),
    "another order and name": (all_of(rename("tilt", "lean"), flip), nothing, "", None),
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
    "another order of points": (
        lambda m: m.bodies[0].points.reverse(),
        nothing,
        "",
        None,
    ),
    "a shape goes": (drop("bodies.0.shapes"), nothing, "", None),
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
    "a body goes with what needs it": (no_leg, nothing, "", None),
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
    "a parameter goes, and one comes": (
        lambda m: m.user_models[0].parameters.__setitem__(0, Parameter("new", "scalar", ("1",))),
        nothing,
        "",
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
    "the view goes": (put("view", None), nothing, "", None),
    "the view comes": (put("view.joint", 7.0), put("view", None), "orphaned: the view", None),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("prefer", ["urdf", "edited"])
def test_what_comes_goes_and_moves(case: str, prefer: str) -> None:
    mine, theirs, outcome, result_edit = CASES[case]
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
