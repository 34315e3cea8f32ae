"""The result of a comparison of two robots, and the verdict in words.

The words are the same on the terminal, on the page, in JSON and in the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from urdf2mbs.messages.diagnostics import counted, some

NOT_CHECKED = "NOT CHECKED"
NOT_THE_SAME = "NOT the same robot"
THE_SAME = "the same robot"


class Difference(msgspec.Struct, omit_defaults=True):
    """A difference between the URDF and the .mbs."""

    kind: str
    message: str
    size: float = 1.0
    """The relative deviation; at most 1, and 1 if there is no measure."""
    link: str | None = None
    joint: str | None = None
    urdf: Any = None
    """The value that the URDF has."""
    mbs: Any = None
    """The value that the .mbs has."""
    body: str | None = None
    """The body of the .mbs, if no link of the URDF is its counterpart."""

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
    """The largest relative deviation of each kind, whether it is a difference or not."""
    differences: list[Difference]
    """Why it is not the same robot, the largest first."""
    frames: list[Difference] = []
    """Link frames that are displaced in the .mbs; by default a matter of convention."""
    urdf_mass: float
    """kg, of all bodies that can move."""
    mbs_mass: float
    """kg, of all bodies that can move."""
    but_for: dict[str, str]
    """Known deviations from the URDF that are not differences, each with the reason."""
    not_compared: dict[str, str]
    """What Robotran reads and nothing here compares, each with the reason."""
    confirmed: list[str] = []
    """What another program computes for the same robot: ``as MuJoCo computes it, to 1e-13``."""

    @property
    def compared(self) -> str:
        """How much was compared, and the largest deviations, or the number of differences."""
        compared = f"{counted(self.groups, 'rigid group')} at {self.positions} positions"
        if self.differences:
            return f"{compared}: {counted(len(self.differences), 'difference')}"
        largest = ", ".join(f"{kind} {deviation:.1e}" for kind, deviation in self.largest.items())
        return f"{compared}; largest deviations: {largest}"

    def count_differing(self) -> int:
        """Count the joints, links and other things that have a difference."""
        return len({each.joint or each.link or each.message for each in self.differences})

    def add_differences(self, differences: Iterable[Difference]) -> None:
        """Add differences; of those of the same size, the new ones come first."""
        merged = [*differences, *self.differences]
        self.differences = sorted(merged, key=lambda difference: -difference.size)
        self.same = not self.differences

    def drop_differences(
        self, faults: Sequence[Difference], names: Mapping[str, Sequence[str]]
    ) -> None:
        """Drop differences that the first robot has from itself.

        Args:
            faults: These differences.
            names: The joints of the first robot, and their names in the second one.
        """
        if not faults:
            return
        keys = {(each.kind, each.joint, each.mbs) for each in faults}
        keys |= {
            (each.kind, names[each.joint][0], each.mbs)
            for each in faults
            if each.joint is not None and each.joint in names
        }
        self.differences = [
            each for each in self.differences if (each.kind, each.joint, each.mbs) not in keys
        ]
        self.same = not self.differences

    def add_frames(self) -> None:
        """Add the link frames that are displaced to the differences."""
        differences, self.differences = self.differences, self.frames
        self.frames = []
        self.add_differences(differences)

    def accept_differences(self, reason: str) -> None:
        """Make the differences known deviations, but not changes that no pass declared."""
        undeclared = [each for each in self.differences if each.kind == "changed"]
        accepted = [each for each in self.differences if each.kind != "changed"]
        self.but_for |= {difference.message: reason for difference in accepted}
        self.differences, self.same = undeclared, not undeclared

    def describe(self, changes: Sequence[str] = ()) -> str:
        """Return the verdict in words.

        Args:
            changes: Sentences about what passes changed on purpose.

        Returns:
            ``NOT the same robot``, or ``the same robot, but for ...; not compared: ...``.
        """
        if not self.same:
            return NOT_THE_SAME
        deviations = [*changes, *_group_by_reason(self.but_for)]
        words = ", and ".join([THE_SAME, *dict.fromkeys(self.confirmed)])
        words += f", but for {'; '.join(deviations)}" if deviations else ""
        not_compared = "; ".join(_group_by_reason(self.not_compared))
        return words + (f"; not compared: {not_compared}" if not_compared else "")


def _group_by_reason(reasons: Mapping[str, str]) -> list[str]:
    """Return the items of each reason together: ``a, b (reason)``.

    Of more than three joints, or links, only the number is named.
    """
    items_of_reason: dict[str, list[str]] = {}
    for item, reason in reasons.items():
        items_of_reason.setdefault(reason, []).append(item)
    phrases = []
    for reason, items in items_of_reason.items():
        kinds = {item.partition(" '")[0] for item in items}
        is_long = len(items) > 3 and kinds in ({"joint"}, {"link"})
        names = counted(len(items), *kinds) if is_long else some(items, 3)
        phrases.append(f"{names} ({reason})")
    return phrases
