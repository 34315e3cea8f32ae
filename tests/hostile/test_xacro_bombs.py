"""xacro is code: whatever it does ends in a clear error, through every command that runs it."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import files
from urdf2mbs.api import convert, verify
from urdf2mbs.cli import main
from urdf2mbs.diagnostics import ConversionError
from urdf2mbs.testing import TINY

posix = pytest.mark.skipif(sys.platform == "win32", reason="limits and pipes of POSIX")

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
#: What needs no limits: it ends by itself.
ENDLESS = {
    "macro": '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
    "two macros": '<xacro:macro name="m"><xacro:n/></xacro:macro>'
    '<xacro:macro name="n"><xacro:m/></xacro:macro><xacro:m/>',
    "include": '<xacro:include filename="r.xacro"/>',
    "property": '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>'
    '<link name="${a}"/>',
    "deep expression": f'<link name="${{{"(" * 5000}{")" * 5000}}}"/>',
    "long expression": f'<link name="${{{"-" * 50_000}1}}"/>',
}  # fmt: skip
MEMORY = "<link name=\"${len('a' * 10**13)}\"/>"

#: Every command that runs xacro.
COMMANDS = (
    "convert r.xacro",
    "run r.yaml",
    "report r.xacro",
    "report r.yaml",
    "verify r.xacro tiny.mbs",
    "verify r.xacro tiny.mbs --engine pinocchio",
    "init r.xacro",
    "explain r.yaml --cost",
)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "tiny.mbs").write_bytes(convert("tiny.urdf").data)
    (tmp_path / "r.yaml").write_text("source: r.xacro\n")
    return tmp_path


def write(inside: str) -> None:
    Path("r.xacro").write_text(f"{HEAD}{inside}\n</robot>\n")


@posix
@pytest.mark.parametrize("command", COMMANDS)
def test_a_memory_bomb_through_every_command(command: str, here: Path, capsys: Any) -> None:
    write(MEMORY)
    before = sorted(here.iterdir())
    assert main([*command.split(), "--isolate"]) == 1
    assert "error[xacro-isolated]: xacro was stopped: it took more than 2GiB" in (
        capsys.readouterr().err
    )
    assert sorted(here.iterdir()) == before


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("kind", ["macro", "include"])
def test_endless_recursion_through_every_command(
    command: str, kind: str, here: Path, capsys: Any
) -> None:
    write(ENDLESS[kind])
    assert main(command.split()) == 1
    assert "error[xacro]: macros, includes or properties that call themselves" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize("kind", ENDLESS)
def test_what_has_no_end(kind: str, here: Path) -> None:
    write(ENDLESS[kind])
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro", cache=False)
    assert caught.value.code in ("xacro", "memory-full")
    assert len(str(caught.value)) < 5000


@posix
def test_the_limits_of_a_config_stay(here: Path, capsys: Any) -> None:
    write('<link name="${(7**(10**8)) % 10}"/>')
    (here / "r.yaml").write_text("source: r.xacro\npasses: {expand: {isolate: {seconds: 0.5}}}\n")
    assert main(["run", "r.yaml", "--isolate"]) == 1
    assert "took more than 0.5 seconds" in capsys.readouterr().err
    with pytest.raises(ConversionError, match=r"took more than 0\.5 seconds"):
        verify("r.xacro", here / "tiny.mbs", isolate={"seconds": 0.5})


@posix
def test_init_writes_the_limits_down(here: Path, capsys: Any) -> None:
    Path("r.xacro").write_text(TINY.replace("<robot ", '<robot xmlns:xacro="x" ', 1))
    assert main(["init", "r.xacro", "-o", "new.yaml", "--isolate"]) == 0
    assert "\npasses:\n  expand: {isolate: {}}" in (here / "new.yaml").read_text()
    text = (here / "new.yaml").read_text()
    (here / "new.yaml").write_text(re.sub(r"#   (contacts|posture):", r"  \1:", text))
    assert main(["explain", "new.yaml"]) == 0
    assert "isolate" in capsys.readouterr().out


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:include filename="large.xacro"/>',
        '<xacro:property name="a" value="${xacro.load_yaml(\'large.xacro\')}"/><link name="${a}"/>',
    ],
    ids=["include", "yaml"],
)
def test_included_files_are_bounded(
    inside: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(inside)
    Path("large.xacro").write_text("<robot>" + " " * 5000 + "</robot>")
    monkeypatch.setattr(files, "MOST", 4000)
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro", cache=False)
    assert caught.value.code == "xacro"
    assert "larger than 4000 bytes" in str(caught.value)
    assert "large.xacro" in str(caught.value)


def test_the_chain_of_includes_and_macros(here: Path) -> None:
    """An error in an included file names file and line, and how xacro came there."""
    write('<xacro:include filename="a.xacro"/>\n<xacro:leg side="left"/>')
    Path("a.xacro").write_text(f'{HEAD}\n<xacro:include filename="b.xacro"/></robot>')
    Path("b.xacro").write_text(
        f'{HEAD}<xacro:macro name="leg" params="side"><xacro:foot side="${{side}}"/>'
        '</xacro:macro>\n<xacro:macro name="foot" params="side">\n'
        '<link name="${side + 1}"/></xacro:macro></robot>'
    )
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro", cache=False)
    said = str(caught.value)
    assert caught.value.file == str(here / "b.xacro")
    assert caught.value.line == 4
    assert said.index("in the macro 'foot'") < said.index("called by the macro 'leg'")
    write('\n\n<xacro:include filename="a.xacro"/>')
    Path("b.xacro").write_text(f'{HEAD}\n<link name="${{nothing_of_the_kind}}"/></robot>')
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro", cache=False)
    said = str(caught.value)
    assert said.startswith(f"{here / 'b.xacro'}:3: error[xacro]: ")
    assert "nothing_of_the_kind" in said
    assert said.index(f"in the file {here / 'b.xacro'}") < said.index(
        f"included from {here / 'a.xacro'}"
    ) < said.index(f"included from {here / 'r.xacro'}")  # fmt: skip
