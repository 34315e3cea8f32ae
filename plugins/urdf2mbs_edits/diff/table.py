"""A model as a flat table ``{path: value}``: diff compares two tables, merge joins three.

    path                                 value
    body 'arm'      mass                 2.0
    body 'arm'      place                (body 'trunk', point 'shoulder')
    joint 'elbow'   owner                body 'arm'
    body 'arm'      [joint]              (joint 'elbow', joint 'slide')
    body 'arm'      ?brake/force         <force>1.5</force>

A path is an entity (a body, joint, point, sensor, ...) and one of its fields.  In paths and
references an entity is a number, not a name, since names and owners change: ``matching`` gives one
number to entities of several versions that are the same.  So the name and the owner of an entity
and its references are values like any other.  Values that mean the same are equal.

A field in ``[]`` is the order of an entity's children of one kind.  A field after ``?`` is the path
of an XML element or attribute that the model does not know.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count
from math import trunc
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.plugin import BASE, ZERO, Mbs, read_mbs_again, writer
from urdf2mbs_edits.diff.unknown import find_unknown_content, normalize_number

#: The XML elements of entities in a file, by the entities' numbers.
XmlElements = dict[int, Any]

#: Kinds of entities, by the field of the model that holds them, in the order of differences.
CHILD_KINDS = {
    "base": "base",
    "bodies": "body",
    "joints": "joint",
    "points": "point",
    "sensor": "sensor",
    "extforce": "force",
    "cuts": "cut",
    "links": "link",
    "user_constraints": "user constraint",
    "user_models": "user model",
    "parameters": "parameter",
    "user_variables": "user variable",
    "shapes": "shape",
    "view": "view",
    "viewpoints": "viewpoint",
    "lights": "light",
}
KINDS = ("model", *CHILD_KINDS.values())
#: Kinds of entities that are only drawn.
GRAPHICAL_KINDS = frozenset(["shape", "view", "viewpoint", "light"])
#: Kinds of which a model has one, without a name.
UNNAMED_KINDS = ("model", "base", "view")
#: Beginnings of the fields of other entities that are only drawn.
_GRAPHICAL_FIELDS = ("position", "drawing", "graphics", "x2D", "x3D")
#: The meaning of values that a file may omit.
_DEFAULTS: dict[str, Any] = {
    "mass": 0.0,
    "com": ZERO,
    "inertia": (0.0,) * 6,
    "q": 0.0,
    "qd": 0.0,
    "qdd": 0.0,
    "symbols": ("q", "qd", "qdd"),
}
#: Fields without a meaning for the model, and fields of a body that its ``place`` contains.
_SKIPPED_FIELDS = frozenset(["origin", "version", ("body", "parent"), ("body", "point")])
#: Fields whose values have no order.
_UNORDERED_FIELDS = ("symbols", "measures")

_numbers = count()


class FieldPath(NamedTuple):
    """A field of an entity."""

    number: int
    """Number of the entity."""
    field: str
    """Empty: the entity itself, with all that belongs to it."""


class Entity(msgspec.Struct, eq=False):
    """A body, joint, point, sensor or other object of a model."""

    kind: str
    """One of ``KINDS``."""
    name: str
    part: Any
    """The object of ``mbs.model``."""
    owner: Entity | None = None
    """The entity that it belongs to: the body of a joint, the point of a sensor."""
    references: dict[str, tuple[Entity | str | None, ...]] = {}
    """Targets of the fields that name entities.

    None is a body's own frame; a text is a name that no entity of the model has.
    """
    attached_bodies: list[Entity] = []
    """Bodies whose parent is this point."""
    number: int = msgspec.field(default_factory=_numbers.__next__)
    """Equal for entities of several versions that are the same."""

    def list_targets(self, field: str) -> tuple[int | str | None, ...]:
        """List the targets of a reference, entities by their numbers."""
        return tuple(
            target.number if isinstance(target, Entity) else target
            for target in self.references[field]
        )

    def list_owners(self) -> Iterator[Entity]:
        """Yield the entity, its owner, the owner's owner, ..., the model."""
        entity: Entity | None = self
        while entity is not None:
            yield entity
            entity = entity.owner

    @property
    def label(self) -> str:
        """The kind and the name."""
        if self.kind in UNNAMED_KINDS:
            return f"the {self.kind}"
        return f"{self.kind} '{self.name}'"

    @property
    def qualified_label(self) -> str:
        """The label, and for a point also that of its body; empty for the model."""
        if self.kind == "point" and self.owner:
            return f"{self.label} of {self.owner.label}"
        return "" if self.kind == "model" else self.label

    @property
    def owner_label(self) -> str:
        """The qualified label of the owner."""
        return self.owner.qualified_label if self.owner else ""


class ModelTable(msgspec.Struct):
    """The table of one version of a model."""

    entities: dict[int, Entity]
    """In the order of the file, by number."""
    values: dict[int, dict[str, Any]]
    """Values of each entity, by field."""
    elements: XmlElements
    """Of the file of this version."""

    def list_children(self, number: int, kind: str) -> list[int]:
        """List the children of an entity that are of a kind, in their order."""
        children: list[int] = self.values.get(number, {}).get(f"[{kind}]", [])
        return children


def is_diagram_position(kind: str, field: str) -> bool:
    """Return whether a field says where an entity is drawn in the 2D diagram."""
    return (field == "position" and kind not in GRAPHICAL_KINDS) or field.startswith("drawing.")


def is_graphical(kind: str, field: str) -> bool:
    """Return whether a field only concerns pictures: the 2D diagram or the 3D view."""
    return kind in GRAPHICAL_KINDS or field.startswith(_GRAPHICAL_FIELDS)


# --- entities ---


def list_entities(mbs: Mbs) -> list[Entity]:
    """List all entities of a model, each after its owner, with their references."""
    entities = list(_walk("model", mbs, None))
    base = entities[1]
    bodies: dict[str | None, Entity] = {
        entity.name: entity for entity in entities if entity.kind == "body"
    }
    bodies[None] = base
    joints = {entity.name: entity for entity in entities if entity.kind == "joint"}
    points = {(entity.owner, entity.name): entity for entity in entities if entity.kind == "point"}

    def find_place(body: str | None, point: str | None) -> tuple[Entity | str | None, ...]:
        owner = bodies.get(body, body)
        if isinstance(owner, Entity) and point:
            return owner, points.get((owner, point), point)
        return owner, point

    for entity in entities:
        part = entity.part
        if entity.kind == "body":
            entity.references = {"place": find_place(*part.place)}
            point = entity.references["place"][1]
            if isinstance(point, Entity):
                point.attached_bodies.append(entity)
        elif entity.kind in ("cut", "link"):
            entity.references = {
                end: find_place(*getattr(part, end)) for end in ("endpoint1", "endpoint2")
            }
        elif entity.kind == "user constraint":
            targets = tuple(joints.get(joint, joint) for joint in part.joints)
            entity.references = {"joints": targets}
        elif entity.kind == "parameter":  # often has the name of the joint whose index it is
            entity.references = {"name": (joints.get(part.name, part.name),)}
        elif entity.kind in ("viewpoint", "light"):
            target = base if part.joint == BASE else joints.get(part.joint, part.joint)
            entity.references = {"joint": (target,)}
    return entities


def _walk(kind: str, part: Any, owner: Entity | None) -> Iterator[Entity]:
    """Yield the entity of an object of the model, then those of the objects in it."""
    yield (entity := Entity(kind, getattr(part, "name", ""), part, owner))
    for field in part.__struct_fields__:
        value = getattr(part, field)
        if field in CHILD_KINDS and not isinstance(value, tuple) and value is not None:
            for child in value if isinstance(value, list) else [value]:
                yield from _walk(CHILD_KINDS[field], child, entity)


# --- values ---


def make_table(mbs: Mbs, entities: list[Entity]) -> ModelTable:
    """Make the table of a model.

    Args:
        mbs: The model.
        entities: Its entities, already numbered by ``matching``.
    """
    elements = find_elements(read_source(mbs), entities)
    objects = set(elements.values())
    values: dict[int, dict[str, Any]] = {}
    for entity in entities:
        unknown = find_unknown_content(elements[entity.number], objects)
        values[entity.number] = list_values(entity)
        values[entity.number] |= {f"?{path}": text for path, text in unknown.items()}
        if entity.owner is not None:
            order = values[entity.owner.number].setdefault(f"[{entity.kind}]", [])
            order.append(entity.number)
    return ModelTable({entity.number: entity for entity in entities}, values, elements)


def read_source(mbs: Mbs) -> bytes:
    """Return the file that a model was read from, or that it would be written to."""
    return mbs.origin.source if mbs.origin else writer.write(mbs)


def find_elements(source: bytes, entities: Iterable[Entity]) -> XmlElements:
    """Find the XML elements of a model's entities in its file."""
    mbs, objects = read_mbs_again(source)
    elements: XmlElements = {}
    for entity, entity_of_file in zip(entities, list_entities(mbs), strict=True):
        tag = {"base": "base", "view": "x3D"}.get(entity.kind)
        if tag:
            element: Any = objects[0].find(tag)
        else:
            element = objects[entity_of_file.part.origin.number]
        assert element is not None
        elements[entity.number] = element
    return elements


def list_values(entity: Entity) -> dict[str, Any]:
    """List the values of an entity by field; a value that the file omits is its default."""
    owner = None if entity.owner is None else entity.owner.number
    values: dict[str, Any] = {"name": entity.name, "owner": owner}
    values |= {field: entity.list_targets(field) for field in entity.references}
    for field in entity.part.__struct_fields__:
        value = getattr(entity.part, field)
        is_children = field in CHILD_KINDS and not isinstance(value, tuple)
        is_skipped = field in _SKIPPED_FIELDS or (entity.kind, field) in _SKIPPED_FIELDS
        if field not in values and not is_children and not is_skipped:
            values |= _normalize(entity.kind, field, value)
    for field in _UNORDERED_FIELDS:
        if field in values:
            values[field] = tuple(sorted(values[field]))
    return values


def _normalize(kind: str, field: str, value: Any) -> dict[str, Any]:
    """Return the values of one field of the model, with one spelling for what means the same."""
    if field == "values":
        value = tuple(map(normalize_number, value))
    if isinstance(value, msgspec.Struct):
        return {
            f"{field}.{part}": _truncate_pixels(getattr(value, part))
            for part in value.__struct_fields__
        }
    if is_diagram_position(kind, field):
        return {field: _truncate_pixels(value)}
    if field in _DEFAULTS:
        return {field: _DEFAULTS[field] if value is None else value}
    return {} if value is None else {field: value}


def _truncate_pixels(value: Any) -> Any:
    """Truncate positions in the diagram (px), as MBSysPad saves them; keep any other value."""
    if not isinstance(value, tuple):
        return value
    return tuple(
        _truncate_pixels(part) if isinstance(part, tuple) else trunc(part) for part in value
    )
