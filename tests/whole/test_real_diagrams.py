"""The diagram of each real robot: nothing overlaps, wires are short."""

from statistics import median

import pytest

from support.diagram_faults import boxes, faults, wires
from support.real_robots import CONVERTIBLE, RealRobot


@pytest.mark.parametrize("robot", CONVERTIBLE)
@pytest.mark.parametrize("preset", ["faithful", "compact"])
def test_diagrams_of_real_robots_have_no_fault(robot: RealRobot, preset: str) -> None:
    mbs = robot.convert(pipeline=preset).mbs
    assert faults(mbs) == []
    lengths = [wire.length for wire in wires(mbs)]
    assert max(lengths) <= 5.0 * median(lengths)
    right = max(box.right for box in boxes(mbs))
    if preset == "compact":
        assert right <= 2_160.0  # with the margins
