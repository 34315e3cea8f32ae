"""xacro is data: whatever it does ends in a clear error, through every command that runs it."""

import io
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.api import convert
from urdf2mbs.cli import main
from urdf2mbs.disk import files
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

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
}
#: A file is made by Python's ``os``, which xacro's own check of names does not see.
ATTACK = (
    "${(lambda: [k for k in ().__class__.__base__.__subclasses__() if k.__name__ == '_wrap_close']"
    "[0].__init__.__globals__['system']('touch attacked') and 'a' or 'a')()}"
)

#: All commands read a robot in one of these ways.
COMMANDS = ("convert r.xacro", "run r.yaml", "verify r.xacro tiny.mbs", "init r.xacro")


@pytest.fixture
def folder(here: Path) -> Path:
    """Return the current folder, with a config of r.xacro."""
    (here / "r.yaml").write_text("source: r.xacro\n")
    return here


def write(inside: str) -> None:
    Path("r.xacro").write_text(f"{HEAD}{inside}\n</robot>\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_an_attack_is_refused_unless_xacro_is_trusted(
    command: str, folder: Path, capsys: Any
) -> None:
    (folder / "tiny.mbs").write_bytes(convert("tiny.urdf").data)
    write(f'<link name="{ATTACK}"/>')
    before = sorted(folder.iterdir())
    assert main(command.split()) == 1
    assert "r.xacro:2: error[xacro-expression]: a lambda is not allowed" in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before
    main([*command.split(), "--trust-xacro"])
    assert (folder / "attacked").exists()


@pytest.mark.parametrize("command", ["convert robots -o out", "run sweep.yaml", "convert -"])
def test_an_attack_from_a_folder_a_sweep_or_standard_input_is_refused(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """A plain URDF is data, however it comes in; --trust-xacro lets the attack through."""
    text = f'<robot name="r">\n<link name="{ATTACK}"/>\n</robot>\n'
    (folder / "robots").mkdir()
    (folder / "robots" / "r.urdf").write_text(text)
    (folder / "sweep.yaml").write_text(
        "source: robots/r.urdf\noutput: out/{a}.mbs\nsweep: {xacro_args: {a: [1]}}\n"
    )

    def run(*more: str) -> int:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
        return main([*command.split(), *more])

    assert run() == 1
    output = capsys.readouterr().err
    assert ":2: error[xacro-expression]: a lambda is not allowed" in output
    assert not (folder / "attacked").exists()
    run("--trust-xacro")
    assert (folder / "attacked").exists()


@pytest.mark.parametrize("kind", ENDLESS)
def test_xacro_without_an_end_is_an_error(kind: str, folder: Path) -> None:
    write(ENDLESS[kind])
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro")
    assert caught.value.code in ("xacro", "memory-full")
    assert len(str(caught.value)) < 5000


def test_init_writes_trust_into_the_config(folder: Path) -> None:
    Path("r.xacro").write_text(TINY.replace("<robot ", '<robot xmlns:xacro="x" ', 1))
    assert main(["init", "r.xacro", "-o", "new.yaml", "--trust-xacro"]) == 0
    assert "\ntrust_xacro: true" in (folder / "new.yaml").read_text()


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:include filename="large.xacro"/>',
        '<xacro:property name="a" value="${xacro.load_yaml(\'large.xacro\')}"/><link name="${a}"/>',
    ],
    ids=["include", "yaml"],
)
def test_included_files_are_bounded(
    inside: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(inside)
    Path("large.xacro").write_text("<robot>" + " " * 5000 + "</robot>")
    monkeypatch.setattr(files, "MAX_FILE_SIZE", 4000)
    with pytest.raises(ConversionError) as caught:
        convert("r.xacro")
    assert caught.value.code == "xacro"
    assert "larger than 4000 bytes" in str(caught.value)
    assert "large.xacro" in str(caught.value)
