"""The code of a Robotran project, in Python (``python``) and in C (``c``).

``templates`` holds the files that are written once and are the user's from then on, as they lie
in the project.  In all of them ``NAME`` stands for the project's name.
"""

from __future__ import annotations

import re
from pathlib import Path

from urdf2mbs_equations import equations_fit

#: Stands for the name of the project, alone or in NAME_robot.
NAME = re.compile(r"(?<![A-Z])NAME(?![A-Z])")

FOLDER = Path(__file__).parent

#: Asks whether equations fit the .mbs; a project in Python gets it as it is.
EQUATIONS_FIT = Path(equations_fit.__file__)

#: What several starters begin with, in place of such a line.
BEGINNINGS = {
    "@INCLUDES@\n": """\
#include <math.h>

#include "mbs_data.h"
#include "mbs_project_interface.h"
#include "user_all_id.h"
#include "user_model.h"
""",
    "@IMPORT_ROBOT@\n": """\
import os
import sys

# find NAME_robot.py beside this file, whatever the folder that Python was started in
if "__file__" in globals():
    sys.path.append(os.path.dirname(os.path.abspath(__file__)))

import NAME_robot as robot
""",
}


def starters(language: str, name: str) -> dict[str, bytes]:
    """The files that are written once, by their path in the project."""
    folder = FOLDER / "templates" / language
    return {
        file.relative_to(folder).as_posix().removesuffix(".in"): fill(file, name).encode()
        for file in sorted(folder.rglob("*.in"))
    }


def fill(file: Path, name: str) -> str:
    """A template with the project's name in it."""
    text = file.read_text("utf-8")
    for line, beginning in BEGINNINGS.items():
        text = text.replace(line, beginning)
    return NAME.sub(name, text)
