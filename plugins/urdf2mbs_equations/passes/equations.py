"""Equations: Robotran's equations of motion for the file just made, in the project's symbolicR.

In the method, Robotran's own generator is the last step, after the conversion (Figure 1): a web
service with an account.  This pass needs no account.  It writes equations if the config names a
language.  It removes equations of urdf2mbs that are of an earlier model, and names Robotran's.  It
warns until there are equations again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from msgspec.structs import replace

from urdf2mbs.plugin import (
    Conversion,
    File,
    Pass,
    counted,
    files,
    is_ours,
    read_mbs,
    some,
    was_ours,
)
from urdf2mbs_equations.equations_fit import fingerprint, fits
from urdf2mbs_equations.followers import list_followers
from urdf2mbs_equations.options import EquationOptions, list_languages
from urdf2mbs_equations.projects import NAMES, SUFFIXES

#: What Robotran writes in the head of its equations.
JOINT_COUNT = re.compile(rb"==> Number of joints *: *(\d+)")
#: The number of bytes of a file in which its head is.
HEAD_SIZE = 2000


class Equations(EquationOptions, Pass):
    """Robotran's equations of motion for the file just made, in the project's symbolicR."""

    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        """Add the files of equations to a conversion, and warn of stale ones."""
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
        from urdf2mbs_equations.files import generate  # which takes time, and is seldom needed

        output = conversion.settings.output
        mbs = read_mbs(data, str(output), mechanics_only=True)
        followers = list_followers(conversion, mbs)
        counts: dict[str, int] = {}
        left_out: dict[str, str] = {}
        report: dict[str, Any] = {"counts": counts, "not_generated": left_out}
        for language in list_languages(self.language, conversion.settings.languages):
            options = replace(self, language=language)
            equations = generate(mbs, data, output.name, options, followers=followers)
            counts |= {name: count.operations for name, count in equations.counts.items()}
            left_out |= equations.left_out
            for name, text in equations.files.items():
                conversion.add_file(f"symbolicR/{name}", text)
            if equations.formulas:
                report |= {"formulas": equations.formulas, "symbols": equations.symbols}
        conversion.report["equations"] = report


def _warn_of_stale(conversion: Conversion, model: bytes) -> None:
    """Remove our equations of another model, and warn of those that are not ours or are missing."""
    folder = conversion.output_folder / "symbolicR"
    if not files.is_folder(folder):
        return
    stale = _find_stale(conversion, folder, model)
    hint = f"make them again: urdf2mbs equations {conversion.settings.output}"
    if stale.removed:
        conversion.files |= dict.fromkeys(stale.removed, File(kind="obsolete"))
        conversion.warn(
            "equations-stale",
            f"{counted(len(stale.removed), 'file')} of equations were of another model, and are "
            f"removed: {some(path.name for path in stale.removed)}",
            hint=hint,
        )
    if stale.remaining:
        conversion.warn(
            "equations-stale",
            f"the model has changed, and {counted(len(stale.remaining), 'file')} of equations that "
            "urdf2mbs does not replace stay as they were: "
            f"{some(path.name for path in stale.remaining)}",
            hint="generate them again in MBSysPad, or move them away and make others: "
            f"urdf2mbs equations {conversion.settings.output}",
        )
    missing = {} if stale.removed else find_missing(conversion)
    were_removed = [NAMES[language] for language, path in missing.items() if was_ours(path)]
    if were_removed:
        conversion.warn(
            "equations-stale",
            f"the equations in {' and '.join(were_removed)} were of another model and are removed: "
            "the project has none",
            hint=hint,
        )


class _StaleEquations(NamedTuple):
    """Files of equations that are of another model, or may be."""

    removed: list[Path]
    """Files of urdf2mbs, which are removed."""
    remaining: list[Path]
    """Files that a user has changed, and files of Robotran: they are only named."""


def _find_stale(conversion: Conversion, folder: Path, model: bytes) -> _StaleEquations:
    name = "*" if conversion.settings.project else conversion.mbs.name
    endings = ("data.m", "example.m", "equations.tex")
    patterns = (f"mbs_*_{name}.*", *(f"{name}_{ending}" for ending in endings))
    equations = sorted(path for pattern in patterns for path in folder.glob(pattern))
    verdicts = {
        path: fits(files.read_beginning(path, HEAD_SIZE), model)
        for path in equations
        if path not in conversion.files
    }
    stale = [path for path, verdict in verdicts.items() if verdict is False]
    removed = [path for path in stale if is_ours(path)]
    remaining = [path for path in stale if path not in removed]
    unknown = [
        path
        for path, verdict in verdicts.items()
        if verdict is None and path.name.startswith("mbs_")  # any other file may be the user's
    ]
    return _StaleEquations(removed, remaining + _choose_stale(conversion, unknown, model))


def _choose_stale(conversion: Conversion, unknown: Iterable[Path], model: bytes) -> list[Path]:
    """Choose from files without a checksum: all if the model has changed, else by their joints."""
    if _has_changed(conversion, model):
        return list(unknown)
    n_joints = len(conversion.mbs.numbers())
    return [path for path in unknown if _states_other_joints(path, n_joints)]


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
    stated = JOINT_COUNT.search(files.read_beginning(equations, HEAD_SIZE))
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
