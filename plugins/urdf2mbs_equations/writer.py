"""What the writers of all languages share: the text of functions that are the same for all models
but for a few tables, from the sections of a template (``accelred.c``, ``accelred.py.in``)."""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.plugin import Mbs
from urdf2mbs_equations.routine import Count, Made, Routine, Statement, statements

#: What ``sensor`` and ``gensensor`` count.
CASES = {"sensor": "sensor", "gensensor": "joint"}


class Writer:
    """Writes the functions of one model; ``count`` is how many operations they do."""

    suffix: str
    comment: str
    template: str
    lacks: frozenset[str] = frozenset(["invdynared"])
    """Functions that Robotran has not in this language."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.count = Count()

    def function(self, name: str, made: Made) -> str:
        """The text of a file below its header."""
        raise NotImplementedError

    def sections(self, *names: str) -> str:
        """Sections of the template, in this order."""
        text = Path(__file__).with_name(self.template).read_text("utf-8")
        parts = re.split(r"(?m)^(?:/\*|#) --- (\w+) ---.*\n", text)
        return "".join(parts[parts.index(name) + 1] for name in names)

    def facts(self) -> dict[str, bool]:
        """What ``accelred`` asks of the model: each decides whether a function is called."""
        joints = [joint for body in self.mbs.bodies for joint in body.joints]
        return {
            "ANY_DRIVEN": any(joint.nature == "driven" for joint in joints),
            "LINKS": any(link.kind == "link" for link in self.mbs.links),
            "LINKS3D": any(link.kind == "link3D" for link in self.mbs.links),
            "EXTFORCES": any(p.extforce for body in self.mbs.bodies for p in body.points),
        }

    def statements(self, routine: Routine) -> list[Statement]:
        lines, count = statements(routine)
        self.count += count
        return lines
