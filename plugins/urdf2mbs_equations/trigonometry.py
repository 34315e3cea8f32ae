"""The shortest form of a trigonometric polynomial.

The same polynomial can be written as a sum of sines and cosines of multiples, or by products of
sines and cosines in which an even power of one is replaced by the other::

    cos q_3 + cos (2 q_2 + q_3)  =  2 cos q_2 cos (q_2 + q_3)
    cos q_2 cos q_3 - sin q_2 sin q_3  =  cos (q_2 + q_3)
    (1 - cos 2 q_2) / 2  =  1 - cos^2 q_2  =  sin^2 q_2

For products, the angles may be those of single joints, or sums along joints in a row, as those of
parallel axes are.  All these forms are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cache
from itertools import product
from math import comb
from typing import Any

from urdf2mbs_equations.formulas import (
    Angle,
    Atom,
    Monomial,
    Product,
    Symbol,
    Trigonometric,
    make_monomial,
)

#: The multiple of each angle: n of exp(i n q).
Multiples = tuple[int, ...]
#: A real sum of exponentials exp(i n q), by the number before each.
Exponentials = Mapping[Multiples, complex]
#: A sum of products of sines and cosines, by the number before each.
Form = dict[Monomial, Fraction]


def find_shortest_form(exponentials: Exponentials, angles: tuple[Symbol, ...]) -> Form:
    """Return the shortest form of a trigonometric polynomial.

    Args:
        exponentials: The polynomial.
        angles: The symbols of the angles.
    """
    used = [k for k in range(len(angles)) if any(multiples[k] for multiples in exponentials)]
    items = sorted(exponentials.items(), key=lambda item: item[0])
    reduced = tuple((tuple(n[k] for k in used), value) for n, value in items)
    return _find_shortest_form(reduced, tuple(angles[k] for k in used))


@cache
def _find_shortest_form(
    items: tuple[tuple[Multiples, complex], ...], angles: tuple[Symbol, ...]
) -> Form:
    exponentials = dict(items)
    forms = [_write_multiples(exponentials, angles)]
    if not angles:
        return forms[0]
    forms += [
        _write_products(*_change_angles(exponentials, angles, steps))
        for steps in _list_steps(exponentials, len(angles))
    ]
    return min(
        forms, key=lambda form: sum(Product(value, m).length + 1 for m, value in form.items())
    )


def _write_multiples(exponentials: Exponentials, angles: tuple[Symbol, ...]) -> Form:
    """Return the sum of sines and cosines of multiples."""
    form: Form = {}
    for multiples, value in exponentials.items():
        first = next((n for n in multiples if n), 0)
        if first < 0:
            continue  # the conjugate of the opposite multiples
        if first == 0:
            form[()] = Fraction(value.real)
        for function, part in (("cos", value.real), ("sin", -value.imag)):
            if first and part:
                angle = tuple((a, n) for a, n in zip(angles, multiples, strict=True) if n)
                form[make_monomial({Trigonometric(function, angle): 1})] = Fraction(2 * part)
    return form


def _list_steps(exponentials: Exponentials, n_angles: int) -> Iterator[Multiples]:
    """List the choices of angles, each by the steps from one angle to the next.

    A step of 0 starts anew with the angle of a joint.  A step of 1 adds this angle to the one
    before, and -1 subtracts it, as of a joint whose axis is opposite.
    """
    signs = []
    for k in range(1, n_angles):
        balance = sum(abs(value) * n[k - 1] * n[k] for n, value in exponentials.items())
        signs.append(1 if balance >= 0 else -1)
    for is_added in product((0, 1), repeat=n_angles - 1):
        yield tuple(sign * chosen for sign, chosen in zip(signs, is_added, strict=True))


def _change_angles(
    exponentials: Exponentials, angles: tuple[Symbol, ...], steps: Multiples
) -> tuple[Exponentials, list[Angle]]:
    """Write a polynomial in other angles; see ``_list_steps``.

    With a_k = a_(k-1) + s_k q_k, and n_k the multiple of q_k, the multiple of a_k is
    s_k n_k - s_(k+1) n_(k+1); s_k is 1 where a_k = q_k.
    """
    names: list[Angle] = []
    for angle, step in zip(angles, (0, *steps), strict=True):
        names.append((*names[-1], (angle, step)) if step else ((angle, 1),))
    changed = {}
    for multiples, value in exponentials.items():
        signed = [n * (step or 1) for n, step in zip(multiples, (0, *steps), strict=True)]
        following = [n * step for n, step in zip(multiples[1:], steps, strict=True)]
        changed[tuple(n - after for n, after in zip(signed, (*following, 0), strict=True))] = value
    return changed, names


def _write_products(exponentials: Exponentials, angles: list[Angle]) -> Form:
    """Return the sum of products of powers of sines and cosines.

    One angle after the other, its exponentials are replaced by powers: with or without squares of
    the sine, whichever has fewer terms.
    """
    sums: Mapping[tuple[Any, ...], complex] = exponentials
    for k in range(len(angles)):
        sums = min((_replace(sums, k, function) for function in ("sin", "cos")), key=len)
    form: Form = {}
    for powers, value in sums.items():
        factors: dict[Atom, int] = {
            Trigonometric(function, angle): power
            for angle, pair in zip(angles, powers, strict=True)
            for function, power in zip(("cos", "sin"), pair, strict=True)
        }
        form[make_monomial(factors)] = Fraction(value.real)
    return form


def _replace(
    sums: Mapping[tuple[Any, ...], complex], k: int, function: str
) -> dict[tuple[Any, ...], complex]:
    """Replace the multiple of an angle by powers of its cosine and sine; see ``_expand``."""
    replaced: dict[tuple[Any, ...], complex] = {}
    for key, value in sums.items():
        for powers, number in _expand(key[k], function).items():
            new_key = (*key[:k], powers, *key[k + 1 :])
            replaced[new_key] = replaced.get(new_key, 0) + value * number
    return {key: value for key, value in replaced.items() if value}


@cache
def _expand(multiple: int, replaced: str) -> dict[tuple[int, int], complex]:
    """Return exp(i n q) = (cos q + i sin q)^n, by the powers of the cosine and the sine.

    Args:
        multiple: n.
        replaced: ``sin`` or ``cos``: its square is replaced by 1 minus that of the other.
    """
    n, sign = abs(multiple), 1j if multiple > 0 else -1j
    expanded: dict[tuple[int, int], complex] = {}
    for sines in range(n + 1):
        squares, odd = divmod(sines if replaced == "sin" else n - sines, 2)
        for k in range(squares + 1):  # (1 - x^2)^squares
            even = (n - sines if replaced == "sin" else sines) + 2 * k
            powers = (even, odd) if replaced == "sin" else (odd, even)
            number = comb(n, sines) * sign**sines * comb(squares, k) * (-1) ** k
            expanded[powers] = expanded.get(powers, 0) + number
    return {powers: number for powers, number in expanded.items() if number}
