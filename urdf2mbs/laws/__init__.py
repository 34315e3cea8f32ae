"""What the code of a project should do: a file for each law, each by a second route.

What a law should give follows from the URDF and from the options of the passes.  The project's own
files are called at random states, and must give the same.  No file here shares a line with what
writes the code, nor with the passes that prepare it.
"""

from __future__ import annotations

from urdf2mbs.laws import equations, followers, forces, ground, joints, sensors, start
from urdf2mbs.laws.case import Case

__all__ = ["Case", "prove"]


def prove(case: Case) -> None:
    """Compare all that the code of a project does; ``case`` gets what is found."""
    for law in (start, joints, followers, ground, forces, sensors, equations):
        law.prove(case)
