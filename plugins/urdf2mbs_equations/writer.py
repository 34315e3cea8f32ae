"""What the writers of all languages share.

The text that is the same for all models, but for a few tables, comes from sections of a template:
``accelred.c`` and ``accelred.py.in``.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.routine import (
    Content,
    OperationCount,
    Routine,
    Statement,
    make_statements,
)

#: What the number of a case stands for.
CASES = {"sensor": "sensor", "gensensor": "joint"}


class Writer:
    """Writes the functions of one model."""

    suffix: str
    comment: str
    template: str
    missing_functions: frozenset[str] = frozenset(["invdynared"])
    """Functions that Robotran does not have in this language."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.count = OperationCount()
        """The operations of everything that was written."""

    def write_function(self, name: str, content: Content) -> str:
        """Return the text of a file, without its head."""
        raise NotImplementedError

    def read_sections(self, *names: str) -> str:
        """Return sections of the template, in this order."""
        text = Path(__file__).with_name(self.template).read_text("utf-8")
        parts = re.split(r"(?m)^(?:/\*|#) --- (\w+) ---.*\n", text)
        return "".join(parts[parts.index(name) + 1] for name in names)

    def find_features(self) -> dict[str, bool]:
        """Return what ``accelred`` has to call for this model, by names of the template."""
        joints = [joint for body in self.mbs.bodies for joint in body.joints]
        return {
            "ANY_DRIVEN": any(joint.nature == "driven" for joint in joints),
            "LINKS": any(link.kind == "link" for link in self.mbs.links),
            "LINKS3D": any(link.kind == "link3D" for link in self.mbs.links),
            "EXTFORCES": any(p.extforce for body in self.mbs.bodies for p in body.points),
        }

    def make_statements(self, routine: Routine) -> list[Statement]:
        """Return the statements of a routine, and count their operations."""
        statements, count = make_statements(routine)
        self.count += count
        return statements
