"""Routines as text, in any language: what all languages have in common.

A language is a subclass.  It says how a variable, a store and a call look, how a function begins
and ends, and it has a template for the functions that are the same for all models but for a few
tables: ``accelred.c`` and ``accelred.py.in``.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from importlib.resources import files

from urdf2mbs.equations.routine import (
    Absent,
    Call,
    Cases,
    Count,
    Loops,
    Made,
    Piece,
    Refused,
    Routine,
    Statement,
    split,
    statements,
)
from urdf2mbs.mbs.model import Mbs

#: What ``sensor`` and ``gensensor`` count.
CASES = {"sensor": "sensor", "gensensor": "joint"}


class Writer(ABC):
    """Writes the functions of one model."""

    piece = 10**9
    """A longer function is cut into pieces of so many statements."""
    suffix: str
    comment: str
    template: str
    """The file of the functions that are the same for all models."""
    before: tuple[str, ...] = ("model", "forces")
    """The sections that ``accelred`` begins with."""
    end = ""
    """What ends a statement."""

    def __init__(self, mbs: Mbs) -> None:
        self.mbs = mbs
        self.count = Count()

    def function(self, name: str, made: Made) -> tuple[str, Count]:
        """The text of a file below its header, and how many operations it does."""
        self.count = Count()
        if isinstance(made, Absent):
            message = f"symbolic files seem obsolete: the model had no {made.what}"
            text = self.stub(name, message, needed=False)
        elif isinstance(made, Refused):
            text = self.stub(name, "not generated, the head of its file says why", needed=True)
        elif isinstance(made, Cases):
            text = self.cases(name, made)
        elif isinstance(made, Loops):
            text = self.common(made, *self.before, "loops", name)
        elif name == "accelred":
            text = self.common(None, *self.before) + self.tree(made)
        else:
            text = self.routine(name, made)
        return self.top(name, text) + text.rstrip("\n") + "\n", self.count

    def common(self, loops: Loops | None, *names: str) -> str:
        """Sections of the template; the section ``model`` is this model's."""
        text = files(__package__).joinpath(self.template).read_text("utf-8")
        parts = re.split(r"(?m)^(?:/\*|#) --- (\w+) ---.*\n", text)
        sections = dict(zip(parts[1::2], parts[2::2], strict=True))
        sections["model"] = self.model(loops)
        return "".join(sections[name] for name in names)

    def facts(self) -> dict[str, bool]:
        """What ``accelred`` asks of the model: each decides whether a function is called."""
        joints = [joint for body in self.mbs.bodies for joint in body.joints]
        return {
            "ANY_DRIVEN": any(joint.nature == "driven" for joint in joints),
            "LINKS": any(link.kind == "link" for link in self.mbs.links),
            "LINKS3D": any(link.kind == "link3D" for link in self.mbs.links),
            "EXTFORCES": any(p.extforce for body in self.mbs.bodies for p in body.points),
        }

    def write(
        self, name: str, parameters: str, routine: Routine, doc: str = "", start: str = ""
    ) -> str:
        """A function; ``start`` is what stands before its name."""
        lines, count = statements(routine)
        self.count += count
        if any(line.call for line in lines) or len(lines) <= self.piece:
            return self.whole(name, parameters, lines, doc, start)
        pieces, sizes = split(lines, self.piece)
        return self.in_pieces(name, parameters, pieces, sizes, doc, start)

    def body(self, lines: Iterable[Statement], piece: Piece | None = None) -> list[str]:
        """The statements; a variable of another piece is read as late as it can be."""
        takes, gives = (dict(piece.takes), piece.gives) if piece else ({}, {})
        out = []
        for line in lines:
            # as late as can be: each is one register less
            for name in dict.fromkeys(line.uses):
                if name in takes:
                    place = takes.pop(name)
                    out.append(self.variable(name, place, pair=place[0] == "v"))
            if line.call is not None:
                out.append(self.call(line.call))
            elif line.variable is not None:
                out.append(self.variable(line.variable, line.text, pair=line.pair))
                if line.variable in gives:
                    out.append(self.store([gives[line.variable]], line.variable))
            else:
                out.append(self.store(line.places, line.text))
        return [f"    {line}{self.end}" for line in out]

    def store(self, places: Sequence[str], text: str) -> str:
        return " = ".join([*map(self.place, places), text])

    @abstractmethod
    def variable(self, name: str, text: str, *, pair: bool) -> str:
        """A variable is given its value; ``pair`` is True if it is two numbers."""

    @abstractmethod
    def place(self, place: str) -> str:
        """A place of a result, such as ``M[1][3]`` or ``sens.P[1]``."""

    @abstractmethod
    def call(self, call: Call) -> str:
        """A call of a user function."""

    @abstractmethod
    def top(self, name: str, text: str) -> str:
        """What a file begins with: all that ``text`` uses of other files."""

    @abstractmethod
    def model(self, loops: Loops | None) -> str:
        """The section ``model`` of the template."""

    @abstractmethod
    def stub(self, name: str, message: str, *, needed: bool) -> str:
        """A function that only says a message and stops the simulation; ``needed`` is False if
        only libraries of before 2025 call it."""

    @abstractmethod
    def routine(self, name: str, routine: Routine) -> str:
        """One of Robotran's functions."""

    @abstractmethod
    def cases(self, name: str, cases: Cases) -> str:
        """A function that does another routine for each number."""

    @abstractmethod
    def tree(self, routine: Routine) -> str:
        """What follows the section ``forces`` in ``accelred`` of a tree."""

    @abstractmethod
    def whole(
        self, name: str, parameters: str, lines: list[Statement], doc: str, start: str
    ) -> str:
        """A function in one piece."""

    def in_pieces(
        self, name: str, parameters: str, pieces: list[Piece], sizes: dict[str, int],
        doc: str, start: str,
    ) -> str:  # fmt: skip
        """A function in several pieces, which share arrays of the sizes given."""
        raise NotImplementedError
