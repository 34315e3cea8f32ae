"""What commands print: what became of a robot, where a pass comes from, paths, JSON."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.messages.diagnostics import Diagnostic, counted, render
from urdf2mbs.summary import Report, of_plugins


def tell(conversion: Conversion, found: Report, verbose: bool) -> None:
    """What became of the robot: the same for every command that converts."""
    joints = found.joints
    links, bodies = counted(found.links, "link"), counted(found.bodies, "body")
    print(f"  {links} -> {bodies}, mass {found.mass:.6g} kg")
    if found.no_dynamics:
        print(f"  {found.no_dynamics}")
    print(
        f"  {counted(joints.urdf, 'URDF joint')} -> {joints}; "
        f"{joints.per_degree_of_freedom:.2f} joints for each degree of freedom"
    )
    for line in of_plugins(conversion).lines:
        print(f"  {line}")
    if found.proof is not None:
        print(f"  {found.verdict}\n  {found.proof.compared}")
        for difference in found.proof.differences:
            print(f"error[not-the-same]: {difference.message}", file=sys.stderr)
    else:
        print(f"  {found.verdict}: the pass 'check' is not in the pipeline")
    tell_diagnostics(conversion.diagnostics, verbose)
    for decision in decisions(conversion, found):
        print(f"  {decision}")


#: What may be decided for a user, the weightiest first: the code of its message, and the line to
#: paste for the other choice.
CHOICES = {
    "massless-leaf": 'passes: {prune-massless: {keep: ["*"]}}',
    "inertia-estimated": "passes: {estimate-inertia: {density: KG_PER_M3}}",
    "stand": "passes: {contacts: {stand: false}}",
    "mesh-missing": "packages: {NAME: DIR}",
    "time-step": "dt0 = SECONDS in workR/main",
}


def decisions(conversion: Conversion, found: Report) -> list[str]:
    """What was decided for the user, in at most three lines: the base, and what weighs most.

    Each line has what the config must say for the other choice.
    """
    said = {one.code: one.message.partition(": ")[0] for one in conversion.diagnostics}
    made = [f"{said[code]}; else '{line}'" for code, line in CHOICES.items() if code in said]
    return [found.base_in_words, *made[:2]]


#: What the reader adds to the name of a file that xacro has expanded.
EXPANDED = " (expanded)"


def tell_diagnostics(diagnostics: Sequence[Diagnostic], verbose: bool) -> None:
    """Count warnings and notes, and print them on stderr: the notes only if ``verbose``.

    A file's path is printed once.  The lines of a text that is in no file are left out.
    """
    warnings, notes = ([d for d in diagnostics if d.level == one] for one in ("warning", "note"))
    more = "" if verbose or not notes else " (-v shows the notes)"
    print(f"  {counted(len(warnings), 'warning')}, {counted(len(notes), 'note')}{more}")
    last = None
    for said in warnings + notes if verbose else _fold(warnings):
        path = (said.file or "").removesuffix(EXPANDED)
        file = Path(path).name if path == last else near(Path(path)) if path else None
        line = said.line if said.file == path else None
        print(render(said.level, said.code, said.message, file, line, said.hint), file=sys.stderr)
        last = path


def _fold(warnings: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The same warnings, those of one code as one."""
    by_code: dict[str, list[Diagnostic]] = {}
    for said in warnings:
        by_code.setdefault(said.code, []).append(said)
    folded = []
    for first, *others in by_code.values():
        shown = [first, *others[:4]]
        message = "; ".join(said.message for said in shown)
        if len(others) > 4:
            message += f"; and {len(others) - 4} more (-v shows them)"
        hint = "; ".join(dict.fromkeys(said.hint for said in shown if said.hint)) or None
        folded.append(msgspec.structs.replace(first, message=message, hint=hint))
    return folded


#: Versions of Robotran's programs; docs/beside-robotran.md says what was tried in them.
TRIED = "tried: MBSysPad 1.8, MBsysC of 2017"


def next_steps(conversion: Conversion, found: Report) -> str:
    """The two lines that say what to do with the files."""
    if conversion.checked.rejected is not None:
        return (
            "Next: see where they differ: urdf2mbs report, in place of run or convert\n"
            "      a plugin's pass that changes the robot on purpose says writes = ('robot',)"
        )
    settings = conversion.settings
    model = near(settings.output)
    if settings.project is None:
        return (
            f"Next: open {model} in MBSysPad ({TRIED}), or draw it: urdf2mbs diagram {model}\n"
            "      for a whole Robotran project: output: {project: DIR}, or convert -o DIR/"
        )
    if found.no_dynamics:
        return (
            f"Next: give the links masses: nothing moves by forces; then open {model} in MBSysPad"
        )
    main = settings.project / "workR" / "main.py"
    run = f"python {near(main)}" if main in conversion.files else "build workR by its CMakeLists"
    return (
        f"Next: let it move: urdf2mbs simulate {near(settings.project)}\n"
        f"      in Robotran ({TRIED}): open {model} in MBSysPad; {run} "
        "(see docs/first-simulation.md)"
    )


def near(path: Path) -> str:
    """A path as the user would type it: relative if it is below the working folder."""
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def beside(model: Path, suffix: str) -> Path:
    """The model's name with another ending; only .mbs is one (``panda_v1.0`` has none)."""
    return model.with_name(model.name.removesuffix(".mbs") + suffix)


def print_json(data: Any) -> None:
    """Print data as JSON."""
    import json

    from urdf2mbs.mbs.model import without_origin

    plain = msgspec.to_builtins(data, enc_hook=without_origin)
    # JSON leaves this one control character as it is
    print(json.dumps(plain, indent=2).replace("\x7f", "\\u007f"))
