"""Convert many robots in several processes, each as ``urdf2mbs run`` converts it."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable, Iterator, Mapping
from typing import Any

from urdf2mbs.plugin import Config, Lines, config_of
from urdf2mbs_many.folder import get_file_key
from urdf2mbs_many.job import Job, Outcome, convert_one
from urdf2mbs_many.sweep import list_members


def convert_many(
    configs: Iterable[str | os.PathLike[str] | Config | Mapping[str, Any]],
    *,
    workers: int | None = None,
    cluster: str | None = None,
    installed_plugins: bool = True,
    force: bool = False,
) -> Iterator[Outcome]:
    """Convert and write many robots.

    Args:
        configs: Config files, ``Config`` objects or mappings of their fields.  Relative paths in
            the last two are relative to the working folder.  A config with a ``sweep`` makes many
            robots.
        workers: Number of processes; by default one for each core.
        cluster: Address of a Dask scheduler, whose workers must see the same files.
        installed_plugins: Use the plugins of installed packages.
        force: Also replace files that were edited.

    Returns:
        An iterator over the outcomes; each comes as soon as its robot is done.  A robot that fails
        has an outcome, too.

    Raises:
        ConfigError: A config is wrong.  Nothing is converted.
    """
    # Not a generator, so that errors come with the call and not with the first outcome.
    jobs = list_jobs(map(config_of, configs), installed_plugins=installed_plugins, force=force)
    return run_jobs(jobs, workers=workers, cluster=cluster)


def list_jobs(
    configs: Iterable[tuple[Config, Lines]], *, installed_plugins: bool = True, force: bool = False
) -> list[Job]:
    """List the jobs for all robots of some configs.

    Args:
        configs: Each config and where its values come from.
        installed_plugins: Use the plugins of installed packages.
        force: Also replace files that were edited.

    Raises:
        ConfigError: A config is wrong, or two robots have the same output.
    """
    jobs: list[Job] = []
    jobs_by_output: dict[str, Job] = {}
    for config, lines in configs:
        # Another process may have another working folder.
        lines.folder = lines.folder.absolute()
        for member in list_members(config, lines):
            job = Job(len(jobs), member.config, lines, member.values, installed_plugins, force)
            jobs.append(job)
            if job.output is None:
                continue
            first_job = jobs_by_output.setdefault(get_file_key(job.output), job)
            if first_job is not job:
                raise lines.error(
                    "output-doubled",
                    f"'{job.output}' is the output of both {first_job.label} and {job.label}",
                    ("output",),
                    "give each its own output; name the values of a sweep: 'models/{NAME}.mbs'",
                )
    return jobs


def run_jobs(
    jobs: list[Job], *, workers: int | None = None, cluster: str | None = None
) -> Generator[Outcome]:
    """Run jobs in this process, in others, or on a cluster.

    Args:
        jobs: The jobs.
        workers: Number of processes; by default one for each core.
        cluster: Address of a Dask scheduler to use instead.

    Yields:
        Each outcome as soon as its job is done.
    """
    if cluster is not None:
        from urdf2mbs_many.cluster import run_on_cluster

        yield from run_on_cluster(jobs, cluster)
        return
    n_processes = min(len(jobs), _count_cores() if workers is None else workers)
    if n_processes <= 1:
        yield from map(convert_one, jobs)
        return
    from urdf2mbs_many.processes import run_in_processes

    yield from run_in_processes(jobs, n_processes)


def _count_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
