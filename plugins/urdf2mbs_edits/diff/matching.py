"""The objects of two models that are the same: by name, else by structure, never by their order.

MBSysPad renumbers and reorders what it saves, and people rename.  Each object of a model becomes a
``Thing``, which knows what it belongs to and what it refers to.  Two things that are the same get
one number, so that references can be compared across models in which they are named otherwise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any

import msgspec

from urdf2mbs.mbs.model import BASE, Body, Mbs, Point, Shape
from urdf2mbs.spatial import ZERO

Key = Callable[["Thing"], Hashable]

#: How each kind of thing is called, in the order in which differences are said.
KINDS = (
    "model", "base", "body", "joint", "point", "sensor", "force", "cut", "link",
    "user constraint", "user model", "parameter", "user variable", "shape", "view", "viewpoint",
    "light",
)  # fmt: skip


class Thing(msgspec.Struct, eq=False):
    """An object of a model."""

    kind: str
    """One of ``KINDS``."""
    name: str
    part: Any
    """The object of ``mbs.model``."""
    owner: Thing | None = None
    """What it belongs to: a joint to its body, a sensor to its point."""
    refers: dict[str, tuple[Thing | str | None, ...]] = {}
    """The things that a field names; None is a body's own frame, a text names nothing known."""


def things(mbs: Mbs) -> list[Thing]:
    """All objects of a model, each after its owner."""
    return list(_things(mbs))


def _things(mbs: Mbs) -> Iterator[Thing]:
    yield (model := Thing("model", mbs.name, mbs))
    base = Thing("base", mbs.base.name, mbs.base, model)
    bodies: dict[str | None, Thing] = {None: base}
    bodies |= {body.name: Thing("body", body.name, body, model) for body in mbs.bodies}
    points: dict[tuple[str | None, str], Thing] = {}
    joints: dict[str, Thing] = {}
    for name, thing in bodies.items():
        yield thing
        if isinstance(thing.part, Body):
            for joint in thing.part.joints:
                joints[joint.name] = Thing("joint", joint.name, joint, thing)
                yield joints[joint.name]
        for point in thing.part.points:
            at = points[name, point.name] = Thing("point", point.name, point, thing)
            yield at
            for kind, part in (("sensor", point.sensor), ("force", point.extforce)):
                if part is not None:
                    yield Thing(kind, part.name, part, at)
        for shape in thing.part.shapes:
            yield Thing("shape", shape.name, shape, thing)

    def place(body: str | None, point: str | None) -> tuple[Thing | str | None, ...]:
        on = bodies.get(body, body)
        return on, None if point is None else points.get((body, point), point)

    for name, thing in bodies.items():
        if name is not None:
            on = place(thing.part.parent, thing.part.point)
            thing.refers = {"parent": on[:1], "point": on[1:]}
    for kind, connections in (("cut", mbs.cuts), ("link", mbs.links)):
        for part in connections:
            ends = {end: place(*getattr(part, end)) for end in ("endpoint1", "endpoint2")}
            yield Thing(kind, part.name, part, model, dict(ends))
    for constraint in mbs.user_constraints:
        concerns = tuple(joints.get(joint, joint) for joint in constraint.joints)
        yield Thing("user constraint", constraint.name, constraint, model, {"joints": concerns})
    for user_model in mbs.user_models:
        yield (holder := Thing("user model", user_model.name, user_model, model))
        for parameter in user_model.parameters:
            # a parameter is often called as the joint whose number it is
            called = (joints.get(parameter.name, parameter.name),)
            yield Thing("parameter", parameter.name, parameter, holder, {"name": called})
    for variable in mbs.user_variables:
        yield Thing("user variable", variable.name, variable, model)
    if mbs.view is not None:
        yield (view := Thing("view", "", mbs.view, model))
        for kind, parts in (("viewpoint", mbs.view.viewpoints), ("light", mbs.view.lights)):
            for eye in parts:
                behind = base if eye.joint == BASE else joints.get(eye.joint, eye.joint)
                yield Thing(kind, eye.name, eye, view, {"joint": (behind,)})


class Matching:
    """The things of two models, and which of them are the same.

    ``same`` are the objects of the two that are the same, where this is known.
    """

    def __init__(
        self, before: Mbs, after: Mbs, same: Iterable[tuple[Any, Any]] | None = None
    ) -> None:
        self.before, self.after = things(before), things(after)
        self.partner: dict[Thing, Thing] = {}
        """The thing after of a thing before, and the other way round."""
        self._numbers: dict[Thing, int] = {}
        if same is None:
            self._match()
            return
        old = {id(thing.part): thing for thing in self.before}
        new = {id(thing.part): thing for thing in self.after}
        for part, partner in same:
            if id(part) in old and id(partner) in new:
                self._join(old[id(part)], new[id(partner)])

    def removed(self) -> list[Thing]:
        return [thing for thing in self.before if thing not in self.partner]

    def added(self) -> list[Thing]:
        return [thing for thing in self.after if thing not in self.partner]

    def pairs(self) -> list[tuple[Thing, Thing]]:
        """Each thing before that has a thing after."""
        return [(thing, self.partner[thing]) for thing in self.before if thing in self.partner]

    def identity(self, thing: Thing | str | None) -> Hashable:
        """A value that is equal for two things, or references to things, that are the same."""
        return self._numbers.get(thing, thing) if isinstance(thing, Thing) else thing

    def identities(self, thing: Thing, field: str) -> tuple[Hashable, ...]:
        """The identities of the things that a field refers to."""
        return tuple(self.identity(target) for target in thing.refers[field])

    def _match(self) -> None:
        for kind in ("model", "base", "view"):
            self._pair(kind, lambda thing: thing.kind)
        for kind in ("body", "joint", "sensor", "force", "user model"):
            self._pair(kind, lambda thing: thing.name)
        self._pair_bodies_by_joints()
        while any(self._pair("body", key, exactly=True) for key in self._of_body()):
            pass
        for name_or_type in (
            lambda joint: (joint.part.type, joint.part.nature, joint.part.q),
            lambda joint: joint.part.type,
        ):
            self._pair("joint", self._within(name_or_type), exactly=True)
        self._pair("point", self._within(lambda point: point.name))
        hanging: dict[Thing, set[Hashable]] = {}
        for body in (*self.before, *self.after):
            for point in body.refers.get("point", ()):
                if isinstance(point, Thing):
                    hanging.setdefault(point, set()).add(self.identity(body))

        def carried(point: Thing) -> Hashable:
            return frozenset(hanging[point]) if point in hanging else None

        for structure in (_place_and_use, _place, carried):
            self._pair("point", self._within(structure), exactly=True)
        for kind in ("sensor", "force"):
            self._pair(kind, self._within(lambda _: ()))
        for kind in ("cut", "link"):
            self._pair(kind, lambda thing: thing.name)
            self._pair(kind, self._ends, exactly=True)
        self._pair("user model", _parameters, exactly=True)
        self._pair("parameter", self._within(lambda thing: self.identities(thing, "name")))
        self._pair("parameter", self._within(lambda thing: thing.name))
        self._pair(
            "parameter", self._within(lambda thing: (thing.part.type, thing.part.values)),
            exactly=True,
        )  # fmt: skip
        for kind in ("user constraint", "user variable", "viewpoint", "light"):
            self._pair(kind, lambda thing: thing.name)
        self._pair("user constraint", lambda thing: self.identities(thing, "joints"), exactly=True)
        self._pair("shape", self._within(_content))
        self._pair("shape", self._within(lambda shape: (shape.name, shape.part.kind)))
        for kind in ("shape", "viewpoint", "light"):
            self._pair(kind, self._within(_but_for_name), exactly=True)
        self._pair("shape", self._within(_form), exactly=True)

    def _pair(self, kind: str, key: Key, *, exactly: bool = False) -> bool:
        """Pair the things of a kind that have equal keys, in the order of the files, and tell
        whether there were any.

        ``exactly``: only where as many things have the key in both models.  A key of None is no
        key.
        """
        groups: tuple[dict[Hashable, list[Thing]], ...] = ({}, {})
        for side, things_of in zip(groups, (self.before, self.after), strict=True):
            for thing in things_of:
                if thing.kind == kind and thing not in self.partner:
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
        self.partner[thing], self.partner[partner] = partner, thing
        self._numbers[thing] = self._numbers[partner] = len(self._numbers)

    def _pair_bodies_by_joints(self) -> None:
        """Pair bodies of different names that have joints of the same names, the most first."""
        shared = Counter(
            (joint.owner, partner.owner) for joint, partner in self.pairs() if joint.kind == "joint"
        )
        for (body, partner), _ in shared.most_common():
            if body and partner and body not in self.partner and partner not in self.partner:
                self._join(body, partner)

    def _within(self, key: Key) -> Key:
        """A key among the things of one owner."""

        def whole(thing: Thing) -> Hashable:
            value = key(thing)
            return None if value is None else (self.identity(thing.owner), value)

        return whole

    def _ends(self, thing: Thing) -> Hashable:
        ends = (self.identities(thing, "endpoint1"), self.identities(thing, "endpoint2"))
        return thing.part.kind, ends

    def _of_body(self) -> list[Key]:
        """The keys by which bodies of different names are the same, the strictest first."""

        def parent(thing: Thing) -> Hashable:
            return self.identities(thing, "parent")

        def types(thing: Thing) -> Hashable:
            return tuple(joint.type for joint in thing.part.joints)

        def inertia(thing: Thing) -> Hashable:
            body = thing.part
            return (body.mass, body.com or ZERO, body.inertia or ()) if body.mass else None

        def points(thing: Thing) -> Hashable:
            return tuple(sorted(point.coordinates for point in thing.part.points)) or None

        def place(thing: Thing) -> Hashable:
            point = thing.refers["point"][0]
            return point.part.coordinates if isinstance(point, Thing) else ZERO

        def off_origin(thing: Thing) -> Hashable:
            return place(thing) if place(thing) != ZERO else None

        return [
            _all(parent, place, types, inertia, lambda thing: points(thing) or ()),
            _all(parent, types, inertia),
            _all(parent, inertia),
            _all(types, inertia),
            _all(parent, place, types, points),
            _all(parent, types, off_origin),
        ]


def _all(*keys: Key) -> Key:
    """Several keys as one; None if one of them is."""

    def whole(thing: Thing) -> Hashable:
        values = tuple(key(thing) for key in keys)
        return None if None in values else values

    return whole


def _place(thing: Thing) -> Hashable:
    point: Point = thing.part
    return point.coordinates


def _place_and_use(thing: Thing) -> Hashable:
    point: Point = thing.part
    users = tuple(part and part.name for part in (point.sensor, point.extforce))
    return point.coordinates, users, point.position


def _parameters(thing: Thing) -> Hashable:
    return tuple(parameter.name for parameter in thing.part.parameters) or None


def _content(thing: Thing) -> Hashable:
    return repr(msgspec.structs.replace(thing.part, origin=None))


def _but_for_name(thing: Thing) -> Hashable:
    part: Shape = thing.part
    return repr(msgspec.structs.replace(part, origin=None, name=""))


def _form(thing: Thing) -> Hashable:
    part: Shape = thing.part
    return part.kind, part.position, part.rotation, part.size, part.radius, part.height, part.url
