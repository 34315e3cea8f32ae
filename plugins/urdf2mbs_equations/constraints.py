"""Cuts: the equations that close the loops of a model, h = 0.

A ``rod`` keeps the distance of two points, a ``ball`` keeps them together, a ``solid`` also
keeps the axes of their bodies parallel.  All is seen from the frame from which the ways to
both ends part: nothing further in can matter.

As Robotran does, an equation is left out if its Jacobian is zero by its form: if no joint of
either way moves it, where sums and products of what is not zero never cancel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

from urdf2mbs.plugin import Connection, Mbs
from urdf2mbs_equations.graph import Expr, Scalar
from urdf2mbs_equations.kinematics import Motion, common, ends, motion
from urdf2mbs_equations.tree import Frame, Tree
from urdf2mbs_equations.vectors import NONE, Vector

#: The order of Robotran's equations; within a kind, that of the file.
ORDER = ("ball", "rod", "solid")
#: A gap up to this (m, m^2 or 1) is a rounding.
CLOSED = 1e-6


#: The fields of a Constraint behind ``start``.
Row = tuple[str, Scalar, dict[int, Scalar], Scalar, bool]


@dataclass
class Constraint:
    """One equation: h, its derivatives by the joints, and what is left of h'' at qdd = 0."""

    cut: Connection
    start: Frame
    """The frame from which the ways to both ends part: ``value`` is in its axes."""
    what: str
    """The direction that the equation holds: ``along x``, ``about x``, or a rod's."""
    value: Scalar
    """m for a ball, m^2 for a rod, 1 for a turn of a solid."""
    jacobian: dict[int, Scalar]
    jdqd: Scalar
    movable: bool
    """False if the Jacobian is zero by its form: Robotran leaves the equation out."""


def constraints(tree: Tree) -> list[Constraint]:
    """The equations of all cuts that Robotran writes, in its order."""
    return [constraint for constraint in every_constraint(tree) if constraint.movable]


def count_equations(mbs: Mbs) -> int:
    """How many equations the cuts make."""
    return len(constraints(Tree(mbs)))


def drops_row(mbs: Mbs) -> bool:
    """True if Robotran leaves out an equation of a cut, as that of a ball in a planar loop."""
    return not all(constraint.movable for constraint in every_constraint(Tree(mbs)))


def constant_gaps(mbs: Mbs) -> Iterator[tuple[str, str]]:
    """The cuts that can never close, each with a sentence on an equation that no joint fulfils."""
    tree, still = Tree(mbs), Tree(mbs, still=True)
    for constraint, at_start in zip(every_constraint(tree), every_constraint(still), strict=True):
        assert not isinstance(at_start.value, Expr)  # all is a number at the start position
        gap = abs(at_start.value)
        moves = any(x and tree.frames[k].moves for k, x in constraint.jacobian.items())
        if gap <= CLOSED or moves:
            continue
        start, name = constraint.start, constraint.cut.name
        axes = f"'{start.body.name}'" if start.body else "the ground"
        gap_in_words = {
            "along the rod": "its ends are not as far apart as it is long",
            "along": f"its ends are {gap:.3g} m apart {constraint.what} of {axes}",
            "about": f"its bodies are turned {constraint.what} of {axes} (sine {gap:.3g})",
        }
        words = gap_in_words.get(constraint.what) or gap_in_words[constraint.what[:5]]
        yield name, f"cut '{name}' can never close: {words}, and no joint changes that"


def every_constraint(tree: Tree) -> Iterator[Constraint]:
    rods = 0
    cuts = [cut for kind in ORDER for cut in tree.mbs.cuts if cut.kind == kind]
    cuts = [cut for cut in cuts if not cut.is_draft]
    for cut in cuts:
        (last1, at1), (last2, at2) = ends(tree, cut)
        start = common(tree, last1, last2)
        a = motion(tree, last1, at1, start=start, accelerations=False)
        b = motion(tree, last2, at2, start=start, accelerations=False)
        forms = _form(tree, last1, at1, start), _form(tree, last2, at2, start)
        form = Form(*(one | two for one, two in zip(*forms, strict=True)))
        if cut.kind == "rod":
            rods += 1
            rows = [_rod(a, b, tree.parameter(cut.length, f"lrod[{rods}]"), form)]
        else:
            rows = _ball(a, b, form) + (_parallel(a, b, form) if cut.kind == "solid" else [])
        for row in rows:
            yield Constraint(cut, tree.frames[start], *row)


def _difference(a: dict[int, Vector], b: dict[int, Vector]) -> dict[int, Vector]:
    return {k: a.get(k, NONE) - b.get(k, NONE) for k in sorted({*a, *b})}


def _rod(a: Motion, b: Motion, length: Scalar, form: Form) -> Row:
    """Half the difference of the squares of distance and length."""
    d = b.position - a.position
    v = b.velocity - a.velocity
    value = 0.5 * (d @ d - length * length)
    jacobian = {k: d @ column for k, column in _difference(b.linear, a.linear).items()}
    jdqd = v @ v + d @ (b.acceleration - a.acceleration)
    return "along the rod", value, jacobian, jdqd, bool(form.place & form.linear)


def _ball(a: Motion, b: Motion, form: Form) -> list[Row]:
    """The first point less the second."""
    gaps, jdqd = a.position - b.position, a.acceleration - b.acceleration
    return _rows("along", gaps, _difference(a.linear, b.linear), jdqd, form.linear)


def _parallel(a: Motion, b: Motion, form: Form) -> list[Row]:
    """The elements (3,2), (1,3) and (2,1) of R1 R2^T, where the columns of R1 and R2 are the axes
    of the bodies.  As in Robotran's equations, their Jacobian is that of the difference of the
    angular velocities, which is their derivative only where the constraint holds."""
    first, second = a.axes.T, b.axes.T
    sines = Vector(first[i - 1] @ second[i - 2] for i in range(3))
    jdqd = a.omega_dot - b.omega_dot
    return _rows("about", sines, _difference(a.angular, b.angular), jdqd, form.angular)


def _rows(
    way: str, values: Vector, columns: dict[int, Vector], jdqd: Vector, movable: set[int]
) -> list[Row]:
    """The equations along or about x, y and z."""
    return [
        (f"{way} {axis}", values[i], {k: v[i] for k, v in columns.items()}, jdqd[i], i in movable)
        for i, axis in enumerate("xyz")
    ]


class Form(NamedTuple):
    """Which coordinates (0, 1, 2) of a point and of its Jacobian can be other than zero."""

    place: set[int]
    linear: set[int]
    """Of the velocity, for any joint of the way."""
    angular: set[int]


def _form(tree: Tree, number: int, at: Vector, start: int) -> Form:
    """The form of a point ``at`` in the frame behind a joint, in the axes of the frame ``start``.

    Inwards, a turn mixes two axes of all that comes after it, and a shift and a point add their
    coordinates.  What a turn moves is its axis crossed with all that comes after it.  A joint that
    never moves turns by its angle and moves nothing.
    """
    form = Form({i for i in range(3) if at[i]}, set(), set())
    turns: list[tuple[set[int], set[int]]] = []
    """The axis of each turn, and all that comes after it."""
    while number != start:
        frame = tree.frames[number]
        i, j = (frame.axis + 1) % 3, (frame.axis + 2) % 3
        if frame.moves and frame.turns:
            turns.append(({frame.axis}, set(form.place)))
        elif frame.moves:
            form.linear.add(frame.axis)
        for coordinates in chain(form, *turns) if frame.sin else ():
            mixed = {i + j - k for k in coordinates if k != frame.axis}
            if not frame.cos:
                coordinates.difference_update((i, j))
            coordinates.update(mixed)
        form.place.update(k for k in range(3) if frame.offset[k])
        number = frame.parent
    for axis, after in turns:
        form.angular.update(axis)
        form.linear.update(3 - i - j for i in axis for j in after if i != j)
    return form
