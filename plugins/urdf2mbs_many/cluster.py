"""Many conversions on a Dask cluster, whose workers see the same files."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from urdf2mbs.plugin import ConfigError, Diagnostic, not_installed
from urdf2mbs_many.job import Job, Outcome, convert_one, died, failed

#: Seconds until a scheduler that does not answer is not there.
PATIENCE = 10


def on_cluster(jobs: list[Job], address: str) -> Generator[Outcome]:
    """Each outcome as it comes.

    Dask gives the jobs of a worker that is gone to the others.  A job may run twice: it
    writes the same bytes, and is one outcome.
    """
    try:
        import distributed
    except ImportError as error:
        raise not_installed("a cluster", error.name or "distributed") from None
    dask: Any = distributed  # whose functions have no types
    try:
        client = dask.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(
            "cluster-unreachable", f"no Dask scheduler answers at '{address}': {error}",
            hint="'dask scheduler' prints its address, such as tcp://127.0.0.1:8786",
        ) from None  # fmt: skip
    with client:
        # not pure: a job is never taken for one of an earlier run
        futures = client.map(convert_one, jobs, pure=False)
        waiting = {future.key: job for future, job in zip(futures, jobs, strict=True)}
        completed = dask.as_completed(futures, loop=client.loop)
        del futures  # so that a result that was given is forgotten
        for future in completed:
            job = waiting.pop(future.key)
            failure = future.exception()
            if failure is None:
                yield future.result()
            elif isinstance(failure, dask.KilledWorker):
                yield died(job)
            else:
                said = f"the cluster's workers cannot convert: {type(failure).__name__}: {failure}"
                yield failed(job, Diagnostic("error", "cluster-failed", said), 2)
