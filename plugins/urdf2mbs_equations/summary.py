"""The commands that a project still needs for Robotran's own programs, for the summary of a run."""

from __future__ import annotations

from pathlib import Path

from urdf2mbs.plugin import Conversion, Summary, near
from urdf2mbs_equations.passes.equations import find_missing


def summarize(conversion: Conversion) -> Summary:
    """Name the commands that make missing equations, and that build a project in C."""
    project = conversion.settings.project
    assert project is not None
    steps = []
    if find_missing(conversion):
        command = f"urdf2mbs equations {near(project)}"
        steps.append(f"equations for Robotran's own programs: {command}")
    build = describe_build(project) if "c" in conversion.settings.languages else None
    if build is not None:
        steps.append(f"in C: {build}")
    return Summary(next_steps=steps)


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
