"""`simulate`: simulate a robot, and write Robotran's result files.

Makes a project of a robot, computes the motion from the
start position, and writes the project's resultsR/*.csv, animationR/*.anim.
'-o PAGE.html' writes a page that plays the motion.
"""

from __future__ import annotations

import argparse
import os
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
    estimate_end,
    find_model,
    is_file,
    near,
    path,
    print_json,
    robot_or_config,
    tell_diagnostics,
    with_near_paths,
)
from urdf2mbs_simulate.support import find_floating_base, propose_support

if TYPE_CHECKING:
    from collections.abc import Callable

    from urdf2mbs.plugin import Config, Conversion, Progress
    from urdf2mbs_simulate.results import Results

EXAMPLES = (
    "urdf2mbs simulate robot.yaml",
    "urdf2mbs simulate project --time 5 --push chest:20,0,0@0.5..0.6",
    "urdf2mbs simulate robot.urdf -o robot_project --language python",
)

#: What is typed in place of an option, and the option, or what to do.
MEANT = {
    "-t": "--time",
    "--duration": "--time",
    "--end": "--time",
    "--length": "--time",
    "--seconds": "--time",
    "--fps": "--rate",
    "--frames": "--rate",
    "--dt": "'--tolerance' sets the length of steps, and '--rate' the frames a second",
    "--integrator": "--method",
    "--solver": "--method",
    "--html": "--output",
    "--page": "--output",
}

#: Up to this many files are compiled without a message.
FEW_FILES = 8


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_printing(command)
    add_running(command)
    command.add_argument(
        "config",
        type=path,
        metavar="SOURCE",
        help="a project's folder, an .mbs, a CONFIG.yaml, or a .urdf, .xacro or MJCF file with the "
        "options below",
    )
    command.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="DIR|PAGE.html",
        help="the folder of the project that a robot becomes (default: NAME_robotran), or an "
        ".mbs outside a project; or a page that plays the motion, and is interactive with the "
        "package ziglang",
    )
    command.add_argument(
        "--time", type=_read_seconds, default=2.0, metavar="S", help="the time to simulate (2 s)"
    )
    command.add_argument(
        "--push",
        action="append",
        default=[],
        metavar="LINK:FX,FY,FZ@T1..T2",
        help="a force (N) on a link, in the axes of the base, from T1 to T2 (s)",
    )
    command.add_argument(
        "--equilibrium", action="store_true", help="start where nothing accelerates, at rest"
    )
    command.add_argument(
        "--method",
        choices=("Rosenbrock", "Radau", "DOP853", "RK4"),
        help="Rosenbrock: our own (default); Radau (implicit) and DOP853 (explicit): scipy's, for "
        "a second opinion; RK4: Robotran's, with the TIME_STEP of the project",
    )
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


def _read_seconds(text: str) -> float:
    """Return a time of the command line (s)."""
    try:
        return float(text)
    except ValueError:
        message = f"'{text}': expected a number of seconds without a unit, such as 1.5"
        raise argparse.ArgumentTypeError(message) from None


class _Clock:
    """Measures how long a command loads and compiles, and how long it computes."""

    def __init__(self) -> None:
        self.begin = perf_counter()
        self.compiled: float | None = None

    def note_step(self) -> float:
        """Return how long the steps have been computed (s)."""
        if self.compiled is None:  # the first step: all files are compiled
            self.compiled = perf_counter()
        return perf_counter() - self.compiled

    def stop(self) -> tuple[float, float]:
        """Return the seconds of loading and compiling, and of computing."""
        end = perf_counter()
        compiled = self.begin if self.compiled is None else self.compiled
        return compiled - self.begin, end - compiled


def carry_out(arguments: argparse.Namespace) -> int:
    """Simulate, write the results, and print a summary; return the exit code."""
    from urdf2mbs.plugin import project_of
    from urdf2mbs_simulate.results import check_results

    _check_numbers(arguments)
    check_output(arguments.output)
    model, conversion = find_model(arguments.config, arguments, "robot", "config"), None
    if model is None:
        conversion = make_project(arguments)
        model = conversion.settings.output
    elif arguments.output is not None and not is_page(arguments.output):
        model = _copy_model(model, arguments)
    if not arguments.force:
        check_results(project_of(model))
    clock = _Clock()
    results = _simulate(model, arguments, clock)
    compiling, computing = clock.stop()
    results.conversion = conversion
    files = _write_results(model, results, arguments)
    if arguments.json:
        print_json(_describe_results(results, files, compiling + computing))
    else:
        _print_summary(results, files, compiling, computing)
    return 1 if results.stopped else 0


def _simulate(model: Path, arguments: argparse.Namespace, clock: _Clock) -> Results:
    from urdf2mbs.plugin import Progress
    from urdf2mbs_simulate.project import simulate

    with Progress(arguments) as progress:

        def watch(time: float) -> None:
            remaining = estimate_end(time, arguments.time, clock.note_step())
            progress.at = f"{time:.3g} of {arguments.time:g} s{remaining}"

        progress.at = "loading"
        return simulate(
            model,
            time=arguments.time,
            push=arguments.push,
            method=arguments.method,
            watch=watch,
            language=arguments.language,
            rate=arguments.rate,
            rtol=arguments.tolerance,
            equilibrium=arguments.equilibrium,
            on_compile=report_compiling(progress, "the simulation"),
        )


def _write_results(model: Path, results: Results, arguments: argparse.Namespace) -> list[Path]:
    """Write the results, and the page if one is asked for; return the files."""
    from urdf2mbs.plugin import Progress

    files = results.write(force=arguments.force)
    if results.equilibrium is not None:
        results.data._run.notes += results.equilibrium.lines()
        pose_files = results.equilibrium.results.write("equil", force=arguments.force)
        files[:0] = [file for file in pose_files if file.suffix == ".res"]
    if is_page(arguments.output):
        with Progress(arguments) as progress:
            progress.at = "writing the page"
            on_compile = report_compiling(progress, "the robot of the page")
            files.insert(0, _write_page(model, results, arguments, on_compile))
    return files


def _copy_model(model: Path, arguments: argparse.Namespace) -> Path:
    """Copy the .mbs to the project that ``-o`` names."""
    from urdf2mbs.plugin import read_model, write_files

    if model.parent.name == "dataR":
        raise ConfigError("usage", f"--output: '{arguments.config}' is a project already")
    copy = Path(arguments.output, "dataR", model.name)
    write_files({copy: read_model(model)}, force=arguments.force)
    return copy


def is_page(output: Path | None) -> bool:
    """Return True if an output is a page, and not a project's folder."""
    return output is not None and output.suffix.lower() == ".html"


def report_compiling(progress: Progress, subject: str) -> Callable[[int, int], None]:
    """Return a function that shows the progress of a compilation.

    Args:
        progress: Where it is shown.
        subject: The name of the program that is compiled.
    """
    begin = perf_counter()

    def report(done: int, total: int) -> None:
        text = f"compiling {subject}: {done} of {total} files"
        if done == 0 and total > FEW_FILES:
            progress.say(f"compiling {subject}, {total} files: only the first time, up to a minute")
        progress.at = text + estimate_end(done, total, perf_counter() - begin)

    return report


def _write_page(
    model: Path,
    results: Results,
    arguments: argparse.Namespace,
    on_compile: Callable[[int, int], None],
) -> Path:
    """Write the page of the model, which plays the results that were just written."""
    from urdf2mbs.plugin import write_files
    from urdf2mbs_report.page import make_model_page
    from urdf2mbs_simulate.live import make_live

    script, reason = None, ""
    try:
        live = make_live(results, on_compile=on_compile)
        if isinstance(live, str):
            reason = live
        else:
            script = live.script()
    except ConversionError as error:
        reason = f"the robot of the page cannot be pulled and dropped: {error.message}"
    mbs, conversion = results.data._run.mbs, results.conversion
    page = make_model_page(mbs, model, live=script, conversion=conversion)
    if reason:
        print(reason, file=sys.stderr)
    for diagnostic in page.diagnostics:
        print(with_near_paths(str(diagnostic)), file=sys.stderr)
    write_files({arguments.output: page.data}, force=arguments.force)
    return Path(arguments.output)


def check_output(output: Path | None) -> None:
    """Raise ConfigError if the output can be neither a page nor the folder of a project."""
    if output is not None and not is_page(output) and is_file(output):
        message = f"--output: '{output}' is a file; expected a folder, or a page (.html)"
        raise ConfigError("usage", message, hint=f"-o {output.with_suffix('.html')}")


def _check_numbers(arguments: argparse.Namespace) -> None:
    for name in ("time", "rate", "tolerance"):
        value = getattr(arguments, name)
        if value is not None and not 0.0 < value < 1e9:
            raise ConfigError("usage", f"--{name} {value:g}: expected a number above 0")


def make_project(arguments: argparse.Namespace) -> Conversion:
    """Make the project of a robot or of a config, and return its conversion.

    A robot without a config is converted as ``init`` proposes: on its feet.
    """
    from urdf2mbs.plugin import Progress, choose_file_name, stem
    from urdf2mbs_simulate.project import with_project, write_project

    config, lines = robot_or_config(arguments)
    is_plain = config.output is None and not config.passes
    output = None if is_page(arguments.output) else arguments.output
    folder = output or Path(f"{stem(Path(config.source))}_robotran")
    converted = None
    with Progress(arguments) as progress:

        def run(
            config: Config,
            before: Conversion | None = None,
            *,
            fresh: bool = False,
            stop_after: str | None = None,
        ) -> Conversion:
            with_plugins = not arguments.no_plugins
            pipeline = Pipeline(config, lines, installed_plugins=with_plugins, fresh=fresh)
            pipeline.watch(progress)
            return pipeline.run(before=before, stop_after=stop_after)

        if is_plain:
            config = _choose_pipeline(config, arguments, folder)
            converted = run(config, fresh=True)
            config = _add_proposed_passes(config, converted, quiet=arguments.json)
        if output is None and lines.file is None:
            if converted is None:
                converted = run(config, fresh=True, stop_after="expand")
            name = choose_file_name(converted.robot.name, converted.settings.source)
            folder = Path(f"{name}_robotran")
        conversion = run(with_project(config, folder), converted)
    if not arguments.json and (is_plain or arguments.verbose):  # of a config, 'run' prints them
        tell_diagnostics(conversion.diagnostics, arguments.verbose)
    write_project(conversion, force=arguments.force)
    return conversion


def _choose_pipeline(config: Config, arguments: argparse.Namespace, folder: Path) -> Config:
    """Return the config that converts a robot to an .mbs in the folder of its project.

    An .mbs that lies beside the robot is neither read nor written.
    """
    from urdf2mbs.plugin import absolute, stem

    if "pipeline" not in choose_fields(arguments, ALONE):
        config = msgspec.structs.replace(config, pipeline="compact")
    model = absolute(folder) / "dataR" / f"{stem(Path(config.source))}.mbs"
    return msgspec.structs.replace(config, output=str(model))


def _add_proposed_passes(config: Config, converted: Conversion, *, quiet: bool) -> Config:
    """Add the passes that ``init`` proposes, and print how the robot starts."""
    from urdf2mbs_project.facts import find_robot_facts

    proposal = find_robot_facts(converted)
    if proposal.feet and not quiet:
        print(f"the robot stands on {', '.join(proposal.feet)}, as init proposes")
    elif "contacts" in proposal.passes and not quiet:
        print(f"no feet: {proposal.why_no_feet}; all that is solid touches the ground")
    elif proposal.why_no_feet and not quiet:
        print(f"the robot has no ground, and drops: {proposal.why_no_feet}")
    return msgspec.structs.replace(config, output=None, passes=proposal.passes)


def _describe_results(results: Results, files: list[Path], seconds: float) -> dict[str, object]:
    """Return the summary as data for --json."""
    story = results.story()
    return {
        "model": results.data.mbs_name,
        "language": results.language,
        "stopped": results.stopped,
        "time": float(results.time[-1]),
        "frames": len(results.time),
        "wall_time": seconds,
        "files": [str(file) for file in files],
        "partition": results.data._run.notes,
        "fell": story and story.fell,
        "events": [event._asdict() for event in story.events] if story else [],
    }


def _print_summary(results: Results, files: list[Path], compiling: float, computing: float) -> None:
    """Print what moved, how fast it was computed (s), and where the motion is."""
    data, time = results.data, float(results.time[-1])
    joints = counted(data.nqu, "independent joint")
    print(f"{data.mbs_name}: {time:g} s of {joints} simulated in {computing:.2f} s")
    compiled = f", after {compiling:.0f} s of loading and compiling" if compiling > 1.0 else ""
    print(f"  computed in {results.language}{compiled}")
    if not data.user_path.is_dir():
        print("  no user functions: gravity alone moves it")
    for note in data._run.notes:
        print(f"  {note}")
    if results.stopped:
        print(f"a user function has stopped the run at {time:g} s (flag_stop)", file=sys.stderr)
    for line in _describe_motion(results):
        print(f"  {line}")
    for file in files:
        if file.suffix in (".csv", ".anim", ".html") and "equil" not in file.name:
            print(f"  {near(file)}")
    page = is_page(files[0])
    see = f"open {near(files[0])}" if page else "add '-o PAGE.html' to see it move"
    print(f"Next: {see}; plot {near(files[-1])}; MBSysPad plays the .anim")
    print(f"      other results are in {os.path.relpath(files[-1].parent)}")


def _describe_motion(results: Results) -> list[str]:
    """Describe the fall of a robot; of a model that does not stand, what moved most."""
    if story := results.story():
        return [story.words]
    data = results.data
    moved = abs(results.q[:, 1:] - results.q[0, 1:]).max(axis=0)
    if not moved.size:
        return []
    name = results.joints[int(moved.argmax())]
    joint = data._run.mbs.joints()[name]
    unit = "m" if joint.type.startswith("T") else "rad"
    lines = [f"joint '{name}' moved most: {moved.max():.3g} {unit}"]
    if joint in find_floating_base(data._run.mbs) and not data.extforce_id:
        lines.append(f"nothing holds it: {propose_support(joint)}")
    return lines
