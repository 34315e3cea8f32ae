"""The symbols of a model's data in formulas: m_1, l_1, l_{c1}, I_1, g.

Subscripts count the joints that move: body 2 is what joint 2 moves.  Bodies that are fixed to one
another get letters, 2a and 2b.  A vector with one component is one symbol, and a symbol is positive
where its number is negative::

    centre of mass (0, 0, -0.3) of body 1:  -l_{c1} along z, and l_{c1} is 0.3 m
    joint 2 at (0.4, 0, 0.1) of body 1:     l_{1x}, l_{1z}
    inertia of which Iyy alone has effect:  I_1
"""

from __future__ import annotations

import copy
import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from string import ascii_lowercase
from typing import NamedTuple

from urdf2mbs.plugin import Mbs, quoted
from urdf2mbs_equations.formulas import Symbol
from urdf2mbs_equations.tree import is_fixed

#: A fixed angle that differs from a quarter turn by less than this (rad) is one: 1.57 in a URDF.
ANGLE_TOLERANCE = 1e-3
#: A number this many times smaller than the largest beside it is zero in formulas.
DUST = 1e-6
#: A length below this (m), or an angle (rad), is zero in formulas.
SMALLEST = 1e-9
AXES = "xyz"
ZERO = (0.0, 0.0, 0.0)
#: The elements of an inertia, by Robotran's index.
INERTIA = {1: "xx", 2: "xy", 3: "xz", 5: "yy", 6: "yz", 9: "zz"}
#: The places of symbols in a product, by letter.
RANKS = {"m": 0, "I": 1, "g": 2, "l": 10, "d": 11, "alpha": 12, "r": 13, "b": 14, "q": 20}
#: The place of velocities in a product, after sines and cosines.
RATE_RANK = 55


class Quantity(NamedTuple):
    """What a symbol stands for."""

    value: float
    unit: str
    meaning: str


def clean_numbers(mbs: Mbs) -> tuple[Mbs, list[str]]:
    """Return a copy of a model, with numbers as formulas for people have them.

    Fixed angles near a quarter turn are quarter turns.  Other joints that never move become driven
    joints, whose positions are symbols.  Numbers that are tiny beside others are zero.

    Returns:
        The copy, and notes of what has changed.
    """
    mbs = copy.deepcopy(mbs)
    notes: list[str] = []
    zeros: list[str] = []
    for joint in filter(is_fixed, mbs.joints().values()):
        value, is_angle = joint.q or 0.0, joint.type[0] == "R"
        joint.q = round(value / (math.pi / 2)) * math.pi / 2 if is_angle else 0.0
        difference = abs(value - joint.q)
        if difference > (ANGLE_TOLERANCE if is_angle else SMALLEST):
            joint.q, joint.symbols = value, ("q", "qd", "qdd")
        elif difference > SMALLEST:
            notes.append(f"the angle {value!r} of {quoted(joint.name)} is taken as {joint.q!r}")
    for body in mbs.bodies:
        name = quoted(body.name)
        if body.com is not None:
            x, y, z = _remove_dust(body.com, f"centre of mass of {name}", zeros)
            body.com = (x, y, z)
        if body.inertia is not None:
            xx, xy, xz, yy, yz, zz = _remove_dust(body.inertia, f"inertia of {name}", zeros, 0.0)
            body.inertia = (xx, xy, xz, yy, yz, zz)
    for (owner, _), point in mbs.points().items():
        x, y, z = _remove_dust(point.coordinates, f"joint on {quoted(owner or 'base')}", zeros)
        point.coordinates = (x, y, z)
    if zeros:
        notes.append(f"numbers below a millionth of those beside them are zero: {', '.join(zeros)}")
    return mbs, notes


def _remove_dust(
    numbers: Sequence[float], name: str, changed: list[str], smallest: float = SMALLEST
) -> list[float]:
    """Return numbers with zeros for tiny ones, and add the name to a list if there are any."""
    threshold = max(DUST * max(map(abs, numbers)), smallest)
    if any(0.0 < abs(number) <= threshold for number in numbers):
        changed.append(name)
    return [number if abs(number) > threshold else 0.0 for number in numbers]


class Datum(NamedTuple):
    """A number of a model that is a symbol of the graph, such as ``l[3][2]``."""

    array: str
    owner: str | None
    """The body; for a joint that never moves, the joint; for gravity, None."""
    part: str | None
    """The anchor point of ``dpt``, else empty."""
    component: str
    """Such as ``x`` or ``xx``; empty for a number that is no element."""
    value: float

    @property
    def sign(self) -> int:
        """The sign of the symbol in formulas: symbols of lengths and of gravity are positive."""
        if self.array in ("g", "l", "dpt"):
            return (self.value > 0.0) - (self.value < 0.0)
        return 1

    @property
    def letter(self) -> str:
        """The letter of the symbol."""
        letters = {"In": "I", "dpt": "l", "R": "alpha", "T": "d"}
        return letters.get(self.array, self.array)

    @property
    def quantity(self) -> Quantity:
        """What the symbol stands for."""
        unit = {"m": "kg", "In": "kg m^2", "R": "rad", "g": "m/s^2"}.get(self.array, "m")
        axis = f", along {'-' * (self.sign < 0)}{self.component}"
        owner = quoted(self.owner or "")
        meanings = {
            "m": f"mass of {owner}",
            "l": f"centre of mass of {owner}{axis}",
            "dpt": f"{quoted(self.part or '')} on {owner}{axis}",
            "In": f"inertia of {owner}, {self.component}",
            "g": f"gravity{axis}",
        }
        meaning = meanings.get(self.array, f"position of {owner}, which never moves")
        return Quantity(self.value * self.sign, unit, meaning)


class DataSymbols:
    """The symbols of the data of one model."""

    def __init__(self, mbs: Mbs, moving: Sequence[int]) -> None:
        """Take a model.

        Args:
            mbs: The model.
            moving: The numbers of the joints that move, in the order of their subscripts.
        """
        self.mbs, self.joints, self.points = mbs, list(mbs.joints().values()), mbs.points()
        numbers = mbs.numbers()
        self.bodies = {numbers[body.joints[-1].name]: body for body in mbs.bodies}
        """By the number of the last joint."""
        self.subscripts: dict[str | None, int] = {None: 0}
        """By body, the subscript of the last moving joint that moves it."""
        for body in mbs.depth_first():
            chain = [numbers[joint.name] for joint in body.joints if numbers[joint.name] in moving]
            last = moving.index(chain[-1]) + 1 if chain else self.subscripts[body.parent]
            self.subscripts[body.name] = last

    def read(self, name: str) -> Datum:
        """Return the number of a symbol of the graph, such as ``l[3][2]``.

        Forces, and velocities of joints that never move, are zero.
        """
        array, *indices = re.findall(r"\w+", name)
        first, last = int(indices[0]), int(indices[-1])
        if array == "q":
            joint = self.joints[first - 1]
            return Datum(joint.type[0], joint.name, "", "", joint.q or 0.0)
        if array == "g":
            return Datum(array, None, "", AXES[first - 1], self.mbs.base.gravity[first - 1])
        if array == "dpt":
            (owner, point_name), point = list(self.points.items())[last - 1]
            return Datum(array, owner, point_name, AXES[first - 1], point.coordinates[first - 1])
        body = self.bodies.get(last)
        if body is None or array not in ("m", "l", "In"):
            return Datum(array, None, "", "", 0.0)
        if array == "m":
            return Datum(array, body.name, "", "", body.mass or 0.0)
        if array == "l":
            return Datum(array, body.name, "", AXES[first - 1], (body.com or ZERO)[first - 1])
        element = (body.inertia or ZERO * 2)[list(INERTIA).index(first)]
        return Datum(array, body.name, "", INERTIA[first], element)

    def name_symbols(self, names: Iterable[str]) -> dict[str, tuple[Symbol, Quantity]]:
        """Choose a symbol for each name of the graph, from the names that have an effect."""
        data = {name: self.read(name) for name in names}
        labels = self._label_bodies(data.values())
        vectors: dict[tuple[str, str | None, str | None], list[str]] = {}
        for name, datum in sorted(data.items(), key=lambda item: _sort_key(item[0])):
            vectors.setdefault((datum.array, datum.owner, datum.part), []).append(name)
        counts = Counter((array, owner) for array, owner, _ in vectors)
        fixed = Counter(array for array, _, _ in vectors)
        letters: Counter[tuple[str, str | None]] = Counter()
        symbols = {}
        for (array, owner, _), elements in vectors.items():
            label = labels.get(owner, "")
            if array in ("R", "T"):
                letters[array, None] += 1
                label = str(letters[array, None]) if fixed[array] > 1 else ""
            elif counts[array, owner] > 1:
                label += ascii_lowercase[letters[array, owner]]
                letters[array, owner] += 1
            for name in elements:
                datum = data[name]
                subscript = ("c" if array == "l" else "") + label
                subscript += datum.component if len(elements) > 1 else ""
                symbol = Symbol(RANKS[datum.letter], datum.letter, subscript)
                symbols[name] = symbol, datum.quantity
        return symbols

    def _label_bodies(self, data: Iterable[Datum]) -> dict[str | None, str]:
        """Return a label for each body that has an effect: 2, or 2a where joint 2 moves several."""
        owners = {datum.owner for datum in data}
        groups: dict[int, list[str]] = {}
        for body in self.mbs.bodies:
            if body.name in owners:
                groups.setdefault(self.subscripts[body.name], []).append(body.name)
        if len(groups) == 1 and len(groups.get(subscript := min(groups), ())) == 1:
            return {groups[subscript][0]: ""}
        return {
            name: f"{subscript}{ascii_lowercase[k] if len(group) > 1 else ''}"
            for subscript, group in groups.items()
            for k, name in enumerate(group)
        }


def _sort_key(name: str) -> tuple[str, list[int]]:
    """Return the key that sorts names of the graph by their numbers."""
    array, *indices = re.findall(r"\w+", name)
    return array, [int(index) for index in reversed(indices)]
