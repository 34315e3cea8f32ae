"""A stranger's folder is worked in: no module and no plugin of it is loaded."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import urdf2mbs
from urdf2mbs.testing import TINY

MAIN = "import sys; from urdf2mbs.cli import main; sys.exit(main())"
#: What ``urdf2mbs`` and its processes import, of Python's library and of others.
MODULES = ["__future__", "argparse", "lxml", "yaml", "msgspec", "pickle", "threading", "evil"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Modules that say that they were loaded, and a package with a plugin."""
    for name in MODULES:
        (tmp_path / f"{name}.py").write_text(f"import os; os.write(2, b'loaded {name} ')\n")
    package = tmp_path / "evil-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[urdf2mbs]\nevil = evil\n")
    for name in ("a", "b"):
        (tmp_path / f"{name}.urdf").write_text(TINY)
        (tmp_path / f"{name}.yaml").write_text(f"source: {name}.urdf\noutput: {name}.mbs\n")
    return tmp_path


def run(words: list[str], folder: Path, **variables: str) -> str:
    """What is said on standard error by a command that must do its work."""
    done = subprocess.run(
        [sys.executable, *words, "-q"], check=False, capture_output=True, text=True, cwd=folder,
        env={**os.environ, **variables},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (folder / "a.mbs").is_file()
    return done.stderr


@pytest.mark.parametrize(
    "command",
    [["convert", "a.urdf"], ["run", "a.yaml"], ["run", "a.yaml", "b.yaml", "--workers", "2"]],
)
def test_python_m(command: list[str], folder: Path) -> None:
    """Python puts the working folder first of all."""
    assert "loaded" not in run(["-m", "urdf2mbs", *command], folder)


@pytest.mark.parametrize("places", [":{}", "{}:", "{}:.", "{}"])
def test_an_empty_entry_of_pythonpath(places: str, folder: Path, tmp_path: Path) -> None:
    """``PYTHONPATH=$PYTHONPATH:DIR`` has one; only a plugin is looked for at the start, for
    Python itself imports from there before any of our code runs."""
    for name in MODULES[:-1]:
        (folder / f"{name}.py").unlink()
    other = Path(urdf2mbs.__file__).parents[1]
    script = ["-P"] if sys.version_info >= (3, 11) else []
    said = run([*script, "-c", MAIN, "convert", "a.urdf"], folder, PYTHONPATH=places.format(other))
    assert "loaded" not in said


def test_a_folder_that_pythonpath_names_in_full_is_meant(folder: Path) -> None:
    for name in MODULES[:-1]:
        (folder / f"{name}.py").unlink()
    said = run(["-m", "urdf2mbs", "convert", "a.urdf"], folder, PYTHONPATH=str(folder))
    assert "loaded evil" in said


def test_python_at_a_prompt(folder: Path) -> None:
    """There the working folder is in ``sys.path`` as an empty entry; it holds no plugin for us."""
    for name in MODULES[:-1]:
        (folder / f"{name}.py").unlink()
    code = "from urdf2mbs import convert; convert('a.urdf', output='a.mbs').write()"
    assert "loaded" not in run(["-c", code], folder)
