"""Our equations beside those of Robotran's generator: numbers, rows, signs, messages."""

import ctypes
import importlib.util
import json
import subprocess
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.equations import write_equations
from support.folders import SHARED
from support.oracle.generated import HEADER, Data, PythonEquations
from support.project_robots import BALL, FOUR_BAR, origin_at, unit_link
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs, Point
from urdf2mbs.mbs.model import Sensor as Measures
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import convert_text
from urdf2mbs_equations.constraints import find_constant_gaps
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.options import EquationOptions

SAMPLES = SHARED / "mbs-samples"
#: Functions that differ by definition: the generator of 2008 gives Z of a link a sign.
DIFFERENT = {"mharding01-coman_flex_feet": {"link"}}
#: Samples that are small: they have a loop, springs or sensors.
SMALL = ("MaxenceVL-Piston_Engine", "Vhinque-Ankle", "maximemchlt-suspension")
REFERENCES = [
    pytest.param(path, id=name, marks=() if name in SMALL else pytest.mark.slow)
    for path in sorted(SAMPLES.glob("*.reference.json"))
    for name in [path.name.removesuffix(".reference.json")]
]


@pytest.mark.skipif(not REFERENCES, reason="no samples beside the project: ../shared/mbs-samples")
@pytest.mark.parametrize("reference", REFERENCES)
def test_the_numbers_of_robotrans_own_equations(reference: Path, tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("check", SAMPLES / "check.py")
    assert spec is not None
    assert spec.loader is not None
    check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check)
    name = reference.name.removesuffix(".reference.json")
    model = SAMPLES / f"{name}.mbs"
    mbs = read_mbs(model.read_bytes(), name, mechanics_only=True)
    for file, text in generate(
        mbs, b"<mbsDescR7/>", name, EquationOptions(language="python")
    ).files.items():
        (tmp_path / file).write_bytes(text)
    expected, data = json.loads(reference.read_text()), check.Data(str(model))
    different = set()
    for function, results in expected["functions"].items():
        generated = check.load(str(tmp_path), function)
        for state, result in zip(expected["states"], results, strict=True):
            if not check.difference(result, check.run(data, function, generated, state)) < 1e-9:
                different.add(function)
    assert different == DIFFERENT.get(name, set())


def convert_closed(text: str, cuts: dict[str, Any]) -> Mbs:
    result = convert_text(text, base="fixed", passes={"loops": {"cuts": cuts}})
    return read_mbs(result.data, "four_bar", mechanics_only=True)


def compute_residual(eq: PythonEquations, s: Data, count: int) -> float:
    """Return the largest element of J qdd + jdqd."""
    _, jacobian, jdqd = eq.constraints(s, count)
    return float(np.abs(jacobian @ s.qdd[1:] + jdqd).max())


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_two_planar_four_bars(c: bool) -> None:
    """Their rows follow one another, without rows of zeros between: the partition counts such."""
    second = FOUR_BAR.partition(">")[2].removesuffix("</robot>").replace(unit_link("base"), "")
    for name in ("left", "coupler", "right", "crank", "elbow", "rocker"):
        second = second.replace(f'"{name}"', f'"{name}2"').replace(f"'{name}'", f"'{name}2'")
    cuts = {
        **BALL,
        "pin2": {"ends": [{**end, "link": f"{end['link']}2"} for end in BALL["pin"]["ends"]]},
    }
    mbs = convert_closed(FOUR_BAR.replace("</robot>", f"{second}</robot>"), cuts)
    assert sum(j.nature == "dependent" for body in mbs.bodies for j in body.joints) == 4
    eq, s = write_equations(mbs, c=c), Data(mbs)
    names = mbs.numbers()
    s.q[names["crank"]], s.qd[names["crank"]], s.qd[names["crank2"]] = 0.3, 1.0, -2.0
    s.q[names["elbow"]], s.q[names["rocker"]] = -0.3, 0.3
    assert eq.accelred(s) == 0
    assert abs(s.qd[names["rocker"]] - 1.0) <= 1e-9
    assert abs(s.qd[names["rocker2"]] + 2.0) <= 1e-9
    _, jacobian, _ = eq.constraints(s, 6)
    assert np.abs(jacobian).max(axis=1).astype(bool).tolist() == [True] * 4 + [False] * 2
    assert compute_residual(eq, s, 4) <= 1e-9


def test_a_turn_that_never_moves_brings_no_row_back() -> None:
    """A plane that stands upright by a driven quarter turn: Robotran's form is that of its
    number."""
    mbs = convert_closed(FOUR_BAR, BALL)
    for body in mbs.bodies:
        if body.parent is None:
            turn = Joint(f"turn_{body.name}", "R1", "driven", q=np.pi / 2, symbols=("q",))
            body.joints.insert(0, turn)
    eq, s = write_equations(mbs), Data(mbs)
    assert eq.accelred(s) == 0
    _, jacobian, _ = eq.constraints(s, 3)
    assert np.abs(jacobian).max(axis=1).astype(bool).tolist() == [True, True, False]


def test_a_row_that_is_zero_after_cancelling_only_is_kept() -> None:
    """A ball on the axis of an R3 behind two R1: Robotran does not see that a x a is zero."""
    mbs = Mbs("m")
    mbs.base.points = [Point("P", (0.0, 0.5, 0.5))]
    mbs.bodies = [
        Body("a", None, None, [Joint("a1", "R1", "dependent")], points=[Point("P", (0, 0.5, 0))]),
        Body(
            "b",
            "a",
            "P",
            [Joint("b1", "R1", "dependent"), Joint("b2", "R3")],
            points=[Point("P", (0.0, 0.0, 0.5)), Point("Q")],
        ),
    ]
    rows = {}
    for point in ("P", "Q"):
        mbs.cuts = [Connection("ball", "cut", ("b", point), (None, "P"))]
        text = (
            generate(mbs, b"<mbsDescR7/>", "m", EquationOptions(language="python"))
            .files["mbs_cons_jdqd_m.py"]
            .decode()
        )
        rows[point] = text.count("Jdqd[")
    assert rows == {"P": 3, "Q": 2}


def make_gap() -> str:
    return FOUR_BAR.replace(origin_at(1, 0, 0), origin_at(1, 0.1, 0))


def test_a_conversion_warns_of_a_gap_that_no_joint_closes() -> None:
    result = convert_text(make_gap(), base="fixed", passes={"loops": {"cuts": BALL}})
    (warning,) = [d for d in result.diagnostics if d.code.startswith("loop-")]
    assert warning.code == "loop-never-closes"
    assert "0.1 m apart along y of 'base'" in warning.message


def test_the_command_warns_of_a_gap_that_no_joint_closes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mbs = convert_closed(make_gap(), BALL)
    path = tmp_path / "four_bar.mbs"
    path.write_bytes(write(mbs))
    assert main(["equations", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    printed = capsys.readouterr()
    assert "warning[loop-never-closes]: cut 'pin' can never close" in printed.err
    (warning,) = json.loads(printed.out)["warnings"]
    assert warning["code"] == "loop-never-closes"
    assert not list(find_constant_gaps(convert_closed(FOUR_BAR, BALL)))
    mbs.cuts[0].kind = "solid"  # in the plane its bodies are parallel
    assert len(list(find_constant_gaps(mbs))) == 1
    turn = Joint("turn", "R1", "driven", q=0.3, symbols=("q",))
    mbs.bodies[-1].joints.append(turn)
    assert any("turned about x" in message for _, message in find_constant_gaps(mbs))
    mbs.cuts = [Connection("rod", "rod", (None, None), (None, None), 0.5)]
    assert ["not as far apart" in message for _, message in find_constant_gaps(mbs)] == [True]


def make_arm(*, links: int = 0) -> Mbs:
    mbs = Mbs("arm")
    mbs.base.points = [Point("P", (0.0, 0.0, 1.0))]
    mbs.bodies = [
        Body("b", None, "P", [Joint("slide", "T3")], 1.0, points=[Point("P", (0.1, 0.0, 0.0))])
    ]
    ends = [((None, "P"), ("b", None)), (("b", None), (None, "P")), (("b", "P"), ("b", "P"))]
    mbs.links = [Connection("link", f"l{i}", *pair) for i, pair in enumerate(ends[:links])]
    return mbs


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_links_along_one_shift_and_in_one_place(c: bool) -> None:
    """Z is the distance of the ends, also in a model of MBSysPad of 2014 (0.0.beta)."""
    mbs = make_arm(links=3)
    mbs.version = "0.0.beta"
    eq, s = write_equations(mbs, c=c), Data(mbs)
    s.q[1], s.qd[1], s.user_LinkForces = -0.5, 2.0, lambda *arguments: 10.0 * arguments[-1]
    eq.loads(s, "link")
    assert s.Z[1:].tolist() == [0.5, 0.5, 0.0]
    assert s.Zd[1:].tolist() == [-2.0, -2.0, 0.0]
    assert s.Fl[1:].tolist() == [10.0, 20.0, 30.0]
    assert s.frc[3, 1] == pytest.approx(30.0)  # positive forces pull the ends together
    assert not s.frc[1:3].any()


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_function_that_the_model_does_not_need(
    c: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    """If it is called, the simulation stops with a message."""
    mbs = make_arm()
    eq, s = write_equations(mbs, c=c), Data(mbs)
    s.flag_stop = 0
    for call in (
        lambda: eq.loads(s, "link"),
        lambda: eq.loads(s, "link3D"),
        lambda: eq.loads(s, "extforces"),
        lambda: eq.sensor(s, 1),
    ):
        call()
        libc.fflush(None)
        assert "symbolic files seem obsolete" in capfd.readouterr().err
        assert c or s.flag_stop == 1
    assert eq.accelred(s) == 0  # does not call them


libc = ctypes.CDLL(None)


@pytest.mark.parametrize("c", [False, True], ids=["python", "c"])
def test_a_sensor_that_the_model_does_not_have(c: bool, capfd: pytest.CaptureFixture[str]) -> None:
    mbs = make_arm()
    mbs.bodies[0].points[0].sensor = Measures("eye", ("Pos",))
    eq, s = write_equations(mbs, c=c), Data(mbs)
    assert eq.sensor(s, 1).P[1] == pytest.approx(0.1)
    eq.loads(s, "extforces")  # an empty function, as Robotran's
    for kind, what in (("sensor", "sensor"), ("gensensor", "joint")):
        for number in (0, 2):
            message = f"the model has no {what} {number}: it has 1"
            if not c:
                with pytest.raises(ValueError, match=message):
                    eq.sensor(s, number, kind)
                continue
            eq.sensor(s, number, kind)
            libc.fflush(None)
            assert message in capfd.readouterr().err


def test_inverse_dynamics_of_a_loop() -> None:
    """The forces that invdynared finds make the accelerations that it was given, and the
    dependent joints have none; a driven joint's force is felt by nobody else."""
    mbs = convert_closed(FOUR_BAR, BALL)
    bodies = {body.joints[0].name: body for body in mbs.bodies}
    bodies["crank"].joints.append(Joint("drive", "R2", "driven", q=0.0))
    eq, s = write_equations(mbs, c=True), Data(mbs)
    names = mbs.numbers()
    s.q[names["drive"]], s.qd[names["drive"]], s.qdd[names["drive"]] = 0.1, 0.4, -3.0
    s.qd[names["crank"]], s.qdd[names["crank"]] = 1.5, 2.5
    expected = s.qdd[names["crank"]]
    assert eq.fill("invdynared", s) == 0
    dependent = [names["elbow"], names["rocker"]]
    assert not s.Qq[dependent].any()
    assert abs(s.Qq[names["crank"]]) > 0.1
    before = s.qdd.copy()
    s.qdd[names["crank"]] = 0.0
    assert eq.accelred(s) == 0
    assert s.qdd[names["crank"]] == pytest.approx(expected, rel=1e-9)
    assert np.abs(s.qdd - before).max() <= 1e-9


def test_inverse_dynamics_of_a_tree() -> None:
    mbs = make_arm()
    eq, s = write_equations(mbs, c=True), Data(mbs)
    s.qdd[1] = 2.0
    assert eq.fill("invdynared", s) == 0
    assert s.Qq[1] == pytest.approx(2.0 + 9.81)


@pytest.mark.parametrize("flags", [[], ["-DMBS_BEFORE_2025"]])
def test_the_c_of_loops_compiles_as_it_stands(flags: list[str], tmp_path: Path) -> None:
    source = files("urdf2mbs_equations").joinpath("accelred.c").read_text("utf-8")
    (tmp_path / "accelred.c").write_text(source)
    (tmp_path / "mbs_data.h").write_text(HEADER)
    warnings = ["-Wall", "-Wextra", "-Wshadow", "-Wpedantic", "-Werror"]
    subprocess.run(
        ["gcc", "-std=c99", *warnings, *flags, "-I.", "-c", "accelred.c"], cwd=tmp_path, check=True
    )


def test_a_draft_of_a_cut_or_a_link() -> None:
    """Functions that do not need it are generated."""
    mbs = make_arm(links=1)
    mbs.links[0].endpoint1 = ("", None)
    made = generate(mbs, b"<mbsDescR7/>", "arm.mbs", EquationOptions(language="c"))
    assert set(made.left_out) == {"link"}
    assert "link 'l0' is a draft" in made.left_out["link"]
    # a library of 2017 calls functions of what the model does not have: these do nothing there
    assert b"BEFORE_2025" not in made.files["mbs_link_arm.c"]
    assert b"#ifndef MBS_BEFORE_2025" in made.files["mbs_link3D_arm.c"]
    mbs.cuts = [Connection("ball", "pin", ("b", ""), (None, "P"))]
    made = generate(mbs, b"<mbsDescR7/>", "arm.mbs", EquationOptions(language="c"))
    assert set(made.left_out) == {"link", "cons_hJ", "cons_jdqd", "accelred", "invdynared"}
    assert len(made.files) == 11
