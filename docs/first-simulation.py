"""Makes first-simulation.svg: the project of first-simulation.md, simulated and plotted.

Nothing runs but generated files, on the stand-in for Robotran's library in tests/project.
Wants matplotlib:  python docs/first-simulation.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt
import numpy as np

DOCS = Path(__file__).resolve().parent


def main() -> None:
    sys.path.insert(0, str(DOCS.parent / "tests"))
    from project.generated import Robotran
    from project.standin import user_functions
    from project.test_only_generated import from_the_page

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        project = from_the_page(Path(folder))
        with user_functions(project) as user:
            data = Robotran(project, user)
            robot = user["user_dirdyn"].robot
            every = round(0.005 / robot.TIME_STEP)
            for k, t in enumerate(data.run(2.0, robot.TIME_STEP)):
                if k % every == 0:
                    feet = [robot.contact_force(data, f"{s}_foot")[2] for s in ("left", "right")]
                    rows.append([t, *data.q[1:], sum(feet)])
    numbers = data.joint_id
    time, q, weight = np.split(np.array(rows), [1, data.njoint + 1], axis=1)

    # the same bytes each time
    mpl.rcParams |= {"svg.hashsalt": "first-simulation", "svg.fonttype": "none"}
    figure, (above, middle, below) = plt.subplots(3, 1, sharex=True, figsize=(7, 7))
    for name in ("left_hip_pitch", "left_knee", "left_ankle"):  # the right leg does the same
        joint = q[:, numbers[name] - 1]
        above.plot(time, joint - joint[0], label=name)
    above.set_ylabel("turned since the start [rad]")
    middle.plot(time, q[:, numbers["floating_base_T1"] - 1], label="floating_base_T1")
    middle.set_ylabel("position of the base [m]")
    below.plot(time, weight, label="both feet")
    below.set_ylabel("force of the ground, upward [N]")
    below.set_xlabel("time [s]")
    for axes in (above, middle, below):
        axes.axvspan(0.5, 0.6, color="0.9", label="push" if axes is above else None)
        axes.legend(fontsize="small", loc="best")
        axes.grid(visible=True, color="0.9")
    figure.tight_layout()
    figure.savefig(DOCS / "first-simulation.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
