"""Equations of motion of small robots in symbols, for people: M(q) qdd + c(q, qd) + g(q) = tau.

The graph of ``dirdyna`` is evaluated as polynomials.  For each product of masses, lengths and other
data, what is left is a polynomial in sines and cosines, which is put into its shortest form; then
common factors are taken out.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from urdf2mbs.plugin import Mbs, counted
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_equations.contents import ContentMaker
from urdf2mbs_equations.factoring import find_shortest
from urdf2mbs_equations.formulas import Atom, Monomial, Sum, Symbol, make_monomial
from urdf2mbs_equations.graph import Op, SignedNode
from urdf2mbs_equations.polynomials import Polynomial, Powers, Ring
from urdf2mbs_equations.routine import Routine, Store
from urdf2mbs_equations.symbols import RANKS, RATE_RANK, DataSymbols, Quantity, clean_numbers
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_equations.trigonometry import find_shortest_form

#: The largest number of moving joints of a robot whose equations are written in full.
MAX_JOINTS = 4
#: In place of the symbol of an angle that has no effect.
UNUSED = Symbol(0, "")


class NoFormulasError(ValueError):
    """A robot that is too large for formulas that people read, or that does not move."""


@dataclass
class SymbolicEquations:
    """The equations of motion of a small robot, in symbols."""

    name: str
    joints: dict[Symbol, Joint]
    """The moving joints, by the symbols of their coordinates."""
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


def find_moving(mbs: Mbs) -> dict[int, Joint]:
    """Return the joints that may move, by their numbers."""
    joints = enumerate(mbs.joints().values(), start=1)
    return {number: joint for number, joint in joints if not is_fixed(joint)}


def make_symbolic_equations(mbs: Mbs) -> SymbolicEquations:
    """Make the equations of motion of a small robot in symbols.

    Raises:
        NoFormulasError: More than ``MAX_JOINTS`` joints move, or none.
    """
    moving = find_moving(mbs)
    if not moving:
        raise NoFormulasError(f"no joint of {mbs.name} moves")
    if len(moving) > MAX_JOINTS:
        raise NoFormulasError(
            f"{counted(len(moving), 'joint')} of {mbs.name} move, and formulas of M, c and g are "
            f"written for at most {MAX_JOINTS}"
        )
    return _EquationsMaker(mbs, moving).make()


class _EquationsMaker:
    """Makes the equations of one model."""

    def __init__(self, mbs: Mbs, moving: Mapping[int, Joint]) -> None:
        clean, notes = clean_numbers(mbs)
        self.routine: Routine = ContentMaker(clean, fold=False).make_dirdyna()
        self.data, self.moving = DataSymbols(clean, list(moving)), list(moving)
        self.symbols: dict[str, Symbol] = {}
        """By the names in the graph."""
        for k, number in enumerate(moving, start=1):
            self.symbols[f"q[{number}]"] = Symbol(RANKS["q"], "q", str(k))
            self.symbols[f"qd[{number}]"] = Symbol(RATE_RANK, "q", str(k), 1)
        joints = {self.symbols[f"q[{number}]"]: joint for number, joint in moving.items()}
        if mbs.cuts or any(joint.nature == "dependent" for joint in moving.values()):
            notes.append("loops are open: M, c and g are those of the tree with all of its joints")
        self.equations = SymbolicEquations(mbs.name, joints, notes=notes)
        graph, results = self.routine.graph, self._list_results().values()
        names = [
            graph.name[node]
            for node in graph.find_dependencies(results)
            if graph.op[node] == Op.SYMBOL
        ]
        self.ring = Ring(names)
        self.angles = [name for name in names if name.startswith("q[") and self._is_angle(name)]
        self.parameters = [name for name in names if name not in self.angles]

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

    def make(self) -> SymbolicEquations:
        """Return the equations."""
        results = self._list_results()
        values = self.ring.evaluate(self.routine.graph, results.values(), self._read_symbol)
        elements = {name: values[result] for name, result in results.items()}
        named = self.data.name_symbols(self._find_used(elements.values()) - self.symbols.keys())
        self.symbols |= {name: symbol for name, (symbol, _) in named.items()}
        self.equations.quantities = dict(sorted(named.values()))
        for row, number in enumerate(self.moving):
            for column in range(row, len(self.moving)):
                element = elements.get(f"M[{number}][{self.moving[column]}]", {})
                self.equations.mass_matrix[row, column] = self._shorten(element)
            forces = elements[f"c[{number}]"]
            gravity = {powers: n for powers, n in forces.items() if self._has_gravity(powers)}
            coriolis = {powers: n for powers, n in forces.items() if powers not in gravity}
            self.equations.gravity.append(self._shorten(gravity))
            self.equations.coriolis.append(self._shorten(coriolis))
        return self.equations

    def _read_symbol(self, name: str) -> Polynomial:
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
