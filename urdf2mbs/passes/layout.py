"""Layout: the method's step 5, "Give 2D graphical properties to each MBS element".

The diagram shows the robot as it stands before you (``style: robot``), else a tidy tree
(``tree``), or the grid of the method's Figure A.5 (``method``).
"""

from __future__ import annotations

from typing import Literal

import msgspec

from urdf2mbs.arrange import arrange
from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass


class Options(msgspec.Struct, forbid_unknown_fields=True):
    style: Literal["robot", "tree", "method"] = "robot"
    """``robot`` is a ``tree`` where the robot has no shape worth following."""


def run(conversion: Conversion, options: Options) -> None:
    style = arrange(conversion.mbs, options.style)
    conversion.report["layout"] = {"style": style}


PASS = Pass("layout", run, Options, needs=("joints", "anchors"), gives=("layout",))
