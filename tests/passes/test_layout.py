"""Layout: the option `style`, and the style that the report names."""

from pathlib import Path

import pytest

from support.diagram_trees import centres, humanoid
from urdf2mbs.config.model import Config
from urdf2mbs.conversion import Conversion, Settings
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.passes.layout import Layout


@pytest.mark.parametrize(
    ("mbs", "style", "used"),
    [(humanoid(), "robot", "robot"), (humanoid(), "tree", "tree"), (Mbs("m"), "robot", "tree")],
)
def test_the_report_names_the_style_that_was_used(mbs: Mbs, style: str, used: str) -> None:
    settings = Settings(Path("robot.urdf"), Path("robot.mbs"), Config(source=""))
    conversion = Conversion(settings, mbs=mbs)
    Layout(style=style).run(conversion)  # type: ignore[arg-type]
    assert conversion.report["layout"] == {"style": used}
    assert set(centres(mbs)) == {"", *(body.name for body in mbs.bodies)}
