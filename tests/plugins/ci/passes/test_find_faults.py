"""Faults of the robot as a whole are reported, and none of a sound robot."""

from urdf2mbs.testing import TINY, convert_text

FAULTS = ["expand", "find-faults"]


def codes(text: str) -> list[str]:
    return [diagnostic.code for diagnostic in convert_text(text, pipeline=FAULTS).diagnostics]


def test_a_sound_robot() -> None:
    assert codes(TINY) == []


def test_each_fault_is_named_once() -> None:
    visual = '<visual><geometry><mesh filename="package://gone/{}.stl"/></geometry></visual>'
    links = "".join(f'<link name="{name}">{visual.format(name) * 2}</link>' for name in "abc")
    limit = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    joints = "".join(
        f'<joint name="to_{child}" type="revolute"><parent link="a"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/>{limit}{mimic}</joint>'
        for child, mimic in (("b", ""), ("c", '<mimic joint="to_b" multiplier="-1"/>'))
    )
    text = f'<robot name="r">{links}{joints}</robot>'
    assert codes(text) == ["no-mass", "mimic-locked", "mesh-missing"]
