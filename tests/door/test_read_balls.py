"""The example read_balls.py: the robot of a table is the robot of the URDF that says the same."""

from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.plugin import ConversionError

PLUGIN = Path(__file__).with_name("read_balls.py")
TABLE = "one,base,0,0,0.1,z,2,0.3\ntwo,one,0.5,0,0,x,1,0.1\n"
URDF = """<robot name="chain"><link name="base"/>
<link name="one"><inertial><mass value="2"/>
  <inertia ixx="ONE" iyy="ONE" izz="ONE"/></inertial></link>
<joint name="one_joint" type="continuous"><parent link="base"/><child link="one"/>
  <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/></joint>
<link name="two"><inertial><mass value="1"/>
  <inertia ixx="TWO" iyy="TWO" izz="TWO"/></inertial></link>
<joint name="two_joint" type="continuous"><parent link="one"/><child link="two"/>
  <origin xyz="0.5 0 0"/><axis xyz="1 0 0"/></joint></robot>"""


def test_a_table_gives_the_bytes_of_its_urdf(tmp_path: Path) -> None:
    (tmp_path / "chain.balls").write_text(TABLE)
    moments = {"ONE": 0.4 * 2 * 0.3**2, "TWO": 0.4 * 1 * 0.1**2}  # of balls of even density
    text = URDF
    for name, moment in moments.items():
        text = text.replace(f'"{name}"', f'"{moment!r}"')
    (tmp_path / "chain.urdf").write_text(text)
    balls = convert(tmp_path / "chain.balls", plugins=[PLUGIN])
    urdf = convert(tmp_path / "chain.urdf", plugins=[PLUGIN], output=tmp_path / "chain.mbs")
    assert [body.mass for body in balls.mbs.bodies] == [2.0, 1.0]
    assert balls.data.replace(b"chain_balls", b"chain") == urdf.data


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("two,one,0.5,0,0,x,heavy,0.1", "could not convert"),
        ("two,one,0.5,0,0,w,1,0.1", "'w'"),
        ("two,one", "not enough values"),
        ("", "not enough values"),
    ],
)
def test_a_wrong_line_is_named(line: str, fault: str, tmp_path: Path) -> None:
    (tmp_path / "chain.balls").write_text(TABLE.splitlines()[0] + f"\n{line}\n")
    with pytest.raises(ConversionError, match=rf"chain.balls:2: error\[balls\]: .*{fault}"):
        convert(tmp_path / "chain.balls", plugins=[PLUGIN])


def test_a_table_that_makes_no_robot_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "chain.balls").write_text(TABLE.replace("one,base", "one,nothing"))
    with pytest.raises(ConversionError, match=r"chain.balls.*link-unknown.*'nothing'"):
        convert(tmp_path / "chain.balls", plugins=[PLUGIN])
