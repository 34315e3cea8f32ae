"""The example rubber.py: a law of our own keeps the energy, in Python and in C."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf2mbs
from urdf2mbs.plugin import ConfigError

pytest.importorskip("urdf2mbs_simulate")

PLUGIN = Path(__file__).with_name("rubber.py")
INERTIA, STIFFNESS, START = 0.2, 3.0, 1.5
#: A wheel about the vertical, which feels no weight.
WHEEL = f"""<robot name="wheel"><link name="base"/>
<link name="wheel"><inertial><mass value="1"/>
  <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="{INERTIA}"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/>
  <axis xyz="0 0 1"/></joint></robot>"""


def convert(folder: Path, *joints: str) -> Any:
    (folder / "wheel.urdf").write_text(WHEEL)
    return urdf2mbs.convert(
        folder / "wheel.urdf",
        base="fixed",
        plugins=[PLUGIN],
        output={"project": folder / "wheel", "language": "both"},
        after={"forces": "rubber"},
        passes={
            "rubber": {"joints": list(joints), "stiffness": STIFFNESS},
            "posture": {"joints": {"axle": START}},
        },
    )


@pytest.mark.parametrize("language", ["python", "c"])
def test_the_wheel_swings_and_keeps_its_energy(language: str, tmp_path: Path) -> None:
    """Its energy is I qd^2 / 2 + k q^4 / 4, as at the start."""
    if language == "c" and not any(map(shutil.which, ("cc", "gcc", "clang"))):
        pytest.skip("no C compiler")
    convert(tmp_path, "axle").write()
    moved = urdf2mbs.simulate(
        tmp_path / "wheel", time=1.0, language=language, rtol=1e-10, atol=1e-12
    )
    position, speed = moved.q[:, -1], moved.qd[:, -1]
    energy = INERTIA * speed**2 / 2 + STIFFNESS * position**4 / 4
    np.testing.assert_allclose(energy, STIFFNESS * START**4 / 4, rtol=1e-6)
    assert position.min() < -0.5 * START  # it swings through zero


def test_a_joint_that_does_not_exist_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"(?s)rubber-joints.*'axel'.*did you mean 'axle'"):
        convert(tmp_path, "axel")
