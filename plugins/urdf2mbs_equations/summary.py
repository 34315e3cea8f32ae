"""The commands that a project still needs for Robotran's own programs, for the summary of a run."""

from __future__ import annotations

from pathlib import Path

from urdf2mbs.plugin import Conversion, Summary, near
from urdf2mbs_equations.passes.equations import find_missing

#: The tables of formulas on a page: their keys in the report, titles and heads.
FORMULA_TABLES = (
    ("formulas", "Equations of motion: M q\u0308 + c + g = τ", ("element", "formula")),
    ("symbols", "Symbols of the equations of motion", ("symbol", "meaning")),
)


def summarize(conversion: Conversion) -> Summary:
    """Return the formulas, and the commands that make missing equations or build a project in C."""
    report = conversion.report.get("equations", {})
    tables: list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]] = [
        (title, heads, list(report[key].items()))
        for key, title, heads in FORMULA_TABLES
        if key in report
    ]
    project = conversion.settings.project
    if project is None:
        return Summary(tables=tables)
    steps = []
    if find_missing(conversion):
        command = f"urdf2mbs equations {near(project)}"
        steps.append(f"equations for Robotran's own programs: {command}")
    build = describe_build(project) if "c" in conversion.settings.languages else None
    if build is not None:
        steps.append(f"in C: {build}")
    return Summary(next_steps=steps, tables=tables)


def describe_build(project: Path) -> str | None:
    """Return the command that builds the C of a project; None if it has no CMakeLists.txt."""
    source = project / "workR"
    if not (source / "CMakeLists.txt").is_file():
        return None
    build = source / "build"
    compile_command = f"cmake --build {near(build)}"
    if build.is_dir():
        return compile_command
    configure = f"cmake -S {near(source)} -B {near(build)} -DROBOTRAN_SOURCE_DIR=.../MBsysC"
    return f"{configure} && {compile_command}"
