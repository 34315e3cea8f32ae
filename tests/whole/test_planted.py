"""Each mistake that a converter could make is planted, and must be found where it is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from making import write_plugin
from proof.test_compare import body, compared, own_joint, setting
from urdf2mbs import Result, convert
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.proof.verdict import Proof

BIPED = Path(__file__).parents[2] / "configs" / "biped.urdf.xacro"


@pytest.fixture(scope="module", params=["faithful", "compact"])
def result(request: pytest.FixtureRequest) -> Result:
    return convert(BIPED, pipeline=request.param)


def again(result: Result, plant: Callable[[Mbs], None] = lambda mbs: None) -> Proof:
    """The comparison that ``check`` makes, of the file with a mistake planted."""
    mbs = read(result.data, "biped.mbs")
    plant(mbs)
    return compared(result, read(write(mbs), "biped.mbs"))


def test_without_a_mistake_there_is_none(result: Result) -> None:
    found = again(result)
    assert (found.differences, found.frames) == ([], [])


def _inertia(name: str, change: Callable[..., tuple[float, ...]]) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        body(mbs, name).inertia = change(*body(mbs, name).inertia)

    return plant


def _about_origin(mbs: Mbs) -> None:
    found = body(mbs, "chest")
    x, y, z = found.com
    xx, xy, xz, yy, yz, zz = found.inertia
    m = found.mass
    found.inertia = (
        xx + m * (y * y + z * z), xy - m * x * y, xz - m * x * z,
        yy + m * (x * x + z * z), yz - m * y * z, zz + m * (x * x + y * y),
    )  # fmt: skip


def _turn(by: float) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        driven = next(j for j in body(mbs, "left_arm").joints if j.nature == "driven")
        driven.q = (driven.q or 0.0) + by

    return plant


def _anchor(by: float) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        points = [p for b in mbs.bodies for p in b.points if p.name == "head"]
        x, y, z = points[0].coordinates
        points[0].coordinates = (x + by, y, z)

    return plant


def _swap_anchors(mbs: Mbs) -> None:
    left, right = body(mbs, "left_arm"), body(mbs, "right_arm")
    left.point, right.point = right.point, left.point


def _centre(mbs: Mbs) -> None:
    x, y, z = body(mbs, "right_thigh").com
    body(mbs, "right_thigh").com = (-x, -y, -z)


def _axis(mbs: Mbs) -> None:
    found = own_joint(mbs, "neck")
    found.type = "R1" if found.type == "R2" else "R2"


def _driven(**values: object) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        found = next(j for j in body(mbs, "left_arm").joints if j.nature == "driven" and j.q)
        for key, value in values.items():
            setattr(found, key, value)

    return plant


def _parameter(model: str, name: str, factor: float) -> Callable[[Mbs], None]:
    def plant(mbs: Mbs) -> None:
        models = [one for one in mbs.user_models if one.name == model]
        found = next(p for p in models[0].parameters if p.name == name)
        found.values = (repr(factor * float(found.values[0])),)

    return plant


PLANTED: dict[str, tuple[Callable[[Mbs], None], str]] = {
    "products of inertia negated": (
        _inertia("chest", lambda xx, xy, xz, yy, yz, zz: (xx, -xy, -xz, yy, -yz, zz)), "chest"),
    "two moments of inertia swapped": (
        _inertia("pelvis", lambda xx, xy, xz, yy, yz, zz: (yy, xy, xz, xx, yz, zz)), "pelvis"),
    "inertia about the origin": (_about_origin, "chest"),
    "a mass dropped": (lambda mbs: setattr(body(mbs, "left_shank"), "mass", None), "left_shank"),
    "a centre negated": (_centre, "right_thigh"),
    "another axis": (_axis, "head"),
    "a turn instead of a shift": (setting("left_slide", type="R3"), "left_hand"),
    "driven instead of independent": (
        setting("left_knee", nature="driven", q=0.0), "left_shank"),
    "dependent instead of independent": (
        setting("right_ankle", nature="dependent"), "right_foot"),
    "a turn of 1e-6 too much": (_turn(1e-6), "left_arm"),
    "a turn of 1e-8 too much": (_turn(1e-8), "left_arm"),
    "the sign of an angle": (_turn(-2 * 0.2), "left_arm"),
    "an anchor 1e-6 m off": (_anchor(1e-6), "head"),
    "anchors swapped": (_swap_anchors, "left_arm"),
    "q alone in the symbols of a joint that moves": (
        setting("left_knee", symbols=("q",)), "left_shank"),
    "no symbols of a joint that moves": (setting("left_knee", symbols=()), "left_shank"),
    "no q in the symbols of a driven joint": (_driven(symbols=("qd",)), "left_arm"),
    "a velocity of a driven joint": (_driven(symbols=None, qd=1.0), "left_arm"),
    "an acceleration of a driven joint": (_driven(symbols=None, qdd=1.0), "left_arm"),
    "damping a hundredfold": (_parameter("damping", "left_knee", 100.0), "left_shank"),
    "a limit moved": (_parameter("q_max", "left_knee", 1.001), "left_shank"),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANTED)
def test_a_mistake_is_found_where_it_is(result: Result, name: str) -> None:
    plant, link = PLANTED[name]
    found = again(result, plant)
    assert found.differences
    named = {difference.link for difference in found.differences}
    # nothing that is right is called wrong; of swapped anchors either arm may be
    assert link in named
    assert named <= ({link, "right_arm"} if "anchors" in name else {link})


def test_what_is_not_the_same_never_takes_the_place_of_a_good_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "biped.yaml"
    config.write_text(f"source: {BIPED}\noutput: biped.mbs\n")
    assert main(["run", str(config)]) == 0
    good = (tmp_path / "biped.mbs").read_bytes()
    capsys.readouterr()

    heavier = "for body in conversion.mbs.bodies:\n  body.mass *= 1 + 0.001 * (body.name == 'head')"
    write_plugin(tmp_path, "sabotage", heavier, reads=("inertias",))
    config.write_text(
        f"source: {BIPED}\noutput: biped.mbs\nplugins: [sabotage.py]\n"
        "after: {reframe-inertia: sabotage}\n"
    )
    assert main(["run", str(config)]) == 3
    said = capsys.readouterr()
    assert "NOT the same robot" in said.out
    assert "link 'head'" in said.err
    assert "mass" in said.err
    assert (tmp_path / "biped.mbs").read_bytes() == good
    assert (tmp_path / "biped.rejected.mbs").exists()


def test_the_walkman_sample_tells_its_story(
    shared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    urdf = shared / "robots" / "walkman" / "robotran_edu_2017" / "bigman.urdf"
    sample = shared / "mbs-samples" / "walkman_robotran.mbs"
    assert main(["verify", str(urdf), str(sample), "--tolerance", "2e-8"]) == 3
    told = capsys.readouterr().out
    assert "31 joints match by name" in told or "31 of 31 joints match by name" in told
    assert "117.754 kg" in told
    assert "121.208 kg" in told
    assert "turned by -0.4538 about y" in told
    assert "R1 -0.733, R3 0.349" in told
    assert "R1 0.733, R3 -0.349" in told
    wrong = {word.split("'")[0] for line in told.splitlines() for word in line.split("link '")[1:]}
    # feet, wrists, head, waist and shoulders, and what the turned frames are of; nothing else
    assert {"DWL", "RShp", "LShp", "RFoot", "LFoot"} <= wrong
    assert not wrong & {"DWS", "DWYTorso", "RElb", "LElb", "RForearm", "LForearm", "RThighUpLeg"}
