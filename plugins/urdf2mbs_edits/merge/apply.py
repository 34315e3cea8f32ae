"""Apply what people changed to a new conversion.

An edit is a ``Change`` of the model that was written last.  Where the new conversion still has
what the edit changes, the edit is made.  Where the new conversion changed the same thing, the
owner decides: the URDF, or people.  An edit of something that is gone is an orphan.
"""

from __future__ import annotations

from collections.abc import Container
from copy import deepcopy
from typing import Any, Literal

import msgspec

from urdf2mbs.mbs.model import BASE, ORIGIN, Mbs
from urdf2mbs_edits.diff.changes import DRAWN, Change, content, in_words, plain_values
from urdf2mbs_edits.diff.matching import Thing
from urdf2mbs_edits.diff.words import line, value_in_words

Side = Literal["urdf", "edited"]
#: Who wins where both changed the same thing: for all fields, or field by field.
Prefer = Side | dict[str, Side]
#: What the things of one of its versions are in a model; what is not named is gone.
Becomes = dict[Thing, Thing]

#: What people set: there an edit wins.  All else is what the URDF defines.
_KINDS_OF_PEOPLE = frozenset(["sensor", "force", "view", "viewpoint", "light", "user variable"])
_FIELDS_OF_PEOPLE = frozenset(
    ["q", "qd", "qdd", "nature", "symbols", "actuated", "color", "transparency"]
)
#: The list of the owner in which a thing stands.
LISTS = {
    "body": "bodies", "joint": "joints", "point": "points", "shape": "shapes", "cut": "cuts",
    "link": "links", "user constraint": "user_constraints", "user model": "user_models",
    "parameter": "parameters", "user variable": "user_variables", "viewpoint": "viewpoints",
    "light": "lights",
}  # fmt: skip
#: The field of the owner that a thing is.
FIELDS = {"sensor": "sensor", "force": "extforce", "view": "view"}
#: The kinds of things that a thing holds.
_HOLDS = {
    "body": ("joint", "point", "shape"), "point": ("sensor", "force"),
    "user model": ("parameter",), "view": ("viewpoint", "light"),
}  # fmt: skip
#: The things whose names are unique in their owner only, or nowhere.
_NAMED_IN_OWNER = frozenset(["point", "parameter"])
_NAMED_FREELY = frozenset(["shape", "viewpoint", "light"])


class Edit(msgspec.Struct):
    """What somebody changed, and the thing of the new conversion that gets the change."""

    change: Change
    target: Thing | None
    """Of what was added, its owner; None: it is gone."""
    source: Thing
    """The thing of the edited file; of what was removed, the thing before."""
    before: Thing | None = None
    """The thing that was written last; None if it was added."""


class Conflict(msgspec.Struct):
    """What both sides changed."""

    edit: Change
    urdf: Any
    """What the new conversion has."""
    wins: Side

    def words(self, other: str, own: str) -> str:
        """The conflict in a sentence; ``other`` and ``own`` are how the sides are called."""
        wins = other if self.wins == "urdf" else own
        return f"{line(self.edit)}; {other} has {value_in_words(self.urdf)} now: {wins} wins"


class Applying:
    """A new conversion in the making, to which edits are applied."""

    def __init__(
        self,
        model: list[Thing],
        edited: list[Thing],
        olds: Becomes,
        news: Becomes,
        touched: Container[Thing],
        prefer: Prefer | None,
    ) -> None:
        """``model`` are the things of the new conversion, ``edited`` those of the edited file;
        ``olds`` and ``news`` are what the things before and after the edits are in the model.
        ``touched`` are the things of the model in which the URDF changed something.  ``prefer``
        None: people made both sides, and the edits win."""
        self.model, self.edited, self.olds, self.news = model, edited, olds, news
        self.touched, self.prefer = touched, prefer
        self.conflicts: list[Conflict] = []
        self.orphans: list[tuple[Edit, str]] = []
        """What can no longer stand, and why."""
        self._doomed: dict[Thing, Edit] = {}
        """What people removed."""
        self._put: dict[Thing, Edit] = {}
        """What edits added or moved."""
        self._left: dict[Thing | None, list[Thing]] = {}
        """What edits moved, by its owner before."""
        self._hung: dict[Thing, tuple[Edit, dict[str, Any]]] = {}
        """What edits let refer to something else, and what it referred to before."""

    def apply(self, edits: list[Edit]) -> None:
        """Make all edits; names come first, because the other edits use them."""
        # a body may hang on a point that is new, too
        edits = sorted(edits, key=lambda edit: edit.change.kind != "point")
        self._removes(edits)
        for does in ("renamed", "reordered", "added", "moved", "changed"):
            for edit in edits:
                if edit.change.change == does:
                    if edit.target is None:
                        self._orphan(edit)
                    else:
                        getattr(self, f"_{does}")(edit, edit.target)
        self._untangle()
        self._remove()
        self._one_each()
        self._write_references()
        mbs: Mbs = self.model[0].part
        there: set[str | None] = {None}
        for body in mbs.bodies:
            if body.parent not in there:  # a file has parents before children
                mbs.bodies = mbs.depth_first()
                break
            there.add(body.name)

    def _edit_wins(self, edit: Edit, field: str, now: Any) -> bool:
        """Whether an edit is made of what the URDF changed, too."""
        change = edit.change
        of_people = change.kind in _KINDS_OF_PEOPLE or field in _FIELDS_OF_PEOPLE
        kept = is_place(change) or (of_people and self.prefer is not None)
        wins: Side = "edited" if kept or self.prefer in ("edited", None) else "urdf"
        if isinstance(self.prefer, dict):
            wins = self.prefer.get(field.split(".")[0], wins)
        if not kept:
            self.conflicts.append(Conflict(change, now, wins))
        return wins == "edited"

    def _orphan(self, edit: Edit, why: str = "") -> None:
        change = edit.change
        if change.change not in ("reordered", "removed") and not is_place(change):
            thing = f"{change.kind} '{change.name}'" if change.name else f"the {change.kind}"
            gone = change.owner if change.change == "added" else thing
            self.orphans.append((edit, why or f"{gone} is gone"))

    # --- one change each ---

    def _renamed(self, edit: Edit, thing: Thing) -> None:
        before, after = edit.change.before, edit.change.after
        if after == thing.name or before == after:
            return
        if thing.name != before and not self._edit_wins(edit, "name", thing.name):
            return
        if self._is_taken(Thing(thing.kind, after, None, thing.owner)):
            self.conflicts.append(Conflict(edit.change, thing.name, "urdf"))
            return
        thing.name = thing.part.name = after

    def _added(self, edit: Edit, owner: Thing) -> None:
        kind, part = edit.change.kind, deepcopy(edit.source.part)
        things = []
        sources = [thing for thing in self.edited if _root(thing, [edit.source])]
        for source, thing in zip(sources, new_things(kind, part, owner), strict=True):
            if source in self.news:  # what was only moved to it comes by itself
                self._take_out(thing)
            else:
                self.news[source] = thing
                things.append(thing)
        if kind == "view" and owner.part.view:
            self._orphan(edit, "the URDF has a view of its own there now")
            return
        for thing in things:
            if self._is_taken(thing):
                self._orphan(edit, f"the URDF has a {thing.kind} '{thing.name}' of its own now")
                return
        self.model += things
        for source in sources:
            thing = self.news[source]
            for field in source.refers if thing in things and thing.kind != "parameter" else ():
                targets, gone = self._resolve(self.news, source, field)
                if gone:
                    self._orphan(edit, gone)
                    self.model = [thing for thing in self.model if thing not in things]
                    return
                thing.refers = {**thing.refers, field: targets}
        self._put[things[0]] = edit
        self._insert(things[0], edit.source)

    def _moved(self, edit: Edit, thing: Thing) -> None:
        assert edit.before is not None
        was, owner = (
            known.get(side.owner) if side.owner else None
            for known, side in ((self.olds, edit.before), (self.news, edit.source))
        )
        if owner is None or owner not in self.model:
            self._orphan(edit, f"{edit.change.after} is gone")
        elif thing.owner is not owner and (
            thing.owner is was or self._edit_wins(edit, "owner", in_words(thing.owner or owner))
        ):
            self._take_out(thing)
            away, thing.owner = thing.owner, owner
            self._insert(thing, edit.source)
            self._put[thing] = edit
            self._left.setdefault(away, []).append(thing)

    def _changed(self, edit: Edit, thing: Thing) -> None:
        change, field = edit.change, edit.change.field
        if field in thing.refers:
            assert edit.before is not None
            was, _ = self._resolve(self.olds, edit.before, field)
            targets, gone = self._resolve(self.news, edit.source, field)
            now = thing.refers[field]
            # the point of a body that hangs on another body now stays behind
            point = now[0] if field == "point" else None
            left = isinstance(point, Thing) and point.owner is not thing.refers["parent"][0]
            if gone:
                self._orphan(edit, gone)
            elif targets != now and (
                was == now or left or self._edit_wins(edit, field, _called(now))
            ):
                self._hung.setdefault(thing, (edit, thing.refers))
                thing.refers = {**thing.refers, field: targets}
            return
        value, (whole, _, inner) = plain_values(thing).get(field), field.partition(".")
        # what is of an element that the model does not know stays in the file by itself
        if value == change.after or not hasattr(thing.part, whole):
            return
        if value == change.before or self._edit_wins(edit, field, value):
            if inner and None in (getattr(edit.source.part, whole), getattr(thing.part, whole)):
                setattr(thing.part, whole, deepcopy(getattr(edit.source.part, whole)))
            elif inner:
                setattr(getattr(thing.part, whole), inner, change.after)
            else:
                setattr(thing.part, whole, change.after)

    def _reordered(self, edit: Edit, owner: Thing) -> None:
        kind = edit.change.kind
        parts = getattr(owner.part, LISTS[kind])
        there = {id(part): place for place, part in enumerate(parts)}
        orders = [
            [known[t].part for t in order if t in known and t.kind == kind and t.owner is whole]
            for known, order, whole in (
                (self.olds, self.olds, edit.before),
                (self.news, self.edited, edit.source),
            )
        ]
        both = set.intersection(set(there), *({id(part) for part in order} for order in orders))
        orders = [[part for part in order if id(part) in both] for order in orders]
        before, after = ([there[id(part)] for part in order] for order in orders)
        if before != sorted(before) and (
            after == sorted(after)
            or not self._edit_wins(edit, "order", [part.name for part in parts])
        ):
            return
        for place, part in zip(sorted(after), orders[1], strict=True):
            parts[place] = part

    def _removes(self, edits: list[Edit]) -> None:
        """Find what people removed, and the URDF did not change."""
        for edit in edits:
            thing = edit.target
            if edit.change.change == "removed" and thing is not None:
                changed = any(_root(one, [thing]) for one in self.model if one in self.touched)
                if not changed or self._edit_wins(edit, "removed", content(thing.part)):
                    self._doomed[thing] = edit

    def _untangle(self) -> None:
        """Hang a body back that hangs on itself, as each side hung one on another."""
        for thing, (edit, before) in self._hung.items():
            above: Any = thing
            seen: set[Any] = set()
            while isinstance(above, Thing) and above not in seen:
                seen.add(above)
                above = above.refers.get("parent", [None])[0]
            if above is thing:
                now = _called(before["parent"])
                self.conflicts.append(Conflict(edit.change, now, "urdf"))
                thing.refers = before

    def _remove(self) -> None:
        """Take away what people removed, unless something needs it."""
        doomed = self._doomed
        while True:
            gone = [thing for thing in self.model if _root(thing, doomed) is not None]
            needed = {
                root
                for thing in self.model
                if thing.kind != "parameter" and thing not in gone
                for targets in thing.refers.values()
                for target in targets
                if isinstance(target, Thing) and (root := _root(target, doomed)) is not None
            }
            have_joints = {t.owner for t in self.model if t.kind == "joint" and t not in gone}
            for thing in self.model:
                if thing.kind == "body" and thing not in gone and thing not in have_joints:
                    needed |= self._bare(thing)
            if not needed:
                break
            for root in needed & doomed.keys():
                self.conflicts.append(Conflict(doomed.pop(root).change, "it is needed", "urdf"))
        for thing in doomed:
            self._take_out(thing)
        self.model = [thing for thing in self.model if thing not in gone]

    def _bare(self, body: Thing) -> set[Thing]:
        """Give a body a joint, as no body is without: one that people removed or moved away, or,
        if they added the body, one that the URDF has elsewhere."""
        for joint in self._doomed:
            if joint.kind == "joint" and joint.owner is body:
                return {joint}
        added = self._put.get(body)
        own = [t for t in self.edited if added and t.kind == "joint" and t.owner is added.source]
        for joint in self._left.get(body) or [self.news[t] for t in own if t in self.news]:
            edit = added or self._put[joint]
            self.conflicts.append(
                Conflict(edit.change, "no joint for it", "edited" if added else "urdf")
            )
            self._take_out(joint)
            joint.owner = body
            body.part.joints.append(joint.part)
            return {joint}
        return set()

    def _one_each(self) -> None:
        """Leave each point one sensor and one force: what an edit put there goes, if the URDF has
        one there."""
        there: dict[tuple[Thing | None, str], Thing] = {}
        for thing in sorted(self.model, key=self._put.__contains__):
            if thing.kind not in FIELDS:
                continue
            stays = there.setdefault((thing.owner, thing.kind), thing)
            if stays is not thing:
                self._insert(stays)
                self.model.remove(thing)
                why = f"the URDF has a {thing.kind} of its own there now"
                self._orphan(self._put[thing], why)

    # --- things, names and places ---

    def _is_taken(self, thing: Thing) -> bool:
        """Whether the name of a thing is one of another that is there."""
        return thing.kind not in _NAMED_FREELY and any(
            other.kind == thing.kind and other.name == thing.name and other is not thing
            and (other.kind not in _NAMED_IN_OWNER or other.owner is thing.owner)
            for other in self.model
        )  # fmt: skip

    def _resolve(
        self, known: Becomes, thing: Thing, field: str
    ) -> tuple[tuple[Thing | str | None, ...], str]:
        """What a field of a thing of another version refers to now, and the words for what is
        gone; a text names nothing in its version either."""
        found: list[Thing | str | None] = []
        gone = ""
        for target in thing.refers[field]:
            now = known.get(target) if isinstance(target, Thing) else target
            if isinstance(target, Thing) and now not in self.model:
                gone = gone or f"{target.kind} '{target.name}' is gone"
            found.append(now)
        return tuple(found), gone

    def _insert(self, thing: Thing, source: Thing | None = None) -> None:
        """Put an object into its owner, after the nearest that it follows in the edited file."""
        owner = thing.owner
        assert owner is not None
        if thing.kind in FIELDS:
            setattr(owner.part, FIELDS[thing.kind], thing.part)
            return
        parts = getattr(owner.part, LISTS[thing.kind])
        assert source is not None
        like = [t for t in self.edited if t.kind == source.kind and t.owner is source.owner]
        before = [id(self.news[t].part) for t in like[: like.index(source)] if t in self.news]
        places = [n for n, part in enumerate(parts, 1) if id(part) in before[-1:]]
        parts.insert(places[0] if places else len(parts) if before else 0, thing.part)

    def _take_out(self, thing: Thing) -> None:
        """Take an object out of its owner."""
        owner = thing.owner
        assert owner is not None
        if thing.kind in FIELDS:
            if getattr(owner.part, FIELDS[thing.kind]) is thing.part:
                setattr(owner.part, FIELDS[thing.kind], None)
            return
        attribute = LISTS[thing.kind]
        parts = getattr(owner.part, attribute)
        setattr(owner.part, attribute, [part for part in parts if part is not thing.part])

    def _write_references(self) -> None:
        """Name what is referred to by the names that it has now."""
        for thing in self.model:
            part, refers = thing.part, thing.refers
            if thing.kind == "body":
                part.parent = _name(refers["parent"][0])
                part.point = _name(refers["point"][0])
            elif thing.kind in ("cut", "link"):
                for end in ("endpoint1", "endpoint2"):
                    setattr(part, end, tuple(map(_name, refers[end])))
            elif thing.kind == "user constraint":
                part.joints = tuple(_name(joint) or "" for joint in refers["joints"])
            elif thing.kind == "parameter" and refers:
                part.name = thing.name = _name(refers["name"][0]) or thing.name  # its joint's
            elif thing.kind in ("viewpoint", "light"):
                part.joint = _name(refers["joint"][0]) or BASE


def is_place(change: Change) -> bool:
    """True if a change is of the 2D diagram."""
    drawn = change.field == "position" and change.kind not in DRAWN
    return drawn or change.field.startswith("drawing.")


def _name(target: Thing | str | None) -> str | None:
    """How a file names a body, point or joint; None is the base and a body's own frame."""
    if not isinstance(target, Thing):
        return target
    return None if target.kind == "base" else target.name


def _called(targets: tuple[Thing | str | None, ...]) -> list[str]:
    return [ORIGIN if name is None else name for name in map(_name, targets)]


def _root(thing: Thing | None, doomed: Container[Thing]) -> Thing | None:
    """The doomed thing that a thing is, or belongs to."""
    while thing is not None and thing not in doomed:
        thing = thing.owner
    return thing


def new_things(kind: str, part: Any, owner: Thing | None) -> list[Thing]:
    """The things that an object is and holds."""
    whole = [Thing(kind, getattr(part, "name", ""), part, owner)]
    for inner in _HOLDS.get(kind, ()):
        held = getattr(part, FIELDS.get(inner) or LISTS[inner])
        parts = held if isinstance(held, list) else [held] if held is not None else []
        for held_part in parts:
            whole += new_things(inner, held_part, whole[0])
    return whole
