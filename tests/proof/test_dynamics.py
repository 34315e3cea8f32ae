"""What Pinocchio is given: the model in its order, and the URDF's text as our reader takes it."""

from __future__ import annotations

from pathlib import Path

import pytest
from proving import SOLID, joint, link, robot

from urdf2mbs.api import verify
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write
from urdf2mbs.testing import TINY, convert_text

pytest.importorskip("pinocchio", reason="Pinocchio is not installed")


def test_bodies_that_are_not_depth_first(tmp_path: Path) -> None:
    """A file edited by hand may have them in any order with parents first."""
    links = [link("world"), *(link(name, SOLID) for name in ("a", "b", "a2", "b2"))]
    joints = [
        joint("world", "a", axis="1 0 0"), joint("world", "b", axis="0 1 0", xyz="1 0 0"),
        joint("a", "a2", axis="0 1 0", xyz="0 1 0"), joint("b", "b2", axis="1 0 0", xyz="0 1 1"),
    ]  # fmt: skip
    text = robot(*links, *joints)
    mbs = read(convert_text(text).data, "")
    bodies = {body.name: body for body in mbs.bodies}
    mbs.bodies = [bodies[name] for name in ("a", "b", "a2", "b2")]
    (tmp_path / "r.urdf").write_text(text)
    (tmp_path / "r.mbs").write_bytes(write(mbs))
    verdict = verify(str(tmp_path / "r.urdf"), tmp_path / "r.mbs", engine="pinocchio")
    assert verdict.same, verdict.differences
    assert verdict.largest["mass matrix"] <= 1e-12


XACRO = (
    '<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    '<xacro:property name="half" value="0.25"/>'
)
SLIPS = {
    "a blank line first": lambda text: "\n" + text,
    "a comment with --": lambda text: text.replace("</robot>", "<!-- a -- b --></robot>"),
    "xacro": lambda text: text.replace('<robot name="tiny">', XACRO).replace(
        '<mass value="0.5"/>', '<mass value="${2 * half}"/>'
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slips_and_xacro_in_a_urdf(slip: str, tmp_path: Path) -> None:
    text = SLIPS[slip](TINY)
    (tmp_path / "r.urdf").write_text(text)
    (tmp_path / "r.mbs").write_bytes(convert_text(text).data)
    assert verify(str(tmp_path / "r.urdf"), tmp_path / "r.mbs", engine="pinocchio").same
