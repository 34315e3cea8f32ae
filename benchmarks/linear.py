"""How time, memory and the file grow with the robot: chains, trees and stars of many links, and
trees of which no two links are alike.

    python benchmarks/linear.py [--links 1000 10000] [--shapes chain tree star mixed]

Each conversion, and each floor, is a process of its own: what it takes at the most is its peak
memory.  Times are of the processor (s), ``check`` included.  The floor is lxml that reads the URDF
and the .mbs and writes both again.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

from robots import generated

SHAPES = ("chain", "tree", "star", "mixed")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--links", type=int, nargs="+", default=[1000, 10_000])
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=SHAPES)
    parser.add_argument("--pipeline", default="faithful")
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        kind, source = arguments.one
        print(*(floor if kind == "floor" else conversion)(Path(source), arguments.pipeline))
        return
    print("| shape | links | s | floor s | above it | µs a link | peak MB | .mbs MB |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "robot.urdf"
        for shape in arguments.shapes:
            for links in arguments.links:
                source.write_bytes(generated(shape, links))
                seconds, peak, size = measured("convert", source, arguments.pipeline)
                (least,) = measured("floor", source, arguments.pipeline)
                above = seconds - least
                print(
                    f"| {shape} | {links:,} | {seconds:.1f} | {least:.1f} | {above:.1f} "
                    f"| {1e6 * seconds / links:.0f} | {peak:.0f} | {size:.1f} |",
                    flush=True,
                )


def measured(kind: str, source: Path, pipeline: str) -> list[float]:
    """What a process of its own prints."""
    command = [sys.executable, __file__, "--one", kind, str(source), "--pipeline", pipeline]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return [float(word) for word in done.stdout.split()]


def conversion(source: Path, pipeline: str) -> tuple[float, float, float]:
    """Seconds, peak memory (MB), size of the file (MB)."""
    from urdf2mbs import convert

    start = process_time()
    result = convert(source, output=source.with_suffix(".mbs"), pipeline=pipeline)
    result.write()
    seconds = process_time() - start
    peak = peak_memory() / 1e6
    if result.conversion.checked.rejected:
        raise SystemExit("not the same robot")
    return seconds, peak, len(result.data) / 1e6


def peak_memory() -> int:
    """Bytes that this process has held at most."""
    status = Path("/proc/self/status")
    if status.is_file():
        # ru_maxrss would count what the process that started this one had
        found = re.search(r"^VmHWM:\s+(\d+) kB", status.read_text(), re.MULTILINE)
        if found:
            return 1024 * int(found[1])
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def floor(source: Path, pipeline: str) -> tuple[float]:
    """Seconds that lxml takes to read the URDF and the .mbs, and to write both again."""
    from lxml import etree

    parser = etree.XMLParser(huge_tree=True)
    start = process_time()
    for file in (source, source.with_suffix(".mbs")):
        etree.tostring(etree.fromstring(file.read_bytes(), parser))
    return (process_time() - start,)


if __name__ == "__main__":
    main()
