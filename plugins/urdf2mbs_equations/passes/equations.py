"""Equations: Robotran's equations of motion for the file just made, in the project's symbolicR.

In the method, Robotran's own generator is the last step, after the conversion (Figure 1): a web
service with an account.  This pass needs no account.  It writes equations if the config gives a
language.  It removes our equations of an earlier model, and names Robotran's.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Literal

from urdf2mbs.disk import files
from urdf2mbs.disk.record import is_ours
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import counted, some
from urdf2mbs.plugin import Conversion, File, Pass


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

    energy: bool = False
    """Also write functions for energy, momentum and centre of mass, which Robotran has not."""

    derivatives: bool = False
    """Also write the derivatives of invdyna by q, qd and qdd, and its regressor."""

    def run(self, conversion: Conversion) -> None:
        output = conversion.settings.output
        if output not in conversion.files:
            return
        data = conversion.files[output]
        if self.language is not None:
            self._write(conversion, data)
        elif "language" not in conversion.settings.config.passes.get(self.name, {"language": None}):
            conversion.warn(
                "equations-language",
                "the config has options of 'equations', but no language: no equations are made",
                hint="such as 'passes: {equations: {language: c}}'; 'language: null' means none",
            )
        _warn_of_stale(conversion, data)

    def _write(self, conversion: Conversion, data: bytes) -> None:
        from urdf2mbs_equations.files import generate  # which takes time, and is seldom asked for

        output = conversion.settings.output
        mbs = read(data, str(output), mechanics_only=True)
        for language in ("python", "c"):
            if self.language in (language, "both"):
                made = generate(
                    mbs, data, output.name, language=language, fold=self.fold, pairs=self.pairs,
                    energy=self.energy, derivatives=self.derivatives,
                )  # fmt: skip
                for name, text in made.files.items():
                    conversion.files[_folder(conversion) / name] = text
        conversion.report["equations"] = {
            "counts": {name: count.operations for name, count in made.counts.items()},
            "not_generated": made.left_out,
        }


def _folder(conversion: Conversion) -> Path:
    settings = conversion.settings
    return (settings.project or settings.output.parent) / "symbolicR"


def _warn_of_stale(conversion: Conversion, model: bytes) -> None:
    """Remove our equations of another model, and warn of such equations that are not ours."""
    output, folder = conversion.settings.output, _folder(conversion)
    if not files.is_folder(folder):
        return
    from xml.etree.ElementTree import ParseError

    from urdf2mbs_equations.equations_fit import fingerprint, fits

    name = "*" if conversion.settings.project else conversion.mbs.name
    there = [
        path for path in sorted(folder.glob(f"mbs_*_{name}.*")) if path not in conversion.files
    ]
    says = {path: fits(files.beginning(path, 2000), model) for path in there}
    ours = [path for path, fit in says.items() if fit is False]
    gone = [path for path in ours if is_ours(path)]
    stale = [path for path in ours if path not in gone]
    with suppress(ParseError, OSError, ValueError):
        parts = "tree, fixed"
        if fingerprint(files.read(output), parts) != fingerprint(model, parts):
            stale += [path for path, fit in says.items() if fit is None]
    if gone:
        conversion.files |= dict.fromkeys(gone, File(kind="obsolete"))
        conversion.warn(
            "equations-stale",
            f"{counted(len(gone), 'file')} of equations were of another model, and are removed: "
            f"{some(path.name for path in gone)}",
            hint=f"make them anew: urdf2mbs equations {output}",
        )
    if stale:
        conversion.warn(
            "equations-stale",
            f"the model has changed, and {counted(len(stale), 'file')} of equations that urdf2mbs "
            f"does not replace stay as they were: {some(path.name for path in stale)}",
            hint="generate them again in MBSysPad, or move them away and make others: "
            f"urdf2mbs equations {output}",
        )
