"""How fast, beside urdf2webots, MuJoCo, Pinocchio and the floor, on the same files.

    pip install -e ".[bench]"
    python benchmarks/speed.py [--repetitions 15] [--processes 10] [ROBOT ...]

Prints one table, in Markdown: our least time in ms, and how many times that of each other it is.
All run in turns within one run, so that what slows the machine down slows all of them.

In process, warm: URDF on disk to the other format on disk.  As a process: the command that a
user types, with all Python code compiled before, as pip leaves it.  The floor is lxml parsing the
file and serialising it again: nobody is faster than that.  MuJoCo loads the URDF and saves it in
its own format; Pinocchio only loads it, and proves nothing.  No file has meshes: urdf2webots reads
them, and that would be another race.
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
from time import perf_counter
from typing import TYPE_CHECKING

from lxml import etree
from robots import generated, real

from urdf2mbs import convert

if TYPE_CHECKING:
    from collections.abc import Callable

Contenders = dict[str, "Callable[[], object]"]


def in_process(source: Path, folder: Path) -> Contenders:
    from urdf2webots.importer import convertUrdfFile

    from urdf2mbs.config.lines import Lines
    from urdf2mbs.engine import order
    from urdf2mbs.engine.plugins import Plugins

    out = folder / "robot.mbs"
    proto = folder / "Robot.proto"
    unchecked = [
        name
        for name in order.expand_preset("faithful", Plugins(installed=False), Lines())[0]
        if name != "check"
    ]

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


def as_process(source: Path, folder: Path) -> Contenders:
    theirs = ["-m", "urdf2webots.importer", f"--input={source}", f"--output={folder / 'R.proto'}"]
    return {
        "urdf2mbs": process([*OURS, "convert", str(source), "-o", str(folder / "r.mbs")], folder),
        "urdf2webots": process([sys.executable, *theirs], folder),
    }


def as_help(folder: Path) -> Contenders:
    return {
        "urdf2mbs --help": process([*OURS, "--help"], folder),
        "import argparse": process([sys.executable, "-c", "import argparse"], folder),
    }


OURS = [str(Path(sysconfig.get_path("scripts")) / "urdf2mbs")]


def process(command: list[str], folder: Path) -> Callable[[], object]:
    """A command; what Python compiles at its first run is kept in the folder."""
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder / "compiled")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    return lambda: subprocess.run(command, check=True, capture_output=True, env=environment)


def race(contenders: Contenders, repetitions: int) -> dict[str, float]:
    """The least seconds of each, all in turns, after one warm-up; a contender that fails on the
    file is left out."""
    least: dict[str, float] = {}
    for name, run in contenders.items():
        try:
            run()
            least[name] = float("inf")
        except (Exception, SystemExit) as error:
            print(f"  {name} fails: {type(error).__name__}: {error}", file=sys.stderr)
    order = list(least)
    for _ in range(repetitions):
        for name in order:
            start = perf_counter()
            contenders[name]()
            least[name] = min(least[name], perf_counter() - start)
        order.append(order.pop(0))  # nobody always runs after the same one
    return least


def versions() -> str:
    """What was raced against, and on which Python."""
    found = []
    for name in ("urdf2mbs", "urdf2webots", "mujoco", "pin", "lxml"):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} is not installed")
    return f"Python {platform.python_version()}, {', '.join(found)}"


HEAD = """\
| robot | ms | : urdf2webots | without `check` : urdf2webots | : MuJoCo | : Pinocchio | : floor \
| process, ms | : urdf2webots |
|---|---|---|---|---|---|---|---|---|"""


def row(robot: str, warm: dict[str, float], whole: dict[str, float]) -> str:
    def ratio(times: dict[str, float], one: str, other: str) -> str:
        return f"{times[one] / times[other]:.2f}" if {one, other} <= times.keys() else "-"

    cells = [
        robot,
        f"{1e3 * warm['urdf2mbs']:.1f}",
        ratio(warm, "urdf2mbs", "urdf2webots"),
        ratio(warm, "without check", "urdf2webots"),
        *(ratio(warm, "urdf2mbs", other) for other in ("MuJoCo", "Pinocchio", "floor")),
        f"{1e3 * whole['urdf2mbs']:.0f}" if whole else "-",
        ratio(whole, "urdf2mbs", "urdf2webots"),
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description="urdf2mbs beside others, and the floor.")
    parser.add_argument("--repetitions", type=int, default=15, help="in process")
    parser.add_argument("--processes", type=int, default=10, help="as a process; 0 for none")
    parser.add_argument("robots", nargs="*", help="only these")
    arguments = parser.parse_args()
    files = {**real(), "tree-50": generated("tree", 50), "tree-400": generated("tree", 400)}
    if arguments.robots:
        files = {name: files[name] for name in arguments.robots}
    print(f"{versions()}\n\n{HEAD}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)  # urdf2webots leaves files where it is
        for robot, text in files.items():
            source = folder / f"{robot}.urdf"
            source.write_bytes(text)
            warm = race(in_process(source, folder), arguments.repetitions)
            processes = arguments.processes
            whole = race(as_process(source, folder), processes) if processes else {}
            print(row(robot, warm, whole), flush=True)
        if arguments.processes:
            help_, bare = race(as_help(folder), 2 * arguments.processes).values()
            print(
                f"\n`urdf2mbs --help`: {1e3 * help_:.0f} ms, {help_ / bare:.2f} times "
                f"`python -c 'import argparse'`"
            )
        os.chdir(Path(__file__).parent)


if __name__ == "__main__":
    main()
