"""The command and the pass, as a user meets them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.engine.config import parse
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.output import write_files
from urdf2mbs.testing import TINY, convert_text

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
    assert main(["equations", str(model), "--numba", "--language", "c"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_the_pass_works_where_it_is_asked_to(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    asked = "source: tiny.urdf\noutput: {project: tiny}\npasses:\n  equations: {language: c}\n"
    for text, wanted in (("source: tiny.urdf\n", 0), (asked, 11)):
        conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
        files = [path for path in conversion.files if path.parent.name == "symbolicR"]
        assert len(files) == wanted
    write_files(conversion.files)
    (tmp_path / "tiny" / "symbolicR" / "mbs_link_tiny.c").write_text("mine")
    conversion = Pipeline(*parse(asked, tmp_path / "tiny.yaml")).run()
    with pytest.raises(ConfigError, match="has no seal of urdf2mbs"):
        write_files(conversion.files)
