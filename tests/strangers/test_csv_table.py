"""samples/csv_table.py: another format is one small pass, and is checked as the .mbs is."""

import csv
from pathlib import Path
from typing import Any

from support.plugin_files import write_plugin
from urdf2mbs.cli import main

PLUGIN = Path(__file__).with_name("samples") / "csv_table.py"


def test_a_table_in_place_of_the_mbs(here: Path, capsys: Any) -> None:
    """And a table of another robot is found out."""
    write_plugin(here, "spoil", "conversion.mbs.bodies[1].mass *= 1.01")
    config = f"source: tiny.urdf\noutput: tiny.csv\nplugins: [{PLUGIN}, spoil.py]\n"
    config += "swap: {emit: csv_table}\n"
    Path("spoilt.yaml").write_text(config + "after: {reframe-inertia: spoil}\n")
    assert main(["run", "spoilt.yaml"]) == 3
    assert "link 'arm': mass" in capsys.readouterr().err
    assert not Path("tiny.csv").exists()
    assert Path("tiny.rejected.csv").exists()
    Path("tiny.yaml").write_text(config)
    assert main(["run", "tiny.yaml"]) == 0
    assert "the same robot" in capsys.readouterr().out
    rows = list(csv.DictReader(Path("tiny.csv").read_text("utf-8").splitlines()))
    assert [row["joint"] for row in rows][:2] == ["floating_base_T1", "floating_base_T2"]
    assert [row["mass"] for row in rows if row["mass"]] == ["2.0", "0.5", "0.1"]
    assert not Path("tiny.mbs").exists()
