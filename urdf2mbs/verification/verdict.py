"""The result of ``verify``, and how it is told."""

from __future__ import annotations

from collections.abc import Iterator

from urdf2mbs.messages.diagnostics import Diagnostic, some
from urdf2mbs.proof.findings import Finding
from urdf2mbs.proof.match import Exchange
from urdf2mbs.proof.verdict import Proof

#: The most exchanges that are told.
MOST_EXCHANGES = 3


class Verdict(Proof, kw_only=True):
    """The result of ``verify``: a proof, and how the two sides match."""

    robot: str
    model: str = ""
    """The file that was compared with the robot."""
    base: str
    """``floating`` or ``fixed``, as the .mbs has it."""
    floating_base: tuple[str, ...] = ()
    """The six .mbs joints of a floating base that is not in the URDF."""
    joints: dict[str, tuple[str, ...]] = {}
    """The URDF's moving joints that the .mbs has too, and its names for them."""
    by: dict[str, str] = {}
    """How each of these joints was found: by its ``name``, a ``map``, or its ``place``."""
    equal: list[list[str]] = []
    """Groups of joints that may be exchanged: the numbers cannot tell them apart."""
    against: list[Exchange] = []
    """Joints found by place, which would match otherwise by name, with more differences."""
    turned: bool = False
    """Whether the whole robot may be turned, with as few differences."""
    instead_of_names: int = 0
    """How many joints would differ by their names, if joints of the same name were not matched."""
    moving: int
    """The number of moving joints of the URDF."""
    findings: list[Finding] = []
    """The differences by their causes: what matters most for the motion first."""
    changed: list[str] = []
    """The changes of the URDF's robot by the passes of a config, a sentence for each pass."""
    diagnostics: list[Diagnostic] = []
    """Warnings and notes of reading the URDF."""
    made_of: str = ""
    """Path of the second robot, if two robots were compared."""
    first: str = "the URDF"
    """What the messages call the first robot."""
    second: str = "the .mbs"
    """What the messages call the second robot."""

    @property
    def verdict(self) -> str:
        """The verdict in words, the same as those of a conversion."""
        return self.describe(self.changed)

    def describe_match(self) -> Iterator[str]:
        """Yield lines on how the joints match."""
        yield self._count_joints()
        by_place = [name for name, how in self.by.items() if how == "place"]
        if by_place:
            pairs = [f"{name} = {' '.join(self.joints[name])}" for name in by_place]
            yield f"by place: {some(pairs, 12)}"
        for group in self.equal:
            yield f"{some(group, 6)} may be exchanged: the numbers are the same"
        if self.turned:
            yield "the whole robot may be turned: the numbers are as near"
        instead = f"instead of {self.count_differing()} (--map FILE decides)"
        for exchange in self.against[:MOST_EXCHANGES]:
            first, second = (f"'{name}'" for name in exchange.joints)
            yield (
                f"by name, {first} and {second} would match the other way round, with differences "
                f"at {exchange.differing} joints {instead}"
            )
        if len(self.against) > MOST_EXCHANGES:
            yield f"and so would {len(self.against) - MOST_EXCHANGES} more pairs"
        if self.instead_of_names:
            yield (
                "joints of the same name are not at the same place: by names there would be "
                f"differences at {self.instead_of_names} joints {instead}"
            )

    def name_sides(self, first: str, second: str) -> None:
        """Name the two robots in all messages, which are worded for a URDF and an .mbs.

        Args:
            first: The name of the first robot.
            second: The name of the second one.
        """

        def reword(text: str) -> str:
            text = text.replace("the one that the passes made", f"that of {first}")
            text = text.replace("a URDF has none", "each file may choose it")
            return text.replace(self.first, first).replace(self.second, second)

        for difference in (*self.differences, *self.frames):
            difference.message = reword(difference.message)
        for finding in self.findings:
            finding.message = reword(finding.message)
        for reasons in (self.but_for, self.not_compared):
            items = [(reword(item), reword(reason)) for item, reason in reasons.items()]
            reasons.clear()
            reasons.update(items)
        self.first, self.second = first, second

    def _count_joints(self) -> str:
        """Return how many joints match, and how."""
        counts = dict.fromkeys(("name", "map", "place"), 0)
        for how in self.by.values():
            counts[how] += 1
        used = [f"{number} by {how}" for how, number in counts.items() if number]
        matches = f"{len(self.joints)} of {self.moving} joints match"
        only_names = not counts["map"] and not counts["place"]
        return f"{matches} by name" if only_names else f"{matches} ({', '.join(used)})"
