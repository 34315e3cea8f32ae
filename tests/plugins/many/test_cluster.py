"""Codes that only odd robots and broken surroundings bring about."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from urdf2mbs.config.lines import Lines
from urdf2mbs_many.convert import list_jobs


def test_a_cluster_whose_workers_cannot_convert(
    tiny: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stand-in for Dask, whose workers have no urdf2mbs, or are killed."""

    class KilledWorkerError(Exception):
        pass

    failures = [ModuleNotFoundError("No module named 'urdf2mbs'"), KilledWorkerError("worker")]

    class Client:
        loop = None

        def __init__(self, address: str, **_: Any) -> None:
            assert address == "tcp://here:1"

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def map(self, work: Any, jobs: list[Any], pure: bool) -> list[Any]:
            return [
                SimpleNamespace(key=n, exception=lambda n=n: failures[n]) for n in range(len(jobs))
            ]

    module = SimpleNamespace(
        Client=Client,
        KilledWorker=KilledWorkerError,
        as_completed=lambda futures, loop: iter(list(futures)),
    )
    monkeypatch.setitem(sys.modules, "distributed", module)  # type: ignore[arg-type]
    from urdf2mbs.config.load import typed
    from urdf2mbs.config.model import Config
    from urdf2mbs_many.cluster import run_on_cluster

    config = typed(Config, {"source": str(tiny)}, Lines())
    other = typed(Config, {"source": str(tiny), "output": "b.mbs"}, Lines())
    jobs = list(list_jobs([(config, Lines()), (other, Lines())]))
    found = [outcome.error for outcome in run_on_cluster(jobs, "tcp://here:1")]
    assert [error.code for error in found if error] == ["cluster-failed", "worker-died"]
    assert found[0] is not None
    assert "No module named 'urdf2mbs'" in found[0].message
