"""Each bad URDF ends in the code that belongs to it, said with file and line; and all is told."""

from pathlib import Path

import pytest

from urdf2mbs.api import convert
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic
from urdf2mbs.urdf.messages import MAX_ERRORS
from urdf2mbs.urdf.reader import parse_urdf

GOOD = """<?xml version="1.0"?>
<robot name="r">
  <link name="a"><inertial><origin xyz="0 0 1" rpy="0 0 0"/><mass value="2.5"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0 0 2" rpy="0 0 1"/><geometry><box size="1 2 3"/></geometry>
      <material name="m"><color rgba="1 0 0 1"/></material></visual>
    <collision><geometry><cylinder radius="4" length="5"/></geometry></collision></link>
  <link name="b"><inertial><mass value="3.5"/>
    <inertia ixx="2" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial></link>
  <joint name="j" type="revolute"><origin xyz="0 0 3" rpy="0 1 0"/><parent link="a"/>
    <child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1.5" effort="6" velocity="7"/>
    <dynamics damping="8" friction="9"/></joint>
</robot>
"""
#: Words where one number is wanted, and three; and where a number stands that the .mbs needs.
NO_NUMBER = {
    "number-missing": ["", " "],
    "number-count": ["1 2", "1&#10;2"],
    "number-invalid": ["one", "1,5", "nan", "-inf", "1e999", "0x10", "1_000", "١", "1;", "1.5.2"],
    "xacro-unexpanded": ["${x}", "$(arg x)"],
}
NO_VECTOR = {
    "number-missing": [""],
    "number-count": ["0 0", "0 0 0 1", "1"],
    "number-invalid": ["x y z", "0 0 nan", "0 0 1e400", "[0 0 1]"],
    "number-commas": ["0, 0, 1"],
    "xacro-unexpanded": ["0 0 ${z}"],
}
NUMBERS = ('value="2.5"', 'ixx="1"', 'izz="2"')
VECTORS = ('xyz="0 0 1"', 'xyz="0 0 3"', 'rpy="0 1 0"', 'xyz="0 1 0"')
#: Where a number stands that the .mbs does not need.
OPTIONAL = (
    'lower="-1"',
    'effort="6"',
    'damping="8"',
    'radius="4"',
    'xyz="0 0 2"',
    'rpy="0 0 1"',
    'size="1 2 3"',
    'rgba="1 0 0 1"',
)


def changed(old: str, new: str) -> bytes:
    assert old in GOOD
    return GOOD.replace(old, new, 1).encode("utf-8", "surrogatepass")


def doctype(text: str, use: str = "2.5") -> bytes:
    bare = GOOD.partition("?>")[2].strip().replace("2.5", use)
    return f"<!DOCTYPE robot [{text}]>\n{bare}".encode()


def end(text: str) -> bytes:
    return changed("</robot>", text)


LAUGHS = '<!ENTITY l0 "lol">' + "".join(
    f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12)
)
PASSWORDS = '"file:///etc/passwd"'
#: What is wrong with the file as XML, or with its letters, by the code.
BYTES: dict[str, list[bytes]] = {
    "file-empty": [b"", b" \n\t\r\n", b"\xef\xbb\xbf", b"\0" * 100],
    "not-xml": [
        b"robot",
        b'{"robot": {}}',
        b"robot:\n  name: r\n",
        b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
        b"PK\x03\x04" + bytes(100),
    ],
    "wrong-root": [b"<sdf/>", b"<html><body/></html>", GOOD.replace("robot", "Robot").encode()],
    "xml-entity": [
        doctype(LAUGHS, "&l11;"),
        doctype(LAUGHS + '<!ATTLIST robot x CDATA "&l11;">'),
        doctype(f'<!ENTITY a "{"a" * 10000}">', "&a;" * 1000),
        doctype(f"<!ENTITY e SYSTEM {PASSWORDS}>", "&e;"),
        doctype('<!ENTITY e SYSTEM "http://127.0.0.1:9/">', "&e;"),
        doctype('<!ENTITY e "x">'),
        doctype(f"<!ENTITY % p SYSTEM {PASSWORDS}>%p;"),
        doctype('<!ENTITY e "&e;">', "&e;"),
    ],
    "xml-syntax": [
        changed("2.5", "&e;"),
        changed('"j"', '"j\0k"'),
        changed('"j"', '"&#0;"'),
        changed('"j"', '"&#xD800;"'),
        changed('"j"', '"\x1b[2J"'),
        changed('"j"', '"\ud800"'),
        GOOD.replace('"j"', '"é"').encode("latin-1"),
        changed('"1.0"', '"1.0" encoding="klingon"'),
        end("</robot><robot/>"),
        changed('"j"', "j"),
        changed('name="j"', 'name="j" name="k"'),
        changed("</joint>", "</link>"),
        changed('"j"', '"j<k"'),
        changed('"j"', '"j&k"'),
    ],
    "xml-truncated": [
        end("<![CDATA[</robot>"),
        end("<!-- </robot>"),
        end(f"<!--{'x' * 21_000_000}-->"),
        *(GOOD.encode()[:cut] for cut in range(30, len(GOOD.rstrip()) - 1, 41)),
    ],
    "xml-too-large": [
        b'<robot name="r">' + b"<a>" * 100_000 + b"</a>" * 100_000 + b"</robot>",
        b'<robot name="r">' + b"<a>" * 100_000,
        end(f"<{'x' * 60_000}/>"),
        end("x" * 11_000_000 + "</robot>"),
        changed('"j"', f'"{"j" * 11_000_000}"'),
    ],
    "xml-mended": [
        end(f"<!--{'x' * 21_000_000}--></robot>"),
        changed('"1.0"', '"2.0"'),
        end("<!-- a -- b --></robot>"),
        b"\n" + GOOD.encode(),
    ],
    "xml-namespace": [end("<x:y/></robot>")],
    "merge-conflict": [changed("  <link", "<<<<<<< HEAD\n  <link")],
    "number-left-out": [
        changed(place, f'{place.partition("=")[0]}="{word}"')
        for place in OPTIONAL
        for word in ("", "x", "nan", "1 2 3 4 5")
    ],
}
CASES = [(code, data) for code, several in BYTES.items() for data in several]
for places, wrong in ((NUMBERS, NO_NUMBER), (VECTORS, NO_VECTOR)):
    CASES += [
        (code, changed(place, f'{place.partition("=")[0]}="{word}"'))
        for place in places
        for code, words in wrong.items()
        for word in words
    ]


def list_messages(data: bytes) -> list[Diagnostic]:
    """All that is said of a file, and the error at the end."""
    try:
        return parse_urdf(data, "r.urdf")[1]
    except ConversionError as error:
        return [*error.earlier, error.diagnostic()]


def test_the_good_one_is_good() -> None:
    assert list_messages(GOOD.encode()) == []


@pytest.mark.parametrize(
    ("code", "data"), CASES, ids=[f"{c}-{n}" for n, (c, _) in enumerate(CASES)]
)
def test_a_bad_file(code: str, data: bytes) -> None:
    matching = [diagnostic for diagnostic in list_messages(data) if diagnostic.code == code]
    assert matching, [str(diagnostic) for diagnostic in list_messages(data)]
    assert matching[0].file == "r.urdf"
    assert matching[0].message
    assert len(str(matching[0])) < 2000, "an error is for a person"
    assert matching[0].line or code == "file-empty", "which line?"


def test_errors_are_told_together_in_their_order() -> None:
    """The tree is judged when the others are mended; not too many are told."""
    three = (
        GOOD.replace('value="2.5"', 'value="x"')
        .replace('value="3.5"', 'value=""')
        .replace('xyz="0 1 0"', 'xyz="0 0 0"')
    )
    joint = '<joint name="{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    more = joint.format("k", "nobody", "b") + joint.format("l", "a", "b") + "</robot>"
    many = '<link name="c{}"><inertial><mass value="x"/></inertial></link>\n'
    for text, wanted in (
        (three, [(3, "number-invalid"), (8, "number-missing"), (11, "axis-zero")]),
        (GOOD.replace("</robot>", more), [(13, "link-unknown"), (13, "two-parents")]),
        (
            GOOD.replace("</robot>", "".join(map(many.format, range(1000))) + "</robot>"),
            [(13 + n, "number-invalid") for n in range(MAX_ERRORS)],
        ),
    ):
        assert [
            (diagnostic.line, diagnostic.code) for diagnostic in list_messages(text.encode())
        ] == wanted
    assert "there may be more" in str(list_messages(text.encode())[-1])


def test_a_name_of_millions_of_letters(tmp_path: Path) -> None:
    """It is cut in a message, and goes through all of the conversion."""
    name = "x" * 2_000_000
    matching = list_messages(
        GOOD.replace('<parent link="a"/>', f'<parent link="{name}"/>').encode()
    )
    assert [diagnostic.code for diagnostic in matching] == ["link-unknown"]
    assert name in matching[0].message
    assert len(str(matching[0])) < 5000
    (tmp_path / "r.urdf").write_text(GOOD.replace('"j"', f'"{name}"'))
    result = convert(tmp_path / "r.urdf")
    assert list(result.robot.joints)[-1] == name
    assert result.conversion.checked.proof is not None
    assert result.conversion.checked.proof.same
