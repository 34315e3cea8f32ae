"""Layout: the method's step 5, "Give 2D graphical properties to each MBS element".

The diagram shows the robot as seen from the front (``style: robot``), or a tidy tree (``tree``).
"""

from __future__ import annotations

from typing import Literal

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagram import arrange
from urdf2mbs.hookspecs import Pass


class Layout(Pass):
    """Place bodies, joints and points in the 2D diagram."""

    reads = ("bodies", "joints", "anchors", "posture", "names")
    writes = ("layout",)

    style: Literal["robot", "tree"] = "robot"
    """``robot`` draws a ``tree`` where the robot has no shape worth following."""

    def run(self, conversion: Conversion) -> None:
        """Arrange the diagram, and report the style that was drawn."""
        conversion.report["layout"] = {"style": arrange(conversion.mbs, self.style)}
