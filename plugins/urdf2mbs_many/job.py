"""One of many conversions: the job, how it is carried out, and its outcome."""

from __future__ import annotations

import os
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    Config,
    ConversionError,
    Diagnostic,
    Lines,
    Pipeline,
    Project,
    Report,
    report,
)
from urdf2mbs.plugin import write_output as write
from urdf2mbs_many.sweep import in_words


class Job(msgspec.Struct, frozen=True):
    """One conversion, as it is handed to another process."""

    number: int
    """Its place among all."""
    config: Config
    lines: Lines
    values: dict[str, Any] = {}
    """Its own values in a sweep."""
    installed_plugins: bool = True
    force: bool = False
    """Replace files, too, that were edited or that are somebody else's."""

    @property
    def source(self) -> str:
        return str(self.lines.folder / self.config.source)

    @property
    def name(self) -> str:
        """The source, and what the sweep makes of it, as messages call the job."""
        return f"'{self.source}'" + (f" ({in_words(self.values)})" if self.values else "")

    @property
    def place(self) -> str | None:
        """The file or project that is written; None: the robot's name decides."""
        output = self.config.output
        name = output.project if isinstance(output, Project) else output
        return None if name is None else os.path.normpath(self.lines.folder / name)


class Outcome(msgspec.Struct):
    """What became of one of many robots."""

    number: int
    """Its place among all jobs: outcomes come as they are done."""
    source: str
    output: str | None
    """What was written."""
    values: dict[str, Any]
    """Its own values in a sweep."""
    code: int
    """As the exit code: 0 done, 1 robot, 2 config, 3 not the same robot."""
    report: Report | None = None
    error: Diagnostic | None = None
    diagnostics: list[Diagnostic] = []
    """What was said before the error."""

    def __str__(self) -> str:
        return f"{self.source}: {self.error.message if self.error else self.output}"


def convert_one(job: Job) -> Outcome:
    """Carry one job out and write its files; what goes wrong is in the outcome."""
    try:
        conversion = Pipeline(
            job.config, job.lines, installed_plugins=job.installed_plugins, fresh=job.force
        ).run()
        write(conversion, force=job.force)
    except ConversionError as error:
        outcome = failed(job, error.diagnostic(), error.exit_code)
        outcome.diagnostics = error.earlier
        return outcome
    output = conversion.written
    return Outcome(
        job.number, job.source, str(output) if output in conversion.files else None,
        job.values, 0 if conversion.checked.rejected is None else 3, report(conversion),
    )  # fmt: skip


def failed(job: Job, error: Diagnostic, exit_code: int = 1) -> Outcome:
    """The outcome of a robot that was not converted."""
    return Outcome(job.number, job.source, None, job.values, exit_code, error=error)


def died(job: Job) -> Outcome:
    """The outcome of a job whose process ended twice without a word."""
    said = (
        f"the process that converts '{job.source}' was ended twice by the system: it may need "
        "more memory than there is"
    )
    return failed(job, Diagnostic("error", "worker-died", said))
