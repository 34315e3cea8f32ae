"""Equations: Robotran's equations of motion for the file just made, in the project's symbolicR.

In the method, Robotran's own generator is the last step, after the conversion (Figure 1): a web
service with an account.  This pass needs no account.  It writes equations if the config gives a
language.  It removes equations of urdf2mbs that are of an earlier model, and names Robotran's.  It
warns until there are equations again.
"""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import Literal

from urdf2mbs.plugin import Conversion, File, Pass, counted, files, is_ours, some, was_ours
from urdf2mbs.plugin import read_mbs as read
from urdf2mbs_equations.equations_fit import fingerprint, fits
from urdf2mbs_equations.projects import NAMES, SUFFIXES

#: What Robotran writes at the beginning of its equations.
JOINTS = re.compile(rb"==> Number of joints *: *(\d+)")


class Equations(Pass):
    reads = ("mbs-file",)

    language: Literal["python", "c", "both", "project"] | None = None
    """``python`` (for MBsysPy), ``c`` (for MBsysC), ``both``, or ``project``: the languages of the
    project's code; without it, nothing is generated."""
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
        counts: dict[str, int] = {}
        left_out: dict[str, str] = {}
        for language in self._languages(conversion):
            made = generate(
                mbs,
                data,
                output.name,
                language=language,
                fold=self.fold,
                pairs=self.pairs,
                energy=self.energy,
                derivatives=self.derivatives,
            )
            counts |= {name: count.operations for name, count in made.counts.items()}
            left_out |= made.left_out
            for name, text in made.files.items():
                conversion.add_file(f"symbolicR/{name}", text)
        conversion.report["equations"] = {"counts": counts, "not_generated": left_out}

    def _languages(self, conversion: Conversion) -> tuple[str, ...]:
        if self.language == "project":
            return conversion.settings.languages
        return ("python", "c") if self.language == "both" else (str(self.language),)


def _warn_of_stale(conversion: Conversion, model: bytes) -> None:
    """Remove our equations of another model, and warn of those that are not ours or are missing."""
    folder = conversion.output_folder / "symbolicR"
    if not files.is_folder(folder):
        return
    name = "*" if conversion.settings.project else conversion.mbs.name
    equations = [
        path for path in sorted(folder.glob(f"mbs_*_{name}.*")) if path not in conversion.files
    ]
    verdicts = {path: fits(files.read_beginning(path, 2000), model) for path in equations}
    stale = [path for path, verdict in verdicts.items() if verdict is False]
    removed = [path for path in stale if is_ours(path)]
    kept = [path for path in stale if path not in removed]
    unknown = [path for path, verdict in verdicts.items() if verdict is None]
    if not _has_changed(conversion, model):
        n_joints = len(conversion.mbs.numbers())
        unknown = [path for path in unknown if _states_other_joints(path, n_joints)]
    kept += unknown
    hint = f"make them again: urdf2mbs equations {conversion.settings.output}"
    if removed:
        conversion.files |= dict.fromkeys(removed, File(kind="obsolete"))
        conversion.warn(
            "equations-stale",
            f"{counted(len(removed), 'file')} of equations were of another model, and are removed: "
            f"{some(path.name for path in removed)}",
            hint=hint,
        )
    if kept:
        conversion.warn(
            "equations-stale",
            f"the model has changed, and {counted(len(kept), 'file')} of equations that urdf2mbs "
            f"does not replace stay as they were: {some(path.name for path in kept)}",
            hint="generate them again in MBSysPad, or move them away and make others: "
            f"urdf2mbs equations {conversion.settings.output}",
        )
    missing = {} if removed else find_missing(conversion)
    were_removed = [NAMES[language] for language, path in missing.items() if was_ours(path)]
    if were_removed:
        conversion.warn(
            "equations-stale",
            f"the equations in {' and '.join(were_removed)} were of another model and are removed: "
            "the project has none",
            hint=hint,
        )


def _has_changed(conversion: Conversion, model: bytes) -> bool:
    """Return True if equations of the model in the output do not fit the model just made."""
    from xml.etree.ElementTree import ParseError

    parts = "tree, fixed"
    with suppress(ParseError, OSError, ValueError):
        before = fingerprint(files.read_bytes(conversion.settings.output), parts)
        return before != fingerprint(model, parts)
    return False


def _states_other_joints(equations: Path, n_joints: int) -> bool:
    """Return True if the head of Robotran's equations states another number of joints."""
    stated = JOINTS.search(files.read_beginning(equations, 2000))
    return stated is not None and int(stated[1]) != n_joints


def find_missing(conversion: Conversion) -> dict[str, Path]:
    """Return the languages of a project that have no equations of motion, and the missing files."""
    folder, written = conversion.output_folder / "symbolicR", conversion.files_of("ours")
    dynamics = {
        language: folder / f"mbs_dirdyna_{conversion.mbs.name}{SUFFIXES[language]}"
        for language in conversion.settings.languages
    }
    return {
        language: path
        for language, path in dynamics.items()
        if path not in written and not files.is_file(path)
    }
