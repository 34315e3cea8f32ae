"""Check code: that the code just made does what the URDF says.

Beyond the method.  The project's Python is loaded into the runtime of ``simulate``, and called at
random states: forces in joints, followers, contacts, wrenches, springs, sensors, the start, and the
equations of motion where the project has them.  What it should give is computed by a second route
(``urdf2mbs/laws``).  A project that differs is not written; its ``.mbs`` is marked as
rejected.  C takes longer to compile than all else to generate: ``verify --code`` compares C.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.proof.verdict import Difference

#: The folders of a project that hold code.
CODE = ("userfctR", "symbolicR")


class CheckCode(Pass):
    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        project, output = conversion.settings.project, conversion.settings.output
        if project is None or conversion.proof is None or output not in conversion.files:
            return
        made = {**conversion.starters, **conversion.files}
        code = {path: data for path, data in made.items() if path.parent.name in CODE}
        files = {path.relative_to(project).as_posix(): data for path, data in code.items()}
        if "c" in conversion.settings.languages:
            conversion.proof.not_compared["the code in C"] = "'verify --code' compares it"
        if "python" in conversion.settings.languages:
            prove_code(conversion, conversion.files[output], files, "python")
        if not conversion.proof.same:
            reject(conversion)


def prove_code(
    conversion: Conversion, model: bytes, files: Mapping[str, bytes], language: str
) -> None:
    """Compare a project's code with the robot of a conversion; its proof gets what is found."""
    from urdf2mbs.laws import Case, prove
    from urdf2mbs.runtime.code import loaded_code

    proof = conversion.proof
    assert proof is not None
    case = None
    try:
        with loaded_code(conversion.mbs.name, model, files, language) as code:
            case = Case(conversion, code.data.mbs, code)
            prove(case)
    except ConversionError as error:
        found = [Difference("code", f"the code in {language} cannot run: {error.message}")]
    except Exception as error:
        found = [Difference("code", f"the code in {language} cannot run: {_said(error)}")]
    else:
        found = case.found
    if case is not None:
        proof.not_compared |= case.unproven
    # what a plugin has changed after the passes that chose it
    strange = [said for said in found if said.kind in conversion.plugged]
    proof.not_compared |= {said.message: "changed by a plugin" for said in strange}
    before = len(proof.differences)
    proof.differ(said for said in found if said not in strange)
    if conversion.edited and not before:
        proof.forgive(f"as edited in {' and '.join(conversion.edited)}")


def _said(error: Exception) -> str:
    text = " ".join(str(error).split())
    return type(error).__name__ + (f": {text}" if text else "")


def reject(conversion: Conversion) -> None:
    """Write the .mbs as rejected, and no code."""
    output = conversion.settings.output
    conversion.rejected = output.with_suffix(f".rejected{output.suffix}")
    conversion.files = {
        path: data
        for path, data in conversion.files.items()
        if path.parent.name not in CODE and path != output
    } | {conversion.rejected: conversion.files[output]}
    conversion.starters = {}
    conversion.obsolete = set()


