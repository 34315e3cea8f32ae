"""Pipelines of the tiny robot."""

from pathlib import Path

from support.plugin_files import passes_of
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.testing import TINY

NINE = passes_of("faithful")


#: Those that have work with the tiny robot alone, as far as they are here.
WORK = {
    "expand",
    "insert-base",
    "prune-massless",
    "reframe-inertia",
    "decompose-joints",
    "collect-anchors",
    "joint-parameters",
    "convert-visuals",
    "assign-names",
    "layout",
    "fit-view",
    "left-out",
    "emit",
    "merge",
    "find-singular",
    "check",
}


RAN = [name for name in NINE if name in WORK]


def pipeline_of(folder: Path, text: str = "") -> Pipeline:
    from urdf2mbs.config.load import load

    (folder / "tiny.urdf").write_text(TINY)
    (folder / "c.yaml").write_text(f"source: tiny.urdf\n{text}")
    return Pipeline(*load(folder / "c.yaml"))
