"""What commands print: what became of a robot, where a pass comes from, paths, JSON."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.summaries import of_plugins
from urdf2mbs.messages.diagnostics import Diagnostic, counted
from urdf2mbs.summary import Report


def tell(conversion: Conversion, found: Report, done: str, verbose: bool, shown: str = "") -> None:
    """What became of the robot, and whether it is the same; ``done`` says where it is written, and
    ``shown`` where its warnings are shown instead."""
    joints, bodies = found.joints, counted(found.bodies, "body")
    free = counted(joints.independent, "independent joint")
    mass = found.no_dynamics or f"{found.mass:.6g} kg"
    print(f"{found.robot}: {done} ({found.base} base, {bodies}, {free}, {mass})")
    for difference in found.proof.differences if found.proof is not None else ():
        print(f"error[not-the-same]: {difference.message}", file=sys.stderr)
    lines = of_plugins(conversion).lines
    tell_diagnostics(conversion.diagnostics, verbose, found.verdict, shown)
    if verbose:
        links, own = counted(found.links, "link"), counted(joints.urdf, "URDF joint")
        compared = [] if found.proof is None else [found.proof.compared]
        lines += [f"{links} -> {bodies}, {own} -> {joints}", *compared]
    print("".join(f"  {line}\n" for line in lines), end="")


def tell_diagnostics(
    diagnostics: Sequence[Diagnostic], verbose: bool, verdict: str = "", shown: str = ""
) -> None:
    """Count warnings and notes, and print them on stderr: the notes only if ``verbose``."""
    warnings, notes = ([d for d in diagnostics if d.level == one] for one in ("warning", "note"))
    more = "" if verbose or not notes else "-v shows the notes"
    folded = warnings if verbose else _fold(warnings)
    kinds = f" of {counted(len(folded), 'kind')}" if len(folded) < len(warnings) else ""
    counts = f"{counted(len(warnings), 'warning')}{kinds}, {counted(len(notes), 'note')}"
    counts += f" ({shown or more})" if shown or more else ""
    print(f"  {verdict}; {counts}" if verdict else f"  {counts}")
    for said in warnings + notes if verbose else [] if shown else folded:
        print(with_near_paths(str(said)), file=sys.stderr)


def _fold(warnings: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The same warnings, those of one code as one, at the place of the first."""
    by_code: dict[str, list[Diagnostic]] = {}
    for said in warnings:
        by_code.setdefault(said.code, []).append(said)
    folded = []
    for first, *others in by_code.values():
        shown = [first, *others[:4]]
        message = first.message
        for said in others[:4]:
            at = f"line {said.line}: " if said.line and said.file == first.file else ""
            message += f"; {at}{said.message}"
        if len(others) > 4:
            message += f"; and {len(others) - 4} more (-v shows them)"
        hint = "; ".join(dict.fromkeys(said.hint for said in shown if said.hint)) or None
        folded.append(msgspec.structs.replace(first, message=message, hint=hint))
    return folded


def next_steps(conversion: Conversion, found: Report) -> str:
    """Return the lines that say what to do with the files."""
    settings = conversion.settings
    model = near(settings.output)
    if conversion.checked.rejected is not None:
        return "Next: see where they differ: urdf2mbs report, in place of run or convert"
    if settings.project is None:
        return f"Next: open {model} in MBSysPad, or draw it: urdf2mbs diagram {model}"
    if found.no_dynamics:
        return f"Next: give the links masses, without which nothing moves; open {model} in MBSysPad"
    play = f"urdf2mbs simulate {near(settings.project)} -o moves.html"
    steps = [f"{play}; or open {model} in MBSysPad", *of_plugins(conversion).next_steps]
    return "Next: " + "\n      ".join(steps)


def near(path: Path) -> str:
    """A path as the user would type it: relative if it is below the working folder."""
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def with_near_paths(text: str) -> str:
    """A message in which each path below the working folder is as the user would type it."""
    try:
        here = f"{Path.cwd()}{os.sep}"
    except OSError:  # the folder is gone
        return text
    return re.sub(rf"(?<![^\s'\"(]){re.escape(here)}", "", text)


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
