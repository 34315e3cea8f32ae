"""The code of a Robotran project, in Python (``python``) and in C (``c``).

``templates`` holds the files that are written once and are the user's from then on, as they lie
in the project.  In all of them ``NAME`` stands for the project's name.
"""

from __future__ import annotations

import re
from pathlib import Path

#: Stands for the name of the project, alone or in NAME_robot.
NAME = re.compile(r"(?<![A-Z])NAME(?![A-Z])")

FOLDER = Path(__file__).parent

#: Asks whether equations fit the .mbs; a project in Python gets it as it is.
EQUATIONS_FIT = FOLDER.parent / "mbs" / "equations_fit.py"


def starters(language: str, name: str) -> dict[str, bytes]:
    """The files that are written once, by their path in the project."""
    folder = FOLDER / "templates" / language
    return {
        file.relative_to(folder).as_posix().removesuffix(".in"): fill(file, name).encode()
        for file in sorted(folder.rglob("*.in"))
    }


def fill(file: Path, name: str) -> str:
    """A template with the project's name in it."""
    return NAME.sub(name, file.read_text("utf-8"))
