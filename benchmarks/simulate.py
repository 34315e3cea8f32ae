"""How fast robots move: the table of ``docs/speed.md``.

    python benchmarks/simulate.py [ROBOT ...]

Seconds of motion in one second of computing, for the first second: C, and C with user functions in
Python.  Seconds are the processor's, so that a busy machine does not count: run with
``OPENBLAS_NUM_THREADS=1``.  A robot that floats and has feet stands on contacts, held by a
controller, with the lines that ``init`` offers; others fall or swing.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import msgspec
from robots import REAL, ROBOTS

from urdf2mbs.config.load import config_of
from urdf2mbs.config.model import Project
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs_project.facts import HOLD_OPTIONS, find_robot_facts
from urdf2mbs_simulate.project import simulate, write_project
from urdf2mbs_simulate.runtime import Results

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
SOURCES = {
    "biped": CONFIGS / "biped.urdf.xacro",
    "arm": CONFIGS / "arm.urdf.xacro",
    "lamp": CONFIGS / "lamp.urdf",
    "ur5": ROBOTS / "ur/expanded/ur5.urdf",
    "fr3": ROBOTS / "franka/expanded/fr3.urdf",
    "robotiq": ROBOTS / "robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf",
    "solo12": ROBOTS / "solo12/expanded/solo12.urdf",
    **{name: ROBOTS / file for name, file in REAL.items()},
}
SOLE = [[0.07, 0.03, -0.045], [0.07, -0.03, -0.045], [-0.03, -0.03, -0.045], [-0.03, 0.03, -0.045]]
#: Contact points where the meshes of the feet are not there.
POINTS: dict[str, dict[str, Any]] = {
    "nao": {"l_ankle": SOLE, "r_ankle": SOLE},
    "cassie": {},
    "solo12": {f"{leg}_FOOT": [[0, 0, 0]] for leg in ("FL", "FR", "HL", "HR")},
}
#: Start positions with the feet below the robot.
POSES = {"solo12": {"*_HFE": 0.8, "*_KFE": -1.6}}


def project(name: str, folder: Path, languages: list[Any]) -> Path:
    """The .mbs of a robot's project."""
    source = SOURCES[name]
    packages = {path.name: str(path) for path in source.parents[2].glob("*") if path.is_dir()}
    config, lines = config_of(
        {"source": str(source)}, pipeline="compact", packages=packages,
        output=Project(str(folder), languages),
    )  # fmt: skip
    conversion = Pipeline(config, lines, installed_plugins=False).run()
    points = POINTS.get(name)
    contacts: dict[str, Any] = {"points": points}
    if points is None:
        contacts = {"links": find_robot_facts(conversion).feet}
    if conversion.base.floating and any(contacts.values()):
        passes: dict[str, Any] = {
            "contacts": contacts,
            "posture": {"hold": HOLD_OPTIONS, "joints": POSES.get(name, {})},
        }
        config = msgspec.structs.replace(config, passes=passes)
        conversion = Pipeline(config, lines, installed_plugins=False).run()
    return write_project(conversion, force=True)


def run(model: Path, time: float, language: str) -> tuple[Results, float]:
    """A simulation, and the seconds that its steps took the processor."""
    seconds = []
    for duration in (1e-3, 1e-3, time):  # the first compiles, and the second loads as the last does
        begin = process_time()
        results = simulate(model, time=duration, language=language)
        seconds.append(process_time() - begin)
    return results, seconds[2] - seconds[1]


def measure(name: str, folder: Path) -> str:
    """A row of the table of factors."""
    both = project(name, folder / f"{name}_both", ["python", "c"])
    mixed = project(name, folder / f"{name}_python", ["python"])
    cells = []
    for model, language, repetitions in ((both, "c", 5), (mixed, "python", 2)):
        found = [run(model, 1.0, language) for _ in range(repetitions)]
        results, best = found[0][0], min(seconds for _, seconds in found)
        cells.append(f"{1.0 / best:.2g}" if best > 0.01 else "over 100")
    data = results.data
    follows = f", and {data.nqv} follow" * bool(data.nqv)
    stands = ", stands" * bool(data.extforce_id)
    return f"| {name} ({data.nqu} joints move{follows}{stands}) | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=list(SOURCES), metavar="ROBOT")
    arguments = parser.parse_args()
    print("| | C | C, user functions in Python |\n|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="simulate-") as folder:
        for name in arguments.robots:
            if SOURCES[name].is_file():
                print(measure(name, Path(folder)), flush=True)


if __name__ == "__main__":
    main()
