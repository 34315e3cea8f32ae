"""Every mesh of the real robots: bounding box and number of triangles, source against .wrl.

The source is read a second time by Assimp, so that neither trimesh nor pycollada is on both sides.
"""

from pathlib import Path

import numpy as np
import pytest

from support.meshes import wrl
from urdf2mbs_meshes.reader import FORMATS, read_mesh
from urdf2mbs_meshes.vrml import write_vrml


@pytest.mark.slow
def test_every_mesh_of_every_robot(shared: Path) -> None:
    coal = pytest.importorskip("coal", reason="Coal, which comes with Pinocchio, is not installed")
    robots = shared / "robots"
    meshes = sorted(p for p in robots.rglob("*") if p.suffix.lower() in FORMATS)
    assert len(meshes) == 142
    wrong, small, large = [], 0, 0
    for path in meshes:
        data = b"".join(write_vrml(read_mesh(path, up_axis=False).parts, (0.5, 0.5, 0.5), 0.0))
        small, large = small + len(data), large + path.stat().st_size
        if "tmp" in path.parts:  # Coal leaves out the centimetres of their exporter
            continue
        source = coal.MeshLoader().load(str(path), np.ones(3))
        points, triangles = source.vertices(), wrl.corners(wrl.read(data))
        ends = triangles.min((0, 1)) - points.min(0), triangles.max((0, 1)) - points.max(0)
        off = np.abs(ends).max() / np.abs(points).max()
        # pycollada's transforms are float32; Assimp leaves out a triangle without area
        alike = source.num_tris <= len(triangles) <= source.num_tris + 3
        if not (alike and off <= 2e-6):
            wrong.append((str(path.relative_to(robots)), len(triangles), source.num_tris, off))
    assert not wrong
    assert small < 0.45 * large
