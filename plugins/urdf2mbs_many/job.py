"""One of many conversions: the job and its outcome."""

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
    write_output,
)
from urdf2mbs_many.sweep import format_values


class Job(msgspec.Struct, frozen=True):
    """One conversion, as it is sent to another process."""

    number: int
    """Its index among all jobs."""
    config: Config
    lines: Lines
    values: dict[str, Any] = {}
    """The values that a sweep gives this robot."""
    installed_plugins: bool = True
    force: bool = False
    """Also replace files that were edited, or that urdf2mbs did not write."""

    @property
    def source(self) -> str:
        """The file of the robot."""
        return str(self.lines.folder / self.config.source)

    @property
    def label(self) -> str:
        """The source and the values of the sweep, for messages."""
        return f"'{self.source}'" + (f" ({format_values(self.values)})" if self.values else "")

    @property
    def output(self) -> str | None:
        """The file or project that is written; None: it depends on the robot's name."""
        output = self.config.output
        output_path = output.project if isinstance(output, Project) else output
        return None if output_path is None else os.path.normpath(self.lines.folder / output_path)


class Outcome(msgspec.Struct):
    """The outcome of one of many conversions."""

    number: int
    """Index of the job: outcomes come as soon as their jobs are done."""
    source: str
    output: str | None
    """The file that was written."""
    values: dict[str, Any]
    """The values that a sweep gives this robot."""
    code: int
    """Like the exit code: 0 done, 1 robot, 2 config, 3 not the same robot."""
    report: Report | None = None
    error: Diagnostic | None = None
    diagnostics: list[Diagnostic] = []
    """The messages before the error."""

    def __str__(self) -> str:
        return f"{self.source}: {self.error.message if self.error else self.output}"


def convert_one(job: Job) -> Outcome:
    """Convert a robot and write its files; errors are part of the outcome."""
    try:
        conversion = Pipeline(
            job.config, job.lines, installed_plugins=job.installed_plugins, fresh=job.force
        ).run()
        write_output(conversion, force=job.force)
    except ConversionError as error:
        outcome = make_failure(job, error.diagnostic(), error.exit_code)
        outcome.diagnostics = error.earlier
        return outcome
    output_file = conversion.written
    return Outcome(
        job.number,
        job.source,
        str(output_file) if output_file in conversion.files else None,
        job.values,
        code=0 if conversion.checked.rejected is None else 3,
        report=report(conversion),
    )


def make_failure(job: Job, error: Diagnostic, exit_code: int = 1) -> Outcome:
    """Make the outcome of a robot that was not converted."""
    return Outcome(job.number, job.source, None, job.values, exit_code, error=error)


def make_death(job: Job) -> Outcome:
    """Make the outcome of a job whose process the system ended twice."""
    message = (
        f"the system ended the process that converts '{job.source}' twice: it may need more "
        "memory than there is"
    )
    return make_failure(job, Diagnostic("error", "worker-died", message))
