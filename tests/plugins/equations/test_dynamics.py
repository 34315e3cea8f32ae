"""The equations of motion against pinocchio, in Python and C, with and without constants."""

import re
from pathlib import Path

import numpy as np
import pytest

from support.equations import convert_robot
from support.folders import CONFIGS, SHARED
from support.oracle.generated import CEquations, PythonEquations, error, random_state
from support.oracle.pin import TOLERANCE, Truth
from support.real_robots import CONVERTIBLE, RealRobot
from urdf2mbs import convert
from urdf2mbs.mbs.model import Connection, Mbs, Sensor
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations.files import generate
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.python import PythonWriter

WALKMAN = SHARED / "mbs-samples" / "walkman_robotran.mbs"


def model(path: Path) -> tuple[Mbs, bytes]:
    if not path.is_file():
        pytest.skip(f"{path.name} is in ../shared, which is not here")
    data = path.read_bytes()
    return read_mbs(data, path.name, mechanics_only=True), data


def compare(eq: PythonEquations, mbs: Mbs, *, sensors: bool = True) -> None:
    truth, rng = Truth(mbs), np.random.default_rng(7)
    for _ in range(2):
        truth.check_forces(eq, random_state(mbs, rng))
    if sensors:
        truth.check_sensors(eq, random_state(mbs, rng))


def compare_accelerations(eq: PythonEquations, mbs: Mbs) -> None:
    """Compare accelred with Pinocchio: its accelerations require the forces that were given."""
    truth, s = Truth(mbs), random_state(mbs, np.random.default_rng(9), loads=False)
    free = np.array([joint.nature != "driven" for joint in mbs.joints().values()])
    s.Qq[1:] = truth.forces(s, accelerated=True)
    s.qdd[1:][free] = np.nan
    assert eq.accelred(s) == 0
    assert error(truth.forces(s, accelerated=True)[free], s.Qq[1:][free]) <= TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fold", "work"), [(False, (12961, 5030, 16150)), (True, (11955, 4766, 15122))]
)
def test_walkmans_own_file_in_python(fold: bool, work: tuple[int, ...], tmp_path: Path) -> None:
    mbs, data = model(WALKMAN)
    made = generate(mbs, data, WALKMAN.name, EquationOptions(language="python", fold=fold))
    names = ("dirdyna", "invdyna", "accelred")
    assert tuple(made.counts[name].operations for name in names) == work
    eq = PythonEquations(made, mbs, tmp_path)
    compare(eq, mbs, sensors=not fold)


#: The operations of biped, and how many of them are done in pairs.
WORK = {
    "c": {
        "dirdyna": (4623, 3388),
        "invdyna": (2026, 1222),
        "accelred": (5044, 0),
        "gensensor": (8142, 0),
    },
    "python": {
        "dirdyna": (4142, 0),
        "invdyna": (1818, 0),
        "accelred": (5044, 0),
        "gensensor": (8142, 0),
    },
}


@pytest.mark.parametrize("language", WORK)
def test_the_operations_of_a_biped(language: str) -> None:
    """The exact number shows each change that costs or saves operations."""
    data = convert(CONFIGS / "biped.urdf.xacro", pipeline="compact").data
    counts = generate(
        read_mbs(data, ""), data, "biped.mbs", EquationOptions(language=language)
    ).counts.items()
    work = {name: (count.operations, count.paired) for name, count in counts if count.operations}
    assert work == WORK[language]


def test_accelred_calls_only_what_the_model_needs() -> None:
    """accelred calls only functions that the model needs."""
    mbs = read_mbs(convert_text(TINY).data, "")
    for body in mbs.bodies:
        for joint in body.joints:
            joint.nature = "independent"
    assert set(PythonWriter(mbs).find_features().values()) == {False}
    mbs.bodies[-1].points[0].extforce = Sensor("push")
    mbs.bodies[-1].joints[-1].nature = "driven"
    mbs.links.append(Connection("link", "spring", (None, None), (mbs.bodies[-1].name, None)))
    facts = PythonWriter(mbs).find_features()
    assert facts == {"ANY_DRIVEN": True, "LINKS": True, "LINKS3D": False, "EXTFORCES": True}
    mbs.links[0].kind = "link3D"
    assert PythonWriter(mbs).find_features() == facts | {"LINKS": False, "LINKS3D": True}


@pytest.mark.parametrize("fold", [False, True], ids=["symbols", "folded"])
def test_the_c_of_a_model_is_as_pinocchio(fold: bool, tmp_path: Path) -> None:
    mbs, data = model(SHARED / "mbs-samples" / "minimal.mbs")
    made = generate(mbs, data, "minimal.mbs", EquationOptions(language="c", fold=fold))
    eq = CEquations(made, mbs, tmp_path)
    compare(eq, mbs)
    compare_accelerations(eq, mbs)


#: All in compact, and some in faithful, whose equations are three times as long.
FAITHFUL = ("ur-ur10e", "franka-fr3", "leo_rover-leo", "robotiq_2f_140-robotiq_arg2f_140_model")
#: An arm, a rover, a gripper with followers, and a biped with closed loops.
FAST = (*FAITHFUL, "cassie-cassie_v4")
EVERY = [
    pytest.param(
        *param.values,
        preset,
        id=f"{param.id}-{preset}",
        marks=() if preset == "compact" and param.id in FAST else [*param.marks, pytest.mark.slow],
    )
    for preset in ("compact", "faithful")
    for param in CONVERTIBLE
    if preset == "compact" or param.id in FAITHFUL
]


@pytest.mark.parametrize(("source", "preset"), EVERY)
def test_the_equations_of_real_robots_are_as_pinocchio(
    source: RealRobot, preset: str, tmp_path: Path
) -> None:
    data = source.convert(pipeline=preset).data
    mbs = read_mbs(data, "robot.mbs", mechanics_only=True)
    if not mbs.numbers():
        pytest.skip("nothing moves")
    made = generate(mbs, data, "robot.mbs", EquationOptions(language="python"))
    eq = PythonEquations(made, mbs, tmp_path)
    compare(eq, mbs)
    if "accelred" in made.left_out:
        assert "no matter moves with joint" in made.left_out["accelred"]
    else:
        compare_accelerations(eq, mbs)


def test_c_in_pieces() -> None:
    """Cassie's equations take several pieces, which share variables.  What they compute is held
    against Pinocchio by ``test_callable``."""
    mbs, data = convert_robot("cassie-cassie_v4")
    made = generate(mbs, data, "robot.mbs", EquationOptions(language="c"))
    text = made.files[f"mbs_dirdyna_{mbs.name}.c"]
    assert b"mbs_dirdyna_5(" in text
    for array in (b"w", b"v"):  # no place is left out, and the size is the last number
        places = {int(number) for number in re.findall(rb"\b%s\[(\d+)\]" % array, text)}
        assert places == set(range(len(places)))


def test_same_input_same_bytes() -> None:
    mbs, data = model(SHARED / "mbs-samples" / "minimal.mbs")
    again = read_mbs(data, "minimal.mbs", mechanics_only=True)
    assert (
        generate(mbs, data, "a", EquationOptions(language="python")).files
        == generate(again, data, "a", EquationOptions(language="python")).files
    )


def test_masses_can_change_without_generating_again(tmp_path: Path) -> None:
    mbs, data = model(SHARED / "mbs-samples" / "minimal.mbs")
    eq = PythonEquations(
        generate(mbs, data, "minimal.mbs", EquationOptions(language="python")), mbs, tmp_path
    )
    rng = np.random.default_rng(3)
    s = random_state(mbs, rng)
    number = 0
    for body in mbs.bodies:
        number += len(body.joints)
        if body.mass:
            body.mass *= rng.uniform(0.5, 2.0)
            s.m[number] = body.mass
        if body.com:
            body.com = tuple(x * rng.uniform(0.5, 2.0) for x in body.com)
            s.l[1:, number] = body.com
    Truth(mbs).check_forces(eq, s)


def test_generated_python_is_silent_under_ruff() -> None:
    """Each variable that is assigned is used."""
    mbs, data = convert_robot("cassie-cassie_v4")
    for name, text in generate(
        mbs, data, "robot.mbs", EquationOptions(language="python")
    ).files.items():
        for function in text.decode().split("\ndef ")[1:]:
            assert ("given = " in function) == ("= given." in function or "given is" in function), (
                name
            )
