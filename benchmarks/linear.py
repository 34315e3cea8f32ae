"""That the time grows no faster than the robot: chains and trees of up to 10,000 links.

python benchmarks/linear.py [--links 1000 3000 10000] [--repetitions 3]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

from robots import generated

from urdf2mbs import convert


def main() -> None:
    parser = argparse.ArgumentParser(description="Microseconds per link, by number of links.")
    parser.add_argument("--links", type=int, nargs="+", default=[1000, 3000, 10000])
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--pipeline", default="faithful")
    arguments = parser.parse_args()
    print(f"{'':8}{'links':>8}{'joints':>8}{'MB':>8}{'s':>8}{'us/link':>10}{'floor us/link':>15}")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "robot.urdf"
        for shape in ("chain", "tree"):
            for links in arguments.links:
                source.write_bytes(generated(shape, links))
                best = least = float("inf")
                for _ in range(arguments.repetitions):
                    start = perf_counter()
                    result = convert(source, pipeline=arguments.pipeline)
                    best = min(best, perf_counter() - start)
                    least = min(least, floor(source))
                joints = sum(len(body.joints) for body in result.mbs.bodies)
                print(
                    f"{shape:8}{links:8}{joints:8}{len(result.data) / 1e6:8.1f}{best:8.2f}"
                    f"{1e6 * best / links:10.0f}{1e6 * least / links:15.1f}"
                )


def floor(source: Path) -> float:
    """Seconds that lxml takes to parse the file and to serialise it again."""
    from lxml import etree

    start = perf_counter()
    parser = etree.XMLParser(huge_tree=True)
    etree.tostring(etree.fromstring(source.read_bytes(), parser))
    return perf_counter() - start


if __name__ == "__main__":
    main()
