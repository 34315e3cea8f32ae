"""Each bad URDF ends in the code that belongs to it, said with file and line; and all is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from hostile.bad_urdf import GOOD, all_cases

from urdf2mbs.api import convert
from urdf2mbs.messages.diagnostics import ConversionError, Diagnostic
from urdf2mbs.urdf.messages import MOST_ERRORS
from urdf2mbs.urdf.reader import parse

CASES = all_cases()


def said(data: bytes) -> list[Diagnostic]:
    """All that is said of a file, and the error at the end."""
    try:
        return parse(data, "r.urdf")[1]
    except ConversionError as error:
        return [*error.said, error.diagnostic()]


def test_there_are_enough_of_them_and_no_two_are_the_same() -> None:
    assert len({data for data, _ in CASES.values()}) == len(CASES) >= 320


def test_the_good_one_is_good() -> None:
    assert said(GOOD.encode()) == []


@pytest.mark.parametrize("name", CASES)
def test_a_bad_file(name: str) -> None:
    data, code = CASES[name]
    found = [one for one in said(data) if one.code == code]
    assert found, [str(one) for one in said(data)]
    assert found[0].file == "r.urdf"
    assert found[0].message
    assert len(str(found[0])) < 2000, "an error is for a person"
    if code not in ("file-empty", "no-links"):
        assert found[0].line, "which line?"


@pytest.mark.parametrize(
    "data",
    [
        GOOD.encode(),
        b"\xef\xbb\xbf" + GOOD.encode(),
        GOOD.encode("utf-16"),
        GOOD.replace('"1.0"', '"1.0" encoding="UTF-16"').encode("utf-16"),
        GOOD.replace('"1.0"', '"1.0" encoding="UTF-8"').encode("utf-16-le"),
        GOOD.replace('"1.0"', '"1.0" encoding="ISO-8859-1"').encode("latin-1"),
        GOOD.replace('"1.0"', '"1.1"').encode(),
        GOOD.replace("\n", "\r\n").encode(),
        GOOD.replace("\n", "\r").encode(),
        GOOD.replace('name="r"', 'name="r" xmlns="http://www.ros.org/urdf"').encode(),
        GOOD.replace("<?xml", "<!DOCTYPE robot>\n<?xml").encode(),
        GOOD.replace("</robot>", f"<!--{'x' * 21_000_000}--></robot>").encode(),
    ],
    ids=["plain", "BOM", "UTF-16", "named UTF-16", "UTF-16 as UTF-8", "Latin-1", "XML 1.1", "CRLF",
         "CR", "default namespace", "DOCTYPE", "21 MB of a comment"],
)  # fmt: skip
def test_an_odd_file_is_the_same_robot(data: bytes) -> None:
    plain, odd = parse(GOOD.encode(), "r.urdf")[0], parse(data, "r.urdf")[0]
    assert list(odd.links) == list(plain.links)
    assert odd.joints["j"].axis == plain.joints["j"].axis
    assert odd.links["a"].inertial == plain.links["a"].inertial


def test_all_errors_are_told_together_in_their_order(tmp_path: Path) -> None:
    file = tmp_path / "r.urdf"
    file.write_text(
        GOOD.replace('value="2.5"', 'value="x"')
        .replace('value="3.5"', 'value=""')
        .replace('xyz="0 1 0"', 'xyz="0 0 0"')
    )
    with pytest.raises(ConversionError) as caught:
        convert(file)
    lines = [line for line in str(caught.value).splitlines() if line.startswith(str(file))]
    assert [line[len(str(file)) :].split("]")[0] for line in lines] == [
        ":3: error[number-invalid", ":8: error[number-missing", ":11: error[axis-zero",
    ]  # fmt: skip


def test_errors_of_the_tree_are_told_together() -> None:
    joint = '<joint name="{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    more = joint.format("k", "nobody", "b") + joint.format("l", "a", "b") + "</robot>"
    codes = [one.code for one in said(GOOD.replace("</robot>", more).encode())]
    assert codes == ["link-unknown", "two-parents"]


def test_not_too_many_are_told() -> None:
    many = "".join(f'<link name="c{n}"><inertial><mass value="x"/></inertial></link>\n'
                   for n in range(1000))  # fmt: skip
    found = said(GOOD.replace("</robot>", many + "</robot>").encode())
    assert [one.code for one in found] == ["number-invalid"] * MOST_ERRORS
    assert "there may be more" in str(found[-1])


def test_a_name_of_a_million_letters_is_cut_in_a_message() -> None:
    name = "x" * 1_000_000
    found = said(GOOD.replace('<parent link="a"/>', f'<parent link="{name}"/>').encode())
    assert [one.code for one in found] == ["link-unknown"]
    assert name in found[0].message
    assert len(str(found[0])) < 5000
    assert str(found[0]).startswith("r.urdf:10: error[link-unknown]: joint 'j'")


def test_megabytes_in_one_attribute(tmp_path: Path) -> None:
    """What libxml2 reads (10,000,000 letters) is a name, through all of the conversion."""
    name = "y" * 2_000_000
    (tmp_path / "r.urdf").write_text(GOOD.replace('"j"', f'"{name}"'))
    result = convert(tmp_path / "r.urdf")
    assert list(result.robot.joints)[-1] == name
    assert result.conversion.proof is not None
    assert result.conversion.proof.same
