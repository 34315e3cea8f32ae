"""What the writers of all languages share: the text of functions that are the same for all models
but for a few tables, from the sections of a template (``accelred.c``, ``accelred.py.in``)."""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs.equations.routine import Count, Made, Routine, Statement, statements
from urdf2mbs.mbs.model import Mbs

#: What ``sensor`` and ``gensensor`` count.
CASES = {"sensor": "sensor", "gensensor": "joint"}

#: A long function is cut into pieces of so many statements.  Pieces of 60 to 100 compile and run
#: fastest (tried: 40 to 1000).
PIECE = 80


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


def crossing(pieces: list[list[Statement]]) -> list[str]:
    """The variables that a piece uses and another one computes, in the order of their use."""
    piece_of = {line.variable: k for k, piece in enumerate(pieces) for line in piece}
    used = ((k, name) for k, piece in enumerate(pieces) for line in piece for name in line.uses)
    return list(dict.fromkeys(name for k, name in used if piece_of.get(name, k) != k))
