"""The example probe.py: on a pendulum, it reads what theory says, in the axes of its link."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf2mbs
from urdf2mbs.plugin import ConfigError

pytest.importorskip("urdf2mbs_simulate")

PLUGIN = Path(__file__).with_name("probe.py")
START, LENGTH = 1.0, 0.3
#: A rod that swings about y. The axes of its tool are turned by 90 degrees about z.
PENDULUM = """<robot name="pendulum"><link name="base"/><link name="tool"/>
<link name="rod"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="rod"/>
  <axis xyz="0 1 0"/></joint>
<joint name="mount" type="fixed"><parent link="rod"/><child link="tool"/>
  <origin xyz="0 0 -0.5" rpy="0 0 1.5707963267948966"/></joint></robot>"""
#: What user_dirdyn_loop reads in each step.
READ = """
    force, turn = robot.imu(mbs_data, "probe")
    for name, value in zip(("fx", "fy", "fz", "wx", "wy", "wz"), (*force, *turn)):
        mbs_data.set_output(value, name)"""


def convert(folder: Path, link: str) -> Any:
    (folder / "pendulum.urdf").write_text(PENDULUM)
    return urdf2mbs.convert(
        folder / "pendulum.urdf",
        base="fixed",
        plugins=[PLUGIN],
        output={"project": folder / "pendulum"},
        passes={
            "probe": {"link": link, "at": [0.1, 0.0, 0.5 - LENGTH]},
            "posture": {"joints": {"axle": START}},
        },
    )


def test_it_reads_specific_force_and_rate_in_the_axes_of_the_tool(tmp_path: Path) -> None:
    """A = qdd' x p + qd' x (qd' x p), less gravity, with p = (0, 0.1, -LENGTH) in the rod."""
    convert(tmp_path, "tool").write()
    file = tmp_path / "pendulum" / "userfctR" / "user_dirdyn.py"
    check = "    robot.check_step(mbs_data)"
    assert check in file.read_text()
    file.write_text(file.read_text().replace(check, check + READ))
    moved = urdf2mbs.simulate(tmp_path / "pendulum", time=1.0, language="python")
    read = {name: table[:, 1] for name, table in moved.outputs.items()}
    q, qd, qdd = moved.q[:, -1], moved.qd[:, -1], moved.qdd[:, -1]
    assert np.ptp(q) > START  # it swings
    zero = np.zeros_like(q)
    expected = {
        "fx": zero,
        "fy": LENGTH * qdd + 9.81 * np.sin(q),
        "fz": LENGTH * qd**2 + 9.81 * np.cos(q),
        "wx": qd,
        "wy": zero,
        "wz": zero,
    }
    for name, values in expected.items():
        np.testing.assert_allclose(read[name], values, atol=1e-9, err_msg=name)


@pytest.mark.parametrize(
    ("link", "says"), [("tol", "did you mean 'tool'"), ("base", "does not move")]
)
def test_a_link_that_cannot_have_it_is_an_error(link: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=f"(?s)probe-link.*{says}"):
        convert(tmp_path, link)
