"""The command and the pass, as a user meets them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.testing import convert_text

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "project" / "dataR" / "robot.mbs"
    path.parent.mkdir(parents=True)
    path.write_bytes(convert_text().data)
    return path


def test_files_go_to_the_project(model: Path, capsys: Any) -> None:
    assert main(["equations", str(model)]) == 0
    assert "equations of" in capsys.readouterr().out
    folder = model.parent.parent / "symbolicR"
    names = "accelred cons_hJ cons_jdqd dirdyna extforces gensensor invdyna link3D link sensor"
    assert sorted(file.name for file in folder.iterdir()) == [
        f"mbs_{name}_robot.py" for name in names.split()
    ]
    assert main(["equations", str(model), "--language", "c", "--fold"]) == 0
    assert main(["equations", str(model), "--energy"]) == 0
    assert main(["equations", str(model), "--derivatives"]) == 0
    for name in ("energy", "momentum", "com", "derivatives"):
        assert (folder / f"mbs_{name}_robot.py").is_file()
    assert (
        (folder / "mbs_dirdyna_robot.c")
        .read_text()
        .startswith("// Written by urdf2mbs from robot.mbs")
    )


def test_json_has_the_counts(model: Path, tmp_path: Path, capsys: Any) -> None:
    assert main(["equations", str(model), "-o", str(tmp_path / "out"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["counts"]["dirdyna"]["products"] > 0
    assert found["not_generated"] == {}


def test_robotrans_own_files_are_not_replaced(model: Path, capsys: Any) -> None:
    file = model.parent.parent / "symbolicR" / "mbs_dirdyna_robot.py"
    file.parent.mkdir()
    file.write_text("# of another program\n")
    assert main(["equations", str(model)]) == 2
    assert "output-not-ours" in capsys.readouterr().err
    assert [path.name for path in file.parent.iterdir()] == [file.name]


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ((b"<mbsname>robot<", b"<mbsname>my robot<"), "mbsname-no-identifier"),
        ((b"<", b""), "not-xml"),
    ],
)
def test_a_model_that_will_not_do(
    model: Path, change: tuple[bytes, bytes], code: str, capsys: Any
) -> None:
    model.write_bytes(model.read_bytes().replace(*change))
    assert main(["equations", str(model)]) == 1
    assert code in capsys.readouterr().err


def test_no_such_model_and_no_such_mix(model: Path, tmp_path: Path, capsys: Any) -> None:
    assert main(["equations", str(tmp_path / "no.mbs")]) == 2
    for language in ("python", "matlab"):
        assert main(["equations", str(model), "--no-pairs", "--language", language]) == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("more", [["-o", "out"], ["--language", "c"]])
def test_standalone_is_for_c_in_a_folder_of_its_own(
    model: Path, more: list[str], capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(model.parent)
    assert main(["equations", str(model), "--standalone", *more]) == 2
    assert "--standalone" in capsys.readouterr().err
    assert not (model.parent / "out").exists()
    assert not (model.parent.parent / "symbolicR").exists()
