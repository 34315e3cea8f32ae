"""Binary STL: the bytes are read as they lie, in little memory, and without trimesh."""

import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from urdf2mbs_meshes import stl
from urdf2mbs_meshes.passes.convert_meshes import Look, draw
from urdf2mbs_meshes.reader import read_mesh


def binary(points: np.ndarray, header: bytes = b"") -> bytes:
    """An STL of (n, 3, 3) points."""
    triangles = np.zeros((len(points), 50), np.uint8)
    triangles[:, 12:48] = points.astype("<f4").reshape(-1, 9).view(np.uint8)
    return header.ljust(80, b"\0") + len(points).to_bytes(4, "little") + triangles.tobytes()


def test_the_points_are_those_of_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "urdf2mbs_meshes.by_trimesh", None)
    points = np.random.default_rng(1).normal(size=(20, 3, 3)).astype(np.float32)
    (tmp_path / "a.stl").write_bytes(binary(points, b"solid by a program that says so") + b"\n")
    mesh = read_mesh(tmp_path / "a.stl")
    (part,) = mesh.parts
    np.testing.assert_array_equal(part.points[part.triangles], points)
    assert not part.smooth
    assert len(mesh.problems) == 1, "a byte after the last triangle"


@pytest.mark.parametrize(
    ("data", "binary"),
    [
        (b"solid a\nendsolid a\n".ljust(90), False),
        (b" \n SOLID a\nendsolid a\n".ljust(90), False),
        (b"solid".ljust(90, b"\0"), True),
        (b"anything".ljust(84), True),
        (b"anything".ljust(83), False),
        (b"", False),
    ],
)
def test_a_text_is_told_from_a_binary_file(data: bytes, binary: bool) -> None:
    assert stl.is_binary(data) == binary


def test_the_memory_that_a_large_one_takes(tmp_path: Path) -> None:
    """Points that no triangles share take the most: the .wrl is 2.4 times as large as the file."""
    file = tmp_path / "a.stl"
    file.write_bytes(binary(np.random.default_rng(1).normal(size=(100_000, 3, 3))))
    tracemalloc.start()
    try:
        draw(read_mesh(file), Look("", (255, 128, 0), 0.0))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8 * file.stat().st_size
