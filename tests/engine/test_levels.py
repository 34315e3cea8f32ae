"""Levels: whose word counts, where, and that an error never leaves a file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.catalogue import DEFAULTS
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import TINY

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With a robot that has the warning joint-dynamics, and one more."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY.replace('name="tool"/>', 'name="tool"><a/></link>', 1))
    (tmp_path / "tiny.yaml").write_text("source: tiny.urdf\nbase: floating\n")
    return tmp_path


def levels(**settings: Any) -> dict[str, str]:
    found = convert("tiny.urdf", base="floating", **settings)
    return {one.code: one.level for one in found.diagnostics}


def test_every_level(folder: Path) -> None:
    usual = levels()
    assert (usual["unknown-element"], usual["joint-dynamics"]) == ("warning", "warning")
    assert usual["base"] == "note"
    changed = levels(diagnostics={"unknown-element": "ignore", "joint-dynamics": "note",
                                  "base": "warning"})  # fmt: skip
    assert "unknown-element" not in changed
    assert (changed["joint-dynamics"], changed["base"]) == ("note", "warning")
    assert changed.keys() | {"unknown-element"} == usual.keys()


def test_all_errors_are_told_at_once(folder: Path, capsys: Any) -> None:
    with pytest.raises(ConversionError) as caught:
        convert("tiny.urdf", strict=True, base="floating")
    assert re.findall(r"error\[([a-z-]+)\]", str(caught.value)) == [
        "unknown-element", "joint-dynamics",
    ]  # fmt: skip
    assert main(["run", "tiny.yaml", "--strict", "--json"]) == 1
    said = capsys.readouterr()
    assert said.err.count("error[") == 2
    assert json.loads(said.out)["error"]["code"] == "joint-dynamics"
    assert "unknown-element" in [d["code"] for d in json.loads(said.out)["diagnostics"]]
    assert not (folder / "tiny.mbs").exists()


def test_a_code_goes_before_strict_and_the_command_line_before_the_config(folder: Path) -> None:
    mild = ["--level", "unknown-element=warning", "--level", "joint-dynamics=note"]
    assert main(["run", "tiny.yaml", "--strict", *mild]) == 0
    config = folder / "tiny.yaml"
    config.write_text(
        "source: tiny.urdf\nbase: floating\nstrict: true\ndiagnostics: {joint-dynamics: error}\n"
    )
    assert main(["run", "tiny.yaml"]) == 1
    assert main(["run", "tiny.yaml", *mild]) == 0
    assert main(["convert", "tiny.urdf", "--base", "floating", "--strict"]) == 1
    assert main(["convert", "tiny.urdf", "--base", "floating", "--strict", *mild]) == 0


def test_the_error_that_ends_a_run_comes_after_what_was_found_before(folder: Path) -> None:
    """A macro that is unknown may be why a link is."""
    (folder / "tiny.urdf").write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:hand/>\n'
        '<link name="a"><x/></link><joint name="j" type="fixed"><parent link="a"/>'
        '<child link="hand"/></joint></robot>'
    )
    for given, codes in (
        ({}, ["xacro-macro-unknown", "link-unknown"]),
        ({"xacro-macro-unknown": "warning"}, ["link-unknown"]),
        ({"unknown-element": "error"}, ["xacro-macro-unknown", "unknown-element", "link-unknown"]),
    ):
        with pytest.raises(ConversionError) as caught:
            convert("tiny.urdf", diagnostics=given)
        assert re.findall(r"error\[([a-z-]+)\]", str(caught.value)) == codes
        assert caught.value.code == "link-unknown"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--level", "unknown-elemnt=note"], "did you mean 'unknown-element'?"),
        (["--level", "two-parents=warning"], "no 'two-parents' among the codes"),
        (["--level", "limit=loud"], "it is one of: error, ignore, note, warning"),
        (["--level", "limit"], "it reads --level CODE=LEVEL"),
    ],
)
def test_wrong_levels(words: list[str], said: str, folder: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf", "--no-plugins", *words]) == 2
    assert said in capsys.readouterr().err
    with pytest.raises(ConfigError):
        convert("tiny.urdf", diagnostics={"limit": "loud"})


def test_the_docs_say_which_can_be_changed() -> None:
    text = (DOCS / "diagnostics.md").read_text()
    rows = re.findall(r"^\| `([a-z0-9-]+)` \| (error|warning|note) \|", text, re.MULTILINE)
    assert dict(rows) == DEFAULTS
