"""Many conversions, each written as ``urdf2mbs run`` writes it, in as many processes as wanted."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from urdf2mbs.plugin import RECORD, Config, Lines, config_of, temporary_name
from urdf2mbs_many.folder import one_name
from urdf2mbs_many.job import Job, Outcome, convert_one
from urdf2mbs_many.sweep import members


def convert_many(
    configs: Iterable[str | os.PathLike[str] | Config | Mapping[str, Any]],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    installed_plugins: bool = True,
    force: bool = False,
) -> Iterator[Outcome]:
    """Convert and write many robots; gives each result as it comes.

    ``configs`` are config files, or each a ``Config`` or a mapping of its fields, whose paths are
    relative to the working folder; a config with a ``sweep`` makes many robots.  ``workers`` is the
    number of processes (default: one for each core); ``cluster`` is the address of a Dask
    scheduler, whose workers must see the same files.  ``force`` replaces files that were edited,
    too.

    A robot that fails is a result, too.  What is wrong with the configs themselves raises
    ConfigError before anything is converted.
    """
    # before the first result, so that errors come at once
    jobs = jobs_of(map(config_of, configs), installed_plugins=installed_plugins, force=force)
    return run(jobs, workers=workers, cluster=cluster)


def jobs_of(
    configs: Iterable[tuple[Config, Lines]], *, installed_plugins: bool = True, force: bool = False
) -> list[Job]:
    """All the robots of some configs; raises ConfigError where two have one output."""
    jobs: list[Job] = []
    taken: dict[str, Job] = {}
    for config, lines in configs:
        # another process may have another working folder
        lines.folder = lines.folder.absolute()
        for member in members(config, lines):
            job = Job(len(jobs), member.config, lines, member.values, installed_plugins, force)
            jobs.append(job)
            other = taken.setdefault(one_name(job.place), job) if job.place else job
            if other is not job:
                raise lines.error(
                    "output-doubled",
                    f"'{job.place}' would be written twice: of {other.name}, and of {job.name}",
                    ("output",),
                    "give each an output of its own; a sweep by its values: 'models/{NAME}.mbs'",
                )
    return jobs


def run(
    jobs: list[Job], *, workers: int | None = None, cluster: str | None = None
) -> Generator[Outcome]:
    """Carry jobs out, here or elsewhere; gives each outcome as it comes."""
    folders = set()
    for outcome in _start(jobs, workers, cluster):
        if outcome.output is not None:
            folders.add(Path(os.path.realpath(outcome.output)).parent)
        yield outcome
    for folder in folders:
        _sort_record(folder / RECORD)


def _start(jobs: list[Job], workers: int | None, cluster: str | None) -> Iterable[Outcome]:
    if cluster is not None:
        from urdf2mbs_many.cluster import on_cluster

        return on_cluster(jobs, cluster)
    count = min(len(jobs), _cores() if workers is None else workers)
    if count <= 1:
        return map(convert_one, jobs)
    from urdf2mbs_many.processes import in_processes

    return in_processes(jobs, count)


def _sort_record(record: Path) -> None:
    """Sort the lines by file: the jobs added theirs in the order in which they were done.

    A sorted record stays as it is, as another run may add a line at any time.
    """
    with suppress(OSError):  # an unsorted record is as true
        lines = record.read_bytes().splitlines(keepends=True)
        by_file = sorted(lines, key=lambda line: line.split(b"  ", 1)[::-1])
        if by_file != lines:
            temporary = temporary_name(record)
            temporary.write_bytes(b"".join(by_file))
            temporary.replace(record)


def _cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
