"""A stand-in for the cache of robot_descriptions: git checkouts where it looks for them."""

import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

#: In whose place of the cache a checkout has to be.
REVISION = "stand-in"


def stand_in(
    monkeypatch: pytest.MonkeyPatch,
    cache: Path,
    repository: str,
    files: Mapping[str, Path | str],
) -> Path:
    """Put a repository with these files (copied, or a text) into a cache; gives its folder.

    Where the network is asked for all the same, git finds none.
    """
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    from robot_descriptions._repositories import REPOSITORIES

    name = REPOSITORIES[repository].cache_path
    folder = cache / f"{name}-{REVISION}" / name
    for path, content in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        text = content.read_bytes() if isinstance(content, Path) else content.encode()
        file.write_bytes(text)
    git = ["git", "-c", "user.name=x", "-c", "user.email=x@localhost", "-C", str(folder)]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "x"], ["tag", REVISION]):
        subprocess.run([*git, *words], check=True, capture_output=True)
    offline(monkeypatch, cache)
    return folder


def offline(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    """Look for robots in this cache only; what was imported before is forgotten."""
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(cache))
    monkeypatch.setenv("ROBOT_DESCRIPTION_COMMIT", REVISION)
    monkeypatch.setenv("GIT_ALLOW_PROTOCOL", "file")
    for module in [name for name in sys.modules if name.startswith("robot_descriptions.")]:
        if module.endswith("_description"):
            monkeypatch.delitem(sys.modules, module)
