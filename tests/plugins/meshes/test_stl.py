"""Binary STL: the points are those of the file, whatever its header says, in little memory."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from urdf2mbs_meshes.model import MeshError
from urdf2mbs_meshes.passes.convert_meshes import Look, draw
from urdf2mbs_meshes.reader import read_mesh

TRIANGLE = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
TEXT = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid a\n"
)


def make_binary_stl(points: np.ndarray, header: bytes = b"") -> bytes:
    """Return an STL of (n, 3, 3) points."""
    triangles = np.zeros((len(points), 50), np.uint8)
    triangles[:, 12:48] = points.astype("<f4").reshape(-1, 9).view(np.uint8)
    return header.ljust(80, b"\0") + len(points).to_bytes(4, "little") + triangles.tobytes()


def test_the_points_are_those_of_the_file(tmp_path: Path) -> None:
    points = np.random.default_rng(1).normal(size=(20, 3, 3)).astype(np.float32)
    data = make_binary_stl(points, b"solid by a program that says so")
    (tmp_path / "a.stl").write_bytes(data + b"\n")
    mesh = read_mesh(tmp_path / "a.stl")
    (part,) = mesh.parts
    np.testing.assert_array_equal(part.points[part.triangles], points)
    assert not part.smooth
    assert len(mesh.problems) == 1, "a byte after the last triangle"


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode(),
        f" \n {TEXT.replace('solid', 'SOLID')}".encode(),
        make_binary_stl(TRIANGLE, b"solid"),
        make_binary_stl(TRIANGLE, b"anything"),
    ],
)
def test_text_and_binary_files_are_told_apart(data: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(data)
    mesh = read_mesh(tmp_path / "a.stl")
    assert mesh.triangle_count == 1
    assert mesh.problems == []


@pytest.mark.parametrize("data", [b"", b"anything".ljust(83), b"solid a\nendsolid a\n".ljust(90)])
def test_a_file_without_triangles_is_refused(data: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_bytes(data)
    with pytest.raises(MeshError):
        read_mesh(tmp_path / "a.stl")


def test_the_memory_that_a_large_mesh_takes(tmp_path: Path) -> None:
    """Points that no triangles share take the most: the .wrl is 2.4 times as large as the file."""
    small, file = tmp_path / "small.stl", tmp_path / "large.stl"
    small.write_bytes(make_binary_stl(TRIANGLE))
    file.write_bytes(make_binary_stl(np.random.default_rng(1).normal(size=(50_000, 3, 3))))
    look = Look("", (255, 128, 0), 0.0)
    draw(read_mesh(small), look)  # imports what both need
    tracemalloc.start()
    try:
        draw(read_mesh(file), look)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 10 * file.stat().st_size
