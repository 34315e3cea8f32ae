"""Equations: Robotran's equations of motion for the file just made, in the project's symbolicR.

In the method, Robotran's own generator is the last step, after the conversion (Figure 1): a web
service with an account.  Here it needs none.  Only done where the config gives a language.
"""

from __future__ import annotations

from typing import Any, Literal

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.reader import read


class Equations(Pass):
    reads = ("mbs-file",)

    language: Literal["python", "c", "both"] | None = None
    """``python`` (for MBsysPy), ``c`` (for MBsysC) or ``both``; without it, nothing is
    generated."""
    fold: bool = False
    """Write masses, centres of mass, inertias and points as numbers: fewer operations, but a
    change of the data has no effect."""
    pairs: bool = True
    """In C, let one operation do its work for both of two mirrored limbs.  This takes gcc or
    clang; without it, any C compiler will do."""

    def run(self, conversion: Conversion) -> None:
        output = conversion.settings.output
        if self.language is None or output not in conversion.files:
            return
        from urdf2mbs.equations import (  # which takes time, and is seldom asked for
            equations,
            not_ours,
        )

        data = conversion.files[output]
        mbs = read(data, str(output), mechanics_only=True)
        folder = (conversion.settings.project or output.parent) / "symbolicR"
        for language in ("python", "c") if self.language == "both" else (self.language,):
            made = equations(
                mbs, data, output.name, language=language, fold=self.fold, pairs=self.pairs
            )
            not_ours(folder, made)
            for name, text in made.files.items():
                conversion.files[folder / name] = text
        report: dict[str, Any] = {
            "counts": {name: count.operations for name, count in made.counts.items()},
            "not_generated": made.left_out,
        }
        conversion.report["equations"] = report
