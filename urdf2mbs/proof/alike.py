"""Two .mbs files, or two URDFs: are they the same robot?

Both become rigid groups, and these are compared as those of a URDF and an .mbs are: a model may
have its bodies and frames as it likes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from urdf2mbs.diff.changes import differences
from urdf2mbs.diff.matching import Matching, Thing
from urdf2mbs.diff.words import line
from urdf2mbs.mbs.model import Joint, LinkFrame, Mbs
from urdf2mbs.messages.diagnostics import counted
from urdf2mbs.proof.comparing import Comparing
from urdf2mbs.proof.mbs_side import mbs_side
from urdf2mbs.proof.parameters import STATED, left_out, stated
from urdf2mbs.proof.rigid import Frame, compose, distance, most, moved
from urdf2mbs.proof.urdf_side import SIX, own_coordinates, urdf_side
from urdf2mbs.proof.verdict import Difference, Proof
from urdf2mbs.spatial import Pose
from urdf2mbs.urdf.model import Robot


def compare_models(first: Mbs, second: Mbs, tolerance: float, called: tuple[str, str]) -> Proof:
    """Compare two .mbs files: motion, inertias, natures, cuts, where links and forces act, and
    the numbers of user models; ``called`` is how messages call the two."""
    matching = Matching(first, second)
    names: dict[str, str] = {}
    problems = list(_joints(matching, names, called))
    comparing = Comparing(
        mbs_side(first, set(names)), mbs_side(second, set(names.values())), names, tolerance,
        called=(*called, "body"),
    )  # fmt: skip
    comparing.compare(problems)
    but_for: dict[str, str] = {}
    comparing.found += _connections(matching, comparing, but_for)
    for change in differences(first, second, physics=True).changes:
        kinds: tuple[str, ...] = ("parameter", "user model", "user constraint")
        if change.change in ("added", "removed"):
            kinds += ("cut", "link", "force")
        if change.kind in kinds and change.change != "reordered":
            kind = "parameter" if change.kind == "user model" else change.kind
            comparing.found.append(Difference(kind, line(change)))
    not_compared = left_out(second, [model.name for model in second.user_models], set())
    not_compared |= left_out(first, [model.name for model in first.user_models], set())
    sensors = [thing for thing in matching.before if thing.kind == "sensor"]
    if sensors:
        not_compared[counted(len(sensors), "sensor")] = "they do not move the robot"
    return comparing.proof(but_for, not_compared)


def _joints(
    matching: Matching, names: dict[str, str], called: tuple[str, str]
) -> Iterator[Difference]:
    """The differences of the joints; fills ``names`` with those that move in both models."""
    for old, new in matching.pairs():
        if old.kind != "joint":
            continue
        ours, theirs = old.part, new.part
        natures = (ours.nature, theirs.nature)
        if natures == ("driven", "driven"):
            if (ours.qd or 0.0, ours.qdd or 0.0) != (theirs.qd or 0.0, theirs.qdd or 0.0):
                yield _difference("symbols", old, "is driven at another speed", called)
        elif "driven" in natures:
            yield _difference(
                "nature", old, f"is {natures[1]} in {called[1]}, and {natures[0]} in", called
            )
        elif ours.type[0] != theirs.type[0]:
            yield _difference("type", old, f"is {theirs.type} in {called[1]}, and {ours.type} in",
                              called)  # fmt: skip
        else:
            names[ours.name] = theirs.name
            if natures[0] != natures[1]:
                said = f"is {natures[1]} in {called[1]}, and {natures[0]} in"
                yield _difference("nature", old, said, called)
        if "driven" not in natures and _symbols(ours) != _symbols(theirs):
            yield _difference("symbols", old, "has other <symbols> than in", called)
    for things, here in ((matching.removed(), called[0]), (matching.added(), called[1])):
        for thing in things:
            if thing.kind == "joint" and thing.part.nature != "driven":
                said = f"joint '{thing.name}' moves in {here} only"
                kind = "joint-missing" if here == called[0] else "joint-extra"
                yield Difference(kind, said, joint=thing.name)


def _difference(kind: str, joint: Thing, said: str, called: tuple[str, str]) -> Difference:
    return Difference(kind, f"joint '{joint.name}' {said} {called[0]}", joint=joint.name)


def _symbols(joint: Joint) -> set[str]:
    return {"q", "qd", "qdd"} if joint.symbols is None else set(joint.symbols)


def _connections(
    matching: Matching, comparing: Comparing, but_for: dict[str, str]
) -> Iterator[Difference]:
    """The cuts, links and forces whose ends are at other places or groups; ends that are only
    exchanged go into ``but_for``."""
    scale = max(comparing.scales)
    for old, new in matching.pairs():
        if old.kind not in ("cut", "link", "force"):
            continue
        if old.kind != "force":
            if old.part.kind != new.part.kind:
                said = f"{old.kind} '{old.name}' is a {new.part.kind}, and should be a "
                yield Difference(old.kind, said + old.part.kind)
            length = most((old.part.length or 0.0,), (new.part.length or 0.0,), scale)
            if not length <= comparing.tolerance:
                yield Difference(old.kind, f"{old.kind} '{old.name}' has another length", length)
        ours, theirs = _ends(old, comparing, second=False), _ends(new, comparing, second=True)
        problems = list(_ends_apart(old, ours, theirs, comparing))
        if problems and any(_ends_apart(old, ours, theirs[::-1], comparing)):
            yield from problems
        elif problems:
            but_for[f"{old.kind} '{old.name}'"] = "its ends are exchanged, and so is its sign"


def _ends(thing: Thing, comparing: Comparing, *, second: bool) -> list[tuple[int, Frame] | None]:
    """The group of the second model that each end is in, and its pose there; None in a draft."""
    if thing.kind == "force":
        ends: list[Any] = [(thing.owner and thing.owner.owner, thing.owner)]
    else:
        ends = [thing.refers["endpoint1"], thing.refers["endpoint2"]]
    places: list[tuple[int, Frame] | None] = []
    for body, point in ends:
        if not isinstance(body, Thing) or isinstance(point, str):
            places.append(None)
            continue
        side = comparing.two if second else comparing.one
        group, at = side.frames[body.name if body.kind == "body" else ""]
        if point is not None:
            at = (*at[:9], *moved(at, point.part.coordinates))
        if not second:
            group, at = comparing.pairs[group], compose(comparing.apart[group], at)
        places.append((group, at))
    return places


def _ends_apart(
    thing: Thing, ours: list[tuple[int, Frame] | None], theirs: list[tuple[int, Frame] | None],
    comparing: Comparing,
) -> Iterator[Difference]:  # fmt: skip
    """The differences between the ends of two connections, end by end."""
    who, scale = f"{thing.kind} '{thing.name}'", max(comparing.scales)
    solid = thing.kind == "cut" and thing.part.kind == "solid"
    for here, there in zip(ours, theirs, strict=True):
        if here is None or there is None:
            if here != there:
                yield Difference(thing.kind, f"{who} has an end on no body")
        elif here[0] != there[0]:
            yield Difference(thing.kind, f"{who} is on another body in {comparing.called[1]}")
        else:
            a, b = here[1], there[1]
            off = distance(a, b, scale) if solid else most(a[9:], b[9:], scale)
            if not off <= comparing.tolerance:
                said = f"{who} has an end {off * scale:.3g} m elsewhere"
                yield Difference(thing.kind, said, off)


def compare_robots(
    first: Robot, second: Robot, joints: dict[str, str], tolerance: float, called: tuple[str, str]
) -> Proof:
    """Compare two URDFs: motion, inertias, followers, limits, damping, friction, controllers, and
    the frames of links; ``joints`` maps those that are called otherwise in the second."""
    names: dict[str, str] = {}
    problems: list[Difference] = []
    expected = {joints.get(name, name): name for name in first.joints}
    for joint in first.joints.values():
        other = second.joints.get(joints.get(joint.name, joint.name))
        ours = own_coordinates(joint, SIX) if joint.moves else []
        theirs = own_coordinates(other, SIX) if other is not None and other.moves else []
        where: dict[str, Any] = {"link": joint.child, "joint": joint.name}
        if [kind for _, kind in ours] != [kind for _, kind in theirs]:
            kinds = f"{joint.type} in {called[0]}, and "
            kinds += f"{other.type} in {called[1]}" if other else f"not in {called[1]}"
            problems.append(Difference("type", f"joint '{joint.name}' is {kinds}", **where))
            continue
        names |= {own: name for (own, _), (name, _) in zip(ours, theirs, strict=True)}
        if other is None or not joint.moves:
            continue
        if joint.mimic != other.mimic:
            problems.append(
                Difference("mimic", f"joint '{joint.name}' has another <mimic>", **where)
            )
        here, there = stated(joint), stated(other)
        problems += [
            Difference(
                "parameter", f"joint '{joint.name}': {kind} is {there.get(kind, 'not stated')}, "
                f"and should be {here.get(kind, 'not stated')}", **where,
            )
            for kind in STATED
            if here.get(kind) != there.get(kind)
        ]  # fmt: skip
    for joint in second.joints.values():
        if joint.moves and joint.name not in expected:
            said = f"joint '{joint.name}' moves in {called[1]} only"
            problems.append(Difference("joint-extra", said, joint=joint.name))
    comparing = Comparing(
        urdf_side(first, {own: own for own in names}, {}, {}),
        urdf_side(second, {own: own for own in names.values()}, {}, {}),
        names, tolerance, called=(*called, "link"),
    )  # fmt: skip
    comparing.compare(problems)
    frames, others = comparing.one.frames, comparing.two.frames
    comparing.compare_frames(
        {link: LinkFrame(link, None, Pose()) for link in frames if link in others}
    )
    for has, lacks, name in ((frames, others, called[0]), (others, frames, called[1])):
        comparing.elsewhere += [
            Difference("frame", f"link '{link}' is in {name} only", link=link)
            for link in has if link not in lacks
        ]  # fmt: skip
    not_compared = {
        f"elements of other programs in {name}": "such as <gazebo>"
        for name, robot in zip(called, (first, second), strict=True)
        if robot.extensions
    }
    return comparing.proof({}, not_compared)
