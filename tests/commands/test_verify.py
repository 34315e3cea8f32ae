"""What the command `verify` prints of pairs that are and are not the same: words and JSON."""

import json
from pathlib import Path
from typing import Any

import pytest

from support.build import joint, link, robot
from support.presets import PRESETS
from urdf2mbs import convert, verify
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text


@pytest.fixture
def pair(here: Path) -> Path:
    """The folder of tiny.urdf and of its .mbs."""
    (here / "tiny.mbs").write_bytes(convert("tiny.urdf").data)
    return here


def test_a_keyword_that_no_config_has_is_refused(pair: Path) -> None:
    with pytest.raises(ConfigError, match="unknown key 'bases'"):
        verify("tiny.urdf", "tiny.mbs", bases="fixed")


def test_what_differs_is_told_by_its_effect_on_the_motion(pair: Path, capsys: Any) -> None:
    text = TINY.replace('<mass value="2"/>', '<mass value="3"/>')
    text = text.replace('xyz="0.1 0 0.15"', 'xyz="0.1001 0 0.15"')
    (pair / "other.urdf").write_text(text)
    assert main(["verify", "other.urdf", "tiny.mbs"]) == 3
    out = capsys.readouterr().out
    mass, place = [line for line in out.splitlines() if "e-" in line[:9]]
    assert "link 'body': mass is 2 in the .mbs; expected 3" in mass
    assert "link 'arm' is displaced after joint 'shoulder'" in place
    assert out.endswith("NOT the same robot\n")
    assert main(["verify", "other.urdf", "tiny.mbs", "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    assert found["same"] is False
    assert found["differences"][0]["message"].startswith("link 'body': mass is 2 in the .mbs")


def test_the_masses_are_of_the_robots_and_not_of_what_matches(pair: Path, capsys: Any) -> None:
    (pair / "stranger.urdf").write_text(
        TINY.replace('"shoulder"', '"a"').replace('"wrist_roll"', '"b"').replace("wrist_pitch", "c")
    )
    (pair / "fixed.mbs").write_bytes(convert("tiny.urdf", base="fixed").data)
    assert main(["verify", "stranger.urdf", "fixed.mbs"]) == 0
    assert "0.6 kg move in the .mbs, 0.6 kg in the URDF" in capsys.readouterr().out


def test_no_deviation_of_zero_stands_beside_a_difference(pair: Path, capsys: Any) -> None:
    text = (pair / "tiny.mbs").read_text()
    (pair / "floats.mbs").write_text(text.replace("-9.81", "9.81"))
    assert main(["verify", "tiny.urdf", "floats.mbs"]) == 3
    out = capsys.readouterr().out
    assert "10 rigid groups at 4 positions: 1 difference\n" in out
    assert "0.0e+00" not in out


def test_frames_that_a_model_may_choose_are_counted_and_not_listed(pair: Path, capsys: Any) -> None:
    links = "".join(
        f'<link name="f{k}"/><joint name="m{k}" type="fixed"><parent link="hand"/>'
        f'<child link="f{k}"/><origin xyz="0 AT {k}"/></joint>'
        for k in range(12)
    )
    text = TINY.replace("</robot>", f"{links}</robot>")
    (pair / "many.urdf").write_text(text.replace("AT", "0"))
    (pair / "many.mbs").write_bytes(convert("many.urdf").data)
    (pair / "many.urdf").write_text(text.replace("AT", "0.5"))
    assert main(["verify", "many.urdf", "many.mbs"]) == 0
    out = capsys.readouterr().out
    assert "12 frames of links and points elsewhere than by the URDF, as a model may choose" in out
    assert "its frame is" not in out
    assert ", frame " not in out


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_rounding_does_not_add_up_along_an_arm(tmp_path: Path) -> None:
    """Its half turns have 12 digits, and `compact` takes the axes as exact: each joint is 2e-13
    rad off, and the wrist, which two joints share, has no length that the rounding could be
    small beside."""
    half, straight, down = "3.14159265359", "0 0 0", "0 -0.2 0"
    arm = [
        ("0 0 0.5", f"0 0 {half}", "0 0 1"),
        (down, f"0 {half} 0", "-1 0 0"),
        (down, straight, "0 -1 0"),
        (down, straight, "-1 0 0"),
        (down, f"0 {half} 0", "0 -1 0"),
        (down, straight, "1 0 0"),
        (straight, f"0 {half} 0", "0 1 0"),
    ]
    text, before = link("world"), "world"
    for number, (xyz, rpy, axis) in enumerate(arm):
        at = straight if number == 6 else "0 -0.1 0"
        body = f'<inertial><origin xyz="{at}"/><mass value="1"/>'
        body += '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>'
        name = f"l{number}"
        text += link(name, body) + joint(before, name, xyz=xyz, rpy=rpy, axis=axis)
        before = name
    (tmp_path / "arm.urdf").write_text(robot(text))
    (tmp_path / "arm.mbs").write_bytes(convert(tmp_path / "arm.urdf", pipeline="compact").data)
    verdict = verify(tmp_path / "arm.urdf", tmp_path / "arm.mbs")
    assert verdict.same
    assert verdict.largest["motion"] < 1e-12


MIMIC = '<axis xyz="0 1 1"/><mimic joint="wrist_roll" multiplier="2"/>'
TOOL = '<origin xyz="0 0 0.1" rpy="0 1.5708 0"/>'


@pytest.mark.parametrize(
    ("old", "new", "kinds"),
    [
        ('<mass value="2"/>', '<mass value="2.00"/>', []),
        ('<mass value="2"/>', '<mass value="3"/>', ["mass"]),
        ('lower="-1.5"', 'lower="-1.4"', ["parameter"]),
        ('name="shoulder"', 'name="elbow"', []),
        ('<axis xyz="0 1 1"/>', MIMIC, ["mimic"]),
        (TOOL, '<origin xyz="0 0 0.2"/>', []),
    ],
)
def test_two_urdfs_are_compared(
    old: str, new: str, kinds: list[str], pair: Path, capsys: Any
) -> None:
    assert old in TINY
    (pair / "new.urdf").write_text(TINY.replace(old, new))
    for files in (("tiny.urdf", "new.urdf"), ("new.urdf", "tiny.urdf")):
        verdict = verify(*files)
        assert sorted({found.kind for found in verdict.differences}) == sorted(kinds)
        assert verdict.not_compared == verdict.but_for == {}
        assert len(verdict.frames) == (old == TOOL)
        assert verify(*files, frames=True).same is (not kinds and old != TOOL)
    assert main(["verify", "tiny.urdf", "new.urdf"]) == (3 if kinds else 0)
    out = capsys.readouterr().out
    assert "new.urdf was converted in memory" in out
    assert "kg move in new.urdf" in out


def test_a_follower_of_both_urdfs_is_no_deviation(pair: Path) -> None:
    (pair / "tiny.urdf").write_text(TINY.replace('<axis xyz="0 1 1"/>', MIMIC))
    assert verify("tiny.urdf", "tiny.urdf").verdict == "the same robot"
    assert "free here" in verify("tiny.urdf", "tiny.mbs").verdict


def test_edits_of_an_mbs_are_no_part_of_its_urdf(pair: Path) -> None:
    convert("tiny.urdf").write(force=True)
    text = (pair / "tiny.mbs").read_text()
    (pair / "tiny.mbs").write_text(text.replace("<mass>2.0<", "<mass>3.0<"))
    assert not verify("tiny.urdf", "tiny.mbs").same
    assert verify("tiny.urdf", "tiny.urdf").same


def test_two_models_are_compared(pair: Path, capsys: Any) -> None:
    assert verify("tiny.mbs", "tiny.urdf").same
    assert verify("tiny.mbs", "tiny.mbs").same
    text = (pair / "tiny.mbs").read_text()
    (pair / "heavy.mbs").write_text(text.replace("<mass>2.0<", "<mass>3.0<"))
    assert main(["verify", "tiny.mbs", "heavy.mbs"]) == 3
    assert "link 'body': mass is 3 in heavy.mbs; expected 2" in capsys.readouterr().out


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_verify_reads_off_the_model_whether_it_floats(pair: Path, base: str) -> None:
    (pair / "tiny.mbs").write_bytes(convert_text(base=base).data)
    found = verify("tiny.urdf", "tiny.mbs")
    assert found.differences == []
    assert found.base == base


@pytest.mark.parametrize(("tolerance", "same"), [(1e-3, True), (1e-9, False)])
def test_verify_takes_its_tolerance(pair: Path, tolerance: float, same: bool) -> None:
    text = (pair / "tiny.mbs").read_text()
    (pair / "tiny.mbs").write_text(text.replace("<mass>0.5<", "<mass>0.50001<"))
    assert (verify("tiny.urdf", "tiny.mbs", tolerance=tolerance).differences == []) is same


def test_six_joints_of_a_urdf_are_no_floating_base(here: Path) -> None:
    """Some authors let a robot float by three shifts and three rotations of their own."""
    axes = ["1 0 0", "0 1 0", "0 0 1"]
    kinds = [*(("prismatic", axis) for axis in axes), *(("continuous", axis) for axis in axes)]
    body = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    elements = [link("world"), *(link(f"l{k}") for k in range(5)), link("l5", body + "</inertial>")]
    parents = ["world", *(f"l{k}" for k in range(5))]
    elements += [
        joint(parent, f"l{k}", kind, axis=axis)
        for k, (parent, (kind, axis)) in enumerate(zip(parents, kinds, strict=True))
    ]
    (here / "own.urdf").write_text(robot(*elements))
    (here / "own.mbs").write_bytes(convert("own.urdf").data)
    verdict = verify("own.urdf", "own.mbs")
    assert verdict.same
    assert len(verdict.joints) == 6
