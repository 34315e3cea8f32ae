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
    is_file,
    near,
    print_json,
    refuse,
    without_config,
    write_files,
)
from urdf2mbs_many import REPORT
from urdf2mbs_many.convert import jobs_of, run
from urdf2mbs_many.folder import robots_in
from urdf2mbs_many.job import Job, Outcome
from urdf2mbs_many.sweep import in_words

#: The most converted robots in the table.
SHOWN = 40

#: What became of the robots with an exit code.
_ENDS = {
    0: "done",
    1: "cannot be converted",
    2: "with a wrong config or command line",
    3: "NOT the same as the URDF",
}


def carry_out_many(configs: Iterable[tuple[Config, Lines]], arguments: argparse.Namespace) -> int:
    """Convert all robots of some configs; the exit code is the worst of theirs."""
    refuse(arguments, ("stop_after", "dump", "plan", "fresh"), "one robot, and these are many")
    if arguments.workers is not None and arguments.workers < 1:
        raise ConfigError("usage", f"--workers {arguments.workers}: give 1 or more")
    jobs = jobs_of(configs, installed_plugins=not arguments.no_plugins, force=arguments.force)
    report = arguments.report or _folder(jobs) / REPORT
    if not arguments.force:
        check_ours({report: b""})
    outcomes = _convert_all(jobs, arguments)
    code = max((outcome.code for outcome in outcomes), default=0)
    whole = {"urdf2mbs": version("urdf2mbs"), "code": code, "robots": outcomes}
    text = msgspec.json.format(msgspec.json.encode(whole), indent=1) + b"\n"
    write_files({report: text}, force=arguments.force)
    if arguments.json:
        print_json({"code": code, "robots": outcomes})
    else:
        _print_table(outcomes)
        print(f"report: {near(report)}")
        print("Next: open a model in MBSysPad, or look at one: urdf2mbs diagram MODEL.mbs")
        print("      the faults of one robot: run or convert it by itself, with -v")
    return code


def carry_out_folder(arguments: argparse.Namespace) -> int:
    """``convert`` for all robots of a folder."""
    folder, output = Path(arguments.robot), arguments.output
    if output is None:
        raise ConfigError(
            "usage", f"'{folder}' is a folder: say where its robots go, such as '-o models/'"
        )
    if is_file(Path(output)):
        raise ConfigError("usage", f"--output: '{output}' is no folder, and '{folder}' is one")
    return carry_out_many(
        [
            without_config(str(source), str(Path(output) / place), arguments)
            for source, place in robots_in(folder).items()
        ],
        arguments,
    )


def _folder(jobs: list[Job]) -> Path:
    """The folder that all outputs are in."""
    try:
        return Path(os.path.commonpath([Path(job.place or job.source).parent for job in jobs]))
    except ValueError:  # they are on several drives of Windows
        return Path.cwd()


def _convert_all(jobs: list[Job], arguments: argparse.Namespace) -> list[Outcome]:
    """Carry all jobs out, with progress on stderr; the outcomes in the order of the jobs."""
    count, failed, start = len(jobs), 0, monotonic()
    done: list[Outcome] = []
    running = run(jobs, workers=arguments.workers, cluster=arguments.cluster)
    with Progress(arguments) as progress, closing(running) as outcomes:
        progress.at = f"0 of {counted(count, 'robot')} done"
        try:
            for outcome in outcomes:
                done.append(outcome)
                failed += outcome.code != 0
                left = (count - len(done)) * (monotonic() - start) / len(done)
                progress.at = (
                    f"{len(done)} of {counted(count, 'robot')} done, {failed} failed, "
                    f"{left:.0f} s left"
                )
        except KeyboardInterrupt:
            print(progress.at, file=sys.stderr)
            raise
    return sorted(done, key=lambda outcome: outcome.number)


def _print_table(outcomes: list[Outcome]) -> None:
    """A line for each robot that is done, all errors on stderr, and the counts."""
    done = [_row(outcome) for outcome in outcomes if outcome.error is None]
    for outcome in outcomes:
        if outcome.error is not None:
            print(f"{_name(outcome)}:\n{outcome.error}", file=sys.stderr)
    for row in done[:SHOWN]:
        print(row)
    if len(done) > SHOWN:
        print(f"and {len(done) - SHOWN} more")
    codes = [outcome.code for outcome in outcomes]
    counts = [(codes.count(code), what) for code, what in _ENDS.items()]
    print(*(f"{counted(count, 'robot')} {what}" for count, what in counts if count), sep="; ")


def _name(outcome: Outcome) -> str:
    own = f" ({in_words(outcome.values)})" if outcome.values else ""
    return near(Path(outcome.source)) + own


def _row(outcome: Outcome) -> str:
    found = outcome.report
    if found is None:
        return _name(outcome)
    warnings = sum(said.level == "warning" for said in found.diagnostics)
    verdict = "" if found.proof is not None and found.proof.same else f"{found.verdict}: "
    output = near(Path(outcome.output)) if outcome.output else "nothing is written"
    return (
        f"{_name(outcome)}: {found.links} links -> {found.bodies} bodies, {found.joints.mbs} "
        f"joints, {found.mass:.6g} kg, {counted(warnings, 'warning')}: {verdict}{output}"
    )
