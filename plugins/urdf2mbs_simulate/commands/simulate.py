"""`simulate`: let a robot move, and write Robotran's result files.

Makes a project of the robot if there is none, computes the motion from the
start position, and writes the project's resultsR/*.csv, animationR/*.anim.
'-o PAGE.html' writes a page that plays the motion.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import msgspec

from urdf2mbs.commands.printing import near, print_json, tell_diagnostics, with_near_paths
from urdf2mbs.commands.settings import (
    ALONE,
    add_fields,
    add_printing,
    add_running,
    choose_fields,
    path,
    robot_or_config,
)
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError, counted

if TYPE_CHECKING:
    from urdf2mbs.config.model import Config
    from urdf2mbs.mbs.model import Joint, Mbs
    from urdf2mbs.plugin import Conversion
    from urdf2mbs_simulate.results import Results

EXAMPLES = (
    "urdf2mbs simulate robot.yaml",
    "urdf2mbs simulate project --time 5 --push chest:20,0,0@0.5..0.6",
    "urdf2mbs simulate robot.urdf -o robot_project --language python",
)

#: How insert-base calls the joint of a floating base; a number ends it where the name is taken.
INSERTED_BASE = "floating_base"


def add_options(command: argparse.ArgumentParser) -> None:
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config", type=path, metavar="SOURCE",
        help="a project's folder, an .mbs, a CONFIG.yaml, or a .urdf or .xacro file with the "
        "options below",
    )  # fmt: skip
    command.add_argument(
        "-o", "--output", type=path, metavar="DIR|PAGE.html",
        help="the folder of the project that a robot becomes (default: NAME_robotran), or an "
        ".mbs outside a project; or a page that plays the motion, where the robot lives with the "
        "extra 'live'",
    )  # fmt: skip
    command.add_argument(
        "--time", type=float, default=2.0, metavar="S", help="the time to simulate (2 s)"
    )
    command.add_argument(
        "--push", action="append", default=[], metavar="LINK:FX,FY,FZ@T1..T2",
        help="a force (N) on a link, in the axes of the base, from T1 to T2 (s)",
    )  # fmt: skip
    command.add_argument(
        "--equilibrium", action="store_true", help="start where nothing accelerates, at rest"
    )
    command.add_argument(
        "--method",
        choices=("Rosenbrock", "LSODA", "RK45", "DOP853", "RK23", "Radau", "BDF", "RK4"),
        help="Rosenbrock: our own, in C (default); LSODA (default for Python) and others: scipy's; "
        "RK4: Robotran's, in steps of 1 ms",
    )  # fmt: skip
    command.add_argument(
        "--tolerance",
        type=float,
        metavar="R",
        help="relative error of a step (default: 1e-5 of Rosenbrock, 1e-6 of the others)",
    )
    command.add_argument(
        "--rate", type=float, default=100.0, metavar="N", help="frames a second (default: 100)"
    )
    command.add_argument(
        "--language",
        choices=("c", "python"),
        help="the code (default: c, where there is a compiler)",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.commands.progress import Progress
    from urdf2mbs.disk.files import model_of, project_of
    from urdf2mbs_simulate.project import simulate
    from urdf2mbs_simulate.results import check_results

    _check(arguments)
    model = model_of(arguments.config)
    if model is None:
        model = make_project(arguments)
    elif arguments.output is not None and not is_page(arguments.output):
        model = _copied(model, arguments)
    if not arguments.force:
        check_results(project_of(model))
    begin, moves = perf_counter(), list[float]()
    with Progress(arguments) as progress:

        def watch(time: float) -> None:
            if not moves:  # all is compiled
                moves.append(perf_counter())
            progress.at = f"{time:.3g} of {arguments.time:g} s"

        progress.at = "compiling"
        results = simulate(
            model, time=arguments.time, push=arguments.push, method=arguments.method, watch=watch,
            language=arguments.language, rate=arguments.rate, rtol=arguments.tolerance,
            equilibrium=arguments.equilibrium,
        )  # fmt: skip
    end = perf_counter()
    files = results.write(force=arguments.force)
    if results.equilibrium is not None:
        results.data.said += results.equilibrium.lines()
        equil = results.equilibrium.results.write("equil", force=arguments.force)
        files[:0] = [file for file in equil if file.suffix == ".res"]
    if is_page(arguments.output):
        with Progress(arguments) as progress:
            progress.at = "compiling the robot of the page"
            files.insert(0, _write_page(model, results, arguments))
    if arguments.json:
        print_json(_described(results, files, end - begin))
    else:
        start = moves[0] if moves else begin
        _tell(results, files, start - begin, end - start)
    return 1 if results.stopped else 0


def _copied(model: Path, arguments: argparse.Namespace) -> Path:
    """The .mbs in the project of its own that ``-o`` names."""
    from urdf2mbs.disk.files import read_model
    from urdf2mbs.engine.output import write_files

    if model.parent.name == "dataR":
        raise ConfigError("usage", f"--output: '{arguments.config}' is a project already")
    copy = Path(arguments.output, "dataR", model.name)
    write_files({copy: read_model(model)}, force=arguments.force)
    return copy


def is_page(output: Path | None) -> bool:
    return output is not None and output.suffix.lower() == ".html"


def _write_page(model: Path, results: Results, arguments: argparse.Namespace) -> Path:
    """Write the page of the model; it plays the results that were just written."""
    from urdf2mbs.engine.output import write_files
    from urdf2mbs_report.page import make_of_model
    from urdf2mbs_simulate.live import make_live

    try:
        live = make_live(results)
    except ConversionError as error:
        live = f"the robot cannot be pulled and dropped: {error.message}"
    script = live if isinstance(live, str) else live.script()
    page = make_of_model(results.data.mbs, model, live=script)
    for diagnostic in page.diagnostics:
        print(with_near_paths(str(diagnostic)), file=sys.stderr)
    write_files({arguments.output: page.data}, force=arguments.force)
    return Path(arguments.output)


def _check(arguments: argparse.Namespace) -> None:
    for name in ("time", "rate", "tolerance"):
        value = getattr(arguments, name)
        if value is not None and not 0.0 < value < 1e9:
            raise ConfigError("usage", f"--{name} {value:g}: a number above 0 is wanted")


def make_project(arguments: argparse.Namespace) -> Path:
    """The project of a robot or of a config; gives its .mbs.

    A robot alone is converted, and stands, as ``init`` proposes.
    """
    from urdf2mbs.commands.progress import Progress
    from urdf2mbs.disk.files import absolute
    from urdf2mbs.urdf.reader import stem
    from urdf2mbs_project.commands.init import find
    from urdf2mbs_simulate.project import make, with_project

    config, lines = robot_or_config(arguments)
    alone = config.output is None and not config.passes
    named = None if is_page(arguments.output) else arguments.output
    folder = named or Path(f"{stem(Path(config.source))}_robotran")
    before = None
    with Progress(arguments) as progress:

        def run(
            config: Config, before: Conversion | None = None, *, fresh: bool = False
        ) -> Conversion:
            installed = not arguments.no_plugins
            converter = Pipeline(config, lines, installed_plugins=installed, fresh=fresh)
            converter.watch(progress)
            return converter.run(before=before)

        if alone:
            if "pipeline" not in choose_fields(arguments, ALONE):
                config = msgspec.structs.replace(config, pipeline="compact")
            # an .mbs that lies beside the robot is neither read nor written
            model = absolute(folder) / "dataR" / f"{stem(Path(config.source))}.mbs"
            before = run(msgspec.structs.replace(config, output=str(model)), fresh=True)
            found = find(before)
            config = msgspec.structs.replace(config, passes=found.passes)
            if found.feet and not arguments.json:
                print(f"the robot stands on {', '.join(found.feet)}, as init proposes")
            elif "contacts" in found.passes and not arguments.json:
                print(f"no feet: {found.why_no_feet}; all that is solid touches the ground")
            elif found.why_no_feet and not arguments.json:
                print(f"the robot has no ground, and drops: {found.why_no_feet}")
        conversion = run(with_project(config, folder), before)
    if not arguments.json and (alone or arguments.verbose):  # of a config, 'run' tells them
        tell_diagnostics(conversion.diagnostics, arguments.verbose)
    return make(conversion, force=arguments.force)


def _described(results: Results, files: list[Path], seconds: float) -> dict[str, object]:
    story = results.story()
    return {
        "model": results.data.mbs_name, "language": results.language, "stopped": results.stopped,
        "time": float(results.time[-1]), "frames": len(results.time), "wall_time": seconds,
        "files": [str(file) for file in files], "partition": results.data.said,
        "fell": story and story.fell,
        "events": [event._asdict() for event in story.events] if story else [],
    }  # fmt: skip


def _tell(results: Results, files: list[Path], preparing: float, moving: float) -> None:
    """What moved, how fast it was computed (s), and where the motion is."""

    data, time = results.data, float(results.time[-1])
    joints = counted(data.nqu, "independent joint")
    print(f"{data.mbs_name}: {time:g} s of {joints} simulated in {moving:.2f} s")
    compiled = f", after {preparing:.0f} s of loading and compiling" if preparing > 1.0 else ""
    print(f"  computed in {results.language}{compiled}")
    if not data.user_path.is_dir():
        print("  no user functions: gravity alone moves it")
    for said in data.said:
        print(f"  {said}")
    if results.stopped:
        print(f"a user function has stopped the run at {time:g} s (flag_stop)", file=sys.stderr)
    moved = abs(results.q[:, 1:] - results.q[0, 1:]).max(axis=0)
    if story := results.story():
        print(f"  {story.words}")
    elif moved.size:
        name = results.joints[int(moved.argmax())]
        joint = data.mbs.joints()[name]
        unit = "m" if joint.type.startswith("T") else "rad"
        print(f"  joint '{name}' moved most: {moved.max():.3g} {unit}")
        if joint in find_floating_base(data.mbs) and not data.extforce_id:
            print(f"  nothing holds it: {_what_holds(joint)}")
    for file in files:
        if file.suffix in (".csv", ".anim", ".html") and "equil" not in file.name:
            print(f"  {near(file)}")
    page = is_page(files[0])
    see = f"open {near(files[0])}" if page else "add '-o PAGE.html' to see it move"
    print(f"Next: {see}; plot {near(files[-1])}; MBSysPad plays the .anim")
    print(f"      other results are in {os.path.relpath(files[-1].parent)}")


def find_floating_base(model: Mbs) -> list[Joint]:
    """Return the six free joints of a base that nothing holds; none of a base that is held.

    A floating base is a body on the ground with three shifts and three turns.  A cut, or a force
    element, between the ground and another body holds it.
    """
    for connection in (*model.cuts, *model.links):
        if None in (connection.endpoint1[0], connection.endpoint2[0]):
            return []
    for body in model.bodies:
        joints = [joint for joint in body.joints if joint.nature != "driven"][:6]
        kinds = sorted(joint.type[0] for joint in joints)
        free = all(joint.nature == "independent" for joint in joints)
        if body.parent is None and free and kinds == ["R", "R", "R", "T", "T", "T"]:
            return joints
    return []


def _what_holds(joint: Joint) -> str:
    """Return what a config can say to hold a base; ``joint`` is one of its joints."""
    ground = "'passes: {contacts: {links: [FOOT]}}' gives it a ground"
    # only a base that insert-base has put in is an option of the config
    inserted = re.fullmatch(rf"{INSERTED_BASE}(_\d+)?_[TR]\d", joint.name)
    return f"'base: fixed' bolts it down, {ground}" if inserted else ground
