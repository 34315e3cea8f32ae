"""What the tests of diagrams share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import pytest

from urdf2mbs.engine.config import Config, Lines
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConversionError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from robots import RealRobot

    from urdf2mbs.mbs.model import Mbs


@pytest.fixture
def laid_out(tmp_path: Path) -> Callable[[RealRobot, str], Mbs]:
    """Converts a robot by a preset as far as its diagram."""

    def convert(robot: RealRobot, preset: str) -> Mbs:
        config = Config(
            source=str(robot.source),
            output=str(tmp_path / "robot.mbs"),
            packages={name: str(folder) for name, folder in robot.packages.items()},
            xacro_args=robot.args,
            pipeline=preset,
        )
        try:
            return Pipeline(config, Lines(), installed_plugins=False).run(stop_after="layout").mbs
        except ConversionError as error:
            if error.code != "nothing-left":
                raise
        # nothing of this robot has mass
        config = msgspec.structs.replace(config, passes={"prune-massless": {"keep": ["*"]}})
        return Pipeline(config, Lines(), installed_plugins=False).run(stop_after="layout").mbs

    return convert
