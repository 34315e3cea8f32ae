"""How fast meshes become .wrl: triangles a second, beside trimesh that loads the same file.

    pip install -e .
    python benchmarks/meshes.py [--subdivisions 6] [--repetitions 5]

A rough sphere is written in each format, read, and written as VRML97 in one process; the least
time of several, in turns.  Then a robot of twelve larger ones is made.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import trimesh

from urdf2mbs import convert
from urdf2mbs_meshes.reader import read_mesh
from urdf2mbs_meshes.vrml import write_vrml

FORMATS = {"STL, binary": "stl", "STL, ASCII": "stl_ascii", "COLLADA": "dae", "OBJ": "obj"}


def sphere(subdivisions: int) -> trimesh.Trimesh:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=0.1)
    mesh.vertices += 0.001 * np.random.default_rng(1).normal(size=mesh.vertices.shape)
    return mesh


def measure_least(functions: list[Callable[[], object]], repetitions: int) -> list[float]:
    """Measure the least time (s) of the processor of each function, in turns."""
    best = [float("inf")] * len(functions)
    for _ in range(repetitions):
        for number, function in enumerate(functions):
            start = process_time()
            function()
            best[number] = min(best[number], process_time() - start)
    return best


def convert_mesh(path: Path) -> bytes:
    return b"".join(write_vrml(read_mesh(path, up_axis=False).parts, (0.5, 0.5, 0.5), 0.0))


def rates(subdivisions: int, repetitions: int) -> None:
    mesh = sphere(subdivisions)
    count = len(mesh.faces)
    print(f"{count:,} triangles, in 1,000 triangles a second:\n")
    print("| format | MB | read | read and written | trimesh, load only | read, of trimesh |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, kind in FORMATS.items():
            path = Path(folder) / f"mesh.{kind.partition('_')[0]}"
            data = mesh.export(file_type=kind)
            path.write_bytes(data.encode() if isinstance(data, str) else data)
            seconds = measure_least(
                [
                    lambda path=path: read_mesh(path, up_axis=False),
                    lambda path=path: convert_mesh(path),
                    lambda path=path: trimesh.load(path, process=False),
                ],
                repetitions,
            )
            read_rate, convert_rate, trimesh_rate = (count / 1000 / each for each in seconds)
            size = path.stat().st_size / 1e6
            print(
                f"| {name} | {size:.1f} | {read_rate:,.0f} | {convert_rate:,.0f} "
                f"| {trimesh_rate:,.0f} | {read_rate / trimesh_rate:.2f} |"
            )


def robot(subdivisions: int) -> None:
    """Print the time (s) on the clock for a robot with twelve meshes."""
    data = sphere(subdivisions).export(file_type="stl")
    with tempfile.TemporaryDirectory() as folder:
        links = ['<link name="base"/>']
        for k in range(12):
            (Path(folder) / f"mesh_{k}.stl").write_bytes(data)
            links.append(
                f'<link name="l{k}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" '
                f'iyy="1" iyz="0" izz="1"/></inertial><visual><geometry>'
                f'<mesh filename="mesh_{k}.stl"/></geometry></visual></link>'
                f'<joint name="j{k}" type="continuous"><parent link="base"/>'
                f'<child link="l{k}"/></joint>'
            )
        source = Path(folder) / "robot.urdf"
        source.write_text(f'<robot name="r">{"".join(links)}</robot>')
        start = perf_counter()
        convert(source, output={"project": Path(folder) / "project"})
        seconds = perf_counter() - start
        print(f"\n12 meshes of {len(data) / 1e6:.0f} MB: {seconds:.1f} s on the clock")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--subdivisions", type=int, default=6)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    rates(arguments.subdivisions, arguments.repetitions)
    robot(arguments.subdivisions + 1)


if __name__ == "__main__":
    main()
