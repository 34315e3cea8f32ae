"""Mirrored limbs, which C computes in pairs."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.equations import convert_robot
from support.examples import reproducible
from support.oracle.generated import CEquations, error, random_state
from support.oracle.pin import Truth
from urdf2mbs.mbs.model import Base, Body, Joint, Mbs, Point
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.graph import Expr, Graph, Op
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.pairs import find_mirrored, pair_mirrored
from urdf2mbs_equations.routine import Routine, make_statements
from urdf2mbs_equations.tree import Tree

numbers = st.sampled_from([0.0, 0.1, -0.2, 0.35])
vectors = st.tuples(numbers, numbers, numbers)


@st.composite
def limbs(draw: st.DrawFn) -> Mbs:
    """Draw a floating body with two limbs of the same joints.

    The second limb has other numbers.  It may have its axes in another order, and a joint that the
    first limb does not have.
    """
    mbs = Mbs("limbs", base=Base(gravity=(0.0, 0.0, -9.81)))
    base = Body("base", None, None, [Joint(f"b{k}", k) for k in ("T1", "T2", "T3", "R1", "R2")])
    base.mass, base.inertia = 5.0, (0.3, 0.0, 0.0, 0.4, 0.0, 0.5)
    base.points = [Point(side, draw(vectors)) for side in "lr"]
    mbs.bodies = [base]
    kinds = draw(st.lists(st.sampled_from(["R1", "R2", "R3", "R1", "R2", "T1"]), min_size=2))[:4]
    shift = draw(st.integers(0, 2))
    turned = draw(st.sampled_from([None, 0.3, np.pi / 2]))
    for side in "lr":
        parent, point = "base", side
        for i, kind in enumerate(kinds):
            axis = int(kind[1]) - 1 + (shift if side == "r" else 0)
            joints = [Joint(f"{side}{i}", f"{kind[0]}{axis % 3 + 1}")]
            if turned and i == 1:
                fixed = Joint(f"{side}f", "R1" if side == "l" else "R2", nature="driven")
                fixed.q, fixed.symbols = turned, ("q",)
                joints.insert(0, fixed)
            body = Body(f"{side}body{i}", parent, point, joints, mass=draw(st.floats(0.5, 2.0)))
            body.com = draw(vectors)
            body.inertia = (0.1, draw(numbers) / 9, 0.0, 0.2, 0.01, 0.25)
            body.points = [Point("P", draw(vectors))]
            mbs.bodies.append(body)
            parent, point = body.name, "P"
        if draw(st.booleans()):
            tip = Body(f"{side}tip", parent, point, [Joint(f"{side}tip", "R1")], mass=0.1)
            mbs.bodies.append(tip)
    return mbs


@settings(reproducible, max_examples=4)
@given(limbs(), st.booleans(), st.integers(0, 9))
def test_equations_in_pairs_of_random_limbs_are_as_pinocchio(
    mbs: Mbs, fold: bool, seed: int
) -> None:
    made = generate(mbs, b"<mbsDescR7/>", "limbs.mbs", EquationOptions(language="c", fold=fold))
    assert made.counts["dirdyna"].paired > 0
    made.files = {name: text for name, text in made.files.items() if "dyna" in name}
    with tempfile.TemporaryDirectory() as folder:
        eq, truth = CEquations(made, mbs, Path(folder)), Truth(mbs)
    s = random_state(mbs, np.random.default_rng(seed))
    truth.check_forces(eq, s)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "dirdyna", "invdyna"),
    [
        ("nao-naoV50_generated_urdf", (13529, 12074), (5796, 4990)),
        ("icub-iCubGazeboV2_5", (14673, 11250), (5712, 4200)),
    ],
)
def test_humanoids_are_mirrored(
    name: str, dirdyna: tuple[int, int], invdyna: tuple[int, int]
) -> None:
    """Operations, and how many of them are in pairs; fewer operations are better.

    iCub's left and right limbs turn about axes of other names.
    """
    mbs, _ = convert_robot(name)
    twin, _ = find_mirrored(Tree(mbs))
    names = [joint.name for body in mbs.bodies for joint in body.joints]
    for k, j in twin.items():
        first_result, second_result = sorted((names[k - 1].lower(), names[j - 1].lower()))
        assert first_result.replace("l", "r") == second_result.replace("l", "r"), (
            first_result,
            second_result,
        )
    counts = generate(mbs, b"<mbsDescR7/>", "robot.mbs", EquationOptions(language="c")).counts
    for routine, expected in (("dirdyna", dirdyna), ("invdyna", invdyna)):
        assert (counts[routine].operations, counts[routine].paired) == expected


def test_no_pairs_if_they_are_not_asked_for() -> None:
    mbs, data = convert_robot("cassie-cassie_v4")
    made = generate(mbs, data, "robot.mbs", EquationOptions(language="c", pairs=False))
    for text in made.files.values():
        assert b"pair" not in text
        assert b"vector_size" not in text


def test_compilers_without_vectors_use_the_plain_c_of_the_same_file(tmp_path: Path) -> None:
    """MSVC among them: below ``#else`` the file is the one that is generated without pairs."""
    mbs, data = convert_robot("cassie-cassie_v4")
    paired, plain = (
        generate(mbs, data, "robot.mbs", EquationOptions(language="c", pairs=pairs), ["dirdyna"])
        for pairs in (True, False)
    )
    ((name, text),) = paired.files.items()
    with_pairs, _, without = text.partition(b"\n#else\n\nPIECE ")
    assert b"pair" in with_pairs
    assert b"pair" not in without
    assert without.removesuffix(b"\n#endif\n") in plain.files[name]
    s = random_state(mbs, np.random.default_rng(1))
    vectors, scalars = (
        CEquations(paired, mbs, tmp_path, *flags).dirdyna(s)
        for flags in (("-O0",), ("-O0", "-DMBS_NO_PAIRS"))
    )
    for expected, actual in zip(vectors, scalars, strict=True):
        assert error(actual, expected) <= 1e-13


@pytest.mark.parametrize("part", [Op.FIRST, Op.SECOND])
def test_a_pair_of_which_half_is_used_has_a_name(part: Op) -> None:
    graph = Graph()
    routine = Routine(graph)
    pair = graph.pair(graph.make_symbol("a[1]").node, graph.make_symbol("a[2]").node)
    routine.store("c[1]", Expr(graph, graph.get_part(part, pair)))
    first, last = make_statements(routine)[0]
    assert (first.text, first.is_pair) == ("PAIR(a[1], a[2])", True)
    assert last.text == f"{first.variable}[{part - Op.FIRST}]"


def test_twins_that_need_each_other_are_taken_apart() -> None:
    graph = Graph()
    a, b, c, d = (graph.make_symbol(f"{x}[{k}]") for x in "ab" for k in (1, 2))
    low, high = a * c, b * d
    first_result = (low + a) * c
    # the sum is a twin of its own operand's sum
    second_result = (first_result * d + b) * d
    routine = Routine(graph)
    routine.store("c[1]", first_result)
    routine.store("c[2]", second_result)
    routine.store("c[3]", high)
    routine.mark_mirrored(first_result, second_result)
    routine.mark_mirrored(low, high)
    paired = pair_mirrored(routine)
    made: set[str] = set()
    for line in make_statements(paired)[0]:
        assert {name for name in line.uses if name.startswith("x")} <= made
        made.add(line.variable or "")
    assert len(paired.steps) == 3
