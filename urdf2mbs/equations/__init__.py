"""Robotran's equations of motion, as files of a project's ``symbolicR``, for any .mbs model.

See ``docs/equations.md``.
"""

from urdf2mbs.equations.files import FUNCTIONS, Equations, equations

__all__ = ["FUNCTIONS", "Equations", "equations"]
