"""Hides the plugins of ours that URDF2MBS_WITHOUT names, as if their folders were taken away."""

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType


class Without:
    """Finds no package ``urdf2mbs_NAME`` of these plugins; ``all`` is each of them."""

    def __init__(self, names: str) -> None:
        self.names = names.replace(",", " ").split()

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, plugin = name.partition(".")[0].partition("_")
        if package == "urdf2mbs" and plugin and ("all" in self.names or plugin in self.names):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return None


if os.environ.get("URDF2MBS_WITHOUT"):
    sys.meta_path.insert(0, Without(os.environ["URDF2MBS_WITHOUT"]))
    # the processes that tests start import sitecustomize.py
    start = str(Path(__file__).with_name("start"))
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [start, os.environ.get("PYTHONPATH")]))
