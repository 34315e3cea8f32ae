"""Mesh files for several test files."""

from __future__ import annotations

from pathlib import Path

import pytest
from meshes.samples import SAMPLES, Sample


@pytest.fixture(params=SAMPLES, ids=lambda sample: sample.name)
def sample(request: pytest.FixtureRequest) -> Sample:
    found: Sample = request.param
    return found


@pytest.fixture
def mesh(sample: Sample, tmp_path: Path) -> Path:
    """The sample's file."""
    return sample.write(tmp_path)
