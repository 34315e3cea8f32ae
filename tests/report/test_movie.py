"""The movie of a simulation: a GIF that moves, the same each time, made without a browser."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from urdf2mbs import ConversionError, simulate
from urdf2mbs.report.movie import RATE, movie

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", ["arm.urdf.xacro", "lamp.urdf"])  # primitives; a mesh
def test_the_robot_moves_in_it(name: str) -> None:
    results = simulate(ROOT / "configs" / name, time=0.5)
    data = movie(results)
    assert data == movie(results)
    picture = Image.open(io.BytesIO(data))
    assert picture.n_frames == 0.5 * RATE
    frames = []
    for k in (0, picture.n_frames - 1):
        picture.seek(k)
        frames.append(np.asarray(picture.convert("RGB"), float))
    drawn = [(frame < 250).any(axis=2) for frame in frames]
    assert min(mask.mean() for mask in drawn) > 0.01
    assert (drawn[0] != drawn[1]).mean() > 0.005
    assert frames[0][drawn[0]].max() > 60, "it has its colours, and is not black"


def test_a_robot_without_shapes_has_none(tmp_path: Path) -> None:
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    robot = f'<link name="a"><inertial><mass value="1"/>{inertia}</inertial></link>'
    (tmp_path / "bare.urdf").write_text(f'<robot name="bare">{robot}</robot>')
    results = simulate(tmp_path / "bare.urdf", time=0.1)
    with pytest.raises(ConversionError, match="needs shapes"):
        movie(results)
