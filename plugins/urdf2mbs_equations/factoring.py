r"""The shortest formula of a sum of products.

The same sum has many formulas::

    m l^2 + 2 m l d c + m d^2        m (l^2 + 2 l d c + d^2)        m (l (l + 2 d c) + d^2)

The shortest is searched for from the outside inwards: what all terms have in common goes out of the
parentheses, and the rest is split in two sums, for each of which the same is done.  One of the two
has the terms with a certain symbol, or is a square, or a product of two sums.  Large sums are not
tried with each symbol, only with the most frequent ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from fractions import Fraction
from itertools import combinations, product
from math import gcd, isqrt, lcm
from typing import NamedTuple

from urdf2mbs_equations.formulas import (
    Atom,
    Factor,
    Monomial,
    Product,
    Sum,
    arrange,
    sort_key,
)

#: The numbers of symbols in order, and their powers.
Powers = tuple[tuple[int, int], ...]
#: The whole number before each product of powers.
Terms = Mapping[Powers, int]

#: How many symbols are tried for a split, by the largest number of terms; else one.
TRIALS = {8: 5, 16: 2}
#: Squares and products of sums are searched for in sums with up to this number of terms.
MAX_TERMS = 40


class _Part(NamedTuple):
    """Some terms of a sum, and the product that they are."""

    terms: Collection[Powers]
    product: Product


def find_shortest(terms: Mapping[Monomial, Fraction]) -> Sum:
    """Return the shortest formula that is found for a sum of products."""
    atoms = sorted({atom for monomial in terms for atom, _ in monomial}, key=sort_key)
    numbers = {atom: number for number, atom in enumerate(atoms)}
    denominator = lcm(*(value.denominator for value in terms.values()))
    whole_numbers = {
        tuple(sorted((numbers[atom], power) for atom, power in monomial)): int(value * denominator)
        for monomial, value in terms.items()
    }
    return _Search(atoms).find_shortest(whole_numbers).scale(Fraction(1, denominator))


class _Search:
    """The search for the formula of one sum."""

    def __init__(self, atoms: list[Atom]) -> None:
        self.atoms = atoms
        self.formulas: dict[tuple[tuple[Powers, int], ...], Sum] = {}
        """Those of sums that were searched for before."""

    def find_shortest(self, terms: Terms) -> Sum:
        """Return the shortest formula that is found for a sum."""
        key = tuple(sorted(terms.items()))
        formula = self.formulas.get(key)
        if formula is None:
            formula = self.formulas[key] = self._find_new(dict(key))
        return formula

    def _find_new(self, terms: Terms) -> Sum:
        if not terms:
            return Sum()
        number, common = _find_common_factor(terms)
        if len(terms) == 1:
            return Sum((self._make_product(number, common),))
        rest = {_divide(powers, common): value // number for powers, value in terms.items()}
        inner = self._split(rest)
        outside = self._make_product(number, common)
        if len(inner.terms) == 1:  # a square, or a product of sums
            (term,) = inner.terms
            coefficient = outside.coefficient * term.coefficient
            return Sum((Product(coefficient, outside.factors + term.factors),))
        formula = Sum((Product(outside.coefficient, (*outside.factors, (inner, 1))),))
        if common:
            return formula
        return min(inner.scale(Fraction(number)), formula, key=lambda tree: tree.length)

    def _make_product(self, number: int, powers: Powers) -> Product:
        factors = tuple((self.atoms[symbol], power) for symbol, power in powers)
        return Product(Fraction(number), factors)

    def _split(self, terms: Terms) -> Sum:
        """Return the shortest formula of a sum whose terms have no common factor."""
        candidates = [[self._make_product(value, powers) for powers, value in terms.items()]]
        cofactors = _find_cofactors(terms)
        repeated = sorted(cofactors, key=lambda symbol: (-len(cofactors[symbol]), symbol))
        n_trials = next((n for size, n in TRIALS.items() if len(terms) <= size), 1)
        for symbol in repeated[:n_trials]:
            parts: tuple[dict[Powers, int], ...] = ({}, {})
            for powers, value in terms.items():
                parts[symbol in dict(powers)][powers] = value
            split = [term for part in parts for term in self.find_shortest(part).terms]
            candidates.append(_take_out_sums(split))
        if len(terms) <= MAX_TERMS:
            for part in (self._find_square(terms), self._find_product(terms, cofactors)):
                if part is not None:
                    rest = {key: terms[key] for key in terms if key not in part.terms}
                    candidates.append([part.product, *self.find_shortest(rest).terms])
        return arrange(min(candidates, key=lambda products: Sum(tuple(products)).length))

    def _find_square(self, terms: Terms) -> _Part | None:
        """Find the square of a sum: the squares of its terms, and twice each product of two."""
        roots: dict[Powers, int] = {}
        for powers, value in terms.items():
            root = isqrt(abs(value))
            if powers and root * root == value and all(power % 2 == 0 for _, power in powers):
                roots[tuple((symbol, power // 2) for symbol, power in powers)] = root
        largest: dict[Powers, int] = {}
        for first, value in roots.items():
            chosen = {first: value}
            for powers, sign in product(roots, (1, -1)):
                candidate = {**chosen, powers: sign * roots[powers]}
                if powers not in chosen and _contains(terms, _square(candidate)):
                    chosen = candidate
            if len(chosen) > max(len(largest), 1):
                largest = chosen
        if not largest:
            return None
        root_formula = self.find_shortest(largest)
        return _Part(_square(largest), Product(Fraction(1), ((root_formula, 2),)))

    def _find_product(self, terms: Terms, cofactors: Mapping[int, Terms]) -> _Part | None:
        """Find symbols with the same cofactor, but for a number: ``a x + a y + 2 b x + 2 b y``."""
        groups: dict[tuple[tuple[Powers, int], ...], dict[Powers, int]] = {}
        for symbol, cofactor in cofactors.items():
            number = gcd(*cofactor.values())
            number = -number if cofactor[min(cofactor)] < 0 else number
            key = tuple(sorted((powers, value // number) for powers, value in cofactor.items()))
            groups.setdefault(key, {})[(symbol, 1),] = number
        for key, symbols in groups.items():
            pairs = {_multiply(first, second) for first in symbols for second, _ in key}
            if len(symbols) > 1 and len(pairs) == len(symbols) * len(key):
                sums = (self.find_shortest(symbols), 1), (self.find_shortest(dict(key)), 1)
                return _Part(pairs, Product(Fraction(1), sums))
        return None


def _find_common_factor(terms: Terms) -> tuple[int, Powers]:
    """Return the greatest number and product of powers that divide all terms."""
    number = gcd(*terms.values())
    first, *following = map(dict, terms)
    common = {
        symbol: min(power, *(each.get(symbol, 0) for each in following)) if following else power
        for symbol, power in first.items()
    }
    powers = tuple((symbol, power) for symbol, power in common.items() if power)
    return (-number if max(terms.values()) < 0 else number), powers


def _divide(powers: Powers, divisor: Powers) -> Powers:
    if not divisor:
        return powers
    divisors = dict(divisor)
    quotient = ((symbol, power - divisors.get(symbol, 0)) for symbol, power in powers)
    return tuple((symbol, power) for symbol, power in quotient if power)


def _multiply(left: Powers, right: Powers) -> Powers:
    powers = dict(left)
    for symbol, power in right:
        powers[symbol] = powers.get(symbol, 0) + power
    return tuple(sorted(powers.items()))


def _find_cofactors(terms: Terms) -> dict[int, dict[Powers, int]]:
    """Return what terms have beside each symbol that several of them have."""
    cofactors: dict[int, dict[Powers, int]] = {}
    for powers, value in terms.items():
        for symbol, _ in powers:
            cofactors.setdefault(symbol, {})[_divide(powers, ((symbol, 1),))] = value
    return {symbol: cofactor for symbol, cofactor in cofactors.items() if len(cofactor) > 1}


def _contains(terms: Terms, part: Terms) -> bool:
    return all(terms.get(powers) == value for powers, value in part.items())


def _square(terms: Terms) -> Terms:
    """Return the square of a sum."""
    square: Counter[Powers] = Counter()
    for (left, value), (right, factor) in product(terms.items(), repeat=2):
        square[_multiply(left, right)] += value * factor
    return square


def _take_out_sums(products: list[Product]) -> list[Product]:
    """Take out a sum that is a factor of two products: ``a (c + d) + b (c + d)``."""
    for first, second in combinations(products, 2):
        for factor, power in first.factors:
            common = min(power, dict(second.factors).get(factor, 0))
            if isinstance(factor, Sum) and common:
                rests = (_lower_power(each, factor, common) for each in (first, second))
                inner = arrange(term for rest in rests for term in rest)
                untouched = [each for each in products if each not in (first, second)]
                return [*untouched, Product(Fraction(1), ((inner, 1), (factor, common)))]
    return products


def _lower_power(divided: Product, divisor: Factor, power: int) -> tuple[Product, ...]:
    """Return the terms of a product that is divided by a power of one of its factors."""
    factors = tuple(
        (factor, exponent - power * (factor == divisor))
        for factor, exponent in divided.factors
        if factor != divisor or exponent > power
    )
    if len(factors) == 1 and isinstance(factors[0][0], Sum) and factors[0][1] == 1:
        return factors[0][0].scale(divided.coefficient).terms
    return (Product(divided.coefficient, factors),)
