"""Emit: the .mbs file itself (the method's A.2)."""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError


class Emit(Pass):
    """Write the model as the bytes of an .mbs file."""

    reads = (
        "base",
        "bodies",
        "inertias",
        "joints",
        "posture",
        "anchors",
        "forces",
        "shapes",
        "names",
        "layout",
        "view",
    )
    writes = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        """Add the file to the files of the conversion."""
        try:
            conversion.files[conversion.settings.output] = write(conversion.mbs)
        except ValueError as error:
            message = f"robot '{conversion.robot.name}': {error}"
            hint = "look for huge numbers in the URDF, and in the passes of plugins"
            file = conversion.robot.file
            raise ConversionError("mbs-unwritable", message, file=file, hint=hint) from None
