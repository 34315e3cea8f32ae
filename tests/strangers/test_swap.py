"""A plugin's pass takes the place of any built-in pass but check, and only where it is asked to."""

import re
from pathlib import Path
from typing import Any

import pytest

from support.folders import CONFIGS
from support.plugin_files import passes_of
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import convert_text

BIPED = CONFIGS / "biped.urdf.xacro"
#: All but check: the verdict is nobody else's.
BUILT_IN = [name for name in passes_of("faithful") if name != "check"]

STAND_IN = """
from urdf2mbs.plugin import hookimpl
from urdf2mbs.engine.plugins import Plugins

Original = Plugins(installed=False).passes["{name}"][0].load()

class StandIn(Original):
    name = "{name}"

    def run(self, conversion):
        super().run(conversion)
        conversion.note("stand-in", "this was the stand-in")

@hookimpl
def urdf2mbs_passes():
    return [StandIn]
"""


@pytest.fixture(scope="module")
def plain() -> bytes:
    return convert(BIPED).data


@pytest.mark.parametrize("name", BUILT_IN)
def test_each_built_in_pass_can_be_replaced(name: str, plain: bytes, tmp_path: Path) -> None:
    plugin = tmp_path / "stand_in.py"
    plugin.write_text(STAND_IN.format(name=name))
    result = convert(BIPED, plugins=[plugin], swap={name: "stand_in"})
    assert result.data == plain
    assert [d.code for d in result.diagnostics].count("stand-in") == 1


def test_a_plugin_gives_no_verdict(tmp_path: Path) -> None:
    plugin = tmp_path / "stand_in.py"
    plugin.write_text(STAND_IN.format(name="check"))
    with pytest.raises(ConversionError, match="pass 'check' of plugin 'stand_in'") as refused:
        convert(BIPED, plugins=[plugin], swap={"check": "stand_in"})
    assert refused.value.code == "plugin-verdict"


def test_explain_says_what_stands_in_and_what_does_not(here: Path, capsys: Any) -> None:
    Path("mine.py").write_text(STAND_IN.format(name="layout"))
    for swap, said in (
        ("swap: {layout: mine}", r"from     mine \(mine.py\), by 'swap'"),
        ("", r"from     urdf2mbs .*layout.py\)\nnot      mine \(mine.py\): 'swap: {lay"),
    ):
        Path("c.yaml").write_text(f"source: tiny.urdf\nplugins: [mine.py]\n{swap}")
        assert main(["explain", "c.yaml"]) == 0
        layout = capsys.readouterr().out.partition(". layout")[2]
        assert re.search(said, re.sub(r"\n +", "\n", layout)), layout
    idle = convert_text(plugins=["mine.py"])
    assert "stand-in" not in [found.code for found in idle.diagnostics]


def test_a_plugin_that_lends_our_function_is_still_the_source(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "from urdf2mbs.hookspecs import hookimpl\n"
        "from urdf2mbs.passes.layout import Layout\n"
        "@hookimpl\ndef urdf2mbs_passes(): return [Layout]\n"
    )
    assert Plugins([file], installed=False).passes["layout"][1].file == str(file)


def test_two_plugins_with_one_pass_are_ambiguous(tmp_path: Path) -> None:
    plugins = [tmp_path / "mine.py", tmp_path / "other.py"]
    for file in plugins:
        text = STAND_IN.format(name="layout").replace('    name = "layout"', '    name = "neat"')
        file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        convert_text(plugins=plugins, after={"layout": "neat"})
    assert caught.value.code == "pass-ambiguous"
    assert "mine and other" in caught.value.message
    assert caught.value.hint == "say which: 'swap: {neat: mine}'"
