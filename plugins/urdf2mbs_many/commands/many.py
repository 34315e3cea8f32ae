"""`run` and `convert` for many robots: progress while they run, then a table and a report."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from contextlib import closing
from importlib.metadata import version
from pathlib import Path
from time import monotonic

import msgspec

from urdf2mbs.plugin import (
    Config,
    ConfigError,
    Lines,
    Progress,
    check_ours,
    counted,
    estimate_end,
    is_file,
    near,
    print_json,
    refuse,
    without_config,
    write_files,
)
from urdf2mbs_many import REPORT
from urdf2mbs_many.convert import list_jobs, run_jobs
from urdf2mbs_many.folder import find_robots
from urdf2mbs_many.job import Job, Outcome
from urdf2mbs_many.sweep import format_values

#: Maximum number of converted robots in the table.
MAX_ROWS = 40

#: Words for the robots with an exit code.
_RESULTS = {
    0: "done",
    1: "cannot be converted",
    2: "with a wrong config or command line",
    3: "NOT the same as the URDF",
}


def convert_configs(configs: Iterable[tuple[Config, Lines]], arguments: argparse.Namespace) -> int:
    """Convert all robots of some configs; return the highest of their exit codes."""
    refuse(arguments, ("stop_after", "dump", "plan", "fresh"), "one robot, and these are many")
    if arguments.workers is not None and arguments.workers < 1:
        raise ConfigError("usage", f"--workers {arguments.workers}: expected 1 or more")
    jobs = list_jobs(configs, installed_plugins=not arguments.no_plugins, force=arguments.force)
    report_file = arguments.report or find_common_folder(jobs) / REPORT
    if not arguments.force:
        check_ours({report_file: b""})
    outcomes = _run_with_progress(jobs, arguments)
    exit_code = max((outcome.code for outcome in outcomes), default=0)
    report_content = {"urdf2mbs": version("urdf2mbs"), "code": exit_code, "robots": outcomes}
    report_data = msgspec.json.format(msgspec.json.encode(report_content), indent=1) + b"\n"
    write_files({report_file: report_data}, force=arguments.force)
    if arguments.json:
        print_json({"code": exit_code, "robots": outcomes})
    else:
        _print_table(outcomes)
        print(f"report: {near(report_file)}")
        print("Next: open a model in MBSysPad, or look at one: urdf2mbs diagram MODEL.mbs")
        print("      the faults of one robot: run or convert it by itself, with -v")
    return exit_code


def convert_folder(arguments: argparse.Namespace) -> int:
    """Convert all robots of a folder; return the highest of their exit codes."""
    folder, output_folder = Path(arguments.robot), arguments.output
    robot_files = find_robots(folder)
    hint = f"urdf2mbs convert {folder} -o models/"
    if output_folder is None:
        message = f"'{folder}' is a folder; expected an output folder for its .mbs files"
        raise ConfigError("usage", message, hint=hint)
    if is_file(Path(output_folder)) or output_folder.lower().endswith(".mbs"):
        message = (
            f"--output: '{output_folder}' is a file; expected a folder, since '{folder}' is one"
        )
        raise ConfigError("usage", message, hint=hint)
    configs = [
        without_config(str(robot_file), str(Path(output_folder) / relative_output), arguments)
        for robot_file, relative_output in robot_files.items()
    ]
    return convert_configs(configs, arguments)


def find_common_folder(jobs: list[Job]) -> Path:
    """Return the folder that contains all outputs."""
    try:
        return Path(os.path.commonpath([Path(job.output or job.source).parent for job in jobs]))
    except ValueError:  # they are on several drives of Windows
        return Path.cwd()


def _run_with_progress(jobs: list[Job], arguments: argparse.Namespace) -> list[Outcome]:
    """Run all jobs with progress on stderr; return the outcomes in the order of the jobs."""
    robot_count, n_failed, start_time = counted(len(jobs), "robot"), 0, monotonic()
    finished: list[Outcome] = []
    running = run_jobs(jobs, workers=arguments.workers, cluster=arguments.cluster)
    with Progress(arguments) as progress, closing(running) as outcomes:
        progress.at = f"0 of {robot_count} done"
        try:
            for outcome in outcomes:
                finished.append(outcome)
                n_failed += outcome.code != 0
                n_done = len(finished)
                remaining = estimate_end(n_done, len(jobs), monotonic() - start_time)
                progress.at = f"{n_done} of {robot_count} done, {n_failed} failed{remaining}"
        except KeyboardInterrupt:
            print(progress.at, file=sys.stderr)
            raise
    return sorted(finished, key=lambda outcome: outcome.number)


def _print_table(outcomes: list[Outcome]) -> None:
    """Print a line for each robot that is done, all errors on stderr, and the counts."""
    rows = [_format_row(outcome) for outcome in outcomes if outcome.error is None]
    for outcome in outcomes:
        if outcome.error is not None:
            print(f"{_format_name(outcome)}:\n{outcome.error}", file=sys.stderr)
    for row in rows[:MAX_ROWS]:
        print(row)
    if len(rows) > MAX_ROWS:
        print(f"and {len(rows) - MAX_ROWS} more")
    exit_codes = [outcome.code for outcome in outcomes]
    counts = [
        (exit_codes.count(exit_code), result_text) for exit_code, result_text in _RESULTS.items()
    ]
    print(
        *(
            f"{counted(n_robots, 'robot')} {result_text}"
            for n_robots, result_text in counts
            if n_robots
        ),
        sep="; ",
    )


def _format_name(outcome: Outcome) -> str:
    """Format the source of a robot and the values of the sweep."""
    values_text = f" ({format_values(outcome.values)})" if outcome.values else ""
    return near(Path(outcome.source)) + values_text


def _format_row(outcome: Outcome) -> str:
    """Format the row of a robot in the table."""
    report = outcome.report
    if report is None:
        return _format_name(outcome)
    n_warnings = sum(message.level == "warning" for message in report.diagnostics)
    is_proven = report.proof is not None and report.proof.same
    verdict = "" if is_proven else f"{report.verdict}: "
    output = near(Path(outcome.output)) if outcome.output else "nothing is written"
    return (
        f"{_format_name(outcome)}: {report.links} links -> {report.bodies} bodies, "
        f"{report.joints.mbs} joints, {report.mass:.6g} kg, {counted(n_warnings, 'warning')}: "
        f"{verdict}{output}"
    )
