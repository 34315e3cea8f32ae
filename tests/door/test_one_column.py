"""The example one_column.py: another diagram of the same robot, in which no box covers another."""

import re
from itertools import pairwise
from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.plugin import ConfigError
from urdf2mbs.testing import assert_same_robot, convert_text

PLUGIN = Path(__file__).with_name("one_column.py")


def test_all_but_the_diagram_is_the_same_to_the_byte() -> None:
    result = convert_text(plugins=[PLUGIN], swap={"layout": "one_column"})
    assert_same_robot(result)
    usual = convert_text().data
    assert result.data != usual
    without_diagram = [re.sub(rb"(?s)<x2D>.*?</x2D>", b"", data) for data in (result.data, usual)]
    assert without_diagram[0] == without_diagram[1]


def test_each_body_is_below_the_one_before() -> None:
    mbs = convert_text(plugins=[PLUGIN], swap={"layout": "one_column"}).mbs
    rows = []
    for body in mbs.bodies:
        positions = [joint.position for joint in body.joints if joint.position is not None]
        assert len(positions) == len(body.joints)
        assert [x for x, _ in positions] == sorted({x for x, _ in positions})
        rows += [y for _, y in positions[:1]]
        assert len({y for _, y in positions}) == 1
        assert body.drawing is not None
        left, right = positions[-1][0] + body.drawing.position[0], body.drawing.size[0]
        assert all(
            point.position == (left + right, point.position[1])
            for point in body.points
            if point.position
        )
    assert mbs.base.position is not None
    rows.insert(0, mbs.base.position[1])
    assert all(below - above == 100.0 for above, below in pairwise(rows))


def test_a_wrong_swap_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(
        f"source: robot.urdf\nplugins: [{PLUGIN}]\nswap: {{layout: one_colum}}\n"
    )
    with pytest.raises(ConfigError, match=r"(?s)robot.yaml:3: .*did you mean 'one_column'"):
        convert(tmp_path / "robot.yaml")
