"""The languages of equations and of a project."""

from __future__ import annotations

from pathlib import Path

#: By language, the suffix of its files.
SUFFIXES = {"python": ".py", "c": ".c", "matlab": ".m"}
#: By language, its name in messages.
NAMES = {"python": "Python", "c": "C", "matlab": "MATLAB", "latex": "LaTeX"}


def find_languages(project: Path) -> list[str]:
    """Return the languages of a project's user functions, else of its equations, else Python."""
    for pattern in ("userfctR/user_*", "symbolicR/mbs_*"):
        endings = {file.suffix for file in project.glob(pattern)}
        languages = [language for language, ending in SUFFIXES.items() if ending in endings]
        if languages:
            return languages
    return ["python"]
