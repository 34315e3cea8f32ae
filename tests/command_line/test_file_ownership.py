"""Every command replaces only what urdf2mbs has written, and nobody has changed since."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY

ONE = ("--workers", "1")
#: Commands, and the file of another that each would write.
WRITE = [
    (["convert", "tiny.urdf", "-o", "thesis.mbs"], "thesis.mbs"),
    (["convert", "tiny.urdf", "-o", "p/"], "p/userfctR/p_robot.py"),
    (["convert", "tiny.urdf", "-o", "p/"], "p/dataR/p.mbs"),
    (["convert", "tiny.urdf", "--dump", "d", "-o", "a.mbs"], "d/01-expand.yaml"),
    (["run", "tiny.yaml"], "tiny.mbs"),
    (["run", "tiny.yaml", "again.yaml", *ONE, "--report", "thesis.json"], "thesis.json"),
    (["run", "tiny.yaml", "again.yaml", *ONE], "tiny.mbs"),
    (["diagram", "m.mbs", "-o", "thesis.svg"], "thesis.svg"),
    (["report", "tiny.urdf", "-o", "thesis.html"], "thesis.html"),
    (["equations", "m.mbs"], "symbolicR/mbs_dirdyna_m.py"),
    (["init", "tiny.urdf", "-o", "mine.yaml"], "mine.yaml"),
    (["new-pass", "look"], "look.py"),
]


@pytest.mark.parametrize(("words", "name"), WRITE)
def test_every_command_asks_whose_a_file_is(
    words: list[str], name: str, here: Path, capsys: Any
) -> None:
    (here / "m.mbs").write_bytes(convert("tiny.urdf", output="m.mbs").data)
    for robot in ("tiny", "again"):
        (here / f"{robot}.yaml").write_text(f"source: tiny.urdf\noutput: {robot}.mbs\n")
    file = here / name
    file.parent.mkdir(parents=True, exist_ok=True)
    for mine in ("mine\n", "<mine/>\n"):
        file.write_text(mine)
        assert main([*words, "-q"]) == 2
        error = capsys.readouterr().err
        assert "error[output-not-ours]" in error
        assert name in error.replace("\\", "/")
        assert "--force" in error
        assert file.read_text() == mine
    assert main([*words, "-q", "--force"]) == 0
    assert file.read_text() != mine
    # what we have written ourselves is ours
    assert main([*words, "-q"]) == 0
    capsys.readouterr()
    # and is not, once it is edited
    file.write_bytes(file.read_bytes().replace(b"e", b"E", 1))
    edited = file.read_bytes()
    assert main([*words, "-q"]) == 2
    assert "was edited since urdf2mbs wrote it" in capsys.readouterr().err
    assert file.read_bytes() == edited


def test_a_project_never_lands_in_the_folder_of_its_robot(here: Path, capsys: Any) -> None:
    source = here / "solo12" / "urdf" / "solo12.urdf"
    source.parent.mkdir(parents=True)
    source.write_text(TINY.replace('"tiny"', '"solo12"'))
    before = sorted(here.rglob("*"))
    for folder in ("solo12", "solo12/urdf/", "."):
        assert main(["convert", str(source), "-o", folder]) == 2
        assert "error[project-in-source]" in capsys.readouterr().err
    assert sorted(here.rglob("*")) == before
    # init names another folder
    assert main(["init", str(source), "-q"]) == 0
    assert "output: {project: solo12_robotran," in (here / "solo12.yaml").read_text()
    assert main(["run", "solo12.yaml", "-q"]) == 0
    # in a project that is there already, the robot may lie anywhere
    (here / "solo12" / "dataR").mkdir()
    assert main(["convert", str(source), "-o", "solo12", "-q"]) == 0


def test_a_rejected_model_is_beside_its_place_and_never_on_standard_output(
    here: Path, capsys: Any
) -> None:
    write_plugin(here, "wrong", "conversion.mbs.bodies[0].mass = 99.0", reads=("inertias",))
    words = ["convert", "tiny.urdf", "--plugin", "wrong.py", "--after", "reframe-inertia=wrong"]
    assert main([*words, "-o", "-"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "tiny: nothing is written" in err
    assert "written to standard output" not in err
    assert main(words) == 3
    out, err = capsys.readouterr()
    assert "Next: see where they differ: urdf2mbs report" in out
    assert "error[not-the-same]" in err
    assert (here / "tiny.rejected.mbs").is_file()
    assert not (here / "tiny.mbs").exists()


# --- what fits the robot no more ---


def make(source: str, *more: str) -> int:
    return main(["convert", source, "-o", "lamp/", "-q", *more])


def test_equations_that_are_made_again_are_not_stale(here: Path, capsys: Any) -> None:
    (here / "other.urdf").write_text(TINY.replace("0 0.5 0", "0 0.6 0"))
    for source in ("tiny.urdf", "other.urdf"):
        assert make(source, "--set", "equations.language=python") == 0
    assert "equations-stale" not in capsys.readouterr().err


@pytest.mark.parametrize("fits", [True, False])
def test_main_asks_whether_the_equations_fit(here: Path, fits: bool) -> None:
    assert make("tiny.urdf") == 0
    assert main(["equations", "lamp/dataR/lamp.mbs", "-q"]) == 0
    model = here / "lamp" / "dataR" / "lamp.mbs"
    old, new = ("<mass>2.0<", "<mass>2.5<") if fits else ("<type>R3<", "<type>R2<")
    assert old in model.read_text()
    model.write_text(model.read_text().replace(old, new))
    library = here / "library"
    library.mkdir()
    script = (here / "lamp" / "workR" / "main.py").read_text()
    assert script.index("check_equations(PROJECT") < script.index("MbsData(")
    (library / "MBsysPy.py").write_text(
        "class MbsData:\n    def __init__(self, path):\n        raise SystemExit('loaded')\n"
    )
    done = subprocess.run(
        [sys.executable, "lamp/workR/main.py"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(library), os.environ["PYTHONPATH"]])},
    )
    assert done.returncode == 1
    assert ("loaded" in done.stderr) is fits
    assert ("Make them anew: urdf2mbs equations" in done.stderr) is not fits
