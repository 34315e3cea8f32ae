"""What equations need to know of a project: its languages, and how its C is built."""

from __future__ import annotations

from pathlib import Path

from urdf2mbs.commands.printing import near

#: By language, the ending of its files.
SUFFIXES = {"python": ".py", "c": ".c", "matlab": ".m"}
#: By language, its name.
NAMES = {"python": "Python", "c": "C", "matlab": "MATLAB"}


def find_languages(project: Path) -> list[str]:
    """Return the languages of a project's user functions, else of its equations, else Python."""
    for pattern in ("userfctR/user_*", "symbolicR/mbs_*"):
        endings = {file.suffix for file in project.glob(pattern)}
        languages = [language for language, ending in SUFFIXES.items() if ending in endings]
        if languages:
            return languages
    return ["python"]


def describe_build(project: Path) -> str | None:
    """Return the command that builds the C of a project; None where no CMakeLists.txt says how."""
    source = project / "workR"
    if not (source / "CMakeLists.txt").is_file():
        return None
    build = source / "build"
    compile_command = f"cmake --build {near(build)}"
    if build.is_dir():
        return compile_command
    configure = f"cmake -S {near(source)} -B {near(build)} -DROBOTRAN_SOURCE_DIR=.../MBsysC"
    return f"{configure} && {compile_command}"
