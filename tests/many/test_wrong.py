"""Many robots, asked for wrongly: each mistake is told with its code."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.testing import TINY


@pytest.mark.parametrize(
    ("command", "code"),
    [
        (["convert", "empty", "-o", "out/"], "folder-empty"),
        (["run", "one.yaml", "other.yaml"], "output-doubled"),
        (["report", "sweep.yaml"], "sweep-many"),
    ],
)
def test_what_cannot_be(
    command: list[str], code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "tiny.urdf").write_text(TINY)
    for name in ("one", "other"):
        (tmp_path / f"{name}.yaml").write_text("source: tiny.urdf\noutput: same.mbs\n")
    (tmp_path / "sweep.yaml").write_text(
        "source: tiny.urdf\noutput: models/{estimate-inertia.density}.mbs\n"
        "sweep: {passes: {estimate-inertia: {density: [1.0, 2.0]}}}\n"
    )
    assert main([*command, "--no-plugins"]) == 2
    assert f"error[{code}]" in capsys.readouterr().err


def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    """The processes do not run the script again."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.urdf").write_text(TINY)
    (tmp_path / "script.py").write_text(
        "from urdf2mbs import convert_many\n"
        "made = convert_many(({'source': f'{n}.urdf'} for n in 'ab'), workers=2)\n"
        "print([one.code for one in made])\n"
    )
    done = subprocess.run(
        [sys.executable, "script.py"], check=False, capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("[0, 0]\n", "")
