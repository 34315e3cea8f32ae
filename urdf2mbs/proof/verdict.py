"""The result of a comparison of two robots, and the verdict in words: the same on the terminal, on
the page, in JSON and in the file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from urdf2mbs.messages.diagnostics import counted, some

NOT_CHECKED = "NOT CHECKED"
NOT_THE_SAME = "NOT the same robot"
THE_SAME = "the same robot"


class Difference(msgspec.Struct, omit_defaults=True):
    """One thing that is not the same."""

    kind: str
    message: str
    size: float = 1.0
    """Relative, at most 1, and 1 where there is no measure."""
    link: str | None = None
    joint: str | None = None
    urdf: Any = None
    mbs: Any = None

    def __post_init__(self) -> None:
        self.size = min(self.size, 1.0)


class Proof(msgspec.Struct, kw_only=True):
    """The result of a comparison: is the .mbs the same robot as the URDF?"""

    same: bool
    positions: int
    """The number of positions at which the motion was compared, zero included."""
    groups: int
    """The number of rigid groups, the ground among them."""
    largest: dict[str, float]
    """The largest relative deviation of each kind, differences or not."""
    differences: list[Difference]
    """Why it is not the same, the largest first."""
    frames: list[Difference] = []
    """Link frames that are elsewhere in the .mbs: by itself a matter of convention."""
    urdf_mass: float
    """kg, of all that can move."""
    mbs_mass: float
    """kg, of all that can move."""
    but_for: dict[str, str]
    """Known deviations from the URDF that are no difference by themselves: each thing, and why."""
    not_compared: dict[str, str]
    """The things that Robotran reads and nothing here compares, each with the reason."""

    @property
    def compared(self) -> str:
        """What was looked at, and the largest relative deviation of each kind, or how many
        differences there are: what differs need not be a number."""
        compared = f"{counted(self.groups, 'rigid group')} at {self.positions} positions"
        if self.differences:
            return f"{compared}: {counted(len(self.differences), 'difference')}"
        found = ", ".join(f"{kind} {off:.1e}" for kind, off in self.largest.items())
        return f"{compared}; largest deviations: {found}"

    def differ(self, differences: Iterable[Difference]) -> None:
        """Add differences; of one size, before those that are there."""
        self.differences = sorted([*differences, *self.differences], key=lambda found: -found.size)
        self.same = not self.differences

    def count_frames(self) -> None:
        """Make each frame that is elsewhere a difference."""
        found, self.differences = self.differences, self.frames
        self.frames = []
        self.differ(found)

    def forgive(self, why: str) -> None:
        """Make differences known deviations, but for what a pass changed and did not say."""
        kept = [found for found in self.differences if found.kind == "changed"]
        self.but_for |= {d.message: why for d in self.differences if d not in kept}
        self.differences, self.same = kept, not kept

    def in_words(self, changes: Sequence[str] = ()) -> str:
        """``NOT the same robot``, or ``the same robot, but for ...; not compared: ...``.

        ``changes`` are sentences of what passes changed on purpose.
        """
        if not self.same:
            return NOT_THE_SAME
        known = [*changes, *_grouped(self.but_for)]
        words = THE_SAME + (f", but for {'; '.join(known)}" if known else "")
        left = "; ".join(_grouped(self.not_compared))
        return words + (f"; not compared: {left}" if left else "")


def _grouped(things: Mapping[str, str]) -> list[str]:
    """Things of one reason together: ``a, b (why)``; of many joints, or links, the number."""
    by_reason: dict[str, list[str]] = {}
    for thing, why in things.items():
        by_reason.setdefault(why, []).append(thing)
    grouped = []
    for why, names in by_reason.items():
        kinds = {name.partition(" '")[0] for name in names}
        many = len(names) > 3 and kinds in ({"joint"}, {"link"})
        grouped.append(f"{counted(len(names), *kinds) if many else some(names, 3)} ({why})")
    return grouped
