r"""Equations of motion of small robots in LaTeX: a document, and what a notebook shows.

Sines and cosines are short, as in books: ``c_{12}`` is the cosine of q_1 + q_2.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction

from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs.plugin import quoted
from urdf2mbs_equations.formulas import Factor, Product, Sum, Symbol, Trigonometric
from urdf2mbs_equations.symbolic import SymbolicEquations

#: The signs that a line has room for.
LINE_LENGTH = 30.0
DOCUMENT = r"""\documentclass{article}
\usepackage[margin=25mm]{geometry}
\usepackage{amsmath, longtable}
\setlength{\LTleft}{0pt}
\allowdisplaybreaks
\begin{document}
\section*{%s}
%s\end{document}
"""
#: How characters are written that are commands of LaTeX.
ESCAPED = str.maketrans(
    {
        **{character: f"\\{character}" for character in "#$%&_{}"},
        "\\": r"\textbackslash{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
    }
)
UNITS = {"kg m^2": "kg\\,m$^2$", "m/s^2": "m/s$^2$"}


def write_document(equations: SymbolicEquations) -> str:
    """Return a document with M, c and g and the meaning of all symbols, without its head."""
    body = write_equations(equations)
    text = f"\\begin{{align*}}\n{body}\n\\end{{align*}}\n{write_legend(equations)}\n"
    rows = [
        f"${write_symbol(symbol)}$ & {escape(joint.name)} & {describe_joint(joint)}"
        for symbol, joint in (equations.joints | equations.followers).items()
    ]
    text += write_table("lll", rows)
    rows = [
        f"${write_symbol(symbol)}$ & {escape(quantity.meaning)} & "
        f"{quantity.value!r} & {UNITS.get(quantity.unit, quantity.unit)}"
        for symbol, quantity in equations.quantities.items()
    ]
    text += write_table("llrl", rows)
    if equations.notes:
        items = "".join(f"\\item {escape(note)}\n" for note in equations.notes)
        text += f"\\begin{{itemize}}\n{items}\\end{{itemize}}\n"
    return DOCUMENT % (escape(equations.name), text)


def escape(text: str) -> str:
    """Return a text in which no character is a command of LaTeX."""
    return quoted(text).translate(ESCAPED)


def describe_joint(joint: Joint) -> str:
    """Return what a coordinate is."""
    return "angle (rad)" if joint.type[0] == "R" else "position (m)"


def write_legend(equations: SymbolicEquations) -> str:
    """Return what short sines and cosines and the elements that are not written mean."""
    text = r"with $M(q)\,\ddot q + c(q, \dot q) + g(q) = \tau$, "
    text += "$c_{ij} = \\cos(q_i + q_j)$ and $s_{ij} = \\sin(q_i + q_j)$"
    return f"{text}; $M$ is symmetric, and what is not written is zero."


def write_table(columns: str, rows: Iterable[str]) -> str:
    """Return a table that may go on on the next page.

    Args:
        columns: The alignment of each column, as ``llr``.
        rows: Their cells, with ``&`` between two.
    """
    lines = "".join(f"{row} \\\\\n" for row in rows)
    return f"\n\\begin{{longtable}}{{{columns}}}\n{lines}\\end{{longtable}}\n"


def write_equations(equations: SymbolicEquations) -> str:
    """Return M, c and g, and what followers are, as lines of an ``align``."""
    subscripts = equations.subscripts
    elements = {
        f"M_{{{subscripts[row]}{subscripts[column]}}}": formula
        for (row, column), formula in equations.mass_matrix.items()
    }
    lines = [_write_matrix(equations)] if _fits_on_line(equations) else []
    elements = {} if lines else elements
    for letter, formulas in (("c", equations.coriolis), ("g", equations.gravity)):
        elements |= {f"{letter}_{k}": each for k, each in zip(subscripts, formulas, strict=True)}
    elements |= {write_symbol(symbol): formula for symbol, formula in equations.relations.items()}
    lines += [
        f"{name} &= {_write_lines(formula)}" for name, formula in elements.items() if formula.terms
    ]
    return " \\\\\n".join(lines)


def _fits_on_line(equations: SymbolicEquations) -> bool:
    """Return True if the mass matrix can be written as a matrix."""
    columns = range(len(equations.joints))
    widths = (
        max(formula.length for key, formula in equations.mass_matrix.items() if column in key)
        for column in columns
    )
    return sum(widths) <= LINE_LENGTH


def _write_matrix(equations: SymbolicEquations) -> str:
    size = range(len(equations.joints))
    rows = (
        " & ".join(write_formula(equations.mass_matrix[min(i, k), max(i, k)]) for k in size)
        for i in size
    )
    lines = " \\\\ ".join(rows)
    return f"M &= \\begin{{pmatrix}} {lines} \\end{{pmatrix}}"


def _write_lines(formula: Sum) -> str:
    """Return a formula that goes on in the next line where one is full."""
    text, length = "", 0.0
    for piece, piece_length in _list_pieces(formula):
        if length and length + piece_length > LINE_LENGTH:
            text += " \\\\\n&\\quad {}"
            length = 0.0
        text += piece
        length += piece_length
    return text


def _list_pieces(formula: Sum) -> Iterator[tuple[str, float]]:
    """Iterate over the parts of a formula between which a line may end, and their lengths."""
    for k, term in enumerate(formula.terms):
        sign = "-" if term.coefficient < 0 else "+" * (k > 0)
        sign = f" {sign} " if k else sign
        inner = next((f for f, power in term.factors if isinstance(f, Sum) and power == 1), None)
        if term.length <= LINE_LENGTH or inner is None:
            yield f"{sign}{_write_product(term)}", term.length + 1
            continue
        outer_factors = tuple(pair for pair in term.factors if pair[0] != inner)
        outside = Product(term.coefficient, outer_factors)
        pieces = list(_list_pieces(inner))
        pieces[0] = (
            f"{sign}{_write_product(outside)} ({pieces[0][0]}",
            outside.length + pieces[0][1],
        )
        pieces[-1] = f"{pieces[-1][0]})", pieces[-1][1]
        yield from pieces


def write_formula(formula: Sum) -> str:
    """Return a formula on one line."""
    return "".join(_write_terms(formula)) or "0"


def _write_terms(formula: Sum) -> Iterator[str]:
    """Iterate over the terms of a formula, each with its sign."""
    for k, term in enumerate(formula.terms):
        sign = "-" if term.coefficient < 0 else "+" * (k > 0)
        yield f" {sign} {_write_product(term)}" if k else f"{sign}{_write_product(term)}"


def _write_product(product: Product) -> str:
    number = abs(product.coefficient)
    factors = [_write_number(number)] if number != 1 or not product.factors else []
    factors += [_write_power(factor, power) for factor, power in product.factors]
    return r" ".join(factors)


def _write_number(number: Fraction) -> str:
    if number.denominator == 1:
        return str(number)
    return rf"\tfrac{{{number.numerator}}}{{{number.denominator}}}"


def _write_power(factor: Factor, power: int) -> str:
    exponent = f"^{_brace(str(power))}" if power != 1 else ""
    if isinstance(factor, Sum):
        return f"({write_formula(factor)}){exponent}"
    if isinstance(factor, Symbol):
        return write_symbol(factor) + exponent
    return _write_trigonometric(factor, exponent)


def write_symbol(symbol: Symbol) -> str:
    """Return a symbol, such as ``l_{c2}``."""
    letter = rf"\{symbol.letter}" if len(symbol.letter) > 1 else symbol.letter
    dots = ("", r"\dot ", r"\ddot ")[symbol.n_dots]
    return f"{dots}{letter}" + (f"_{_brace(symbol.subscript)}" if symbol.subscript else "")


def _brace(text: str) -> str:
    return text if len(text) == 1 else f"{{{text}}}"


def _write_trigonometric(trigonometric: Trigonometric, exponent: str) -> str:
    if trigonometric.is_plain_sum:
        subscript = "".join(symbol.subscript for symbol, _ in trigonometric.angle)
        return f"{trigonometric.function[0]}_{_brace(subscript)}{exponent}"
    angle = _write_angle(trigonometric)
    argument = f" {angle}" if angle.startswith("\\") else f"({angle})"
    return rf"\{trigonometric.function}{exponent}{argument}"


def _write_angle(trigonometric: Trigonometric) -> str:
    terms = tuple(
        Product(Fraction(multiple), ((symbol, 1),)) for symbol, multiple in trigonometric.angle
    )
    return write_formula(Sum(terms))
