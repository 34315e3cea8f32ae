"""A mass on a spring with a damper, and the theory of its motion."""

import math
from pathlib import Path
from typing import Any

import numpy as np

#: kg, N/m, N s/m: a mass that hangs on a spring with a damper.
MASS, STIFFNESS, DAMPING = 2.0, 50.0, 1.2


SLIDER = f"""<robot name="slider"><link name="base"/><link name="load"><inertial>
<origin xyz="0.1 0.2 0.3"/><mass value="{MASS}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0"
izz="1"/></inertial></link><joint name="rail" type="prismatic"><parent link="base"/><child
link="load"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="0" velocity="9"/><dynamics
damping="{DAMPING}"/></joint><gazebo reference="rail"><springStiffness>{STIFFNESS}</springStiffness>
</gazebo></robot>"""


def model(project: Path) -> Path:
    (file,) = project.glob("dataR/*.mbs")
    return file


def falls(time: Any) -> tuple[Any, Any]:
    """Where the slider is (m), and how fast, that is let go at zero under gravity."""
    rest, decay = -MASS * 9.81 / STIFFNESS, DAMPING / (2 * MASS)
    turn = math.sqrt(STIFFNESS / MASS - decay**2)
    fades, c, s = np.exp(-decay * time), np.cos(turn * time), np.sin(turn * time)
    q = rest * (1 - fades * (c + decay / turn * s))
    return q, rest * fades * (decay**2 + turn**2) / turn * s
