"""What many conversions came to: a JSON report, and until it is whole, a journal of it.

The journal has a line for each robot that is done.  An interrupted run leaves it there, and the
same command then converts only what is not in it, or is not as it was.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import IO

import msgspec

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.plugins import version_of
from urdf2mbs.many.convert import Job, Outcome, digest
from urdf2mbs.output import check_ours, write_files


class Line(msgspec.Struct):
    """One line of the journal."""

    version: str
    key: str
    """The digest of what the robot's config asked for."""
    outcome: Outcome


class Journal:
    """The outcomes of some jobs, on disk as they come."""

    def __init__(self, report: Path, jobs: list[Job], *, force: bool = False) -> None:
        self.report = report
        self.force = force
        self.file = report.with_name(report.name + ".part")
        self.jobs = jobs
        self.outcomes: dict[int, Outcome] = {}
        self._version = version_of("urdf2mbs")
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
        self._write(outcome)

    def finish(self) -> None:
        """The report in place of the journal."""
        if self._open is not None:
            self._open.close()
        ordered = [self.outcomes[job.number] for job in self.jobs]
        robots = [shown(outcome) for outcome in ordered]
        whole = {"urdf2mbs": self._version, "code": worst(ordered), "robots": robots}
        write_files(
            {self.report: msgspec.json.format(msgspec.json.encode(whole), indent=1) + b"\n"},
            force=self.force,
        )
        self.file.unlink(missing_ok=True)

    def _write(self, outcome: Outcome) -> None:
        if self._open is None:
            raise ValueError("the journal is not open")
        key = self.jobs[outcome.number].key
        line = msgspec.json.encode(Line(self._version, key, outcome))
        self._open.write(line + b"\n")
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
                line = msgspec.json.decode(text, type=Line)
                job, outcome = jobs.get(line.key), line.outcome
                if job is None or line.version != self._version or outcome.code:
                    continue
                for name in outcome.files:
                    if name not in known:
                        known[name] = digest(Path(name))
                if all(known[name] == was for name, was in outcome.files.items()):
                    outcome.number, outcome.kept = job.number, True
                    self.outcomes[job.number] = outcome


def worst(outcomes: list[Outcome]) -> int:
    """The exit code of all: the highest."""
    return max((outcome.code for outcome in outcomes), default=0)


def shown(outcome: Outcome) -> dict[str, object]:
    """What the report says of a robot: nothing that is not the same another time."""
    return {
        "source": outcome.source, "output": outcome.output, "values": outcome.values,
        "code": outcome.code, "error": outcome.error, "diagnostics": outcome.diagnostics,
        "report": outcome.report,
    }  # fmt: skip
