"""`explain`: what a config means, and what passes there are."""

import json
from pathlib import Path
from typing import Any

from urdf2mbs.cli import main
from urdf2mbs.commands.printing import near

ROOT = Path(__file__).resolve().parents[3]


def test_explain_runs_nothing(here: Path, capsys: Any) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\n")
    (here / "tiny.urdf").unlink()
    assert main(["explain", "tiny.yaml"]) == 0
    out = capsys.readouterr().out
    assert f"source  {here}/tiny.urdf" in out
    assert "prune-massless: the method's" in out
    assert "   reads    robot\n   writes   bodies\n   options  keep: []" in out
    assert main(["explain", "--json", "tiny.yaml"]) == 0
    told = json.loads(capsys.readouterr().out)
    prune = next(one for one in told if one["name"] == "prune-massless")
    assert prune["options"] == {"keep": []}
    assert prune["writes"] == ["bodies"]
    assert prune["file"].endswith("prune_massless.py")


def test_passes(capsys: Any) -> None:
    plugin = str(ROOT / "tests" / "door" / "rename_links.py")
    assert main(["explain", "--no-plugins", "--plugin", plugin]) == 0
    out = capsys.readouterr().out
    assert "robot -> bodies; urdf2mbs " in out
    assert f"- -> robot; rename_links ({near(Path(plugin))})" in out
    assert main(["explain", "--no-plugins", "--json"]) == 0
    assert {one["name"] for one in json.loads(capsys.readouterr().out)} >= {"expand", "emit"}


def test_set_changes_a_config(here: Path, capsys: Any) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\npasses: {check: {tolerance: 1.0e-3}}\n")
    assert main(["explain", "tiny.yaml", "--json", "--set", "prune-massless.keep=[tool]"]) == 0
    options = {one["name"]: one["options"] for one in json.loads(capsys.readouterr().out)}
    assert options["check"]["tolerance"] == 1e-3
    assert options["prune-massless"]["keep"] == ["tool"]
