"""The things of two models that are the same: by name, else by structure, never by their order.

MBSysPad renumbers and reorders what it saves, and people rename.  Two things that are the same get
one number, so that references can be compared across models in which they are named otherwise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable
from typing import Any

import msgspec

from urdf2mbs.mbs.model import Point, Shape
from urdf2mbs.spatial import ZERO
from urdf2mbs_edits.diff.flat import Thing, is_place, said

Key = Callable[[Thing], Hashable]


def match(before: list[Thing], after: list[Thing]) -> None:
    """Give each thing after the number of the thing before that it is."""
    _Matching(before, after).match()


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
    """Two models that are matched, and the pairs that are found so far, by their numbers."""

    def __init__(self, before: list[Thing], after: list[Thing]) -> None:
        self.before, self.after = before, after
        self.pairs: dict[int, tuple[Thing, Thing]] = {}

    def match(self) -> None:
        for kind in ("model", "base", "view"):
            self._pair(kind, lambda thing: thing.kind)
        for kind in ("body", "joint", "sensor", "force", "user model"):
            self._pair(kind, _name)
        self._pair_bodies_by_joints()
        while any(self._pair("body", key, exactly=True) for key in _OF_BODY):
            pass
        for key in (_within(_type_and_use), _within(_type)):
            self._pair("joint", key, exactly=True)
        self._pair("point", _within(_name))
        for key in (_place_and_use, _place, self._carried()):
            self._pair("point", _within(key), exactly=True)
        for kind in ("sensor", "force"):
            self._pair(kind, _within(lambda _: ()))
        for kind in ("cut", "link"):
            self._pair(kind, _name)
            self._pair(kind, _ends, exactly=True)
        self._pair("user model", _parameters, exactly=True)
        self._pair("parameter", _within(lambda thing: thing.refs("name")))
        self._pair("parameter", _within(_name))
        self._pair("parameter", _within(lambda t: (t.part.type, t.part.values)), exactly=True)
        for kind in ("user constraint", "user variable", "viewpoint", "light"):
            self._pair(kind, _name)
        self._pair("user constraint", lambda thing: thing.refs("joints"), exactly=True)
        self._pair("shape", _within(_content))
        self._pair("shape", _within(lambda shape: (shape.name, shape.part.kind)))
        for kind in ("shape", "viewpoint", "light"):
            self._pair(kind, _within(_but_for_name), exactly=True)
        self._pair("shape", _within(_form), exactly=True)

    def _pair(self, kind: str, key: Key, *, exactly: bool = False) -> bool:
        """Pair the things of a kind that have equal keys, in the order of the files, and tell
        whether there were any.

        ``exactly``: only where as many things have the key in both models.  A key of None is no
        key.
        """
        groups: tuple[dict[Hashable, list[Thing]], ...] = ({}, {})
        for side, things_of in zip(groups, (self.before, self.after), strict=True):
            for thing in things_of:
                if thing.kind == kind and thing.number not in self.pairs:
                    value = key(thing)
                    if value is not None:
                        side.setdefault(value, []).append(thing)
        paired = False
        for value, old in groups[0].items():
            new = groups[1].get(value, [])
            if exactly and len(old) != len(new):
                continue
            for thing, partner in zip(old, new, strict=False):
                self._join(thing, partner)
                paired = True
        return paired

    def _join(self, thing: Thing, partner: Thing) -> None:
        partner.number = thing.number
        self.pairs[thing.number] = thing, partner

    def _pair_bodies_by_joints(self) -> None:
        """Pair bodies of different names that have joints of the same names, the most first."""
        joints = [pair for pair in self.pairs.values() if pair[0].kind == "joint"]
        shared = Counter((joint.owner, partner.owner) for joint, partner in joints)
        for (body, partner), _ in shared.most_common():
            if body and partner and self.pairs.keys().isdisjoint([body.number, partner.number]):
                self._join(body, partner)

    def _carried(self) -> Key:
        """The bodies that hang on a point."""
        hanging: dict[Thing, set[int]] = {}
        for body in (*self.before, *self.after):
            point = body.refers["place"][1] if body.kind == "body" else None
            if isinstance(point, Thing):
                hanging.setdefault(point, set()).add(body.number)
        return lambda point: frozenset(hanging[point]) if point in hanging else None


def _within(key: Key) -> Key:
    """A key among the things of one owner."""

    def whole(thing: Thing) -> Hashable:
        value = key(thing)
        return None if value is None else (thing.owner and thing.owner.number, value)

    return whole


def _all(*keys: Key) -> Key:
    """Several keys as one; None if one of them is."""

    def whole(thing: Thing) -> Hashable:
        values = tuple(key(thing) for key in keys)
        return None if None in values else values

    return whole


def _name(thing: Thing) -> Hashable:
    return thing.name


def _ends(thing: Thing) -> Hashable:
    return thing.part.kind, thing.refs("endpoint1"), thing.refs("endpoint2")


# --- joints, points, parameters, shapes ---


def _type(joint: Thing) -> Hashable:
    return joint.part.type  # type: ignore[no-any-return]


def _type_and_use(joint: Thing) -> Hashable:
    return joint.part.type, joint.part.nature, joint.part.q


def _place(point: Thing) -> Hashable:
    return point.part.coordinates  # type: ignore[no-any-return]


def _place_and_use(point: Thing) -> Hashable:
    part: Point = point.part
    users = tuple(used and used.name for used in (part.sensor, part.extforce))
    return part.coordinates, users, part.position


def _parameters(model: Thing) -> Hashable:
    return tuple(parameter.name for parameter in model.part.parameters) or None


def _content(thing: Thing) -> Hashable:
    return repr(msgspec.structs.replace(thing.part, origin=None))


def _but_for_name(thing: Thing) -> Hashable:
    return repr(msgspec.structs.replace(thing.part, origin=None, name=""))


def _form(shape: Thing) -> Hashable:
    part: Shape = shape.part
    return part.kind, part.position, part.rotation, part.size, part.radius, part.height, part.url


# --- bodies ---


def _parent(body: Thing) -> Hashable:
    return body.refs("place")[:1]


def _types(body: Thing) -> Hashable:
    return tuple(joint.type for joint in body.part.joints)


def _inertia(body: Thing) -> Hashable:
    part = body.part
    return (part.mass, part.com or ZERO, part.inertia or ()) if part.mass else None


def _points(body: Thing) -> Hashable:
    return tuple(sorted(point.coordinates for point in body.part.points)) or None


def _at(body: Thing) -> Hashable:
    point = body.refers["place"][1]
    return point.part.coordinates if isinstance(point, Thing) else ZERO


#: The keys by which bodies of different names are the same, the strictest first.
_OF_BODY = (
    _all(_parent, _at, _types, _inertia, lambda body: _points(body) or ()),
    _all(_parent, _types, _inertia),
    _all(_parent, _inertia),
    _all(_types, _inertia),
    _all(_parent, _at, _types, _points),
    _all(_parent, _types, lambda body: None if _at(body) == ZERO else _at(body)),
)
