"""The Robotran project folder: what is written, and what is never touched."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.disk.record import checksum


@pytest.fixture
def config(here: Path) -> Path:
    config = here / "tiny.yaml"
    config.write_text("source: tiny.urdf\noutput: {project: robot}\n")
    return config


def test_a_project_has_the_folders_that_robotran_expects(config: Path) -> None:
    assert main(["run", str(config)]) == 0
    project = config.parent / "robot"
    paths = {path.relative_to(project).as_posix() for path in project.rglob("*")}
    assert {path for path in paths if not path.startswith("userfctR/")} == {
        "animationR",
        "animationR/vrml",
        "dataR",
        "dataR/.urdf2mbs",
        "dataR/robot.mbs",
        "dataR/robot.mbs.base",
        "dataR/robot.proof.json",
        "resultsR",
        "symbolicR",
        "userfctR",
        "workR",
        "workR/.urdf2mbs",
        "workR/main.py",
    }


def test_a_file_whose_name_is_no_identifier_is_told(config: Path, capsys: Any) -> None:
    robot, output = config.parent / "tiny.urdf", config.parent / "my-robot.mbs"
    assert main(["convert", "-v", str(robot), "-o", str(output)]) == 0
    assert b"<mbsname>my_robot</mbsname>" in output.read_bytes()
    note = "note[mbs-name]: the model and its equations are called 'my_robot' in the .mbs"
    assert note in capsys.readouterr().err
    assert main(["convert", "-v", str(robot), "-o", str(config.parent / "mine.mbs")]) == 0
    assert "mbs-name" not in capsys.readouterr().err


# --- the user's own files ---


def test_a_starter_that_nobody_touched_is_renewed_and_a_touched_one_stays(config: Path) -> None:
    assert main(["run", str(config)]) == 0
    folder = config.parent / "robot" / "userfctR"
    mine, untouched = folder / "user_ExtForces.py", folder / "user_JointForces.py"
    mine.write_text("# mine\n")
    record = folder / ".urdf2mbs"
    # as an older version of urdf2mbs wrote it
    old = b"# an older starter\n"
    record.write_text(record.read_text().replace(checksum(untouched.read_bytes()), checksum(old)))
    new = untouched.read_bytes()
    untouched.write_bytes(old)
    assert main(["run", str(config)]) == 0
    assert untouched.read_bytes() == new
    assert mine.read_text() == "# mine\n"
    untouched.write_text("# mine, too\n")
    assert main(["run", str(config)]) == 0
    assert untouched.read_text() == "# mine, too\n"


@pytest.mark.parametrize("exists", [True, False])
def test_convert_into_a_folder_makes_a_project(here: Path, exists: bool) -> None:
    if exists:
        (here / "arm").mkdir()
    words = ["convert", "tiny.urdf", "-o", "arm" if exists else "arm/"]
    assert main([*words, "--language", "c"]) == 0
    assert (here / "arm" / "dataR" / "arm.mbs").is_file()
    assert list((here / "arm" / "userfctR").glob("*.c"))
    assert not list((here / "arm").rglob("main.py"))
