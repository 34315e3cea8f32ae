"""What commands print: the summary of a conversion, messages, paths, JSON."""

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
from urdf2mbs.summary import Report, list_robot_settings

#: The most messages of one code that are printed, unless all are asked for.
MAX_PER_CODE = 5


def print_summary(
    conversion: Conversion, report: Report, outcome: str, verbose: bool, elsewhere: str = ""
) -> None:
    """Print what became of the robot, and whether it is the same.

    Args:
        conversion: The conversion.
        report: The report of the conversion.
        outcome: Where the result is, such as ``"written to robot.mbs"``.
        verbose: Whether to print notes and counts, too.
        elsewhere: Where the warnings are shown instead, such as ``"the page shows them"``.
    """
    joints, bodies = report.joints, counted(report.bodies, "body")
    independent_joints = counted(joints.independent, "independent joint")
    mass_text = report.no_dynamics or f"{report.mass:.6g} kg"
    description = f"{report.base} base, {bodies}, {independent_joints}, {mass_text}"
    print(f"{report.robot}: {outcome} ({description})")
    for difference in report.proof.differences if report.proof is not None else ():
        print(f"error[not-the-same]: {difference.message}", file=sys.stderr)
    printed_lines = of_plugins(conversion).lines
    print_diagnostics(conversion.diagnostics, verbose, report.verdict, elsewhere)
    if verbose:
        link_count, urdf_joints = counted(report.links, "link"), counted(joints.urdf, "URDF joint")
        compared_lines = [] if report.proof is None else [report.proof.compared]
        printed_lines += [f"{link_count} -> {bodies}, {urdf_joints} -> {joints}", *compared_lines]
    print_robot_settings(conversion)
    print("".join(f"  {line}\n" for line in printed_lines), end="")


def print_robot_settings(conversion: Conversion) -> None:
    """Print which keys of the config the robot's own file has set."""
    names = list_robot_settings(conversion)
    if names:
        source = near(conversion.settings.source)
        print(f"  set by {source}, unless the config says otherwise: {', '.join(names)}")


def print_diagnostics(
    diagnostics: Sequence[Diagnostic], verbose: bool, verdict: str = "", elsewhere: str = ""
) -> None:
    """Print the numbers of warnings and notes, and the messages on stderr.

    Args:
        diagnostics: The warnings and notes.
        verbose: Whether to print the notes, too, and all warnings of one code.
        verdict: Whether the robot is the same, in words.
        elsewhere: Where the warnings are shown instead.
    """
    warnings = [diagnostic for diagnostic in diagnostics if diagnostic.level == "warning"]
    notes = [diagnostic for diagnostic in diagnostics if diagnostic.level == "note"]
    remark = elsewhere or ("" if verbose or not notes else "-v shows the notes")
    shown_warnings = warnings if verbose else _fold(warnings)
    kind_count = (
        f" of {counted(len(shown_warnings), 'kind')}" if len(shown_warnings) < len(warnings) else ""
    )
    counts = f"{counted(len(warnings), 'warning')}{kind_count}, {counted(len(notes), 'note')}"
    counts += f" ({remark})" if remark else ""
    print(f"  {verdict}; {counts}" if verdict else f"  {counts}")
    for diagnostic in warnings + notes if verbose else [] if elsewhere else shown_warnings:
        print(with_near_paths(str(diagnostic)), file=sys.stderr)


def _fold(warnings: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Return the warnings with those of one code as one, at the place of the first."""
    warnings_by_code: dict[str, list[Diagnostic]] = {}
    for warning in warnings:
        warnings_by_code.setdefault(warning.code, []).append(warning)
    folded_warnings: list[Diagnostic] = []
    for equal_warnings in warnings_by_code.values():
        first_warning, *more_warnings = equal_warnings[:MAX_PER_CODE]
        message = first_warning.message
        for warning in more_warnings:
            is_near = warning.line and warning.file == first_warning.file
            position = f"line {warning.line}: " if is_near else ""
            message += f"; {position}{warning.message}"
        if len(equal_warnings) > MAX_PER_CODE:
            message += f"; and {len(equal_warnings) - MAX_PER_CODE} more (-v shows them)"
        hints = [warning.hint for warning in (first_warning, *more_warnings) if warning.hint]
        hint = "; ".join(dict.fromkeys(hints)) or None
        folded_warnings.append(msgspec.structs.replace(first_warning, message=message, hint=hint))
    return folded_warnings


def list_next_steps(conversion: Conversion, report: Report) -> str:
    """Return the lines that say what to do with the files."""
    settings = conversion.settings
    model_path = near(settings.output)
    if conversion.checked.rejected is not None:
        return "Next: see where they differ: urdf2mbs report, in place of run or convert"
    if settings.project is None:
        return f"Next: open {model_path} in MBSysPad, or draw it: urdf2mbs diagram {model_path}"
    if report.no_dynamics:
        step = "give the links masses, without which nothing moves"
        return f"Next: {step}; open {model_path} in MBSysPad"
    simulate = f"urdf2mbs simulate {near(settings.project)} -o moves.html"
    next_steps = [
        f"{simulate}; or open {model_path} in MBSysPad",
        *of_plugins(conversion).next_steps,
    ]
    return "Next: " + "\n      ".join(next_steps)


def near(path: Path) -> str:
    """Return a path as the user would type it: relative if it is below the working folder."""
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def with_near_paths(text: str) -> str:
    """Return a message with each path below the working folder as the user would type it."""
    try:
        working_folder = f"{Path.cwd()}{os.sep}"
    except OSError:  # the folder was removed
        return text
    return re.sub(rf"(?<![^\s'\"(]){re.escape(working_folder)}", "", text)


def beside(model: Path, suffix: str) -> Path:
    """Return a model's name with another ending; only .mbs is one (``panda_v1.0`` has none)."""
    return model.with_name(model.name.removesuffix(".mbs") + suffix)


def print_json(data: Any) -> None:
    """Print data as JSON."""
    import json

    from urdf2mbs.mbs.model import without_origin

    plain_data = msgspec.to_builtins(data, enc_hook=without_origin)
    # DEL is the only control character that JSON does not escape
    print(json.dumps(plain_data, indent=2).replace("\x7f", "\\u007f"))
