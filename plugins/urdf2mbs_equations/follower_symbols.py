r"""The rules of followers (``<mimic>``) in symbols: q_3 = -r_3 q_2 + b_3.

Multipliers such as -1 and 1/2 are numbers, and all others are symbols, r; offsets are symbols, b.
Where q_3 = -q_2 is an angle, it is not a variable of its own: a sine of it is one of q_2.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from urdf2mbs.plugin import Mbs, quoted
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.formulas import Product, Sum, Symbol
from urdf2mbs_equations.polynomials import Polynomial, Ring
from urdf2mbs_equations.symbols import RANKS, Quantity
from urdf2mbs_equations.tree import is_fixed

#: The largest denominator of a multiplier that is a number in formulas.
MAX_DENOMINATOR = 8


class _Factor(NamedTuple):
    """A multiplier: a number, or a sign and a symbol."""

    number: Fraction
    name: str | None
    """That of the symbol in the ring."""


class FollowerSymbols:
    """The rules of the followers of one model."""

    def __init__(
        self,
        followers: Sequence[Follower],
        joints: Mapping[int, Joint],
        coordinates: Mapping[str, Symbol],
    ) -> None:
        """Take the rules of followers.

        Args:
            followers: Joints that follow others which move.
            joints: The joints that move, by their numbers.
            coordinates: The symbols of q and qd of these, by names such as ``q[3]``.
        """
        self.joints, self.coordinates = joints, coordinates
        self.symbols: dict[str, Symbol] = {}
        """The symbols of multipliers and offsets, by their names in the ring."""
        self.quantities: dict[Symbol, Quantity] = {}
        """What these stand for."""
        self.factors: dict[int, dict[int, _Factor]] = {}
        """By follower and leader."""
        self.offsets: dict[int, str | None] = {}
        """By follower, the name of the offset in the ring; None if it is zero."""
        for follower in followers:
            self._add(follower)

    def _add(self, follower: Follower) -> None:
        joint = self.joints[follower.joint]
        meaning = f"multiplier of {quoted(joint.name)}"
        self.factors[follower.joint] = {}
        for leader, value in follower.factors.items():
            number, name = Fraction(value), None
            if number.denominator > MAX_DENOMINATOR:
                number, name = Fraction(1 if value > 0 else -1), f"r[{follower.joint}][{leader}]"
                more = self.coordinates[f"q[{leader}]"].subscript * (len(follower.factors) > 1)
                self._name(name, follower.joint, more, Quantity(abs(value), "", meaning))
            self.factors[follower.joint][leader] = _Factor(number, name)
        self.offsets[follower.joint] = None
        if follower.offset:
            name = self.offsets[follower.joint] = f"b[{follower.joint}]"
            unit = "rad" if joint.type[0] == "R" else "m"
            meaning = f"offset of {quoted(joint.name)}"
            self._name(name, follower.joint, "", Quantity(follower.offset, unit, meaning))

    def _name(self, name: str, joint: int, more: str, quantity: Quantity) -> None:
        letter, subscript = name[0], self.coordinates[f"q[{joint}]"].subscript + more
        symbol = self.symbols[name] = Symbol(RANKS[letter], letter, subscript)
        self.quantities[symbol] = quantity

    def find_multiples(self) -> dict[str, tuple[str, int]]:
        """Return the angles of followers that are whole multiples of an angle."""
        multiples: dict[str, tuple[str, int]] = {}
        for joint, factors in self.factors.items():
            (leader, (number, name)), *more = factors.items()
            are_angles = self.joints[joint].type[0] == self.joints[leader].type[0] == "R"
            is_whole = number.denominator == 1 and name is None and self.offsets[joint] is None
            if are_angles and is_whole and not more:
                multiples[f"q[{joint}]"] = f"q[{leader}]", int(number)
        return multiples

    def is_substituted(self, name: str) -> bool:
        """Return True for the q of a follower that slides as others do.

        An angle is no variable of the ring, but exp(i q).  So a follower of an angle keeps the
        symbol of its position.
        """
        coordinates = {f"q[{joint}]": factors for joint, factors in self.factors.items()}
        return name in coordinates and not any(
            self.joints[joint].type[0] == "R" for joint in coordinates[name]
        )

    def make_row(self, ring: Ring, joint: int) -> dict[int, Polynomial]:
        """Return a row of T: by leader, the multiplier; of a joint that leads, 1."""
        if joint not in self.factors:
            return {joint: ring.make_constant(1)}
        return {
            leader: ring.make_power(name, 1, complex(number))
            if name
            else ring.make_constant(complex(number))
            for leader, (number, name) in self.factors[joint].items()
        }

    def make_offset(self, ring: Ring, joint: int) -> Polynomial:
        """Return the offset of a follower."""
        name = self.offsets[joint]
        return ring.make_power(name) if name else {}

    def list_relations(self) -> dict[Symbol, Sum]:
        """Return what the coordinate of each follower is."""
        relations = {}
        for joint, factors in self.factors.items():
            terms = []
            for leader, (number, name) in factors.items():
                coordinate = (self.coordinates[f"q[{leader}]"], 1)
                factor = ((self.symbols[name], 1),) if name else ()
                terms.append(Product(number, (*factor, coordinate)))
            offset = self.offsets[joint]
            if offset:
                terms.append(Product(Fraction(1), ((self.symbols[offset], 1),)))
            relations[self.coordinates[f"q[{joint}]"]] = Sum(tuple(terms))
        return relations


def lock_followers(mbs: Mbs, followers: Sequence[Follower]) -> tuple[Mbs, list[Follower]]:
    """Lock followers of joints that never move.

    Returns:
        A copy of the model, and the followers that move, by leaders that do.
    """
    mbs = copy.deepcopy(mbs)
    joints = dict(enumerate(mbs.joints().values(), start=1))
    moving = []
    for number, all_factors, offset in followers:
        factors = {}
        for leader, factor in all_factors.items():
            if is_fixed(joints[leader]):
                offset += factor * (joints[leader].q or 0.0)
            elif factor:
                factors[leader] = factor
        if factors:
            moving.append(Follower(number, factors, offset))
        else:
            joint = joints[number]
            joint.nature, joint.q, joint.symbols = "driven", offset, ("q",)
    return mbs, moving
