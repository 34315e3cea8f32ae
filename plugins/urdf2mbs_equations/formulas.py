"""Formulas as trees: sums of products of symbols, sines, cosines, and sums in parentheses.

The length of a formula is the number of its signs: symbols, numbers, powers, + and -, parentheses.
Some count a little more, so that the shortest formula is what books write.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain
from typing import NamedTuple, TypeAlias


class Symbol(NamedTuple):
    """A symbol, such as ``l_{c2}``, or a time derivative of one."""

    rank: int
    """The order of symbols in a product."""
    letter: str
    """Such as ``l``, or ``alpha``."""
    subscript: str = ""
    n_dots: int = 0
    """1 for a velocity, 2 for an acceleration."""

    @property
    def length(self) -> float:
        """The signs to read: a mass counts more, since books write it only once."""
        return 1.2 if self.letter == "m" else 1.0

    @property
    def is_of_dynamics(self) -> bool:
        """True for masses, inertias, gravity and velocities; False for lengths and positions."""
        return self.letter in ("m", "I", "g") or self.n_dots > 0

    @property
    def name(self) -> str:
        """A name for programs, such as ``l_c2``, ``q_1`` and ``qdot_1``."""
        letter = self.letter + ("", "dot", "ddot")[self.n_dots]
        return f"{letter}_{self.subscript}" if self.subscript else letter


#: Symbols and their multiples: q_2 + q_3 is ``((q_2, 1), (q_3, 1))``.
Angle = tuple[tuple[Symbol, int], ...]


class Trigonometric(NamedTuple):
    """The sine or the cosine of an angle."""

    function: str
    """``cos`` or ``sin``."""
    angle: Angle

    @property
    def rank(self) -> int:
        """The order in a product: after all symbols but velocities."""
        return 50

    @property
    def is_plain_sum(self) -> bool:
        """True for angles such as q_1 + q_2, for which books write ``c_{12}``."""
        return all(multiple == 1 and symbol.letter == "q" for symbol, multiple in self.angle)

    @property
    def length(self) -> float:
        """The signs to read: 1 for ``c_{12}``, 2 for ``cos 2 q_1``."""
        if self.is_plain_sum:
            return 1.0
        return sum(1.0 + (abs(multiple) != 1) for _, multiple in self.angle) + len(self.angle) - 1


Atom: TypeAlias = Symbol | Trigonometric
#: Atoms, sorted, and their powers.
Monomial = tuple[tuple[Atom, int], ...]


@dataclass(frozen=True)
class Product:
    """A product of a number and of factors, each with a positive power."""

    coefficient: Fraction
    factors: tuple[tuple[Factor, int], ...] = ()

    @cached_property
    def length(self) -> float:
        """The signs to read."""
        length = float(abs(self.coefficient) != 1 or not self.factors)
        sums = [factor for factor, _ in self.factors if isinstance(factor, Sum)]
        # Books take masses and velocities out of parentheses, and lengths out of sums of masses,
        # but they write l^2 + 2 l d rather than l (l + 2 d).
        inside = (factor for each in sums for term in each.terms for factor, _ in term.factors)
        is_usual = any(
            isinstance(factor, Symbol) and factor.is_of_dynamics
            for factor in chain((factor for factor, _ in self.factors), inside)
        )
        length += sum((1.0 if is_usual else 2.0) * (factor.depth + 1) for factor in sums)
        return length + sum(factor.length + (power != 1) for factor, power in self.factors)

    @cached_property
    def order(self) -> tuple[object, ...]:
        """The place in a sum: by subscripts; terms with sines and cosines are last."""
        has_angle = any(isinstance(factor, Trigonometric) for factor, _ in self.factors)
        first = self.factors[0][0] if self.factors else None
        subscript = first.subscript.lstrip("c") if isinstance(first, Symbol) else ""
        powers = [(factor.rank, repr(factor), -power) for factor, power in self.factors]
        return (has_angle, subscript, powers)


@dataclass(frozen=True)
class Sum:
    """A sum of products; zero without terms."""

    terms: tuple[Product, ...] = ()
    rank = 60

    @cached_property
    def length(self) -> float:
        """The signs to read."""
        return sum(term.length for term in self.terms) + max(len(self.terms) - 1, 0)

    @cached_property
    def depth(self) -> int:
        """The depth of parentheses inside."""
        factors = (factor for term in self.terms for factor, _ in term.factors)
        return max((factor.depth + 1 for factor in factors if isinstance(factor, Sum)), default=0)

    def scale(self, number: Fraction) -> Sum:
        """Return a multiple, with the number in each term."""
        return Sum(tuple(Product(term.coefficient * number, term.factors) for term in self.terms))


Factor: TypeAlias = Symbol | Trigonometric | Sum


def sort_key(atom: Atom) -> tuple[object, ...]:
    """Return the key by which atoms are sorted."""
    return (atom.rank, *atom)


def make_monomial(powers: Mapping[Atom, int]) -> Monomial:
    """Return atoms in order, without those whose power is 0."""
    factors = [(atom, power) for atom, power in powers.items() if power]
    return tuple(sorted(factors, key=lambda item: sort_key(item[0])))


def arrange(products: Iterable[Product]) -> Sum:
    """Return a sum of terms in their order, but with a positive one first."""
    terms = sorted(products, key=lambda term: term.order)
    first = next((k for k, term in enumerate(terms) if term.coefficient > 0), 0)
    return Sum((terms.pop(first), *terms))
