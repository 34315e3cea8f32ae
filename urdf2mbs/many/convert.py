"""Many conversions, each written as ``urdf2mbs run`` writes it, in as many processes as wanted."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from urdf2mbs.cores import cores
from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic, render
from urdf2mbs.engine.config import Config, Lines, Project, load, typed
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.files import read as read_file
from urdf2mbs.many.sweep import members
from urdf2mbs.output import write
from urdf2mbs.summary import Report, report


class Job(msgspec.Struct, frozen=True):
    """One conversion, as it is handed to another process."""

    number: int
    """Its place among all."""
    config: Config
    lines: Lines
    values: dict[str, Any] = {}
    """What it has of its own in a sweep."""
    installed_plugins: bool = True
    force: bool = False
    """Whether files are replaced that were edited, or that are somebody else's."""

    @property
    def source(self) -> str:
        return str(self.lines.folder / self.config.source)

    @property
    def key(self) -> str:
        """A digest of all that it asks for."""
        asked = [str(self.lines.folder), self.config, self.installed_plugins]
        return sha256(msgspec.json.encode(asked, order="sorted")).hexdigest()


class Failure(msgspec.Struct):
    """Why there is no robot."""

    code: str
    message: str
    file: str | None = None
    line: int | None = None
    hint: str | None = None

    def __str__(self) -> str:
        return render("error", self.code, self.message, self.file, self.line, self.hint)


class Outcome(msgspec.Struct):
    """What became of one of many robots."""

    number: int
    """Its place among all: results come in the order in which they are done."""
    source: str
    output: str | None
    """What was written."""
    values: dict[str, Any]
    """What it has of its own in a sweep."""
    code: int
    """As the exit code: 0 done, 1 robot, 2 config, 3 not the same robot."""
    report: Report | None = None
    error: Failure | None = None
    diagnostics: list[Diagnostic] = []
    """What was said before the error."""
    seconds: float = 0.0
    kept: bool = False
    """It was done before an interruption."""
    files: dict[str, str] = {}
    """The sha256 of every file that was read or written."""

    def __str__(self) -> str:
        return f"{self.source}: {self.error.message if self.error else self.output}"


def convert_many(
    configs: Iterable[str | os.PathLike[str] | Mapping[str, Any]],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    installed_plugins: bool = True,
    force: bool = False,
) -> Iterator[Outcome]:
    """Convert and write many robots; gives each result as it comes.

    ``configs`` are config files, or mappings with the keys of one, whose paths are relative to
    the working folder; a config with a ``sweep`` makes many robots.  ``workers`` is the number of
    processes (default: one for each core); ``cluster`` is the address of a Dask scheduler, whose
    workers must see the same files.  ``force`` replaces files that were edited, too.

    A robot that fails is a result, too.  What is wrong with the configs themselves raises
    ConfigError before anything is converted.  Like all that starts processes in Python, a script
    calls this below ``if __name__ == "__main__":``.
    """
    jobs = jobs_of(
        (_read(config) for config in configs),
        installed_plugins=installed_plugins,
        force=force,
    )  # before the first result, so that errors come at once
    return run(jobs, workers=workers, cluster=cluster)


def _read(config: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[Config, Lines]:
    if isinstance(config, Mapping):
        lines = Lines(folder=Path.cwd())
        return typed(Config, dict(config), lines), lines
    return load(Path(config))


def jobs_of(
    configs: Iterable[tuple[Config, Lines]],
    *,
    installed_plugins: bool = True,
    force: bool = False,
) -> list[Job]:
    """All the robots of some configs; raises ConfigError where two have one output."""
    jobs: list[Job] = []
    taken: dict[str, Job] = {}
    for config, lines in configs:
        # another process may have another working folder
        lines.folder = lines.folder.absolute()
        for member in members(config, lines):
            job = Job(len(jobs), member.config, lines, member.values, installed_plugins, force)
            place = _place(job)
            if place is not None:
                # Windows and macOS have one file for two names that differ in letter case
                if place.lower() in taken:
                    raise lines.error(
                        "output-doubled",
                        f"'{place}' would be written twice: of '{taken[place.lower()].source}', "
                        f"and of '{job.source}'",
                        ("output",),
                        "give each an output of its own",
                    )
                taken[place.lower()] = job
            jobs.append(job)
    return jobs


def _place(job: Job) -> str | None:
    """What is written, as far as it is known before."""
    output = job.config.output
    if output is None:
        return None
    name = output.project if isinstance(output, Project) else output
    return os.path.normpath(job.lines.folder / name)


def run(
    jobs: list[Job], *, workers: int | None = None, cluster: str | None = None
) -> Iterator[Outcome]:
    """Carry jobs out, here or elsewhere."""
    if cluster is not None:
        from urdf2mbs.many.cluster import on_cluster

        return on_cluster(jobs, cluster)
    from urdf2mbs.many.processes import in_processes

    return in_processes(jobs, cores() if workers is None else workers)


def convert_one(job: Job) -> Outcome:
    """Carry one job out and write its files; what goes wrong is in the outcome."""
    start = perf_counter()
    try:
        pipeline = Pipeline(job.config, job.lines, installed_plugins=job.installed_plugins)
        conversion = pipeline.run()
        write(conversion, force=job.force)
    except ConversionError as error:
        outcome = failed(job, error.code, error.message, error.exit_code)
        outcome.error = Failure(error.code, error.message, error.file, error.line, error.hint)
        outcome.diagnostics = error.said
        outcome.seconds = perf_counter() - start
        return outcome
    output = conversion.rejected or conversion.settings.output
    read = {*conversion.sources, *(job.lines.folder / name for name in job.config.plugins)}
    files = {str(file): digest(file) for file in sorted(read)}
    files |= {str(file): sha256(data).hexdigest() for file, data in conversion.files.items()}
    return Outcome(
        job.number, job.source, str(output) if output in conversion.files else None, job.values,
        0 if conversion.rejected is None else 3, report(conversion),
        seconds=perf_counter() - start, files=files,
    )  # fmt: skip


def failed(job: Job, code: str, message: str, exit_code: int = 1) -> Outcome:
    """The outcome of a robot that was not converted."""
    return Outcome(
        job.number, job.source, None, job.values, exit_code, error=Failure(code, message)
    )


def died(job: Job) -> Outcome:
    """The outcome of a job whose process ended twice without a word."""
    return failed(
        job, "worker-died",
        f"the process that converts '{job.source}' was ended twice by the system: it may need "
        "more memory than there is",
    )  # fmt: skip


def digest(file: Path) -> str:
    """The sha256 of a file; empty where it cannot be read."""
    try:
        return sha256(read_file(file)).hexdigest()
    except OSError:
        return ""


def no_extra(name: str) -> ConfigError:
    """The error where the package for clusters is not installed."""
    return ConfigError(
        "extra-missing", f"a cluster needs the package '{name}'",
        hint="pip install 'urdf2mbs[batch]'",
    )  # fmt: skip
