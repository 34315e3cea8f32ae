"""Match the entities of two models that are the same: by name, else by structure, never by order.

MBSysPad renumbers and reorders objects, and people rename them.  Two entities that are the same
get one number, so that references can be compared across models that name them differently.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable
from typing import Any, NamedTuple

from urdf2mbs.plugin import ZERO
from urdf2mbs_edits.diff.table import Entity, is_diagram_position, list_values

#: Returns a value that is equal for two entities that are the same; None equals nothing.
Key = Callable[[Entity], Hashable]


class Rule(NamedTuple):
    """Entities of these kinds are the same if their keys are equal."""

    kinds: str
    """Separated by commas."""
    key: Key
    equal_counts: bool = False
    """Match the entities with a key only if both models have as many of them."""


def match_entities(before: list[Entity], after: list[Entity]) -> None:
    """Give each entity of ``after`` the number of the entity of ``before`` that it is."""
    matching = _Matching(before, after)
    matching.apply_all(_RULES_BEFORE_BODIES)
    matching.match_bodies_by_joints()
    while any(matching.apply("body", key, equal_counts=True) for key in _BODY_KEYS):
        pass
    matching.apply_all(_RULES_AFTER_BODIES)


def match_added(edited: Iterable[Entity], converted: Iterable[Entity]) -> None:
    """Give equal entities that two versions added one number, wherever the diagrams have them."""
    candidates = list(converted)
    for entity in edited:
        values = _list_values_but_positions(entity)
        for candidate in candidates:
            if entity.kind == candidate.kind and values == _list_values_but_positions(candidate):
                candidate.number = entity.number
                candidates.remove(candidate)
                break


def _list_values_but_positions(entity: Entity) -> dict[str, Any]:
    return {
        field: value
        for field, value in list_values(entity).items()
        if not is_diagram_position(entity.kind, field)
    }


class _Matching:
    """Two models, and the numbers of the entities that are already matched."""

    def __init__(self, before: list[Entity], after: list[Entity]) -> None:
        self.before, self.after = before, after
        self.matched: set[int] = set()

    def apply_all(self, rules: Iterable[Rule]) -> None:
        """Apply rules one after the other."""
        for rule in rules:
            for kind in rule.kinds.split(", "):
                self.apply(kind, rule.key, equal_counts=rule.equal_counts)

    def apply(self, kind: str, key: Key, *, equal_counts: bool) -> bool:
        """Match the entities of a kind that have equal keys, in the order of the files.

        Returns:
            Whether any were matched.
        """
        groups_before = self._group(self.before, kind, key)
        groups_after = self._group(self.after, kind, key)
        matched_any = False
        for value, old in groups_before.items():
            new = groups_after.get(value, [])
            if value is None or (equal_counts and len(old) != len(new)):
                continue
            for entity, partner in zip(old, new, strict=False):
                self._match(entity, partner)
                matched_any = True
        return matched_any

    def _group(self, entities: list[Entity], kind: str, key: Key) -> dict[Hashable, list[Entity]]:
        """Group the entities of a kind that are not matched yet by their keys."""
        groups: dict[Hashable, list[Entity]] = {}
        for entity in entities:
            if entity.kind == kind and entity.number not in self.matched:
                groups.setdefault(key(entity), []).append(entity)
        return groups

    def _match(self, entity: Entity, partner: Entity) -> None:
        partner.number = entity.number
        self.matched.add(entity.number)

    def match_bodies_by_joints(self) -> None:
        """Match bodies of different names that share names of joints, those that share most first.

        Joints are already matched by their names.
        """
        joints = {entity.number: entity for entity in self.after if entity.kind == "joint"}
        shared_joints = Counter(
            (entity.owner, joints[entity.number].owner)
            for entity in self.before
            if entity.number in joints
        )
        for (body, partner), _ in shared_joints.most_common():
            if body and partner and self.matched.isdisjoint([body.number, partner.number]):
                self._match(body, partner)


# --- keys ---


def _get_name(entity: Entity) -> Hashable:
    return entity.name


def _get_owner(entity: Entity) -> Hashable:
    return entity.owner and entity.owner.number


def _get_owner_and_name(entity: Entity) -> Hashable:
    return _get_owner(entity), entity.name


def _get_values_but_name(entity: Entity) -> Hashable:
    return repr({**list_values(entity), "name": ""})


def _get_form(shape: Entity) -> Hashable:
    fields = ("kind", "position", "rotation", "size", "radius", "height", "url")
    return _get_owner(shape), *(getattr(shape.part, field) for field in fields)


def _get_place_and_use(point: Entity) -> Hashable:
    part = point.part
    users = tuple(user and user.name for user in (part.sensor, part.extforce))
    return _get_owner(point), part.coordinates, users, part.position


def _get_attached_bodies(point: Entity) -> Hashable:
    bodies = frozenset(body.number for body in point.attached_bodies)
    return (_get_owner(point), bodies) if bodies else None


def _make_body_key(*fields: str) -> Key:
    """Make a key of properties of a body; the key is None if the body lacks one of them."""

    def get_properties(body: Entity) -> Hashable:
        part, point = body.part, body.references["place"][1]
        place = point.part.coordinates if isinstance(point, Entity) else ZERO
        points = tuple(sorted(point.coordinates for point in part.points))
        inertia = (part.mass, part.com or ZERO, part.inertia or ())
        properties = {
            "parent": body.list_targets("place")[0],
            "place": place,
            "place away from the parent's origin": place if place != ZERO else None,
            "joint types": tuple(joint.type for joint in part.joints),
            "points": points,
            "points, at least one": points or None,
            "inertia": inertia if part.mass else None,
        }
        values = tuple(properties[field] for field in fields)
        return None if None in values else values

    return get_properties


#: The keys of bodies that were renamed, the strictest first.
_BODY_KEYS = (
    _make_body_key("parent", "place", "joint types", "inertia", "points"),
    _make_body_key("parent", "joint types", "inertia"),
    _make_body_key("parent", "inertia"),
    _make_body_key("joint types", "inertia"),
    _make_body_key("parent", "place", "joint types", "points, at least one"),
    _make_body_key("parent", "joint types", "place away from the parent's origin"),
)
_RULES_BEFORE_BODIES = (
    Rule("model, base, view", lambda entity: entity.kind),
    Rule("body, joint, sensor, force, user model", _get_name),
)
_RULES_AFTER_BODIES = (
    Rule(
        "joint",
        lambda entity: (_get_owner(entity), entity.part.type, entity.part.nature, entity.part.q),
        equal_counts=True,
    ),
    Rule("joint", lambda entity: (_get_owner(entity), entity.part.type), equal_counts=True),
    Rule("point", _get_owner_and_name),
    Rule("point", _get_place_and_use, equal_counts=True),
    Rule("point", lambda entity: (_get_owner(entity), entity.part.coordinates), equal_counts=True),
    Rule("point", _get_attached_bodies, equal_counts=True),
    Rule("sensor, force", _get_owner),
    Rule("cut, link, user constraint, user variable, viewpoint, light", _get_name),
    Rule(
        "cut, link",
        lambda entity: (
            entity.part.kind,
            entity.list_targets("endpoint1"),
            entity.list_targets("endpoint2"),
        ),
        equal_counts=True,
    ),
    Rule(
        "user model",
        lambda entity: tuple(parameter.name for parameter in entity.part.parameters) or None,
        equal_counts=True,
    ),
    Rule("parameter", lambda entity: (_get_owner(entity), entity.list_targets("name"))),
    Rule("parameter", _get_owner_and_name),
    Rule(
        "parameter",
        lambda entity: (_get_owner(entity), entity.part.type, entity.part.values),
        equal_counts=True,
    ),
    Rule("user constraint", lambda entity: entity.list_targets("joints"), equal_counts=True),
    Rule("shape", lambda entity: repr(list_values(entity))),
    Rule("shape", lambda entity: (_get_owner(entity), entity.name, entity.part.kind)),
    Rule("shape, viewpoint, light", _get_values_but_name, equal_counts=True),
    Rule("shape", _get_form, equal_counts=True),
)
