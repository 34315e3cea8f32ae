"""`explain`: all passes on a screen, one pass whole, and what a config means."""

import json
from pathlib import Path

import pytest

from support.folders import ROOT
from support.plugin_files import passes_of
from support.presets import PRESETS
from urdf2mbs.cli import main
from urdf2mbs.commands.printing import near
from urdf2mbs.engine.plugins import Plugins

RENAME = ROOT / "tests" / "door" / "rename_links.py"
LAB = '''
import msgspec
from urdf2mbs.plugin import Pass, hookimpl


class Load(msgspec.Struct):
    kg: float
    """Its mass."""


class Payload(Pass):
    """Add masses to links."""

    reads = writes = ("robot",)
    after = ("expand",)
    loads: dict[str, Load]
    """By link."""
    kind: str = "box"

    def run(self, conversion):
        raise AssertionError("explain runs nothing")


@hookimpl
def urdf2mbs_passes():
    return [Payload]


@hookimpl
def urdf2mbs_presets():
    return {"lab": {"extends": "faithful"}, "odd": {"extends": "nowhere"}}
'''
CONFIG = "source: tiny.urdf\nplugins: [lab.py]\npasses: {payload: {loads: {hand: {kg: 1.0}}}}\n"


@pytest.fixture
def lab(here: Path) -> Path:
    (here / "lab.py").write_text(LAB)
    (here / "lab.yaml").write_text(CONFIG)
    return here


Capture = pytest.CaptureFixture[str]


def test_explain_runs_nothing(here: Path, capsys: Capture) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\n")
    (here / "tiny.urdf").unlink()
    assert main(["explain", "tiny.yaml", "-v"]) == 0
    out = capsys.readouterr().out
    assert f"source  {here}/tiny.urdf" in out
    assert "prune-massless: Decide which links become bodies" in out
    assert "    reads    robot\n    writes   bodies\n    options  keep: []" in out
    assert main(["explain", "--json", "tiny.yaml"]) == 0
    told = json.loads(capsys.readouterr().out)
    prune = next(entry for entry in told if entry["name"] == "prune-massless")
    assert prune["options"] == {"keep": []}
    assert prune["writes"] == ["bodies"]
    assert prune["file"].endswith("prune_massless.py")


def test_a_config_is_a_line_for_each_pass_and_what_it_changes(lab: Path, capsys: Capture) -> None:
    text = CONFIG.replace("passes: {", "passes: {prune-massless: {keep: [tool]}, ")
    (lab / "lab.yaml").write_text(text)
    assert main(["explain", "lab.yaml"]) == 0
    out = capsys.readouterr().out
    numbered = [line for line in out.splitlines() if line[:2].strip().isdigit()]
    more = [line for line in out.splitlines() if line.startswith("    ")]
    assert numbered[1].split(maxsplit=2) == ["2.", "payload", "Add masses to links."]
    assert more == [
        "    from     lab (lab.py)",
        "    options  loads: {'hand': {'kg': 1.0}}",
        "    options  keep: ['tool']",
    ]


def test_all_passes_fit_a_screen(capsys: Capture) -> None:
    assert main(["explain", "--no-plugins"]) == 0
    lines = capsys.readouterr().out.splitlines()
    passes = Plugins(installed=False).passes
    assert len(lines) <= 45
    assert max(map(len, lines)) <= 80
    names = [line.split()[0] for line in lines[: len(passes)]]
    assert sorted(names) == sorted(passes)
    assert names.index("expand") < names.index("insert-base") < names.index("emit")


def test_explain_lists_the_passes_of_a_plugin(capsys: Capture) -> None:
    assert main(["explain", "--no-plugins", "--plugin", str(RENAME)]) == 0
    *_, rename, _, _ = capsys.readouterr().out.splitlines()
    assert rename.startswith("rename-links ")
    assert rename.endswith(" (rename_links)")
    assert main(["explain", "--no-plugins", "--plugin", str(RENAME), "-v"]) == 0
    out = capsys.readouterr().out
    assert "robot -> bodies; urdf2mbs " in out
    assert f"- -> robot; rename_links ({near(RENAME)})" in out
    assert main(["explain", "--no-plugins", "--json"]) == 0
    assert {entry["name"] for entry in json.loads(capsys.readouterr().out)} >= {"expand", "emit"}


def test_one_pass_is_shown_whole(lab: Path, capsys: Capture) -> None:
    assert main(["explain", "payload", "--plugin", "lab.py"]) == 0
    out = capsys.readouterr().out
    begin, _, end = out.partition("  place    ")
    assert begin == "payload: Add masses to links.\n  from     lab (lab.py)\n"
    places, _, rest = end.partition("  reads    ")
    shown = dict(line.split(maxsplit=1) for line in places.splitlines())
    assert shown == expected_places()
    assert rest == (
        "robot\n  writes   robot\n  options\n"
        "    loads: dict[str, Load], required\n        By link.\n"
        "    kind: str, default: box\n"
        "  each Load\n    kg: float, required\n        Its mass.\n"
    )
    assert main(["explain", "payload", "--plugin", "lab.py", "--json"]) == 0
    (explained,) = json.loads(capsys.readouterr().out)
    assert explained["presets"] == expected_places()
    assert [option["name"] for option in explained["options"]] == ["loads", "kind"]


def expected_places() -> dict[str, str]:
    """Return where the pass of the lab stands in each preset, in words."""
    places = {}
    for name in PRESETS:
        count = len(passes_of(name)) + 1
        places[name] = f"2 of {count}, after 'expand'"
    places["lab"] = places["faithful"]
    broken = "there is no preset 'nowhere', which 'odd' extends"
    return {**places, "odd": f"the preset cannot be used: {broken}"}


def test_a_pass_goes_before_a_folder_of_its_name(here: Path, capsys: Capture) -> None:
    (here / "layout").mkdir()
    assert main(["explain", "layout"]) == 0
    assert "style: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message", "hint"),
    [
        ("laiout", "'laiout' is neither a file nor a pass", "did you mean 'layout'"),
        ("qqqqqq", "'qqqqqq' is neither a file nor a pass", "--plugin FILE.py"),
        ("lab", "'lab' is neither a file nor a pass", "did you mean 'lab.yaml'"),
        ("faithful", "'faithful' is a preset", "--pipeline faithful"),
        ("payload", "'payload' is neither a file nor a pass", "--plugin FILE.py"),
    ],
)
def test_a_word_that_explain_does_not_know_is_refused(
    words: str, message: str, hint: str, lab: Path, capsys: Capture
) -> None:
    assert main(["explain", words]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert hint in told


def test_set_changes_a_config(here: Path, capsys: Capture) -> None:
    (here / "tiny.yaml").write_text("source: tiny.urdf\npasses: {check: {tolerance: 1.0e-3}}\n")
    assert main(["explain", "tiny.yaml", "--json", "--set", "prune-massless.keep=[tool]"]) == 0
    options = {entry["name"]: entry["options"] for entry in json.loads(capsys.readouterr().out)}
    assert options["check"]["tolerance"] == 1e-3
    assert options["prune-massless"]["keep"] == ["tool"]


def test_json_of_a_sweep_is_json_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    config = f"source: {ROOT}/configs/biped.urdf.xacro\n"
    config += (
        "output: m/{check.tolerance}.mbs\nsweep: {passes: {check: {tolerance: [1e-9, 1e-8]}}}\n"
    )
    Path("sweep.yaml").write_text(config)
    assert main(["explain", "sweep.yaml"]) == 0
    assert "2 robots; this is the first" in capsys.readouterr().out
    assert main(["explain", "sweep.yaml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["name"] == "expand"
