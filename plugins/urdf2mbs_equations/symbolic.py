"""Equations of motion of small robots in symbols, for people: M(q) qdd + c(q, qd) + g(q) = tau.

The graph of ``dirdyna`` is evaluated as polynomials.  For each product of masses, lengths and other
data, what is left is a polynomial in sines and cosines, which is put into its shortest form; then
common factors are taken out.

Joints that follow others (``<mimic>``) are not among the rows and columns: with q = T q + offset,
M is T' M T, and c and g are T' c and T' g.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from urdf2mbs.plugin import Mbs, counted
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_equations.contents import ContentMaker
from urdf2mbs_equations.factoring import find_shortest
from urdf2mbs_equations.follower_symbols import FollowerSymbols, lock_followers
from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.formulas import Atom, Monomial, Sum, Symbol, make_monomial
from urdf2mbs_equations.graph import Op, SignedNode
from urdf2mbs_equations.options import MAX_JOINTS, MAX_WITH_FOLLOWERS
from urdf2mbs_equations.polynomials import (
    Polynomial,
    Powers,
    Ring,
    TooManyTermsError,
    add_polynomials,
    multiply,
)
from urdf2mbs_equations.routine import Routine, Store
from urdf2mbs_equations.symbols import RANKS, RATE_RANK, DataSymbols, Quantity, clean_numbers
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_equations.trigonometry import find_shortest_form

#: The largest number of terms of all elements, before they are shortened: it takes 10 s.
MAX_TERMS = 5000
#: In place of the symbol of an angle that has no effect.
UNUSED = Symbol(0, "")


class NoFormulasError(ValueError):
    """A robot that is too large for formulas that people read, or that does not move."""


@dataclass
class SymbolicEquations:
    """The equations of motion of a small robot, in symbols."""

    name: str
    joints: dict[Symbol, Joint]
    """The moving joints but for followers, by the symbols of their coordinates."""
    followers: dict[Symbol, Joint] = field(default_factory=dict)
    relations: dict[Symbol, Sum] = field(default_factory=dict)
    """What the coordinate of each follower is."""
    mass_matrix: dict[tuple[int, int], Sum] = field(default_factory=dict)
    """Elements of M with row <= column, from 0."""
    coriolis: list[Sum] = field(default_factory=list)
    """c: centrifugal and Coriolis forces."""
    gravity: list[Sum] = field(default_factory=list)
    """g: forces against gravity."""
    quantities: dict[Symbol, Quantity] = field(default_factory=dict)
    """What the symbols of data stand for."""
    notes: list[str] = field(default_factory=list)
    """Where the formulas depart from the numbers of the .mbs."""

    @property
    def subscripts(self) -> list[str]:
        """Those of the rows and columns: followers have numbers, but no rows."""
        return [symbol.subscript for symbol in self.joints]


def find_moving(mbs: Mbs) -> dict[int, Joint]:
    """Return the joints that may move, by their numbers."""
    joints = enumerate(mbs.joints().values(), start=1)
    return {number: joint for number, joint in joints if not is_fixed(joint)}


def make_symbolic_equations(
    mbs: Mbs, followers: Sequence[Follower] = (), *, max_terms: int = MAX_TERMS
) -> SymbolicEquations:
    """Make the equations of motion of a small robot in symbols.

    Args:
        mbs: The model.
        followers: Joints that follow others.
        max_terms: The largest number of terms, before the formulas are shortened.

    Raises:
        NoFormulasError: More than ``MAX_JOINTS`` joints move, or none; or there are more terms.
    """
    mbs, followers = lock_followers(mbs, followers)
    n_moving = len(find_moving(mbs))
    n_leading = n_moving - len(followers)
    if not n_moving:
        raise NoFormulasError(f"no joint of {mbs.name} moves")
    if n_leading > MAX_JOINTS or n_moving > MAX_WITH_FOLLOWERS:
        following = f", of which {len(followers)} follow others," if followers else ""
        largest = f"{MAX_JOINTS}" + (f", and {MAX_WITH_FOLLOWERS} in all" if followers else "")
        raise NoFormulasError(
            f"{counted(n_moving, 'joint')} of {mbs.name} move{following or ','} and formulas of "
            f"M, c and g are written for at most {largest}"
        )
    try:
        return _EquationsMaker(mbs, followers).make(max_terms)
    except TooManyTermsError:
        raise NoFormulasError(
            f"M, c and g of {mbs.name} have more than {max_terms} terms"
        ) from None


class _EquationsMaker:
    """Makes the equations of one model."""

    def __init__(self, mbs: Mbs, followers: Sequence[Follower]) -> None:
        moving = find_moving(mbs)
        clean, notes = clean_numbers(mbs)
        self.routine: Routine = ContentMaker(clean, fold=False).make_dirdyna()
        self.data, self.moving = DataSymbols(clean, list(moving)), list(moving)
        self.symbols: dict[str, Symbol] = {}
        """By the names in the graph."""
        for k, number in enumerate(moving, start=1):
            self.symbols[f"q[{number}]"] = Symbol(RANKS["q"], "q", str(k))
            self.symbols[f"qd[{number}]"] = Symbol(RATE_RANK, "q", str(k), 1)
        joints = {self.symbols[f"q[{number}]"]: joint for number, joint in moving.items()}
        self.rules = FollowerSymbols(followers, moving, self.symbols)
        self.symbols |= self.rules.symbols
        self.leading = [number for number in moving if number not in self.rules.factors]
        relations = self.rules.list_relations()
        leading = {symbol: joint for symbol, joint in joints.items() if symbol not in relations}
        if mbs.cuts or any(joint.nature == "dependent" for joint in leading.values()):
            notes.append("loops are open: M, c and g are those of the tree with all of its joints")
        self.equations = SymbolicEquations(mbs.name, leading, notes=notes)
        self.equations.followers = {symbol: joints[symbol] for symbol in relations}
        self.equations.relations = relations
        self.ring = self._make_ring()
        self.T = {number: self.rules.make_row(self.ring, number) for number in self.moving}
        """By the numbers of joints that move, and of those that lead."""
        names = list(self.ring.index)
        self.angles = [name for name in names if name.startswith("q[") and self._is_angle(name)]
        self.parameters = [name for name in names if name not in self.angles]

    def _make_ring(self) -> Ring:
        """Return the ring of all that the results may depend on."""
        graph, results = self.routine.graph, self._list_results().values()
        names = dict.fromkeys(
            graph.name[node]
            for node in graph.find_dependencies(results)
            if graph.op[node] == Op.SYMBOL
        )
        leaders = {k for factors in self.rules.factors.values() for k in factors}
        names |= dict.fromkeys(f"{x}[{k}]" for k in sorted(leaders) for x in ("q", "qd"))
        names |= dict.fromkeys(self.rules.symbols)
        multiples = self.rules.find_multiples()
        return Ring([name for name in names if name not in multiples], multiples)

    def _list_results(self) -> dict[str, SignedNode]:
        """Return the results for the joints that move, by elements such as ``M[1][2]``."""
        return {
            step.targets[0]: step.value
            for step in self.routine.steps
            if isinstance(step, Store)
            and {*map(int, re.findall(r"\d+", step.targets[0]))} <= {*self.moving}
        }

    def _is_angle(self, name: str) -> bool:
        return self.data.joints[int(name[2:-1]) - 1].type[0] == "R"

    def make(self, max_terms: int) -> SymbolicEquations:
        """Return the equations.

        Raises:
            TooManyTermsError: They are too long.
        """
        results = self._list_results()
        values = self.ring.evaluate(
            self.routine.graph, results.values(), self._read_symbol, max_terms
        )
        if sum(map(len, values.values())) > max_terms:
            raise TooManyTermsError
        elements = {name: values[result] for name, result in results.items()}
        named = self.data.name_symbols(self._find_used(elements.values()) - self.symbols.keys())
        self.symbols |= {name: symbol for name, (symbol, _) in named.items()}
        self.equations.quantities = dict(sorted(named.values()))
        self.equations.quantities |= self.rules.quantities
        for row, number in enumerate(self.leading):
            for column, other in enumerate(self.leading[row:], start=row):
                element = self._reduce_mass(elements, number, other)
                self.equations.mass_matrix[row, column] = self._shorten(element)
            forces = self._reduce_forces(elements, number)
            gravity = {powers: n for powers, n in forces.items() if self._has_gravity(powers)}
            coriolis = {powers: n for powers, n in forces.items() if powers not in gravity}
            self.equations.gravity.append(self._shorten(gravity))
            self.equations.coriolis.append(self._shorten(coriolis))
        return self.equations

    def _reduce_mass(
        self, elements: Mapping[str, Polynomial], first: int, second: int
    ) -> Polynomial:
        """Return the element of T' M T of two joints that lead."""
        element: Polynomial = {}
        for row, row_factors in self.T.items():
            for column, column_factors in self.T.items():
                name = f"M[{min(row, column)}][{max(row, column)}]"
                if first in row_factors and second in column_factors and name in elements:
                    factor = multiply(row_factors[first], column_factors[second])
                    element = add_polynomials(element, multiply(factor, elements[name]))
        return element

    def _reduce_forces(self, elements: Mapping[str, Polynomial], leader: int) -> Polynomial:
        """Return the element of T' c of a joint that leads."""
        force: Polynomial = {}
        for joint, factors in self.T.items():
            if leader in factors:
                force = add_polynomials(force, multiply(factors[leader], elements[f"c[{joint}]"]))
        return force

    def _read_symbol(self, name: str) -> Polynomial:
        array, number = name.partition("[")[0], int(re.findall(r"\d+", name)[0])
        if (array == "qd" and number in self.rules.factors) or self.rules.is_substituted(name):
            position = self.rules.make_offset(self.ring, number) if array == "q" else {}
            for leader, factor in self.T[number].items():
                rate = self.ring.make_power(f"{array}[{leader}]")
                position = add_polynomials(position, multiply(factor, rate))
            return position
        if name in self.ring.multiples:
            return {}  # an angle, of which only the sine and the cosine count
        if name in self.symbols:
            return self.ring.make_power(name)
        datum = self.data.read(name)
        return self.ring.make_power(name, 1, datum.sign) if datum.value else {}

    def _find_used(self, polynomials: Iterable[Polynomial]) -> set[str]:
        """Return the names of the graph that have an effect."""
        return {
            name
            for polynomial in polynomials
            for powers in polynomial
            for name, power in zip(self.ring.index, powers, strict=True)
            if power
        }

    def _has_gravity(self, powers: Powers) -> bool:
        names = zip(self.ring.index, powers, strict=True)
        return any(power and name.startswith("g[") for name, power in names)

    def _shorten(self, polynomial: Polynomial) -> Sum:
        """Return the shortest formula of a polynomial."""
        index = self.ring.index
        parts: dict[Powers, dict[Powers, complex]] = {}
        for powers, value in polynomial.items():
            key = tuple(powers[index[name]] for name in self.parameters)
            multiples = tuple(powers[index[name]] for name in self.angles)
            parts.setdefault(key, {})[multiples] = value
        angles = tuple(self.symbols.get(name, UNUSED) for name in self.angles)
        terms: dict[Monomial, Fraction] = {}
        for key, exponentials in parts.items():
            factors: dict[Atom, int] = {
                self.symbols[name]: power
                for name, power in zip(self.parameters, key, strict=True)
                if power
            }
            for monomial, number in find_shortest_form(exponentials, angles).items():
                terms[make_monomial({**factors, **dict(monomial)})] = number
        return find_shortest(terms)
