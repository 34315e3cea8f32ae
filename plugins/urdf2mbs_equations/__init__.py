"""Robotran's equations of motion, as files of a project's ``symbolicR``, for any .mbs model.

See ``docs/how-equations-are-made.md``.
"""

from urdf2mbs_equations.constraints import constant_gaps, count_equations, drops_row
from urdf2mbs_equations.files import FUNCTIONS, NEVER_CLOSES, OWN, Equations, generate

__all__ = [
    "FUNCTIONS", "NEVER_CLOSES", "OWN", "Equations", "constant_gaps", "count_equations",
    "drops_row", "generate",
]  # fmt: skip
