"""Too little memory is a clear error, wherever it runs out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.api import convert
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY


def full(*_: Any, **__: Any) -> None:
    raise MemoryError


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    return tmp_path


def test_in_a_pass(tiny: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr("urdf2mbs.passes.emit.write", full)
    with pytest.raises(ConversionError) as caught:
        convert("tiny.urdf")
    assert caught.value.code == "memory-full"
    assert "pass 'emit' on robot 'tiny'" in caught.value.message
    assert main(["convert", "tiny.urdf"]) == 1
    assert "error[memory-full]: pass 'emit' on robot 'tiny' takes more" in capsys.readouterr().err
    assert [file.name for file in tiny.iterdir()] == ["tiny.urdf"]


def test_in_a_command(tiny: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    convert("tiny.urdf", output="tiny.mbs").write()
    monkeypatch.setattr("urdf2mbs.diagram.draw.draw", full)
    assert main(["diagram", "tiny.mbs"]) == 1
    assert capsys.readouterr().err.startswith("error[memory-full]: ")


def test_in_xacro(tiny: Path) -> None:
    (tiny / "r.xacro").write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        "<link name=\"${len('a' * 10**18)}\"/></robot>"
    )
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro", trust_xacro=True)
    assert caught.value.code == "memory-full"


def test_a_plugin_s_pass_too(tiny: Path) -> None:
    (tiny / "hungry.py").write_text(
        "from urdf2mbs.plugin import Pass, hookimpl\n\n"
        "class Hungry(Pass):\n    def run(self, conversion):\n        raise MemoryError\n\n"
        "@hookimpl\ndef urdf2mbs_passes():\n    return [Hungry]\n"
    )
    with pytest.raises(ConversionError) as caught:
        convert("tiny.urdf", plugins=["hungry.py"], after={"emit": "hungry"})
    assert caught.value.code == "memory-full"
