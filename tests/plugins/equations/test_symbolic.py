"""Formulas of small robots: those of the books, no longer, and equal to the generated equations."""

import io
import math
import shutil
import subprocess
import tokenize
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from support.equations import few, trees, write_equations
from support.oracle.generated import random_state
from support.textbook import (
    DOUBLE_PENDULUM,
    ORIGIN,
    PUMA,
    TEXTBOOKS,
    Textbook,
    X,
    Y,
    Z,
    make_joint,
    make_link,
    make_robot,
)
from urdf2mbs import load_equations
from urdf2mbs.cli import main
from urdf2mbs.engine.summaries import of_plugins
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations.factoring import find_shortest
from urdf2mbs_equations.formulas import Factor, Sum, Symbol, Trigonometric, make_monomial
from urdf2mbs_equations.latex import LINE_LENGTH, escape, write_document, write_formula
from urdf2mbs_equations.latex_recursion import write_recursion
from urdf2mbs_equations.plain_text import list_formulas
from urdf2mbs_equations.symbolic import (
    NoFormulasError,
    SymbolicEquations,
    find_moving,
    make_symbolic_equations,
)
from urdf2mbs_equations.symbols import clean_numbers
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_equations.trigonometry import find_shortest_form

#: The longest that an element of M may be, beside that of the book.
LONGEST = 1.2


def convert(urdf: str) -> Mbs:
    return read_mbs(convert_text(urdf).data, "robot", mechanics_only=True)


def write_python(factor: Factor) -> str:
    """Write a formula as the books' formulas are written here."""
    if isinstance(factor, Symbol):
        return f"qd{factor.subscript}" if factor.n_dots else factor.name
    if isinstance(factor, Trigonometric):
        if factor.is_plain_sum:
            return factor.function[0] + "".join(symbol.subscript for symbol, _ in factor.angle)
        angle = " + ".join(f"{multiple}*{symbol.name}" for symbol, multiple in factor.angle)
        return f"{factor.function}({angle})"
    terms = []
    for term in factor.terms:
        factors = [str(term.coefficient)] if term.coefficient != 1 or not term.factors else []
        for each, power in term.factors:
            text = write_python(each)
            text = f"({text})" if isinstance(each, Sum) else text
            factors.append(text if power == 1 else f"{text}**{power}")
        terms.append("*".join(factors).replace("-1*", "-"))
    return " + ".join(terms).replace("+ -", "- ") or "0"


def count_signs(text: str) -> int:
    """Count symbols, numbers, + and -; not parentheses."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    kinds = (tokenize.NAME, tokenize.NUMBER)
    return sum(token.type in kinds or token.string in ("+", "-", "/") for token in tokens)


def evaluate(text: str, equations: SymbolicEquations, state: Any) -> float:
    """Evaluate a formula with the numbers of the model, at positions and velocities."""
    q, qd = state
    names: dict[str, Any] = {"sin": math.sin, "cos": math.cos}
    names |= {symbol.name: quantity.value for symbol, quantity in equations.quantities.items()}
    for k in range(len(q)):
        names |= {f"q_{k + 1}": q[k], f"qd{k + 1}": qd[k]}
        for last in range(k, len(q)):
            digits = "".join(str(n + 1) for n in range(k, last + 1))
            angle = sum(q[k : last + 1])
            names |= {f"c{digits}": math.cos(angle), f"s{digits}": math.sin(angle)}
    return float(eval(text, names))


def make_states(n_joints: int, n_states: int = 5) -> Any:
    return np.random.default_rng(n_joints).uniform(-2, 2, (n_states, 2, n_joints))


@pytest.mark.parametrize("book", TEXTBOOKS.values(), ids=TEXTBOOKS)
def test_formulas_are_those_of_the_books(book: Textbook) -> None:
    """Element by element: equal numbers, and at most 1.2 times as long."""
    equations = make_symbolic_equations(convert(book.urdf))
    assert equations.notes == []
    pairs = []
    for (row, column), formula in equations.mass_matrix.items():
        expected = book.mass_matrix.get((row + 1, column + 1), "0")
        actual = write_python(formula)
        assert count_signs(actual) <= LONGEST * count_signs(expected), (actual, expected)
        pairs.append((actual, expected))
    for formulas, expectations in (
        (equations.coriolis, book.coriolis),
        (equations.gravity, book.gravity),
    ):
        for k, expected in expectations.items():
            pairs.append((write_python(formulas[k - 1]), expected))
    for state in make_states(len(equations.joints)):
        for actual, expected in pairs:
            value = evaluate(expected, equations, state)
            assert abs(evaluate(actual, equations, state) - value) <= 1e-14 * max(1.0, abs(value))


GENERAL = make_robot(
    "general",
    '<link name="l1"><inertial><origin xyz="0.1 0.02 -0.03" rpy="0.3 0.2 0.1"/>'
    '<mass value="3"/><inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0.002" '
    'iyz="-0.003"/></inertial></link>',
    make_link("l2", 2.0, (0.1, -0.02, 0.03), (0.02, 0.03, 0.04)),
    make_link("tool", 0.5, (0.0, 0.02, 0.03), (0.002, 0.003, 0.004)),
    make_joint("j1", "continuous", "base l1", Z, (0.1, 0.2, 0.3), (0.4, 0.0, 0.0)),
    make_joint("j2", "continuous", "l1 l2", Y, (0.1, 0.2, 0.3), (0.0, 0.7, 0.3)),
    '<joint name="weld" type="fixed"><parent link="l2"/><child link="tool"/>'
    '<origin xyz="0.1 0 0.2" rpy="0 0 0.6"/></joint>',
)
BRANCHED = make_robot(
    "branched",
    make_link("cart", 3.0, ORIGIN, (0.1, 0.1, 0.1)),
    make_link("left", 1.0, (0.0, 0.1, 0.4), (0.03, 0.04, 0.01)),
    make_link("right", 1.0, (0.0, 0.0, 0.4), (0.03, 0.04, 0.01)),
    make_joint("rail", "prismatic", "base cart", (0.6, 0.0, 0.8)),
    make_joint("hinge", "continuous", "cart left", Y, (0.1, 0.0, 0.2)),
    make_joint("skew", "continuous", "cart right", (0.0, 0.6, 0.8), (-0.1, 0.0, 0.0)),
)


@pytest.mark.parametrize(
    "urdf",
    [*(book.urdf for book in TEXTBOOKS.values()), GENERAL, BRANCHED],
    ids=[*TEXTBOOKS, "general", "branched"],
)
def test_formulas_equal_the_generated_equations(urdf: str, tmp_path: Path) -> None:
    model = tmp_path / "robot.mbs"
    model.write_bytes(convert_text(urdf).data)
    equations = make_symbolic_equations(read_mbs(model.read_bytes(), "", mechanics_only=True))
    robot = load_equations(model, language="python", moving=True)
    assert [joint.name for joint in equations.joints.values()] == robot.joints
    n = len(robot.joints)
    matrix = {key: write_python(formula) for key, formula in equations.mass_matrix.items()}
    forces = [
        f"{write_python(c)} + {write_python(g)}"
        for c, g in zip(equations.coriolis, equations.gravity, strict=True)
    ]
    for state in make_states(n):
        mass, bias = robot.mass_matrix(state[0]), robot.bias(*state)
        for (row, column), text in matrix.items():
            actual = evaluate(text, equations, state)
            assert abs(actual - mass[row, column]) <= 1e-14 * max(1.0, np.abs(mass).max())
        for k, text in enumerate(forces):
            actual = evaluate(text, equations, state)
            assert abs(actual - bias[k]) <= 1e-14 * max(1.0, np.abs(bias).max())


@few
@given(trees(2), st.integers(0, 9))
def test_formulas_of_random_trees(mbs: Mbs, seed: int) -> None:
    """All kinds of joints; those after the second are still. No two data share a symbol."""
    for joint in [joint for joint in mbs.joints().values() if not is_fixed(joint)][2:]:
        joint.nature, joint.symbols, joint.q = "driven", ("q",), 0.4
    moving = [number - 1 for number in find_moving(mbs)]
    assume(moving)
    equations = make_symbolic_equations(mbs)
    names = [symbol.name for symbol in equations.quantities]
    assert len({*names}) == len(names)
    clean, _ = clean_numbers(mbs)
    s = random_state(clean, np.random.default_rng(seed), loads=False)
    for number, joint in enumerate(clean.joints().values()):
        if number not in moving:
            s.q[number + 1], s.qd[number + 1] = joint.q or 0.0, 0.0
    mass, bias = write_equations(clean, functions=["dirdyna"]).dirdyna(s)
    state = s.q[1:][moving], s.qd[1:][moving]
    for (row, column), formula in equations.mass_matrix.items():
        expected = mass[moving[row], moving[column]]
        assert abs(evaluate(write_python(formula), equations, state) - expected) <= 1e-13
    for k, number in enumerate(moving):
        formulas = (equations.coriolis[k], equations.gravity[k])
        actual = sum(evaluate(write_python(formula), equations, state) for formula in formulas)
        assert abs(actual - bias[number]) <= 1e-13 * max(1.0, np.abs(bias).max())


def test_symbols_have_the_names_and_numbers_of_the_model() -> None:
    """Lengths are positive; two bodies of one joint have letters; gravity has one symbol."""
    equations = make_symbolic_equations(convert(GENERAL))
    quantities = {s.name: (q.value, q.meaning) for s, q in equations.quantities.items()}
    assert quantities["m_1"] == (3.0, "mass of l1")
    assert quantities["m_2a"] == (2.0, "mass of l2")
    assert quantities["m_2b"] == (0.5, "mass of tool")
    assert quantities["l_c2ay"] == (0.02, "centre of mass of l2, along -y")
    assert quantities["g"] == (9.81, "gravity, along -z")
    assert {name for name in quantities if name.startswith("alpha")} == {
        "alpha_1",
        "alpha_2",
        "alpha_3",
        "alpha_4",
    }
    assert {symbol.name: joint.name for symbol, joint in equations.joints.items()} == {
        "q_1": "j1",
        "q_2": "j2",
    }


def test_rounding_is_no_part_of_formulas() -> None:
    """A quarter turn of 1.57, a millionth of a length, and products of inertia of CAD programs."""
    urdf = DOUBLE_PENDULUM.urdf.replace("1.5707963267948966", "1.57")
    urdf = urdf.replace('xyz="0.25 0.0 0.0"', 'xyz="0.25 1e-8 0"').replace('iyz="0"', 'iyz="1e-9"')
    assert urdf.count("1e-8") == 1
    equations = make_symbolic_equations(convert(urdf))
    exact = make_symbolic_equations(convert(DOUBLE_PENDULUM.urdf))
    assert equations.mass_matrix == exact.mass_matrix
    assert equations.gravity == exact.gravity
    assert any(
        "1.57 of shoulder_origin_R1 is taken as 1.570796" in note for note in equations.notes
    )
    assert any("centre of mass of upper" in note for note in equations.notes)
    assert any("inertia of lower" in note for note in equations.notes)


def test_open_loops_are_named() -> None:
    mbs = convert(DOUBLE_PENDULUM.urdf)
    mbs.joints()["elbow"].nature = "dependent"
    (note,) = make_symbolic_equations(mbs).notes
    assert note.startswith("loops are open")
    assert f"\\item {note}" in write_document(make_symbolic_equations(mbs))


ANGLES = tuple(Symbol(20, "q", str(k)) for k in (1, 2, 3))


@few
@given(
    st.dictionaries(
        st.tuples(*[st.integers(-2, 2)] * 3),
        st.tuples(st.integers(-4, 4), st.integers(-4, 4)),
        max_size=5,
    )
)
def test_a_trigonometric_polynomial_keeps_its_value(terms: dict[Any, Any]) -> None:
    exponentials: dict[Any, complex] = {}
    for multiples, (cosine, sine) in terms.items():
        opposite = tuple(-n for n in multiples)
        for key, value in ((multiples, cosine / 2 - sine / 2j), (opposite, cosine / 2 + sine / 2j)):
            exponentials[key] = exponentials.get(key, 0) + value
    exponentials = {key: value for key, value in exponentials.items() if value}
    form = find_shortest_form(exponentials, ANGLES)
    q = np.array([0.3, -1.1, 2.3])
    expected = sum(value * np.exp(1j * np.dot(key, q)) for key, value in exponentials.items())
    actual = sum(
        float(value)
        * math.prod(
            getattr(math, atom.function)(
                sum(n * q[ANGLES.index(symbol)] for symbol, n in atom.angle)
            )
            ** power
            for atom, power in monomial
            if isinstance(atom, Trigonometric)
        )
        for monomial, value in form.items()
    )
    assert abs(actual - expected) <= 1e-12


LETTERS = tuple(Symbol(rank, letter) for rank, letter in enumerate("mldx"))


@few
@given(
    st.dictionaries(
        st.tuples(*[st.integers(0, 2)] * 4),
        st.fractions(-3, 3, max_denominator=4).filter(bool),
        max_size=8,
    )
)
def test_a_shortest_formula_keeps_its_value(terms: dict[Any, Fraction]) -> None:
    polynomial = {
        make_monomial(dict(zip(LETTERS, powers, strict=True))): value
        for powers, value in terms.items()
    }
    formula = find_shortest(polynomial)
    values = {"m": Fraction(3, 2), "l": Fraction(-2), "d": Fraction(1, 3), "x": Fraction(5)}
    expected = sum(
        value * math.prod(values[symbol.letter] ** power for symbol, power in monomial)
        for monomial, value in polynomial.items()
        if all(isinstance(symbol, Symbol) for symbol, _ in monomial)
    )
    text = write_python(formula).replace("1/", "Fraction(1)/").replace("3/", "Fraction(3)/")
    assert eval(text, {**values, "Fraction": Fraction}) == pytest.approx(float(expected), abs=1e-9)
    flat = sum(2 * len(monomial) + 2 for monomial in polynomial)
    assert formula.length <= 1.3 * flat


def make_terms(*terms: tuple[int, str]) -> dict[Any, Fraction]:
    """Make a sum such as ``(2, "m l l")``."""
    by_letter = {symbol.letter: symbol for symbol in LETTERS}
    return {
        make_monomial({by_letter[x]: letters.split().count(x) for x in letters.split()}): Fraction(
            n
        )
        for n, letters in terms
    }


@pytest.mark.parametrize(
    ("terms", "expected"),
    [
        ([(1, "m l l"), (2, "m l d"), (1, "m d d")], "m (l + d)^2"),
        ([(1, "m l"), (1, "m d"), (2, "x l"), (2, "x d")], "(m + 2 x) (l + d)"),
        ([(-1, "m l"), (-3, "m d")], "-m (l + 3 d)"),
        ([(-1, "l"), (1, "d")], "d - l"),
        ([(1, "l l"), (1, "l d"), (1, "d d")], "l^2 + l d + d^2"),
        # the same beside each, but no product of two sums
        (
            [(1, x) for x in ("m m", "l l", "d d", "m l", "m d", "l d")],
            "m (m + l + d) + l^2 + l d + d^2",
        ),
        ([(1, "l l"), (2, "l d"), (1, "d d"), (2, "m l"), (2, "m d")], "(2 m + l + d) (l + d)"),
        # a mass goes out of parentheses rather than a length
        ([(1, "m l l"), (1, "m d d"), (1, "x")], "m (l^2 + d^2) + x"),
        ([(1, "l l"), (2, "l d"), (2, "l x"), (1, "d x")], "l^2 + 2 l d + 2 l x + d x"),
        ([], "0"),
        ([(1, "")], "1"),
    ],
)
def test_common_factors_are_taken_out(terms: Any, expected: str) -> None:
    assert write_formula(find_shortest(make_terms(*terms))) == expected


def test_latex_of_the_double_pendulum() -> None:
    text = write_document(make_symbolic_equations(convert(DOUBLE_PENDULUM.urdf)))
    for line in (
        r"c_1 &= -m_2 l_1 l_{c2} s_2 \dot q_2 (2 \dot q_1 + \dot q_2) \\",
        r"c_2 &= m_2 l_1 l_{c2} s_2 \dot q_1^2 \\",
        r"g_2 &= m_2 g l_{c2} c_{12}",
        r"$q_2$ & elbow & angle (rad) \\",
        r"$l_{c1}$ & centre of mass of upper, along x & 0.25 & m \\",
    ):
        assert f"{line}\n" in text
    assert (
        r"M &= \begin{pmatrix} m_1 l_{c1}^2 + I_1 + m_2 (l_1^2 + l_{c2}^2 + 2 l_1 l_{c2} c_2) + I_2"
        r" & m_2 l_{c2} (l_{c2} + l_1 c_2) + I_2 \\" in text
    )


def test_long_formulas_go_on_in_the_next_line() -> None:
    """A line ends before + or -, also inside parentheses."""
    text = write_document(make_symbolic_equations(convert(PUMA.urdf)))
    (c1,) = (part for part in text.split("\\\\\n") if part.startswith("c_1 &="))
    assert len(c1) < 6 * LINE_LENGTH
    assert "\\\\\n&\\quad {} + 2 s_{23} (c_{23}" in text
    assert text.count("(") == text.count(")")


def test_names_are_no_commands_of_latex() -> None:
    assert escape(r"a_b{\x}") == r"a\_b\{\textbackslash{}\textbackslash{}x\}"


def test_many_joints_get_the_recursion() -> None:
    mbs = convert(TINY)
    with pytest.raises(NoFormulasError, match=r"9 joints of .* move, .* at most 4"):
        make_symbolic_equations(mbs)
    text = write_recursion(mbs)
    assert "8 & shoulder & 7 & turns about z & 0, 0, 0 \\\\" in text
    assert "8 & arm & 0.5 & 0, 0, 0.15 & 0.004, 0, 0, 0.003738, 0.000846964, 0.001262 \\\\" in text
    assert "never moves: turns about y, $q_i = 0.5$" in text
    weld = make_joint("weld", "fixed", "base rod", X)
    still = convert_text(make_robot("still", make_link("rod", 1.0, X), weld), base="fixed")
    with pytest.raises(NoFormulasError, match="no joint of robot moves"):
        make_symbolic_equations(still.mbs)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="LaTeX is not installed (pdflatex)")
def test_latex_takes_the_documents(tmp_path: Path) -> None:
    """Long lines do not leave the page, and names with all characters are no commands."""
    texts = {name: make_symbolic_equations(convert(book.urdf)) for name, book in TEXTBOOKS.items()}
    documents = {name.replace(" ", ""): write_document(each) for name, each in texts.items()}
    documents["general"] = write_document(make_symbolic_equations(convert(GENERAL)))
    documents["recursion"] = write_recursion(convert(TINY.replace('"shoulder"', '"a_b%~^{#$}"')))
    for name, text in documents.items():
        (tmp_path / f"{name}.tex").write_text(text)
        command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", f"{name}.tex"]
        ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stdout
        assert "Overfull" not in ran.stdout, (name, ran.stdout)


def test_the_command_writes_latex(tmp_path: Path, capsys: Any) -> None:
    for name, urdf in (("puma", PUMA.urdf), ("tiny", TINY)):
        model = tmp_path / f"{name}.mbs"
        model.write_bytes(convert_text(urdf).data)
        assert main(["equations", str(model), "--language", "latex", "-o", str(tmp_path)]) == 0
        printed = capsys.readouterr().out
        assert "in LaTeX" in printed
        assert "_equations.tex, or copy the formulas" in printed
        assert ("the file has the recursion of Newton and Euler" in printed) == (name == "tiny")
    files = {path.name: path.read_text() for path in tmp_path.glob("*.tex")}
    assert len(files) == 2 or "robot_equations.tex" in files
    for text in files.values():
        assert text.startswith("% Written by urdf2mbs from ")
        assert "\n% Fits (tree, numbers): sha256 " in text
    assert main(["equations", str(model), "--language", "latex", "--fold"]) == 2
    assert "--fold is for programs" in capsys.readouterr().err


def list_tables(conversion: Any) -> list[dict[str, str]]:
    return [dict(rows) for _, _, rows in of_plugins(conversion, for_page=True).tables]


def test_the_page_shows_formulas_of_small_robots() -> None:
    """In plain text, by the tables that any plugin may add to a page."""
    asked: Any = {"equations": {"language": "latex"}}
    conversion = convert_text(DOUBLE_PENDULUM.urdf, passes=asked).conversion
    formulas, symbols = list_tables(conversion)
    assert formulas["M₁₂"] == "m₂ lc₂ (lc₂ + l₁ cos(q₂)) + I₂"
    assert formulas["c₁"] == "-m₂ l₁ lc₂ sin(q₂) q\u0307₂ (2 q\u0307₁ + q\u0307₂)"
    assert symbols["q₂"] == "elbow"
    assert symbols["lc₁"] == "0.25 m: centre of mass of upper, along x"
    (file,) = (path for path in conversion.files if path.suffix == ".tex")
    assert file.name == "robot_equations.tex"
    by_default = convert_text(DOUBLE_PENDULUM.urdf).conversion
    assert list_tables(by_default) == [formulas, symbols]
    assert of_plugins(by_default).tables == []  # the command line shows none
    for passes in ({}, asked):
        assert list_tables(convert_text(TINY, passes=passes).conversion) == []


def test_the_page_says_where_formulas_depart_from_numbers() -> None:
    urdf = DOUBLE_PENDULUM.urdf.replace('rpy="1.5707963267948966 ', 'rpy="1.5708 ')
    assert urdf != DOUBLE_PENDULUM.urdf
    _, symbols = list_tables(convert_text(urdf).conversion)
    assert "the angle 1.5708 of " in symbols[""]


def test_long_formulas_are_not_on_the_page() -> None:
    """Oblique axes: the page is made as fast as without them."""
    urdf = PUMA.urdf.replace('rpy="0.0 0.0', 'rpy="0.3 0.2')
    assert urdf != PUMA.urdf
    assert list_tables(convert_text(urdf).conversion) == []


def test_powers_in_plain_text() -> None:
    equations = make_symbolic_equations(convert(PUMA.urdf))
    text = list_formulas(equations)["M₁₁"]
    assert text.startswith("I₁ + m₃ (l₂ cos(q₂) + lc₃ cos(q₂ + q₃))² + cos²(q₂) (m₂ lc₂² + I₂zz)")


def test_sympy_gets_formulas(tmp_path: Path) -> None:
    sympy = pytest.importorskip("sympy", reason="sympy is not installed (urdf2mbs[sympy])")
    model = tmp_path / "arm.urdf"
    model.write_text(DOUBLE_PENDULUM.urdf)
    robot: Any = load_equations(model, math=sympy)
    m_2, l_1, l_c2 = sympy.symbols("m_2 l_1 l_c2")
    q_2, qdot_1, qdot_2 = robot.q[1], *robot.qd
    h = -m_2 * l_1 * l_c2 * sympy.sin(q_2)
    expected = sympy.Matrix([h * (2 * qdot_1 * qdot_2 + qdot_2**2), -h * qdot_1**2])
    assert sympy.expand(robot.coriolis() - expected) == sympy.zeros(2, 1)
    numbers = load_equations(model, language="python", moving=True)
    q, qd, qdd = np.random.default_rng(2).uniform(-1, 1, (3, 2))
    for name, arguments in (
        ("mass_matrix", (q,)),
        ("bias", (q, qd)),
        ("inverse_dynamics", (q, qd, qdd)),
        ("forward_dynamics", (q, qd, qdd)),
    ):
        formula = getattr(robot, name)(*arguments).subs(robot.values)
        actual = np.array(formula.tolist(), dtype=float).squeeze()
        assert np.allclose(actual, getattr(numbers, name)(*arguments), rtol=1e-13, atol=1e-14)
    assert robot._repr_latex_().startswith("$$\\begin{aligned}\nM &= ")
    with pytest.raises(TypeError, match="casadi has all functions"):
        robot.jacobian("lower", q)
    (tmp_path / "tiny.urdf").write_text(TINY)
    with pytest.raises(ValueError, match=r"9 joints .* math=casadi"):
        load_equations(tmp_path / "tiny.urdf", math=sympy)
