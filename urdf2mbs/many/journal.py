"""The JSON report of many conversions, and the journal that stands for it during the run.

The journal has a line for each robot that is done.  An interrupted run leaves it there.  The same
command then keeps a robot where all that it depends on is known and the same: the config, every
file that was read or looked for, the environment's variables, and what is installed.  A plugin may
depend on more, so a robot that a plugin had a part in is made anew.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import IO

import msgspec

from urdf2mbs.disk.files import digest
from urdf2mbs.disk.output import check_ours, write_files
from urdf2mbs.engine.plugins import version_of
from urdf2mbs.many.job import Job, Outcome
from urdf2mbs.messages.diagnostics import ConfigError, counted


class Journal:
    """The outcomes of some jobs, on disk as they come."""

    def __init__(self, report: Path, jobs: list[Job], *, force: bool = False) -> None:
        self.report = report
        self.force = force
        self.file = report.with_name(report.name + ".part")
        self.jobs = jobs
        self.outcomes: dict[int, Outcome] = {}
        self._keeps = False
        """True if the next run can keep a robot of this run."""
        self._open: IO[bytes] | None = None

    def __enter__(self) -> Journal:
        """Take up what an interrupted run has left."""
        if not self.force:
            check_ours({self.report: b""})
        self._take_up()
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            self._open = self.file.open("wb")
        except OSError as error:
            raise ConfigError(
                "output-unwritable", f"cannot write '{self.file}': {error.strerror}"
            ) from None
        for outcome in list(self.outcomes.values()):
            self._write(outcome)
        return self

    def __exit__(self, *_: object) -> None:
        if self._open is not None:
            self._open.close()

    @property
    def todo(self) -> list[Job]:
        return [job for job in self.jobs if job.number not in self.outcomes]

    def add(self, outcome: Outcome) -> None:
        self.outcomes[outcome.number] = outcome
        self._keeps = self._keeps or bool(outcome.key)
        self._write(outcome)

    def state(self) -> str:
        """What a stopped run says: how many robots are done, and whether the run can go on."""
        done = f": {len(self.outcomes)} of {counted(len(self.jobs), 'robot')} done"
        return done + "; the same command goes on" * self._keeps

    def finish(self) -> None:
        """The report in place of the journal."""
        if self._open is not None:
            self._open.close()
        ordered = [self.outcomes[job.number] for job in self.jobs]
        robots = [to_report(outcome) for outcome in ordered]
        whole = {"urdf2mbs": version_of("urdf2mbs"), "code": worst(ordered), "robots": robots}
        write_files(
            {self.report: msgspec.json.format(msgspec.json.encode(whole), indent=1) + b"\n"},
            force=self.force,
        )
        self.file.unlink(missing_ok=True)

    def _write(self, outcome: Outcome) -> None:
        if self._open is None:
            raise ValueError("the journal is not open")
        self._open.write(msgspec.json.encode(outcome) + b"\n")
        self._open.flush()

    def _take_up(self) -> None:
        try:
            data = self.file.read_bytes()
        except OSError:
            return
        jobs = {job.key: job for job in self.jobs}
        known: dict[str, str] = {}
        for text in data.splitlines():
            with suppress(msgspec.MsgspecError):  # the last line may be cut off
                outcome = msgspec.json.decode(text, type=Outcome)
                job = jobs.get(outcome.key)
                if job is None or outcome.code:
                    continue
                for name in outcome.files:
                    if name not in known:
                        known[name] = digest(name)
                if all(known[name] == was for name, was in outcome.files.items()):
                    outcome.number, outcome.kept = job.number, True
                    self.outcomes[job.number] = outcome


def worst(outcomes: list[Outcome]) -> int:
    """The exit code of all: the highest."""
    return max((outcome.code for outcome in outcomes), default=0)


def to_report(outcome: Outcome) -> dict[str, object]:
    """The part of the report on a robot.  It is the same each time."""
    return {
        "source": outcome.source, "output": outcome.output, "values": outcome.values,
        "code": outcome.code, "error": outcome.error, "diagnostics": outcome.diagnostics,
        "report": outcome.report,
    }  # fmt: skip
