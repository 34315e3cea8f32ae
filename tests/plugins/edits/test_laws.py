"""The laws of the merge, on any models: one side alone wins, edits of both add up, none is lost."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import SHARED
from mbs.models import everything, few, models
from urdf2mbs.mbs import model as m
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.changes import differences
from urdf2mbs_edits.diff.flat import things
from urdf2mbs_edits.merge.merge import Merged, merge

SAMPLES = sorted((SHARED / "mbs-samples").glob("*.mbs"))

# --- edits of any model; one that finds nothing to change does nothing ---


def new(random: Random, word: str) -> str:
    return f"{word}_{random.randrange(10**6)}"


def vector(random: Random) -> Any:
    return tuple(random.randrange(-40, 40) / 8 for _ in range(3))


def some(random: Random, parts: Iterable[Any]) -> Any:
    parts = list(parts)
    return random.choice(parts) if parts else None


def joints(mbs: m.Mbs) -> list[m.Joint]:
    return [joint for body in mbs.bodies for joint in body.joints]


def a_value(mbs: m.Mbs, random: Random) -> None:
    """Another number for something that has one."""
    owners: list[Any] = [*mbs.bodies, mbs.base]
    found = [(body, field) for body in mbs.bodies for field in ("mass", "com")]
    found += [(p, "coordinates") for o in owners for p in o.points if p.name != "origin"]
    found += [
        (shape, field) for o in owners for shape in o.shapes for field in ("rotation", "scale")
    ]
    found += [(joint, field) for joint in joints(mbs) for field in ("q", "qd")]
    found += [(mbs.base, "gravity")]
    part, field = random.choice(found)
    value = vector(random)
    setattr(part, field, value if field not in ("mass", "q", "qd") else value[0])


def a_word(mbs: m.Mbs, random: Random) -> None:
    joint = some(random, joints(mbs))
    if joint:
        joint.type = random.choice(["R1", "R2", "R3", "T1", "T2", "T3"])
        joint.nature = random.choice(["independent", "dependent", "driven"])


def a_place(mbs: m.Mbs, random: Random) -> None:
    for joint in joints(mbs)[: random.randrange(3)]:
        joint.position = (float(random.randrange(900)), float(random.randrange(900)))


def body_on_a_new_point(mbs: m.Mbs, random: Random) -> None:
    on = some(random, mbs.bodies) or mbs.base
    point = m.Point(new(random, "hook"), vector(random))
    on.points.append(point)
    parent = on.name if isinstance(on, m.Body) else None
    joint, body = (new(random, word) for word in ("turn", "load"))
    mbs.bodies.append(m.Body(body, parent, point.name, [m.Joint(joint, "R2")], 1.5))
    mbs.links.append(m.Connection("link", new(random, "rope"), (body, None), (parent, point.name)))


def a_point(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body:
        point = m.Point(new(random, "eye"), vector(random))
        setattr(
            point, random.choice(["sensor", "extforce"]), m.Sensor(new(random, "feel"), ("Pos",))
        )
        body.points.insert(random.randrange(len(body.points) + 1), point)


def a_joint(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body:
        place = random.randrange(len(body.joints) + 1)
        body.joints.insert(place, m.Joint(new(random, "slide"), "T2"))


def a_shape(mbs: m.Mbs, random: Random) -> None:
    shape = m.Shape("box", "New_Shape", size=vector(random))
    (some(random, mbs.bodies) or mbs.base).shapes.append(shape)


def a_model(mbs: m.Mbs, random: Random) -> None:
    parameter = m.Parameter(new(random, "gain"), "scalar", ("0.5",))
    own = some(random, mbs.user_models)
    if own and random.random() < 0.5:
        own.parameters.append(parameter)
    else:
        mbs.user_models.append(m.UserModel(new(random, "Mine"), [parameter]))
    mbs.user_variables.append(m.UserVariable(new(random, "mine"), "in", "3"))
    if mbs.view is not None:
        light = m.Light(new(random, "lamp"), vector(random))
        mbs.view.lights.append(light)


def a_cut(mbs: m.Mbs, random: Random) -> None:
    one, two = (some(random, [None, *mbs.bodies]) for _ in range(2))
    ends = [(body.name, None) if body else (None, None) for body in (one, two)]
    mbs.cuts.append(m.Connection("rod", new(random, "rod"), *ends, 1.5))


def no_thing(mbs: m.Mbs, random: Random) -> None:
    """A thing goes, of those that nothing needs."""
    ends = [end for c in (*mbs.cuts, *mbs.links) for end in (c.endpoint1, c.endpoint2)]
    used = {body.place for body in mbs.bodies} | {*ends}
    concerned = {name for constraint in mbs.user_constraints for name in constraint.joints}
    concerned |= {light.joint for light in (mbs.view.lights if mbs.view else [])}
    concerned |= {eye.joint for eye in (mbs.view.viewpoints if mbs.view else [])}
    lists: list[tuple[list[Any], Any]] = []
    for body in mbs.bodies:
        lists += [(body.points, p) for p in body.points if (body.name, p.name) not in used]
        lists += [(body.shapes, shape) for shape in body.shapes]
        if len(body.joints) > 1:
            lists += [(body.joints, joint) for joint in body.joints if joint.name not in concerned]
        names = {joint.name for joint in body.joints}
        if body.name not in {place[0] for place in used} and not names & concerned:
            lists.append((mbs.bodies, body))
    for parts in (mbs.cuts, mbs.links, mbs.user_models, mbs.user_variables):
        lists += [(parts, part) for part in parts]
    if lists:
        parts, part = random.choice(lists)
        parts[:] = [one for one in parts if one is not part]


def sensors_change_places(mbs: m.Mbs, random: Random) -> None:
    points = [point for body in mbs.bodies for point in body.points]
    if len(points) > 1:
        one, two = random.sample(points, 2)
        field = random.choice(["sensor", "extforce"])
        here, there = getattr(one, field), getattr(two, field)
        setattr(one, field, there)
        setattr(two, field, here)


def joint_moves(mbs: m.Mbs, random: Random) -> None:
    body = some(random, [body for body in mbs.bodies if len(body.joints) > 1])
    if body:
        joint = body.joints.pop(random.randrange(len(body.joints)))
        other = random.choice(mbs.bodies)
        other.joints.insert(random.randrange(len(other.joints) + 1), joint)


def body_hangs_elsewhere(mbs: m.Mbs, random: Random) -> None:
    body = some(random, mbs.bodies)
    if body is None:
        return
    below = {body.name}
    for other in mbs.bodies:
        below |= {other.name} if other.parent in below else set()
    on = random.choice([mbs.base, *[b for b in mbs.bodies if b.name not in below]])
    body.parent = on.name if isinstance(on, m.Body) else None
    body.point = random.choice([None, *[p.name for p in on.points if p.name != "origin"]])
    mbs.bodies = mbs.depth_first()


def order(mbs: m.Mbs, random: Random) -> None:
    lists = [mbs.cuts, mbs.links, mbs.user_models]
    lists += [parts for b in mbs.bodies for parts in (b.joints, b.points, b.shapes)]
    parts: Any = some(random, [parts for parts in lists if len(parts) > 1])
    if parts:
        parts.insert(random.randrange(len(parts)), parts.pop(random.randrange(len(parts))))


def rename(mbs: m.Mbs, random: Random) -> None:
    """Call a body, joint or point otherwise wherever it is named."""
    found = things(mbs)
    thing = some(random, [t for t in found if t.kind in ("body", "joint", "sensor", "point")])
    if thing is None or thing.name == "origin":
        return
    name = new(random, "other")
    for other in found:
        for field, targets in other.refers.items():
            names = [
                name if target is thing else None if target is None or target.kind == "base"
                else target.name for target in targets if not isinstance(target, str)
            ]  # fmt: skip
            if thing in targets and len(names) == len(targets):
                one = field in ("joint", "name")
                setattr(other.part, field, names[0] if one else tuple(names))
    thing.part.name = name


EDITS: list[Callable[[m.Mbs, Random], None]] = [
    a_value, a_word, a_place, body_on_a_new_point, a_point, a_joint, a_shape, a_model, a_cut,
    no_thing, sensors_change_places, joint_moves, body_hangs_elsewhere, order, rename,
]  # fmt: skip


def edited(data: bytes, random: Random, count: int) -> bytes:
    """A file with some edits, and with elements that nobody knows."""
    mbs = read(data, "base")
    for edit in random.choices(EDITS, k=count):
        edit(mbs, random)
    made = write(mbs)
    if random.random() < 0.3:
        places = [found.end() for found in re.finditer(rb"</jointname>|</bodyname>", made)]
        if places:
            at = random.choice(places)
            made = made[:at] + b"<brake><force>%d</force></brake>" % random.randrange(9) + made[at:]
    return made


def three(base: bytes, ours: bytes, theirs: bytes) -> Merged:
    return merge(read(base, "base"), read(ours, "ours"), read(theirs, "theirs"), None)


def differ(one: bytes, two: bytes) -> list[Any]:
    return differences(read(one, "one"), read(two, "two")).changes


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
    names = [{(t.kind, t.name) for t in things(read(d, "m"))} for d in (base, ours, theirs)]
    results = three(base, ours, theirs), three(base, theirs, ours)
    for done in results:
        there = {(thing.kind, thing.name) for thing in things(read(done.data, "m"))}
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


@settings(few, max_examples=12)
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
