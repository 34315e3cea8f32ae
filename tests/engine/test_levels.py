"""Levels: whose word counts, where, and that an error never leaves a file."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from support.codes import CATALOGUE, DEFAULTS
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import TINY


@pytest.fixture
def folder(here: Path) -> Path:
    """With a robot that has the warning base-guessed, and one more."""
    text = TINY.replace('name="tool"/>', 'name="tool"><visul/></link>', 1)
    (here / "tiny.urdf").write_text(text)
    (here / "tiny.yaml").write_text("source: tiny.urdf\n")
    return here


def levels(**settings: Any) -> dict[str, str]:
    return {one.code: one.level for one in convert("tiny.urdf", **settings).diagnostics}


def test_all_errors_are_told_at_once(folder: Path, capsys: Any) -> None:
    with pytest.raises(ConversionError) as caught:
        convert("tiny.urdf", strict=True)
    assert re.findall(r"error\[([a-z-]+)\]", str(caught.value)) == [
        "misspelt",
        "base-guessed",
    ]
    assert main(["run", "tiny.yaml", "--strict", "--json"]) == 1
    said = capsys.readouterr()
    assert said.err.count("error[") == 2
    assert json.loads(said.out)["error"]["code"] == "base-guessed"
    assert "misspelt" in [d["code"] for d in json.loads(said.out)["diagnostics"]]
    assert not (folder / "tiny.mbs").exists()


def test_a_code_goes_before_strict_and_the_command_line_before_the_config(folder: Path) -> None:
    mild = ["--level", "misspelt=warning", "--level", "base-guessed=note"]
    assert main(["run", "tiny.yaml", "--strict", *mild]) == 0
    config = folder / "tiny.yaml"
    config.write_text("source: tiny.urdf\nstrict: true\ndiagnostics: {base-guessed: error}\n")
    assert main(["run", "tiny.yaml"]) == 1
    assert main(["run", "tiny.yaml", *mild]) == 0
    assert main(["convert", "tiny.urdf", "--strict"]) == 1
    assert main(["convert", "tiny.urdf", "--strict", *mild]) == 0


PLUGIN = """
from urdf2mbs.plugin import hookimpl

@hookimpl
def urdf2mbs_codes():
    return {"bearing-hot": "warning: a bearing is hot. Oil it."}

@hookimpl
def urdf2mbs_after_pass(pass_, conversion):
    if pass_.name == "emit":
        conversion.warn("bearing-hot", "it glows")
"""


def test_a_plugin_names_its_codes(folder: Path) -> None:
    (folder / "lab.py").write_text(PLUGIN)
    assert levels(plugins=["lab.py"])["bearing-hot"] == "warning"
    assert "bearing-hot" not in levels(plugins=["lab.py"], diagnostics={"bearing-hot": "ignore"})
    with pytest.raises(ConfigError, match="unknown-code") as caught:
        levels(plugins=["lab.py"], diagnostics={"bearing-hott": "ignore"})
    assert "'bearing-hot'" in str(caught.value.hint)


def test_a_plugin_says_what_its_codes_mean(folder: Path) -> None:
    codes = '{"bearing-hot": "warning: it glows", "bearing-lost": "error: it is gone", "x": None}'
    text = PLUGIN.replace('{"bearing-hot": "warning: a bearing is hot. Oil it."}', codes)
    (folder / "lab.py").write_text(text)
    assert levels(plugins=["lab.py"], diagnostics={"bearing-hot": "note"})["bearing-hot"] == "note"
    with pytest.raises(ConfigError, match="unknown-code"):
        levels(plugins=["lab.py"], diagnostics={"bearing-lost": "note"})


def test_codes_without_their_meaning_are_refused(folder: Path) -> None:
    (folder / "lab.py").write_text(PLUGIN.replace(': "warning: a bearing is hot. Oil it."', ""))
    with pytest.raises(
        ConfigError, match=r"urdf2mbs_codes returned {'bearing-hot'}; expected a dict"
    ):
        levels(plugins=["lab.py"])


def test_a_plugin_that_cannot_say_its_codes_is_named(folder: Path) -> None:
    (folder / "lab.py").write_text(PLUGIN.replace("return {", "return 1 / 0; {"))
    with pytest.raises(ConfigError, match="plugin 'lab': urdf2mbs_codes failed: ZeroDivision"):
        levels(plugins=["lab.py"], diagnostics={"bearing-hot": "note"})


def test_all_but_errors_can_be_changed(folder: Path) -> None:
    levels(diagnostics=dict.fromkeys(DEFAULTS, "note"))
    with pytest.raises(ConfigError) as caught:
        levels(diagnostics=dict.fromkeys(CATALOGUE, "note"))
    refused = re.findall(r"there is no '([a-z0-9-]+)' among the codes", str(caught.value))
    assert set(refused) == CATALOGUE.keys() - DEFAULTS.keys()


def test_no_table_of_codes_is_read_unless_a_config_sets_levels(folder: Path) -> None:
    code = (
        "import sys; from urdf2mbs.cli import main; main(['run', 'tiny.yaml'])\n"
        "assert not [name for name in sys.modules if name.endswith('.codes') and 'urdf' in name]"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
