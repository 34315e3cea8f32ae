"""The verdict compares the robot that was read with MuJoCo's own numbers, and sees what differs."""

import sys
from pathlib import Path
from random import Random
from typing import Any

import msgspec
import numpy as np
import pytest

from support.folders import TESTS
from support.mjcf import ARM, with_parts
from urdf2mbs import convert, verify
from urdf2mbs.cli import main
from urdf2mbs_mjcf import reader
from urdf2mbs_mjcf.model import Compiled
from urdf2mbs_mjcf.process import compile_mjcf

pytest.importorskip("mujoco")


@pytest.fixture(autouse=True)
def mjcf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "robot.xml"
    file.write_text(ARM)
    return file


def change(monkeypatch: pytest.MonkeyPatch, kind: str, number: int, **fields: Any) -> None:
    """Let the reader see another model than MuJoCo has computed with."""

    def compile_changed(source: Path) -> Compiled:
        model = compile_mjcf(source)
        elements = getattr(model, kind)
        elements[number] = msgspec.structs.replace(elements[number], **fields)
        return model

    monkeypatch.setattr(reader, "compile_mjcf", compile_changed)


@pytest.mark.parametrize(
    ("kind", "number", "fields", "said"),
    [
        ("joints", 1, {"pos": (0.0, 0.0, 0.1 + 1e-6)}, "mass matrix"),
        ("joints", 1, {"axis": (-1.0, -1.0, 0.0)}, "mass matrix"),
        ("bodies", 2, {"mass": 1.0}, "mass matrix"),
        ("bodies", 3, {"inertia": (0.1, 0.1, 0.001)}, "mass matrix"),
        ("bodies", 2, {"pos": (0.2, 1e-7, 0.0)}, "pose"),
    ],
)
def test_another_robot_is_rejected(
    mjcf: Path,
    monkeypatch: pytest.MonkeyPatch,
    kind: str,
    number: int,
    fields: dict[str, Any],
    said: str,
) -> None:
    change(monkeypatch, kind, number, **fields)
    result = convert(mjcf)
    assert result.report.verdict == "NOT the same robot"
    assert result.conversion.checked.rejected is not None
    proof = result.report.proof
    assert proof is not None
    assert any(said in difference.message for difference in proof.differences)


def test_a_gravity_that_is_not_read_shows_in_the_bias(
    mjcf: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def compile_changed(source: Path) -> Compiled:
        return msgspec.structs.replace(compile_mjcf(source), gravity=(0.0, 0.0, -9.81))

    monkeypatch.setattr(reader, "compile_mjcf", compile_changed)
    proof = convert(mjcf).report.proof
    assert proof is not None
    assert [difference.message for difference in proof.differences if "bias" in difference.message]


def test_verify_says_it_too(mjcf: Path, capsys: Any) -> None:
    convert(mjcf).write()
    said = "the same robot, and as MuJoCo computes it, to 1e-1"
    assert verify("robot.xml", "robot.mbs").verdict.startswith(said)
    config = Path("robot.yaml")
    config.write_text("source: robot.xml\n")
    assert verify(config).verdict.startswith(said)
    assert main(["convert", "robot.xml", "--stop-after", "expand", "--dump", "dump"]) == 0
    urdf = Path("dump", "expanded.urdf")
    differences = verify(urdf, "robot.xml").differences
    assert [difference.kind for difference in differences] == ["gravity"]
    mjcf.write_text(ARM.replace("0 0 -3", "0 0 -9.81"))
    assert verify(urdf, "robot.xml").verdict.startswith(said)


def test_a_pass_before_it_may_change_the_robot(mjcf: Path) -> None:
    drop_links = TESTS / "door" / "drop_links.py"
    result = convert(
        mjcf,
        plugins=[drop_links],
        after={"expand": "drop-links"},
        passes={"drop-links": {"links": ["lower"]}},
    )
    assert "as MuJoCo computes it" in result.report.verdict
    assert "but for what drop-links changed" in result.report.verdict


def random_model(choice: Random) -> str:
    """A tree of bodies with joints of all kinds, each anywhere."""

    def numbers(count: int, scale: float = 1.0) -> str:
        return " ".join(f"{choice.uniform(-scale, scale):.6g}" for _ in range(count))

    count = choice.randint(2, 7)
    parents = [None, *(choice.randrange(k) for k in range(1, count))]
    children: dict[int | None, list[int]] = {}
    for child, parent in enumerate(parents):
        children.setdefault(parent, []).append(child)

    def body(number: int) -> str:
        kinds = choice.choice(
            (["hinge"], ["slide"], ["ball"], ["hinge", "slide"], ["hinge"] * 2, [])
        )
        if number == 0 and choice.random() < 0.5:
            kinds = ["free"]
        joints = ""
        for index, kind in enumerate(kinds):
            place = "" if kind == "free" else f'pos="{numbers(3)}"'
            axis = f'axis="{numbers(3)}" ref="{numbers(1)}"' if kind in ("hinge", "slide") else ""
            joints += f'<joint name="j{number}_{index}" type="{kind}" {place} {axis}/>'
        size = " ".join(f"{choice.uniform(0.05, 0.3):.6g}" for _ in range(3))
        geom = f'<geom type="box" size="{size}" pos="{numbers(3)}" euler="{numbers(3, 3.0)}"/>'
        inner = "".join(map(body, children.get(number, [])))
        return (
            f'<body name="b{number}" pos="{numbers(3)}" euler="{numbers(3, 3.0)}">'
            f"{joints}{geom}{inner}</body>"
        )

    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{numbers(3, 10.0)}"/>'
        f"<worldbody>{body(0)}</worldbody></mujoco>"
    )


@pytest.mark.parametrize("seed", range(4))
def test_random_models_are_those_of_mujoco(mjcf: Path, seed: int) -> None:
    mjcf.write_text(random_model(Random(seed)))
    result = convert(mjcf)
    assert result.report.verdict.startswith("the same robot")
    numbers = result.report.passes.get("compare-mujoco")
    if numbers is not None:  # it has joints
        assert max(numbers[kind] for kind in ("mass matrix", "bias", "pose")) < 2e-12


def test_the_numbers_are_those_of_another_program(mjcf: Path) -> None:
    """Pinocchio's mass matrix and bias, of a tree that both can read."""
    pinocchio = pytest.importorskip("pinocchio")
    mjcf.write_text(with_parts(option='<option gravity="0 0 -9.81"/>'))
    result = convert(mjcf)
    assert result.conversion.expanded is not None
    model = pinocchio.buildModelFromXML(result.conversion.expanded.decode())
    state = compile_mjcf(mjcf).states[0]
    angles = [coordinates[0] for coordinates in state.angles]
    q = np.ravel([(np.cos(angle), np.sin(angle)) for angle in angles])
    data = model.createData()
    mass_matrix = pinocchio.crba(model, data, q)
    mass_matrix = np.triu(mass_matrix) + np.triu(mass_matrix, 1).T
    assert mass_matrix == pytest.approx(np.array(state.mass_matrix), rel=1e-12)
    bias = pinocchio.rnea(model, data, q, np.array(state.velocity), np.zeros(2))
    assert bias == pytest.approx(np.array(state.bias), rel=1e-12)


def test_a_plain_urdf_imports_nothing_of_the_plugin(mjcf: Path, tmp_path: Path) -> None:
    import subprocess

    code = (
        "import sys, urdf2mbs, urdf2mbs.testing as testing\n"
        "testing.convert_text(testing.TINY)\n"
        "print(*[name for name in sys.modules if name.startswith('urdf2mbs_mjcf')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["urdf2mbs_mjcf"]
