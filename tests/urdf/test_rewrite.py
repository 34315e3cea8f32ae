"""Ball joints and joints of one name, in the words of URDF: every reader sees the same robot."""

from pathlib import Path

import pytest

from support.build import SOLID, joint, link, robot
from support.presets import PRESETS
from urdf2mbs import convert
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.urdf.reader import parse_urdf

#: A ball joint with damping on a turned origin, and one behind it; three joints of two names.
BALLS = robot(
    link("a", SOLID),
    link("b", SOLID),
    link("c", SOLID),
    link("d", SOLID),
    link("b_R1"),
    joint("a", "b", "spherical", xyz="0.1 0.2 0.3", rpy="0.3 0.2 0.1", name="hip").replace(
        "</joint>", '<dynamics damping="2"/></joint>'
    ),
    joint("b", "c", "ball", xyz="0, 0, 0.8", name="knee"),
    joint("c", "d", name="turn"),
    joint("d", "b_R1", "fixed", name="turn"),
)


def test_new_names_are_free() -> None:
    """Of a ball joint beside a joint of such a name; of three joints of one name, and of two that
    lead to one link, which no name can mend."""
    text = BALLS.replace('name="turn"', 'name="hip_R1"', 1).replace("knee", "turn")
    names = list(parse_urdf(text.encode(), "r.urdf")[0].joints)
    assert names == [
        "hip_R1_2",
        "hip_R2",
        "hip_R3",
        "turn_R1",
        "turn_R2",
        "turn_R3",
        "hip_R1",
        "turn_2",
    ]
    alike = [joint(a, b, name="j") for a, b in ("ab", "bc", "cd")]
    text = robot(*map(link, "abcd"), *alike, joint("d", "e", name="j_2"), link("e"))
    assert list(parse_urdf(text.encode(), "r.urdf")[0].joints) == ["j", "j_3", "j_4", "j_2"]
    with pytest.raises(ConversionError) as caught:
        parse_urdf(robot(*map(link, "abc"), alike[0], *[alike[1]] * 2).encode(), "r.urdf")
    assert caught.value.code == "name-doubled"


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_a_ball_joint_is_three_joints(preset: str, base: str, tmp_path: Path) -> None:
    source = tmp_path / "r.urdf"
    source.write_text(BALLS)
    result = convert(source, pipeline=preset, base=base, output=tmp_path / "r.mbs")
    assert result.report.proof is not None
    assert result.report.proof.same
    coordinates = result.report.names.coordinates
    expected = [f"{name}_R{k}" for name in ("hip", "knee") for k in (1, 2, 3)]
    assert list(coordinates)[-7:] == [*expected, "turn"]
    types = {j.name: j.type for body in result.mbs.bodies for j in body.joints}
    assert [types[coordinates[name][0]] for name in expected] == ["R1", "R2", "R3"] * 2
    assert set(result.robot.joints) >= {*expected, "turn", "turn_2"}
    assert [result.robot.joints[name].dynamics.damping for name in expected[:3]] == [2.0] * 3
    codes = [diagnostic.code for diagnostic in result.diagnostics]
    assert codes.count("joint-ball") == codes.count("joint-renamed") == 1
    assert "number-commas" in codes
