"""What `new-pass` writes is typed, and runs as it is."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from support.folders import ROOT
from urdf2mbs.cli import main
from urdf2mbs_setup.commands.new_pass import new_pass


def test_new_pass_is_typed(tmp_path: Path) -> None:
    pytest.importorskip("mypy", reason="mypy comes with urdf2mbs[dev]")
    new_pass("my-pass", tmp_path)
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "mypy",
            "--strict",
            "--cache-dir",
            str(ROOT / ".mypy_cache"),
            str(tmp_path / "my_pass.py"),
            str(ROOT / "tests/strangers/samples/csv_table.py"),
        ],
        check=False,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stdout


def test_a_new_pass_and_its_test_run_as_they_are(here: Path, capsys: Any) -> None:
    """What it writes runs as it is, by the very lines that it says to add; so does the test."""
    assert main(["new-pass", "count-links"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("wrote count_links.py and test_count_links.py\n")
    lines = [
        line[2:] for line in out.splitlines() if line.startswith("  ") and "urdf2mbs" not in line
    ]
    (here / "tiny.yaml").write_text("\n".join(["source: tiny.urdf", *lines[:3]]))
    assert main(["run", "-v", "tiny.yaml"]) == 0
    assert "note[heavy-link]: link 'body' has 2 kg" in capsys.readouterr().err
    with Path("tiny.yaml").open("a") as config:
        config.write("\ndiagnostics: {heavy-link: ignore}\n")
    assert main(["run", "-v", "tiny.yaml"]) == 0
    assert "heavy-link" not in capsys.readouterr().err
    assert main(["explain", "tiny.yaml"]) == 0
    assert "from     count_links (count_links.py)" in capsys.readouterr().out
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_count_links.py"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout
