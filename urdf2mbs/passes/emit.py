"""Emit: the .mbs file itself (the method's A.2)."""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.mbs.writer import write
from urdf2mbs.messages.diagnostics import ConversionError


class Emit(Pass):
    reads = (
        "base", "bodies", "inertias", "joints", "posture", "anchors", "forces", "shapes", "names",
        "layout", "view",
    )  # fmt: skip
    writes = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        try:
            output = conversion.settings.output
            conversion.files[output] = write(conversion.mbs)
        except ValueError as error:
            raise ConversionError(
                "mbs-unwritable", f"robot '{conversion.robot.name}': {error}",
                file=conversion.robot.file,
                hint="look for huge numbers in the URDF, and in the passes of plugins",
            ) from None  # fmt: skip
