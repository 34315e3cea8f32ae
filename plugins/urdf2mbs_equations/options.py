"""The options of equations: those of the pass and of the command are these."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import msgspec

#: The largest number of moving joints of a robot whose formulas are written in full, but for
#: followers, and the largest number of all of them.
MAX_JOINTS = 4
MAX_WITH_FOLLOWERS = 8

#: The languages of equations, and words for several of them.
Language = Literal["python", "c", "matlab", "latex", "both", "project"]


class EquationOptions(msgspec.Struct):
    """Options of the generated functions and their files."""

    language: Language | None = None
    """``python`` (for MBsysPy), ``c`` (for MBsysC), ``matlab`` (for MBsysLab), ``latex`` (for
    people), ``both`` (Python and C), or ``project``: the languages of the project's code."""

    fold: bool = False
    """Write masses, centres of mass, inertias and points as numbers: fewer operations, but a
    change of the data has no effect."""

    pairs: bool = True
    """In C, compute two mirrored limbs at once if the compiler is gcc or clang; other compilers use
    the plain C in the same file."""

    energy: bool = False
    """Also write functions for energy, momentum and centre of mass, which Robotran does not
    have."""

    derivatives: bool = False
    """Also write the derivatives of invdyna by q, qd and qdd, and its regressor."""


def list_languages(language: Language | None, of_project: Iterable[str]) -> tuple[str, ...]:
    """Return the languages that an option stands for.

    Args:
        language: The option.
        of_project: The languages of the project's code.
    """
    if language == "project":
        return tuple(of_project)
    if language == "both":
        return ("python", "c")
    return () if language is None else (language,)
