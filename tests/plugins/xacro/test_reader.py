"""What the reader says of a robot that xacro has expanded."""

from pathlib import Path

import pytest

from support.urdf_files import XMLNS, read
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_xacro import has_xacro


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (
            '<robot>\n<link name="a"/><joint name="j" type="$${x}"/></robot>',
            "xacro-unexpanded",
            "type='${x}' of joint 'j' was left by xacro\n  joint 'j' is in ",
        ),
        (
            f'<robot {XMLNS}><xacro:macro name="arm"/><xacro:macro name="hand"/></robot>',
            "no-links",
            "defines the macro(s) 'arm, hand' and calls none\n  name the robot that includes it",
        ),
        (
            '<robot>\n<link name="a"><inertial><mass value="$${m}"/></inertial></link></robot>',
            "xacro-unexpanded",
            "value='${m}' of link 'a' was left by xacro",
        ),
        (
            f'<robot {XMLNS}><xacro:macro name="arm"/><link/></robot>',
            "name-missing",
            "a link without a name\n",
        ),
        (
            f'<robot {XMLNS}><xacro:macro name="arm"><a/></xacro:macro><xacro:arm/></robot>',
            "no-links",
            "the robot has no links\n  ",
        ),
    ],
)
def test_what_is_wrong_after_xacro(tmp_path: Path, text: str, code: str, words: str) -> None:
    with pytest.raises(ConversionError) as caught:
        read(tmp_path, text)
    error = caught.value
    assert (error.code, error.file) == (code, f"{tmp_path / 'robot.urdf'} (expanded)")
    assert words in str(error)


def test_messages_of_xacro_come_before_those_of_the_reader(tmp_path: Path) -> None:
    inside = "${xacro.warning('low')}<link name='a'><visual/></link>"
    _, reported = read(tmp_path, f"<robot {XMLNS}><xacro:if value='0'/>{inside}</robot>")
    assert [diagnostic.code for diagnostic in reported] == [
        "xacro-warning",
        "geometry-unknown",
        "robot-unnamed",
    ]
    with pytest.raises(ConversionError) as caught:
        read(tmp_path, f"<robot {XMLNS}><xacro:if value='0'/>{inside}<link/><link/></robot>")
    codes = [diagnostic.code for diagnostic in caught.value.earlier]
    assert codes == ["xacro-warning", "geometry-unknown", "name-missing"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f'<robot {XMLNS}><xacro:if value="1"/></robot>', True),
        ('<robot><xacro:if value="1"/></robot>', True),
        (f'<robot {XMLNS}><xacro:macro name="m"/></robot>', True),
        (f"<robot {XMLNS}><xacro:macro/><xacro:hand/></robot>", False),
        (f'<robot {XMLNS.replace(":xacro", ":x")}><x:if value="1"/></robot>', True),
        (f"<robot {XMLNS.replace(':xacro', '')}/>", True),
        (f"<robot {XMLNS.replace(':xacro', ':its_xacro-2')}><its_xacro-2:if/></robot>", True),
        ('<robot><link name="${prefix}arm"/></robot>', True),
        ('<robot><joint><origin xyz="$(arg x) 0 0"/></joint></robot>', True),
        ('<robot><plugin file="${path}"/></robot>', False),
        (f"<robot {XMLNS}/>", False),
        (f'<robot {XMLNS}><!-- by xacro: ${{this}} --><link name="$"/></robot>', False),
        ('<robot name="xacro"><link name="xacro"/><!-- <xacro:if/> --></robot>', False),
    ],
)
def test_whether_there_is_xacro(text: str, expected: bool) -> None:
    assert has_xacro(text.encode(), "r.urdf") is expected
