"""plugins/csv_table.py: another format is one small pass, and is checked as the .mbs is."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from urdf2mbs.cli import main
from urdf2mbs.testing import TINY

PLUGIN = Path(__file__).resolve().parents[2] / "plugins" / "csv_table.py"
SPOIL = """
from making import hookimpl, make

def run(conversion, options):
    conversion.mbs.bodies[1].mass *= 1.01

@hookimpl
def urdf2mbs_passes():
    return [make("spoil", run)]
"""


def convert(folder: Path, more: str = "") -> int:
    (folder / "tiny.urdf").write_text(TINY)
    (folder / "spoil.py").write_text(SPOIL)
    config = folder / "tiny.yaml"
    config.write_text(
        f"source: tiny.urdf\noutput: tiny.csv\nplugins: [{PLUGIN}, spoil.py]\n"
        f"swap: {{emit: csv_table}}\n{more}"
    )
    return main(["run", str(config)])


def test_a_table_in_place_of_the_mbs(tmp_path: Path, capsys: Any) -> None:
    assert convert(tmp_path) == 0
    assert "the same robot" in capsys.readouterr().out
    rows = list(csv.DictReader((tmp_path / "tiny.csv").read_text("utf-8").splitlines()))
    assert [row["joint"] for row in rows][:2] == ["floating_base_T1", "floating_base_T2"]
    assert [row["mass"] for row in rows if row["mass"]] == ["2.0", "0.5", "0.1"]
    assert not (tmp_path / "tiny.mbs").exists()


def test_another_robot_is_found_in_this_format_too(tmp_path: Path, capsys: Any) -> None:
    assert convert(tmp_path, "after: {reframe-inertia: spoil}\n") == 3
    assert "link 'arm': mass" in capsys.readouterr().err
    assert not (tmp_path / "tiny.csv").exists()
    assert (tmp_path / "tiny.rejected.csv").exists()
