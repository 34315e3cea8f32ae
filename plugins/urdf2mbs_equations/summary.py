"""The commands that a project still needs for Robotran's own programs, for the summary of a run."""

from __future__ import annotations

from pathlib import Path

from urdf2mbs.plugin import Conversion, Summary, near, read_mbs
from urdf2mbs_equations.options import MAX_WITH_FOLLOWERS
from urdf2mbs_equations.passes.equations import find_missing

#: The tables of formulas on a page: their keys in the report, titles and heads.
FORMULA_TABLES = (
    ("formulas", "Equations of motion: M q\u0308 + c + g = τ", ("element", "formula")),
    ("symbols", "Symbols of the equations of motion", ("symbol", "meaning")),
)


#: The largest number of terms of formulas on a page: they take up to 0.3 s.
MAX_TERMS = 300


def summarize(conversion: Conversion, *, for_page: bool) -> Summary:
    """Return the formulas, and the commands that make missing equations or build a project in C."""
    tables: list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]] = []
    if for_page:
        report = conversion.report.get("equations", {})
        formulas = report if "formulas" in report else _make_formulas(conversion)
        tables = [
            (title, heads, list(formulas[key].items()))
            for key, title, heads in FORMULA_TABLES
            if key in formulas
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


def _make_formulas(conversion: Conversion) -> dict[str, dict[str, str]]:
    """Return M, c and g of a robot with few joints in short, by the keys of ``FORMULA_TABLES``."""
    from urdf2mbs_equations.tree import is_fixed

    n_moving = sum(not is_fixed(joint) for joint in conversion.mbs.joints().values())
    if not 0 < n_moving <= MAX_WITH_FOLLOWERS or conversion.written not in conversion.files:
        return {}
    from urdf2mbs_equations.followers import list_followers
    from urdf2mbs_equations.plain_text import list_formulas, list_symbols
    from urdf2mbs_equations.symbolic import NoFormulasError, make_symbolic_equations

    data = conversion.files[conversion.written]
    mbs = read_mbs(data, str(conversion.written), mechanics_only=True)
    followers = list_followers(conversion, mbs)
    try:
        equations = make_symbolic_equations(mbs, followers, max_terms=MAX_TERMS)
    except NoFormulasError:
        return {}
    return {"formulas": list_formulas(equations), "symbols": list_symbols(equations)}


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
