"""Formulas as plain text, for tables of a page: ``m₂ lc₂ (lc₂ + l₁ cos(q₂)) + I₂``."""

from __future__ import annotations

from fractions import Fraction

from urdf2mbs_equations.formulas import Factor, Product, Sum, Symbol
from urdf2mbs_equations.symbolic import SymbolicEquations

SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Letters of other alphabets, and the dots of derivatives, which follow a letter.
GREEK = {"alpha": "α"}
DOTS = ("", "\u0307", "\u0308")


def list_formulas(equations: SymbolicEquations) -> dict[str, str]:
    """Return the elements of M, c and g that are not zero, and followers, by their names."""
    subscripts = equations.subscripts
    elements = {
        f"M{subscripts[row]}{subscripts[column]}": formula
        for (row, column), formula in equations.mass_matrix.items()
    }
    for letter, formulas in (("c", equations.coriolis), ("g", equations.gravity)):
        elements |= {f"{letter}{k}": each for k, each in zip(subscripts, formulas, strict=True)}
    elements |= {write_symbol(symbol): formula for symbol, formula in equations.relations.items()}
    return {
        name.translate(SUBSCRIPTS): write_text(formula)
        for name, formula in elements.items()
        if formula.terms
    }


def list_symbols(equations: SymbolicEquations) -> dict[str, str]:
    """Return what each symbol is: the name of a joint, or a number with its unit and meaning.

    The last row, without a symbol, says where the formulas depart from the numbers of the .mbs.
    """
    all_joints = equations.joints | equations.followers
    joints = {write_symbol(symbol): joint.name for symbol, joint in all_joints.items()}
    symbols = joints | {
        write_symbol(symbol): f"{quantity.value!r} {quantity.unit}".rstrip()
        + f": {quantity.meaning}"
        for symbol, quantity in equations.quantities.items()
    }
    return symbols | ({"": "; ".join(equations.notes)} if equations.notes else {})


def write_text(formula: Sum) -> str:
    """Return a formula on one line."""
    terms = (
        f"{'-' if term.coefficient < 0 else '+'} {_write_product(term)}" for term in formula.terms
    )
    text = " ".join(terms) or "0"
    return f"-{text[2:]}" if text.startswith("- ") else text.removeprefix("+ ")


def write_symbol(symbol: Symbol) -> str:
    """Return a symbol, such as ``lc₂``."""
    letter = GREEK.get(symbol.letter, symbol.letter)
    return f"{letter}{DOTS[symbol.n_dots]}{symbol.subscript.translate(SUBSCRIPTS)}"


def _write_product(product: Product) -> str:
    number = abs(product.coefficient)
    factors = [str(number)] if number != 1 or not product.factors else []
    factors += [_write_power(factor, power) for factor, power in product.factors]
    return " ".join(factors)


def _write_power(factor: Factor, power: int) -> str:
    exponent = str(power).translate(SUPERSCRIPTS) if power != 1 else ""
    if isinstance(factor, Symbol):
        return f"{write_symbol(factor)}{exponent}"
    if isinstance(factor, Sum):
        return f"({write_text(factor)}){exponent}"
    terms = (Product(Fraction(multiple), ((symbol, 1),)) for symbol, multiple in factor.angle)
    return f"{factor.function}{exponent}({write_text(Sum(tuple(terms)))})"
