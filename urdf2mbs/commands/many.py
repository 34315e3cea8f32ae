"""`run` and `convert` for many robots: progress while they run, then a table and a report."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from time import monotonic

import msgspec

from urdf2mbs.commands.printing import near, print_json
from urdf2mbs.commands.progress import Progress
from urdf2mbs.commands.settings import REPORT, refuse
from urdf2mbs.disk.output import check_ours, write_files
from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.plugins import version_of
from urdf2mbs.many.convert import jobs_of, run
from urdf2mbs.many.job import Job, Outcome
from urdf2mbs.many.sweep import in_words
from urdf2mbs.messages.diagnostics import ConfigError, counted

#: The most converted robots in the table.  All failed robots are in it.
SHOWN = 40


def carry_out_many(configs: Iterable[tuple[Config, Lines]], arguments: argparse.Namespace) -> int:
    """Convert all robots of some configs; the exit code is the worst of theirs."""
    refuse(arguments, ("stop_after", "dump", "plan", "fresh"), "one robot, and these are many")
    if arguments.workers is not None and arguments.workers < 1:
        raise ConfigError("usage", f"--workers {arguments.workers}: give 1 or more")
    jobs = jobs_of(configs, installed_plugins=not arguments.no_plugins, force=arguments.force)
    jobs = _chosen(jobs, arguments.only)
    report = arguments.report or _folder(jobs) / REPORT
    if not arguments.force:
        check_ours({report: b""})
    outcomes = _convert_all(jobs, arguments)
    code = max((outcome.code for outcome in outcomes), default=0)
    robots = [_to_report(outcome) for outcome in outcomes]
    whole = {"urdf2mbs": version_of("urdf2mbs"), "code": code, "robots": robots}
    text = msgspec.json.format(msgspec.json.encode(whole), indent=1) + b"\n"
    write_files({report: text}, force=arguments.force)
    if arguments.json:
        print_json({"code": code, "robots": robots})
    else:
        for outcome in outcomes:
            if outcome.error is not None:
                print(f"{_name(outcome)}:\n{outcome.error}", file=sys.stderr)
        print(_table(outcomes, report))
    return code


def _chosen(jobs: list[Job], only: list[str]) -> list[Job]:
    """The robots of a sweep that have all these values."""
    for text in only:
        name, _, value = text.partition("=")
        kept = [job for job in jobs if _is(job.values.get(name), value)]
        if not kept:
            known = dict.fromkeys(in_words(job.values) for job in jobs if job.values)
            raise ConfigError(
                "usage", f"--only {text}: no robot has this value",
                hint=f"there are: {'; '.join([*known][:5])}" if known else "this is no sweep",
            )  # fmt: skip
        jobs = kept
    return jobs


def _is(value: object, text: str) -> bool:
    """True if a value is this text, or the same number."""
    try:
        return str(value) == text or float(str(value)) == float(text)
    except ValueError:
        return False


def _to_report(outcome: Outcome) -> dict[str, object]:
    """The part of the report on a robot.  It is the same each time."""
    return {
        "source": outcome.source, "output": outcome.output, "values": outcome.values,
        "code": outcome.code, "error": outcome.error, "diagnostics": outcome.diagnostics,
        "report": outcome.report,
    }  # fmt: skip


def _folder(jobs: list[Job]) -> Path:
    """The folder that all outputs are in."""
    try:
        return Path(os.path.commonpath([Path(job.place or job.source).parent for job in jobs]))
    except ValueError:  # they are on several drives of Windows
        return Path.cwd()


def _name(outcome: Outcome) -> str:
    own = f" ({in_words(outcome.values)})" if outcome.values else ""
    return near(Path(outcome.source)) + own


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
                rate = len(done) / (monotonic() - start)
                progress.at = (
                    f"{len(done)} of {counted(count, 'robot')} done, {failed} failed, "
                    f"{rate:.3g} a second, {(count - len(done)) / rate:.0f} s left"
                )
        except KeyboardInterrupt:
            print(progress.at, file=sys.stderr)
            raise
    return sorted(done, key=lambda outcome: outcome.number)


def _table(outcomes: list[Outcome], report: Path) -> str:
    """A line for each robot, and the counts."""
    done = [outcome for outcome in outcomes if outcome.code == 0]
    listed = [outcome for outcome in outcomes if outcome.code] + done[:SHOWN]
    lines = [_row(outcome) for outcome in sorted(listed, key=lambda outcome: outcome.number)]
    if len(done) > SHOWN:
        lines.append(f"and {len(done) - SHOWN} more that are done")
    failures = "; ".join(
        f"{counted(number, 'robot')} {what}"
        for code, what in _FAILURES.items()
        if (number := sum(outcome.code == code for outcome in outcomes))
    )
    lines.append(f"{counted(len(done), 'robot')} done" + (failures and f"; {failures}"))
    lines.append(f"report: {near(report)}")
    lines.append("Next: open a model in MBSysPad, or look at one: urdf2mbs diagram MODEL.mbs")
    lines.append("      what is wrong with a robot: run or convert it by itself, with -v")
    return "\n".join(lines)


_FAILURES = {
    1: "cannot be converted",
    2: "with a wrong config or command line",
    3: "NOT the same as the URDF",
}


def _row(outcome: Outcome) -> str:
    name, found, error = _name(outcome), outcome.report, outcome.error
    if found is None or error is not None:
        return f"{name}: error[{error.code}]: {error.message.splitlines()[0]}" if error else name
    warnings = sum(said.level == "warning" for said in found.diagnostics)
    verdict = "" if found.proof is not None and found.proof.same else f"{found.verdict}: "
    output = near(Path(outcome.output)) if outcome.output else "nothing is written"
    return (
        f"{name}: {found.links} links -> {found.bodies} bodies, {found.joints.mbs} joints, "
        f"{found.mass:.6g} kg, {counted(warnings, 'warning')}: {verdict}{output}"
    )
