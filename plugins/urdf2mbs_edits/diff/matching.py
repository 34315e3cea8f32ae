"""The things of two models that are the same: by name, else by structure, never by their order.

MBSysPad renumbers and reorders what it saves, and people rename.  Two things that are the same get
one number, so that references can be compared across models in which they are named otherwise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable
from typing import Any

from urdf2mbs.plugin import ZERO
from urdf2mbs_edits.diff.flat import Thing, is_place, said

#: What is equal for two things that are the same; None is equal to nothing.
Key = Callable[[Thing], Hashable]


def match(before: list[Thing], after: list[Thing]) -> None:
    """Give each thing after the number of the thing before that it is."""
    matching = _Matching(before, after)
    matching.pair_all(_FIRST)
    matching.pair_bodies_by_joints()
    while any(matching.pair("body", key, exactly=True) for key in _OF_BODIES):
        pass
    matching.pair_all(_THEN)


def match_added(ours: Iterable[Thing], theirs: Iterable[Thing]) -> None:
    """Give what two sides added alike one number, wherever each has it in the diagram."""
    candidates = list(theirs)
    for thing in ours:
        alike = _said_but_for_places(thing)
        for other in candidates:
            if thing.kind == other.kind and alike == _said_but_for_places(other):
                other.number = thing.number
                candidates.remove(other)
                break


def _said_but_for_places(thing: Thing) -> dict[str, Any]:
    return {field: v for field, v in said(thing).items() if not is_place(thing.kind, field)}


class _Matching:
    """Two models, and the numbers of the things that are paired so far."""

    def __init__(self, before: list[Thing], after: list[Thing]) -> None:
        self.before, self.after = before, after
        self.paired: set[int] = set()

    def pair_all(self, rules: Iterable[tuple[str, Key, bool]]) -> None:
        for kinds, key, exactly in rules:
            for kind in kinds.split(", "):
                self.pair(kind, key, exactly=exactly)

    def pair(self, kind: str, key: Key, *, exactly: bool) -> bool:
        """Pair the things of a kind that have equal keys, in the order of the files, and tell
        whether there were any; ``exactly``: only where both models have as many."""
        groups: tuple[dict[Hashable, list[Thing]], ...] = ({}, {})
        for side, things_of in zip(groups, (self.before, self.after), strict=True):
            for thing in things_of:
                if thing.kind == kind and thing.number not in self.paired:
                    side.setdefault(key(thing), []).append(thing)
        paired = False
        for value, old in groups[0].items():
            new = groups[1].get(value, [])
            if value is None or (exactly and len(old) != len(new)):
                continue
            for thing, partner in zip(old, new, strict=False):
                self._join(thing, partner)
                paired = True
        return paired

    def _join(self, thing: Thing, partner: Thing) -> None:
        partner.number = thing.number
        self.paired.add(thing.number)

    def pair_bodies_by_joints(self) -> None:
        """Pair bodies of different names that have joints of the same names, the most first."""
        joints = {thing.number: thing for thing in self.after if thing.kind == "joint"}
        shared = Counter(
            (thing.owner, joints[thing.number].owner)
            for thing in self.before
            if thing.number in joints
        )
        for (body, partner), _ in shared.most_common():
            if body and partner and self.paired.isdisjoint([body.number, partner.number]):
                self._join(body, partner)


# --- keys ---


def _name(thing: Thing) -> Hashable:
    return thing.name


def _owner(thing: Thing) -> Hashable:
    return thing.owner and thing.owner.number


def _name_in_owner(thing: Thing) -> Hashable:
    return _owner(thing), thing.name


def _but_for_name(thing: Thing) -> Hashable:
    return repr({**said(thing), "name": ""})


def _form(shape: Thing) -> Hashable:
    fields = ("kind", "position", "rotation", "size", "radius", "height", "url")
    return _owner(shape), *(getattr(shape.part, field) for field in fields)


def _place_and_use(point: Thing) -> Hashable:
    users = tuple(used and used.name for used in (point.part.sensor, point.part.extforce))
    return _owner(point), point.part.coordinates, users, point.part.position


def _carried(point: Thing) -> Hashable:
    bodies = frozenset(body.number for body in point.carries)
    return (_owner(point), bodies) if bodies else None


def _of_body(*fields: str) -> Key:
    """A key of what a body says; None where it does not say all of it."""

    def key(body: Thing) -> Hashable:
        part, point = body.part, body.refers["place"][1]
        at = point.part.coordinates if isinstance(point, Thing) else ZERO
        points = tuple(sorted(point.coordinates for point in part.points))
        said = {
            "parent": body.refs("place")[0], "at": at, "away": at if at != ZERO else None,
            "types": tuple(joint.type for joint in part.joints), "all points": points,
            "points": points or None,
            "inertia": (part.mass, part.com or ZERO, part.inertia or ()) if part.mass else None,
        }  # fmt: skip
        values = tuple(said[field] for field in fields)
        return None if None in values else values

    return key


#: The keys of bodies that have other names, the strictest first.
_OF_BODIES = (
    _of_body("parent", "at", "types", "inertia", "all points"),
    _of_body("parent", "types", "inertia"),
    _of_body("parent", "inertia"),
    _of_body("types", "inertia"),
    _of_body("parent", "at", "types", "points"),
    _of_body("parent", "types", "away"),
)
#: Kinds, their key, and whether only as many as in the other model are paired: before the bodies
#: are known, and then.
_FIRST: tuple[tuple[str, Key, bool], ...] = (
    ("model, base, view", lambda thing: thing.kind, False),
    ("body, joint, sensor, force, user model", _name, False),
)
_THEN: tuple[tuple[str, Key, bool], ...] = (
    ("joint", lambda t: (_owner(t), t.part.type, t.part.nature, t.part.q), True),
    ("joint", lambda t: (_owner(t), t.part.type), True),
    ("point", _name_in_owner, False),
    ("point", _place_and_use, True),
    ("point", lambda t: (_owner(t), t.part.coordinates), True),
    ("point", _carried, True),
    ("sensor, force", _owner, False),
    ("cut, link, user constraint, user variable, viewpoint, light", _name, False),
    ("cut, link", lambda t: (t.part.kind, t.refs("endpoint1"), t.refs("endpoint2")), True),
    ("user model", lambda t: tuple(p.name for p in t.part.parameters) or None, True),
    ("parameter", lambda t: (_owner(t), t.refs("name")), False),
    ("parameter", _name_in_owner, False),
    ("parameter", lambda t: (_owner(t), t.part.type, t.part.values), True),
    ("user constraint", lambda t: t.refs("joints"), True),
    ("shape", lambda t: repr(said(t)), False),
    ("shape", lambda t: (_owner(t), t.name, t.part.kind), False),
    ("shape, viewpoint, light", _but_for_name, True),
    ("shape", _form, True),
)
