"""Three tables become one: which side gives the value of each path, and what stands.

One rule for each path: where one side alone changed a value, its value counts; where both did, the
owner of the value decides.  A thing of one side stands, unless the other side took it away.  Then
the whole is made one that a file can hold: each reference has its target, each name one thing, each
point one sensor, each body a joint, and no body hangs on itself.  Where it is not, the other side
gives the value, or a thing that people removed comes back, or a thing of theirs cannot stand.
Each of these is a conflict or an orphan, and each is done once, so it ends.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import Any, Literal

from urdf2mbs_edits.diff.changes import Path, compare
from urdf2mbs_edits.diff.flat import Thing, Version, is_place

Side = Literal["urdf", "edited"]
#: Who wins where both changed the same thing: for all fields, or field by field.
Prefer = Side | dict[str, Side]

#: What people set: there an edit wins.  All else is what the URDF defines.
_KINDS_OF_PEOPLE = frozenset(["sensor", "force", "view", "viewpoint", "light", "user variable"])
_FIELDS_OF_PEOPLE = frozenset(
    ["q", "qd", "qdd", "nature", "symbols", "actuated", "color", "transparency"]
)
#: A path's field as people prefer it.
_CALLED = {"": "removed", "place": "parent"}
#: The things of which their owner has one; those whose names are unique in their owner, or nowhere.
_SINGLE = frozenset(["sensor", "force", "view"])
_NAMED_IN_OWNER = frozenset(["point", "parameter"])
_NAMED_FREELY = frozenset(["model", "base", "shape", "view", "viewpoint", "light"])


class Settled:
    """What becomes of two sides of one base; ours is the edited one.

    ``prefer`` None: people made both sides, and ours wins.
    """

    def __init__(
        self, base: Version, ours: Version, theirs: Version, prefer: Prefer | None
    ) -> None:
        self.base, self.ours, self.theirs, self.prefer = base, ours, theirs, prefer
        self.other, self.own = ("theirs", "ours") if prefer is None else ("the URDF", "the edit")
        self.taken: set[Path] = set()
        """The paths whose values theirs gives, of things that both sides have."""
        self.contested: dict[Path, str] = {}
        """What nobody can decide: where both sides changed a value, or a file cannot hold it."""
        self.homeless: dict[Path, str] = {}
        """Where ours refers to what is gone, so that theirs counts; and why."""
        self.lost: dict[int, str] = {}
        """What cannot stand, and why."""
        self.doomed: set[int] = set()
        """What ours removed, each the largest thing."""
        self.edits = {path: change for change, path in reversed(compare(base, ours))}
        """What ours changed, by the paths."""
        self.moved = prefer is not None and any(
            is_place(change.kind, field) for (_, field), change in self.edits.items()
        )
        """Whether people moved something in a diagram that is made anew: then it stays theirs."""
        for number in [number for number in ours.values if number in theirs.values]:
            self._take(number)
        self._doom()
        self.stand()
        while any([self._refer(), self._be_alone(), self._have_joints(), self._untangle()]):
            pass

    # --- one rule for each path ---

    def _take(self, number: int) -> None:
        """Decide each value of a thing that both sides have."""
        was, own, other = (
            version.values.get(number, {}) for version in (self.base, self.ours, self.theirs)
        )
        kind = self.ours.things[number].kind
        for field in dict.fromkeys([*own, *other]):
            before, mine, then = was.get(field), own.get(field), other.get(field)
            if self.moved and mine is not None and is_place(kind, field):
                continue
            if field[0] == "[" or then in (mine, before):
                continue
            if mine == before or self._theirs_wins(number, field):
                self.taken.add((number, field))

    def _theirs_wins(self, number: int, field: str) -> bool:
        """Who wins where both changed the same; a conflict, if it is not of people by nature."""
        kind = self.base.things.get(number, self.ours.things.get(number)).kind  # type: ignore[union-attr]
        of_people = kind in _KINDS_OF_PEOPLE or field in _FIELDS_OF_PEOPLE
        kept = is_place(kind, field) or (of_people and self.prefer is not None)
        wins: Side = "edited" if kept or self.prefer in ("edited", None) else "urdf"
        if isinstance(self.prefer, dict):
            called = [_CALLED.get(field, field.strip("?[]").split(".")[0])]
            called += ["point"] * (field == "place") + ["order"] * (field[:1] == "[")
            wins = next((self.prefer[name] for name in called if name in self.prefer), wins)
        if not kept:
            self.contested[number, field] = ""
        return wins == "urdf"

    def _doom(self) -> None:
        """Find what ours removed; where theirs changed something in it, one of the two wins."""
        gone = [
            n for n in self.theirs.values if n in self.base.values and n not in self.ours.values
        ]
        touched = set()
        for number in gone:
            was, now = self.base.values[number], self.theirs.values[number]
            kind = self.base.things[number].kind
            for field in [*was, *now]:
                before, then = was.get(field), now.get(field)
                if field[0] == "[":  # what theirs took out or moved in it is no reason to keep it
                    before, then = set(), set(then or ()) - set(before or ())
                if before != then and not is_place(kind, field):
                    touched |= {thing.number for thing in _with_owners(self.theirs.things[number])}
        for number in gone:
            whole = self.base.values[number]["owner"] in self.ours.values
            if whole and not (number in touched and self._theirs_wins(number, "")):
                self.doomed.add(number)

    # --- what stands ---

    def stand(self) -> None:
        """Find what stands: the things of both sides, but for what a side took away."""
        self.there = {
            number: thing
            for number, thing in {**self.theirs.things, **self.ours.things}.items()
            if number not in self.lost and self._doomed(number) is None
            and (number in self.theirs.things or number not in self.base.things)
        }  # fmt: skip

    def _doomed(self, number: int) -> int | None:
        """The doomed thing in which a thing of theirs is."""
        if number in self.ours.things or number not in self.theirs.things:
            return None
        for thing in _with_owners(self.theirs.things[number]):
            if thing.number in self.ours.things:
                break
            if thing.number in self.doomed:
                return thing.number
        return None

    def is_ours(self, number: int, field: str) -> bool:
        """Whether ours gives a value."""
        return number in self.ours.values and (number, field) not in self.taken

    def value(self, number: int, field: str) -> Any:
        side = self.ours if self.is_ours(number, field) else self.theirs
        return side.values[number].get(field)

    def _said(self, number: int) -> dict[str, Any]:
        return self.ours.values.get(number) or self.theirs.values[number]

    def name(self, number: int) -> str:
        """The name of a thing; a parameter may be called as its joint."""
        value = self.value(number, "name")
        target = value[0] if isinstance(value, tuple) else value
        if not isinstance(target, int):
            return str(target)
        if target in self.there:
            return self.name(target)
        return (self.ours if self.is_ours(number, "name") else self.theirs).things[number].name

    def _restore(self, number: int, why: str) -> None:
        """Let what people removed come back."""
        self.doomed.remove(number)
        self.contested[number, ""] = why
        self.stand()

    def _lose(self, number: int, why: str) -> None:
        self.lost[number] = why
        self.there.pop(number, None)

    def _give(self, number: int, field: str, said: dict[Path, str], why: str) -> bool:
        """Let the other side give a value, once, if its value can stand."""
        path = number, field
        if path in self.homeless or self.contested.get(path) or number not in self.ours.values:
            return False
        if number not in self.theirs.values:
            return False
        self.taken ^= {path}
        for target in _targets(self.value(number, field)):
            if target not in self.there and self._doomed(target) is None:
                self.taken ^= {path}
                return False
        self.contested.pop(path, None)
        said[path] = why
        return True

    def _give_or_lose(self, number: int, field: str, said: dict[Path, str], why: str) -> None:
        if not self._give(number, field, said, why):
            self._lose(number, why)

    # --- what a file can hold: each rule tells whether it did anything ---

    def _refer(self) -> bool:
        """What a thing belongs to, and refers to, is there."""
        done = False
        for number, thing in list(self.there.items()):
            for field in ["owner", *thing.refers]:
                targets = _targets(self.value(number, field)) if number in self.there else []
                gone = next((target for target in targets if target not in self.there), None)
                if gone is None or field == "name":  # a parameter may be called as nothing else
                    continue
                done = True
                root = self._doomed(gone)
                if root is not None and field != "owner" and not self.is_ours(number, field):
                    self._restore(root, f"{self.other} needs it")
                    continue
                target = self.ours.things.get(gone) or self.theirs.things[gone]
                why = f"{target.title()} is {'orphaned' if gone in self.lost else 'gone'}"
                self._give_or_lose(number, field, self.homeless, why)
        return done

    def _be_alone(self) -> bool:
        """No two things have one name, and no point has two sensors: what theirs has stays."""
        claims: dict[Hashable, list[Path]] = {}
        for number, thing in self.there.items():
            kind, owner = thing.kind, self.value(number, "owner")
            if kind in _SINGLE:
                claims.setdefault((kind, owner), []).append((number, "owner"))
            if kind not in _NAMED_FREELY:
                scope = owner if kind in _NAMED_IN_OWNER else ""
                claims.setdefault((kind, scope, self.name(number)), []).append((number, "name"))
        done = False
        for claim in claims.values():
            if len(claim) < 2 or all(self._has(self.ours, *path) for path in claim):
                continue
            for number, field in claim:
                if number in self.there and not self._has(self.theirs, number, field):
                    kind = self.there[number].kind
                    what = f"{kind} '{self.name(number)}'" if field == "name" else kind
                    there = "" if field == "name" else " there"
                    why = f"{self.other} has a {what} of its own{there} now"
                    self._give_or_lose(number, field, self.contested, why)
                    done = True
        return done

    def _has(self, version: Version, number: int, field: str) -> bool:
        """Whether a version has the value that a path has now."""
        values = version.values.get(number, {})
        return field in values and values[field] == self.value(number, field)

    def _have_joints(self) -> bool:
        """No body is without a joint: one that was removed or moved away comes back."""
        joints = {
            self.value(n, "owner") for n, thing in self.there.items() if thing.kind == "joint"
        }
        bare = [n for n, thing in self.there.items() if thing.kind == "body" and n not in joints]
        for body in bare:
            why = f"{self.there[body].title()} has no other joint"
            own = [*self.theirs.held(body, "joint"), *self.ours.held(body, "joint")]
            removed = [joint for joint in own if joint in self.doomed]
            if removed:
                self._restore(removed[0], why)
            elif not any(n in self.there and self._give(n, "owner", self.contested, why)
                         for n in own):  # fmt: skip
                self._lose(body, f"no joint is left for {self.there[body].title()}")
        return bool(bare)

    def _untangle(self) -> bool:
        """No body hangs on itself, as each side hung one on another."""
        safe: set[Any] = set()
        for body in [n for n, thing in self.there.items() if thing.kind == "body"]:
            way: list[int] = []
            above: Any = body
            while above in self.there and above not in safe and above not in way:
                way.append(above)
                above = (self.value(above, "place") or (None,))[0]
            circle = way[way.index(above) :] if above in way else []
            for one in sorted(circle, key=lambda n: not self.is_ours(n, "place")):
                if self._has(self.ours, one, "place") and self._has(self.theirs, one, "place"):
                    continue
                if self._give(one, "place", self.contested, "bodies hang on each other"):
                    return True
            safe |= {*way}
        return False

    # --- orders ---

    def orders(self) -> dict[Path, list[int]]:
        """What each thing holds now, by kind and in order."""
        held: dict[Path, set[int]] = {}
        for number, thing in self.there.items():
            if thing.owner is not None:
                held.setdefault((self.value(number, "owner"), f"[{thing.kind}]"), set()).add(number)
        orders = {path: self._ordered(path, here) for path, here in held.items()}
        for path in [path for path in orders if path[1] == "[body]"]:
            orders[path] = self._parents_first(orders[path])
        return orders

    def _parents_first(self, bodies: list[int]) -> list[int]:
        """The bodies as a file has them: each behind its parent."""
        order: dict[int, None] = {}
        for body in bodies:
            way: list[int] = []
            while body in self.there and body not in order and self.there[body].kind == "body":
                way.append(body)
                body = self.value(body, "place")[0]
            order |= dict.fromkeys(reversed(way))
        return list(order)

    def _ordered(self, path: Path, here: set[int]) -> list[int]:
        """What both sides have, as each side moved it, and what one side has alone behind what it
        stands behind there; of two such, the first by name."""
        number, kind = path[0], path[1][1:-1]
        was, own, other = (
            [one for one in version.held(number, kind) if one in here]
            for version in (self.base, self.ours, self.theirs)
        )
        common = self._common_order(path, was, own, other)
        alone = [_behind(order, set(common)) for order in (own, other)]
        order: list[int] = []
        for anchor in [None, *common]:
            order += [] if anchor is None else [anchor]
            runs = [run for run in (side.get(anchor, []) for side in alone) if run]
            if len(runs) == 2 and kind == "joint":  # which moves the other?
                runs = runs[::-1] if self._theirs_order_wins(path) else runs
            else:
                runs.sort(key=lambda run: [(self.name(one), repr(self._said(one))) for one in run])
            order += [one for run in runs for one in run]
        return order

    def _common_order(
        self, path: Path, was: list[int], own: list[int], other: list[int]
    ) -> list[int]:
        """The order of what both sides have: each two stand as the side that moved them has it."""
        both = set(own) & set(other)
        known = [[one for one in order if one in both] for order in (was, own, other)]
        if known[1] == known[2] or known[0] == known[2]:
            return known[1]
        if known[0] == known[1]:
            return known[2]
        ranks = [{one: rank for rank, one in enumerate(order)} for order in known]

        def stands_first(one: int, two: int) -> bool:
            before, mine, then = (
                rank[one] < rank[two] if one in rank and two in rank else None for rank in ranks
            )
            return bool(then if mine == before else mine)

        places = {one: sum(stands_first(two, one) for two in both - {one}) for one in both}
        if len(set(places.values())) == len(both) and both == set(known[0]):
            return sorted(both, key=places.__getitem__)
        return known[2] if self._theirs_order_wins(path) else known[1]

    def _theirs_order_wins(self, path: Path) -> bool:
        wins = self._theirs_wins(*path)
        self.taken |= {path} if wins else set()
        return wins


def _behind(order: list[int], common: set[int]) -> dict[int | None, list[int]]:
    """What is not common, by the common one behind which it stands."""
    behind: dict[int | None, list[int]] = {}
    anchor = None
    for one in order:
        if one in common:
            anchor = one
        else:
            behind.setdefault(anchor, []).append(one)
    return behind


def _targets(value: Any) -> Iterator[int]:
    for target in value if isinstance(value, tuple) else (value,):
        if isinstance(target, int):
            yield target


def _with_owners(thing: Thing) -> Iterator[Thing]:
    at: Thing | None = thing
    while at is not None:
        yield at
        at = at.owner
