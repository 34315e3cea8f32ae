"""How fast, beside urdf2webots, MuJoCo, Pinocchio and the floor, on the same files.

    pip install -e ".[bench]"
    python benchmarks/speed.py [--repetitions 20] [--processes 20]

All run in turns within one run, so that what slows the machine down slows all of them.
In process, warm: URDF on disk to the other format on disk. As a process: the command a user
types. The floor is lxml parsing the file and serialising it again: nobody is faster than that.
MuJoCo loads the URDF and saves it in its own format; Pinocchio only loads it, and proves nothing.
No file has meshes: urdf2webots reads them, and that would be another race.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import platform
import subprocess
import sys
import sysconfig
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING

from lxml import etree
from robots import generated, real

from urdf2mbs import convert
from urdf2mbs.engine.config import Lines, preset

if TYPE_CHECKING:
    from collections.abc import Callable

Contenders = dict[str, "Callable[[], object]"]


def in_process(source: Path, folder: Path) -> Contenders:
    from urdf2webots.importer import convertUrdfFile

    out = folder / "robot.mbs"
    proto = folder / "Robot.proto"
    unchecked = [name for name in preset("faithful", Lines())[0] if name != "check"]

    def floor() -> None:
        etree.tostring(etree.fromstring(source.read_bytes()))

    def ours() -> None:
        out.write_bytes(convert(source).data)

    def ours_unchecked() -> None:
        out.write_bytes(convert(source, pipeline=unchecked).data)

    def urdf2webots() -> None:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            convertUrdfFile(input=str(source), output=str(proto))

    def mujoco() -> None:
        import mujoco

        model = mujoco.MjModel.from_xml_path(str(source))
        mujoco.mj_saveLastXML(str(folder / "robot.xml"), model)

    def pinocchio() -> None:
        import pinocchio

        pinocchio.buildModelFromUrdf(str(source), pinocchio.JointModelFreeFlyer())

    return {
        "floor": floor,
        "urdf2mbs": ours,
        "without check": ours_unchecked,
        "urdf2webots": urdf2webots,
        "MuJoCo": mujoco,
        "Pinocchio": pinocchio,
    }


def versions() -> str:
    """What was raced against, and on which Python."""
    found = []
    for name in ("urdf2mbs", "urdf2webots", "mujoco", "pin", "lxml"):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} is not installed")
    return f"Python {platform.python_version()}, {', '.join(found)}"


def as_process(source: Path, folder: Path) -> Contenders:
    script = Path(sysconfig.get_path("scripts")) / "urdf2mbs"
    ours = [str(script), "convert", str(source), "-o", str(folder / "robot.mbs")]
    theirs = [sys.executable, "-m", "urdf2webots.importer"]
    theirs += [f"--input={source}", f"--output={folder / 'Robot.proto'}"]
    code = "import sys; from lxml import etree; etree.tostring(etree.parse(sys.argv[1]))"
    floor = [sys.executable, "-c", code, str(source)]

    def run(command: list[str]) -> Callable[[], object]:
        return lambda: subprocess.run(command, check=True, capture_output=True)

    return {"floor": run(floor), "urdf2mbs": run(ours), "urdf2webots": run(theirs)}


def race(contenders: Contenders, repetitions: int) -> dict[str, tuple[float, float]]:
    """Median and least seconds of each, all in turns, after one warm-up; a contender that fails
    on the file is left out."""
    times: dict[str, list[float]] = {}
    for name, run in contenders.items():
        try:
            run()
            times[name] = []
        except (Exception, SystemExit) as error:
            print(f"  {name} fails: {type(error).__name__}: {error}", file=sys.stderr)
    order = list(times)
    for _ in range(repetitions):
        for name in order:
            start = perf_counter()
            contenders[name]()
            times[name].append(perf_counter() - start)
        order.append(order.pop(0))  # nobody always runs after the same one
    return {name: (median(taken), min(taken)) for name, taken in times.items()}


def show(title: str, rows: dict[str, dict[str, tuple[float, float]]]) -> None:
    """Milliseconds, and ratios of medians (of least times)."""
    contenders = list(dict.fromkeys(name for row in rows.values() for name in row))
    print(f"\n{title}: median (least) in ms")
    print(f"{'':14}" + "".join(f"{name:>20}" for name in contenders) + f"{'ours : webots':>20}")
    for robot, row in rows.items():
        cells = [
            f"{1e3 * row[name][0]:.2f} ({1e3 * row[name][1]:.2f})" if name in row else "fails"
            for name in contenders
        ]
        ratio = "-"
        if {"urdf2mbs", "urdf2webots"} <= row.keys():
            a, b = (row["urdf2mbs"][i] / row["urdf2webots"][i] for i in (0, 1))
            ratio = f"{a:.2f} ({b:.2f})"
        print(f"{robot:14}" + "".join(f"{cell:>20}" for cell in cells) + f"{ratio:>20}")
    print("times the floor, by least times")
    for robot, row in rows.items():
        cells = [f"{row[n][1] / row['floor'][1]:.1f}" if n in row else "-" for n in contenders]
        print(f"{robot:14}" + "".join(f"{cell:>20}" for cell in cells))


def main() -> None:
    parser = argparse.ArgumentParser(description="urdf2mbs beside urdf2webots and the floor.")
    parser.add_argument("--repetitions", type=int, default=20, help="in process")
    parser.add_argument("--processes", type=int, default=20, help="as a process; 0 for none")
    parser.add_argument("robots", nargs="*", help="only these")
    arguments = parser.parse_args()
    files = {**real(), "tree-50": generated("tree", 50), "tree-400": generated("tree", 400)}
    if arguments.robots:
        files = {name: files[name] for name in arguments.robots}
    warm: dict[str, dict[str, tuple[float, float]]] = {}
    whole: dict[str, dict[str, tuple[float, float]]] = {}
    print(versions())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)
        for robot, text in files.items():
            source = folder / f"{robot}.urdf"
            source.write_bytes(text)
            warm[robot] = race(in_process(source, folder), arguments.repetitions)
            if arguments.processes:
                whole[robot] = race(as_process(source, folder), arguments.processes)
        os.chdir(Path(__file__).parent)
    show("in process, warm", warm)
    if whole:
        show("as a process", whole)


if __name__ == "__main__":
    main()
