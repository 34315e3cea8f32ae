"""Other units and a turned base are one difference, and do not hide the others."""

import re
from math import degrees, pi
from pathlib import Path

import pytest

from support.build import robot
from support.nameless import change, make_humanoid, rename_mbs, rename_urdf
from urdf2mbs import verify
from urdf2mbs.cli import main
from urdf2mbs.verification import Verdict

#: With turned joints, and a link that is fixed to the world.
HUMANOID = re.sub(
    '(name="(?:left|right)_(?:knee|elbow|wrist|ankle)".*?rpy=")0 0 0',
    r"\g<1>0.3 0.2 -0.5",
    make_humanoid(),
)


def compare(tmp_path: Path, second: str, seed: int = 7, first: str = HUMANOID) -> Verdict:
    """Compare with a robot in which names do not help."""
    (tmp_path / "a.urdf").write_text(first)
    (tmp_path / "b.urdf").write_bytes(rename_urdf(second, seed).data)
    return verify(tmp_path / "a.urdf", tmp_path / "b.urdf")


def multiply(text: str, attribute: str, factor: float) -> str:
    """Multiply the numbers of an attribute; those of an axis stay."""

    def scale(found: re.Match[str]) -> str:
        numbers = (repr(float(number) * factor) for number in found[3].split())
        return f'{found[1]}{found[2]}="{" ".join(numbers)}"'

    return re.sub(rf'(<(?:origin|inertia)[^>]*?)\b({attribute})="([^"]*)"', scale, text)


def in_millimetres(text: str, *, inertia: bool) -> str:
    """State a robot in mm, and its inertia in kg mm^2."""
    text = multiply(text, "xyz", 1000.0)
    for moment in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz") if inertia else ():
        text = multiply(text, moment, 1e6)
    return text


@pytest.mark.parametrize("inertia", [True, False])
def test_millimetres_for_metres(inertia: bool, tmp_path: Path) -> None:
    verdict = compare(tmp_path, in_millimetres(HUMANOID, inertia=inertia))
    (difference,) = verdict.differences
    assert difference.kind == "units"
    assert "all lengths are 1000 times those in a.urdf" in difference.message
    assert ("inertia, too" in difference.message) is inertia
    back = compare(tmp_path, HUMANOID, first=in_millimetres(HUMANOID, inertia=inertia))
    assert "all lengths are 0.001 times" in back.differences[0].message


def test_other_units_do_not_hide_a_wrong_mass(tmp_path: Path) -> None:
    wrong = change(HUMANOID, '(name="head"><inertial>.*?<mass value=")3', r"\g<1>5")
    verdict = compare(tmp_path, in_millimetres(wrong, inertia=True))
    assert [each.kind for each in verdict.differences][:2] == ["units", "mass"]
    assert "link 'head': mass is 5" in verdict.findings[1].message


def test_degrees_for_radians(tmp_path: Path) -> None:
    verdict = compare(tmp_path, multiply(HUMANOID, "rpy", degrees(1.0)))
    (difference,) = verdict.differences
    assert difference.kind == "units"
    assert "the angles are in degrees" in difference.message
    back = compare(tmp_path, HUMANOID, first=multiply(HUMANOID, "rpy", degrees(1.0)))
    assert "if those in a.urdf are in degrees" in back.differences[0].message


def test_millimetres_and_degrees(tmp_path: Path) -> None:
    second = multiply(in_millimetres(HUMANOID, inertia=False), "rpy", degrees(1.0))
    verdict = compare(tmp_path, second)
    assert [each.kind for each in verdict.differences] == ["units"]
    assert "1000 times" in verdict.differences[0].message
    assert "degrees" in verdict.differences[0].message


def on_world(angle: float) -> str:
    """The humanoid's pelvis as a root that is the ground, turned about z."""
    turned = f'rpy="0 0 {angle!r}"'
    fixed = (
        '<link name="world"/><joint name="stand" type="fixed"><parent link="world"/>'
        f'<child link="pelvis"/><origin xyz="0 0 0" {turned}/></joint>'
    )
    return HUMANOID.replace('<robot name="r">', f'<robot name="r">{fixed}')


@pytest.mark.parametrize("angle", [pi / 2, pi, 1.5708, 0.3])
def test_a_turned_robot_is_one_difference(angle: float, tmp_path: Path) -> None:
    verdict = compare(tmp_path, on_world(angle), first=on_world(0.0))
    (difference,) = verdict.differences
    assert difference.kind == "root"
    assert f"rotated by {angle:.6g} about z on its base" in difference.message
    assert len(verdict.joints) == 16


@pytest.mark.parametrize(("first", "second"), [("xyz", "yzx"), ("xz", "zx"), ("yz", "zy")])
@pytest.mark.parametrize("are_named", [True, False])
def test_shifts_may_have_another_order(
    first: str, second: str, are_named: bool, tmp_path: Path
) -> None:
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    inertial = '<inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/><inertia ixx="1" iyy="1.2" '
    inertial += 'izz="1.4" ixy="0.1" ixz="0" iyz="0"/></inertial>'

    def hang(order: str) -> str:
        elements, parent = ['<link name="world"/>'], "world"
        for number, axis in enumerate(order):
            is_last = number == len(order) - 1
            child = "body" if is_last else f"slide{number}"
            elements.append(f'<link name="{child}">{inertial if is_last else ""}</link>')
            elements.append(
                f'<joint name="along_{axis}" type="prismatic"><parent link="{parent}"/><child '
                f'link="{child}"/><origin xyz="0 0.1 0.2"/><axis xyz="{axes[axis]}"/>'
                '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
            )
            parent = child
        return robot(*elements)

    (tmp_path / "a.urdf").write_text(hang(first))
    data = hang(second).encode() if are_named else rename_urdf(hang(second), 3).data
    (tmp_path / "b.urdf").write_bytes(data)
    verdict = verify(tmp_path / "a.urdf", tmp_path / "b.urdf")
    assert verdict.same, [difference.message for difference in verdict.differences]


def test_two_models_of_other_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    first = rename_mbs(HUMANOID, 1)
    wrong = change(HUMANOID, '(name="head"><inertial>.*?<mass value=")3', r"\g<1>5")
    Path("a.mbs").write_bytes(first.data)
    Path("b.mbs").write_bytes(rename_mbs(HUMANOID, 2).data)
    Path("c.mbs").write_bytes(rename_mbs(wrong, 3).data)
    verdict = verify("a.mbs", "b.mbs")
    assert verdict.same
    second = rename_mbs(HUMANOID, 2)
    for name, other in first.names.items():
        assert verdict.joints[other] == (second.names[name],)
    assert main(["verify", "a.mbs", "c.mbs"]) == 3
    out = capsys.readouterr().out
    assert "mass is 5 in c.mbs; expected 3" in out
    assert "the base floats" in out
