"""A sweep of our biped: robots a second on one core, on two, and on a local Dask cluster.

    pip install -e ".[cluster]"
    python benchmarks/many.py [--robots 1000]

Every robot is expanded, converted, proven and written.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

from urdf2mbs import convert_many

BIPED = Path(__file__).resolve().parents[1] / "configs" / "biped.urdf.xacro"


def made(
    folder: Path, count: int, *, workers: int | None = None, cluster: str | None = None
) -> float:
    """Seconds for a sweep."""
    study = {
        "source": str(BIPED),
        "output": f"{folder}/{{height}}.mbs",
        "sweep": {"xacro_args": {"height": {"from": 0.5, "to": 2.0, "count": count}}},
    }
    start = perf_counter()
    codes = [one.code for one in convert_many([study], workers=workers, cluster=cluster)]
    seconds = perf_counter() - start
    if codes != [0] * count or len(list(folder.glob("*.mbs"))) != count:
        raise SystemExit(f"not all are made: {codes}")
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description="A sweep on one core, on two, and on a cluster.")
    parser.add_argument("--robots", type=int, default=1000)
    count = parser.parse_args().robots
    print(f"{'':24}{'s':>8}{'robots/s':>10}")

    def show(name: str, seconds: float) -> None:
        print(f"{name:24}{seconds:8.1f}{count / seconds:10.1f}", flush=True)

    for workers in (1, 2):
        with tempfile.TemporaryDirectory() as folder:
            name = f"{workers} process" + "es" * (workers > 1)
            show(name, made(Path(folder), count, workers=workers))
    from distributed import LocalCluster

    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        show("Dask, 2 workers", made(Path(folder), count, cluster=cluster.scheduler_address))


if __name__ == "__main__":
    main()
