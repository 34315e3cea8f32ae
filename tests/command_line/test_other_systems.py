"""What is different on Windows and macOS, as far as it can be tried anywhere."""

import os
from errno import EACCES
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.disk.files import is_portable
from urdf2mbs.engine import output
from urdf2mbs.engine.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY
from urdf2mbs_many.commands import many


@pytest.mark.parametrize(
    "name",
    [
        "con",
        "CON",
        "nul.mbs",
        "Aux.tar.gz",
        "com1",
        "LPT9.yaml",
        "prn .x",
        "a.",
        "a ",
        "a:b",
        "a|b",
        "a?",
        "a*",
        "a<b",
        'a"',
        "a\\b",
        "a/b",
        "a\nb",
        "a\x1f",
        "",
    ],
)
def test_names_that_windows_has_not(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not is_portable(name)
    if not name or "/" in name:
        return
    monkeypatch.setattr(output, "WINDOWS", True)
    with pytest.raises(ConfigError, match="Windows has no file of this name") as caught:
        write_files({tmp_path / "good": b"", tmp_path / name: b""})
    assert caught.value.code == "output-unwritable"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "name", ["a", "a.mbs", "console", "com10", ".urdf2mbs", "腕", "a b", "x-1"]
)
def test_names_that_every_system_has(name: str) -> None:
    assert is_portable(name)


def test_a_file_that_another_program_has_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows refuses to replace it: the message says so, no file is half, and no litter stays."""
    replace = os.replace

    def refused(part: Any, place: Any) -> None:
        if Path(place).name == "b.mbs":
            raise PermissionError(EACCES, "The process cannot access the file", str(place))
        replace(part, place)

    files = {tmp_path / "a.mbs": b"<old/>", tmp_path / "b.mbs": b"<old/>"}
    write_files(files)
    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", refused)
        with pytest.raises(ConfigError, match=r"b\.mbs.*cannot access the file"):
            write_files(dict.fromkeys(files, b"<new/>"))
    assert [file.read_bytes() for file in files] == [b"<new/>", b"<old/>"]
    assert sorted(file.name for file in tmp_path.iterdir()) == [".urdf2mbs", "a.mbs", "b.mbs"]
    write_files(dict.fromkeys(files, b"<new/>"))
    assert [file.read_bytes() for file in files] == [b"<new/>", b"<new/>"]


def test_outputs_that_differ_only_in_letter_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    for name in ("Arm", "arm"):
        (tmp_path / f"{name}1.yaml").write_text(f"source: tiny.urdf\noutput: {name}.mbs\n")
    assert main(["run", "Arm1.yaml", "arm1.yaml"]) == 2
    assert "error[output-doubled]" in capsys.readouterr().err


def test_outputs_on_two_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    def two_drives(_: Any) -> str:
        raise ValueError("Paths don't have the same drive")

    monkeypatch.setattr(many.os.path, "commonpath", two_drives)
    assert many.find_common_folder([]) == Path.cwd()


def test_line_ends_of_windows_in_every_input(tmp_path: Path) -> None:
    from urdf2mbs.api import convert

    plain, other = tmp_path / "a", tmp_path / "b"
    for folder, text in ((plain, TINY), (other, TINY.replace("\n", "\r\n"))):
        folder.mkdir()
        (folder / "tiny.urdf").write_bytes(text.encode())
        config = "source: tiny.urdf\noutput: {project: p}\npasses:\n  sensors: {links: [hand]}\n"
        if folder == other:
            config = "\ufeff" + config.replace("\n", "\r\n")
        (folder / "tiny.yaml").write_bytes(config.encode())
        assert main(["run", str(folder / "tiny.yaml"), "-q"]) == 0
    for file in plain.rglob("*"):
        if file.is_file() and file.suffix in (".mbs", ".py", ".c", ".h"):
            data = file.read_bytes()
            assert data == (other / file.relative_to(plain)).read_bytes(), file
            assert b"\r" not in data, file
    assert convert(plain / "tiny.urdf").data == convert(other / "tiny.urdf").data
