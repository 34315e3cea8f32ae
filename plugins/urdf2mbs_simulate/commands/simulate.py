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

from urdf2mbs.plugin import (
    ALONE,
    ConfigError,
    ConversionError,
    Pipeline,
    add_fields,
    add_printing,
    add_running,
    choose_fields,
    counted,
    near,
    path,
    print_json,
    robot_or_config,
    tell_diagnostics,
    with_near_paths,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf2mbs.plugin import Config, Conversion, Mbs, Progress
    from urdf2mbs.plugin import MbsJoint as Joint
    from urdf2mbs_simulate.results import Results

EXAMPLES = (
    "urdf2mbs simulate robot.yaml",
    "urdf2mbs simulate project --time 5 --push chest:20,0,0@0.5..0.6",
    "urdf2mbs simulate robot.urdf -o robot_project --language python",
)

#: How insert-base calls the joint of a floating base; a number ends it where the name is taken.
INSERTED_BASE = "floating_base"


#: So many files are compiled without a word.
FEW_FILES = 8


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
        choices=("Rosenbrock", "Radau", "DOP853", "RK4"),
        help="Rosenbrock: our own (default); Radau (implicit) and DOP853 (explicit): scipy's, for "
        "a second opinion; RK4: Robotran's, with the TIME_STEP of the project",
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
        help="of the user functions (default: c, if those in Python are unchanged)",
    )
    add_fields(command, *ALONE)


def carry_out(arguments: argparse.Namespace) -> int:
    from urdf2mbs.plugin import Progress, model_of, project_of
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
            progress.at = describe_progress(time, arguments.time, perf_counter() - moves[0])

        progress.at = "loading"
        results = simulate(
            model,
            time=arguments.time,
            push=arguments.push,
            method=arguments.method,
            watch=watch,
            language=arguments.language,
            rate=arguments.rate,
            rtol=arguments.tolerance,
            equilibrium=arguments.equilibrium,
            on_compile=tell_compiling(progress, "the simulation"),
        )
    end = perf_counter()
    files = results.write(force=arguments.force)
    if results.equilibrium is not None:
        results.data._run.notes += results.equilibrium.lines()
        equil = results.equilibrium.results.write("equil", force=arguments.force)
        files[:0] = [file for file in equil if file.suffix == ".res"]
    if is_page(arguments.output):
        with Progress(arguments) as progress:
            progress.at = "writing the page"
            on_compile = tell_compiling(progress, "the robot of the page")
            files.insert(0, _write_page(model, results, arguments, on_compile))
    if arguments.json:
        print_json(_described(results, files, end - begin))
    else:
        start = moves[0] if moves else begin
        _tell(results, files, start - begin, end - start)
    return 1 if results.stopped else 0


def _copied(model: Path, arguments: argparse.Namespace) -> Path:
    """The .mbs in the project of its own that ``-o`` names."""
    from urdf2mbs.plugin import read_model, write_files

    if model.parent.name == "dataR":
        raise ConfigError("usage", f"--output: '{arguments.config}' is a project already")
    copy = Path(arguments.output, "dataR", model.name)
    write_files({copy: read_model(model)}, force=arguments.force)
    return copy


def is_page(output: Path | None) -> bool:
    return output is not None and output.suffix.lower() == ".html"


def describe_progress(time: float, end: float, passed: float) -> str:
    """Return how far a run is, and how long it still takes."""
    text = f"{time:.3g} of {end:g} s"
    if time > 0.0 and passed > 1.0:
        text += f", about {passed * (end / time - 1.0):.0f} s to go"
    return text


def tell_compiling(progress: Progress, what: str) -> Callable[[int, int], None]:
    """Return what says once that the first compilation takes long, and how far it is."""
    begin = perf_counter()

    def tell(done: int, total: int) -> None:
        text = f"compiling {what}: {done} of {total} files"
        if done == 0 and total > FEW_FILES:
            progress.say(f"compiling {what}, {total} files: only the first time, up to a minute")
        elif done:
            left = (perf_counter() - begin) / done * (total - done)
            text += f", about {left:.0f} s to go"
        progress.at = text

    return tell


def _write_page(
    model: Path,
    results: Results,
    arguments: argparse.Namespace,
    on_compile: Callable[[int, int], None],
) -> Path:
    """Write the page of the model; it plays the results that were just written."""
    from urdf2mbs.plugin import write_files
    from urdf2mbs_report.page import make_model_page
    from urdf2mbs_simulate.live import make_live

    try:
        live = make_live(results, on_compile=on_compile)
    except ConversionError as error:
        live = f"the robot cannot be pulled and dropped: {error.message}"
    script = live if isinstance(live, str) else live.script()
    page = make_model_page(results.data._run.mbs, model, live=script)
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
    from urdf2mbs.plugin import Progress, absolute, stem
    from urdf2mbs_project.facts import find_robot_facts
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
            found = find_robot_facts(before)
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
        "files": [str(file) for file in files], "partition": results.data._run.notes,
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
    for said in data._run.notes:
        print(f"  {said}")
    if results.stopped:
        print(f"a user function has stopped the run at {time:g} s (flag_stop)", file=sys.stderr)
    moved = abs(results.q[:, 1:] - results.q[0, 1:]).max(axis=0)
    if story := results.story():
        print(f"  {story.words}")
    elif moved.size:
        name = results.joints[int(moved.argmax())]
        joint = data._run.mbs.joints()[name]
        unit = "m" if joint.type.startswith("T") else "rad"
        print(f"  joint '{name}' moved most: {moved.max():.3g} {unit}")
        if joint in find_floating_base(data._run.mbs) and not data.extforce_id:
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
