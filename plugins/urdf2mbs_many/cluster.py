"""Run many conversions on a Dask cluster, whose workers see the same files."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from urdf2mbs.plugin import ConfigError, Diagnostic, not_installed
from urdf2mbs_many.job import Job, Outcome, convert_one, make_death, make_failure

#: Time to wait for the scheduler to answer (s).
PATIENCE = 10


def run_on_cluster(jobs: list[Job], address: str) -> Generator[Outcome]:
    """Run jobs on a cluster.

    Dask reassigns the jobs of a lost worker to the other workers.  A job may run twice: it writes
    the same bytes, and has one outcome.

    Args:
        jobs: The jobs.
        address: Address of the Dask scheduler.

    Yields:
        Each outcome as soon as its job is done.

    Raises:
        ConfigError: Dask is not installed, or no scheduler answers.
    """
    try:
        import distributed
    except ImportError as error:
        raise not_installed("a cluster", error.name or "distributed") from None
    dask: Any = distributed  # its functions have no types
    try:
        client = dask.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(
            "cluster-unreachable",
            f"no Dask scheduler answers at '{address}': {error}",
            hint="'dask scheduler' prints its address, such as tcp://127.0.0.1:8786",
        ) from None
    with client:
        # A pure job would get the result that Dask remembers from an earlier run.
        futures = client.map(convert_one, jobs, pure=False)
        waiting = {future.key: job for future, job in zip(futures, jobs, strict=True)}
        completed_futures = dask.as_completed(futures, loop=client.loop)
        del futures  # Dask frees a result when nothing refers to its future
        for future in completed_futures:
            job = waiting.pop(future.key)
            failure = future.exception()
            if failure is None:
                yield future.result()
            elif isinstance(failure, dask.KilledWorker):
                yield make_death(job)
            else:
                failure_type = type(failure).__name__
                message = f"the cluster's workers cannot convert: {failure_type}: {failure}"
                yield make_failure(job, Diagnostic("error", "cluster-failed", message), 2)
