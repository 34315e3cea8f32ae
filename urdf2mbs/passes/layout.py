"""Layout: the method's step 5, "Give 2D graphical properties to each MBS element".

The diagram shows the robot as it stands before you (``style: robot``), else a tidy tree
(``tree``), or the grid of the method's Figure A.5 (``method``).  With ``keep``, what stands in
the file that is there already stays where it is.
"""

from __future__ import annotations

from typing import Any, Literal

from urdf2mbs.conversion import Conversion
from urdf2mbs.diagram import arrange
from urdf2mbs.disk import files
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import ConversionError


class Layout(Pass):
    reads = ("joints", "anchors", "forces", "names")
    writes = ("layout",)

    style: Literal["robot", "tree", "method"] = "robot"
    """``robot`` draws a ``tree`` where the robot has no shape worth following."""
    keep: bool = False
    """Take the places from the output that is there, as you left them in MBSysPad."""

    def run(self, conversion: Conversion) -> None:
        report: dict[str, Any] = {"style": arrange(conversion.mbs, self.style)}
        if self.keep:
            report["kept"] = _keep(conversion)
        conversion.facts["layout"] = report


def _keep(conversion: Conversion) -> int:
    output = conversion.settings.output
    if not files.is_file(output):
        conversion.note("layout-kept", f"'{output.name}' is not there yet: all places are new")
        return 0
    try:
        drawn = read(files.read(output), str(output))
    except (ConversionError, OSError) as error:
        why = error.strerror if isinstance(error, OSError) else error.message
        conversion.warn(
            "layout-not-kept",
            f"the places in '{output}' cannot be kept, since it cannot be read: {why}",
            hint="mend the file; or leave 'keep' out of the options of layout, and it is replaced",
        )
        return 0
    from urdf2mbs.diagram.keep import keep

    kept = keep(conversion.mbs, drawn)
    count = len(conversion.mbs.bodies)
    conversion.note("layout-kept", f"{kept} of {count} bodies stay where '{output.name}' has them")
    return kept
