"""Makes first-simulation.svg: the project of first-simulation.md, simulated and plotted.

Nothing runs but generated files.
Wants matplotlib:  python docs/first-simulation.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

from urdf2mbs import simulate

DOCS = Path(__file__).resolve().parent


def main() -> None:
    sys.path.insert(0, str(DOCS.parent / "tests"))
    from plugins.simulate.test_only_generated import from_the_page

    with tempfile.TemporaryDirectory() as folder:
        results = simulate(from_the_page(Path(folder)), time=2.0, rate=200.0, language="python")
    weight = sum(rows[:, 2] for name, rows in results.external.items() if "contact" in name)
    time = results.time

    # the same bytes each time
    mpl.rcParams |= {"svg.hashsalt": "first-simulation", "svg.fonttype": "none"}
    figure, (above, middle, below) = plt.subplots(3, 1, sharex=True, figsize=(7, 7))
    for name in ("left_hip_pitch", "left_knee", "left_ankle"):  # the right leg does the same
        joint = results.joint(name)
        above.plot(time, joint - joint[0], label=name)
    above.set_ylabel("turned since the start [rad]")
    middle.plot(time, results.joint("floating_base_T1"), label="floating_base_T1")
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
