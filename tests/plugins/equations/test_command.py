"""The command and the pass, as a user meets them."""

import json
import shutil
import subprocess
from argparse import ArgumentParser
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import fields

from urdf2mbs.cli import main
from urdf2mbs.config.load import parse
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY, convert_text
from urdf2mbs_equations.c import CWriter
from urdf2mbs_equations.commands.equations import add_options, read_options
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.passes.equations import Equations
from urdf2mbs_equations.routine import Refused


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
    assert sorted(file.name for file in folder.glob("mbs_*")) == [
        f"mbs_{name}_robot.py" for name in names.split()
    ]
    more = ["--fold", "--energy", "--derivatives", "--json"]
    assert main(["equations", str(model), "--language", "c", *more]) == 0
    for name in ("energy", "momentum", "com", "derivatives", "invdynared"):
        assert (folder / f"mbs_{name}_robot.c").is_file()
    text = (folder / "mbs_dirdyna_robot.c").read_text()
    assert text.startswith("// Written by urdf2mbs from robot.mbs")
    actual = json.loads(capsys.readouterr().out)
    assert actual["counts"]["dirdyna"]["products"] > 0
    assert actual["not_generated"] == {}


@pytest.mark.parametrize(
    ("files", "languages"),
    [
        ([], ["py"]),
        (["userfctR/user_dirdyn.c"], ["c"]),
        (["userfctR/user_dirdyn.py", "userfctR/user_dirdyn.c"], ["c", "py"]),
        (["symbolicR/mbs_dirdyna_old.c"], ["c"]),
        (["userfctR/user_dirdyn.m", "symbolicR/mbs_dirdyna_old.c"], ["m"]),
        (["userfctR/robot_robot.h", "userfctR/user_dirdyn.py"], ["py"]),
    ],
)
@pytest.mark.parametrize("named", ["model", "folder"])
def test_the_language_is_that_of_the_project(
    model: Path, files: list[str], languages: list[str], named: str, capsys: Any
) -> None:
    project = model.parent.parent
    for file in files:
        (project / file).parent.mkdir(exist_ok=True)
        (project / file).write_text("")
    assert main(["equations", str(model if named == "model" else project)]) == 0
    actual = {file.suffix[1:] for file in (project / "symbolicR").glob("mbs_*_robot.*")}
    assert sorted(actual) == languages
    names = {"py": "Python", "c": "C", "m": "MATLAB"}
    shown = " and ".join(names[language] for language in sorted(languages, reverse=True))
    assert f"written to {project / 'symbolicR'}, in {shown}\n" in capsys.readouterr().out


def test_the_pass_and_the_command_have_the_same_options(model: Path) -> None:
    parser = ArgumentParser()
    add_options(parser)
    arguments = parser.parse_args([str(model)])
    words = parser.format_help().replace(",", " ").split()
    for field in fields(Equations):
        assert {f"--{field.name}", f"--no-{field.name}"} & {*words}
    assert read_options(arguments) == EquationOptions(language="project")
    arguments = parser.parse_args([str(model), "--language", "both", "--fold", "--no-pairs"])
    assert read_options(arguments) == EquationOptions(language="both", fold=True, pairs=False)


@pytest.mark.parametrize(
    ("language", "suffixes"), [("matlab", {".m"}), ("both", {".py", ".c"}), ("project", {".py"})]
)
def test_each_language_for_the_pass_and_the_command(
    model: Path, tmp_path: Path, language: str, suffixes: set[str]
) -> None:
    assert main(["equations", str(model), "--language", language]) == 0
    files = (model.parent.parent / "symbolicR").glob("mbs_*")
    assert {file.suffix for file in files} == suffixes
    (tmp_path / "tiny.urdf").write_text(TINY)
    passes = f"passes: {{equations: {{language: {language}}}}}\n"
    text = f"source: tiny.urdf\noutput: {{project: tiny}}\n{passes}"
    conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
    written = [path for path in conversion.files if path.parent.name == "symbolicR"]
    assert {path.suffix for path in written} == suffixes


def test_a_named_language_is_that_language_alone(model: Path) -> None:
    project = model.parent.parent
    (project / "userfctR").mkdir()
    (project / "userfctR" / "user_dirdyn.c").write_text("")
    assert main(["equations", str(project), "--language", "python"]) == 0
    assert not list((project / "symbolicR").glob("*.c"))
    assert main(["equations", str(project), "--no-pairs"]) == 0
    assert list((project / "symbolicR").glob("*.c"))


@pytest.mark.parametrize(
    ("language", "steps"),
    [
        ("python", ["python lamp/workR/main.py"]),
        ("c", ["cmake -S lamp/workR -B lamp/workR/build -DROBOTRAN_SOURCE_DIR="]),
        ("both", ["python lamp/workR/main.py", "in C: cmake -S lamp/workR"]),
    ],
)
def test_the_next_steps_are_those_of_the_project(
    language: str, steps: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lamp.urdf").write_text(TINY)
    output = f"{{project: lamp, language: {language}}}"
    (tmp_path / "lamp.yaml").write_text(f"source: lamp.urdf\noutput: {output}\n")
    assert main(["run", "lamp.yaml"]) == 0
    after_run = capsys.readouterr().out.partition("\nNext: ")[2]
    assert "equations for Robotran's own programs: urdf2mbs equations lamp\n" in after_run
    assert ("in C: cmake -S lamp/workR" in after_run) == (language != "python")
    assert main(["equations", "lamp"]) == 0
    after_equations = capsys.readouterr().out.partition("\nNext: ")[2]
    assert [step for step in steps if step in after_equations] == steps
    assert ("cmake" in after_equations) == (language != "python")
    assert main(["run", "lamp.yaml"]) == 0
    assert "urdf2mbs equations" not in capsys.readouterr().out.partition("\nNext: ")[2]
    (tmp_path / "lamp" / "workR" / "build").mkdir()
    assert main(["equations", "lamp"]) == 0
    assert "cmake -S" not in capsys.readouterr().out


def read_program(text: str) -> str:
    """Return the lines that follow ``Next: in ...:``."""
    head, *lines = text.partition("\nNext: in ")[2].splitlines()
    assert head.endswith(":")
    assert len(lines) == 3
    return "\n".join(line.strip() for line in lines)


@pytest.mark.parametrize(
    ("options", "call"),
    [
        ([], '"robot.urdf"'),
        (["--language", "c"], '"robot.urdf"'),
        (["--base", "fixed"], '"robot.urdf", base="fixed"'),
        (["--base", "fixed", "-o", "other"], '"robot.urdf", base="fixed"'),
    ],
)
def test_a_robot_is_converted_in_memory_and_the_lines_run(
    options: list[str], call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(TINY)
    assert main(["equations", "robot.urdf", *options]) == 0
    program = read_program(capsys.readouterr().out)
    assert f"load_equations({call})" in program
    folder = tmp_path / ("other" if "-o" in options else "symbolicR")
    suffix = "c" if "c" in options else "py"
    assert (folder / f"mbs_dirdyna_robot.{suffix}").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"robot.urdf", folder.name}
    exec(program, {})
    rows = capsys.readouterr().out.splitlines()
    assert rows[0].startswith("[[")
    assert rows[-1].endswith("]]")


def test_a_model_and_a_config_have_lines_that_run(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "tiny.yaml").write_text("source: tiny.urdf\nbase: fixed\n")
    for source in ("project/dataR/robot.mbs", "project", "tiny.yaml"):
        assert main(["equations", source]) == 0
        program = read_program(capsys.readouterr().out)
        assert f'load_equations("{source}")' in program
        exec(program, {})
        assert capsys.readouterr().out.startswith("[[")


def test_the_lines_of_matlab_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(TINY)
    assert main(["equations", "robot.urdf", "--language", "matlab"]) == 0
    program = read_program(capsys.readouterr().out)
    assert program.splitlines()[0] == "addpath('symbolicR')"
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("GNU Octave is not installed")
    command = [octave, "--no-gui", "--norc", "--eval", program]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, "M =" in result.stdout) == (0, True), result.stderr


def test_robotrans_own_files_are_not_replaced(model: Path, capsys: Any) -> None:
    file = model.parent.parent / "symbolicR" / "mbs_dirdyna_robot.py"
    file.parent.mkdir()
    file.write_text("# of another program\n")
    assert main(["equations", str(model)]) == 2
    assert "output-not-ours" in capsys.readouterr().err
    assert [path.name for path in file.parent.iterdir()] == [file.name]


def test_no_such_model_and_no_such_mix(model: Path, tmp_path: Path, capsys: Any) -> None:
    assert main(["equations", str(tmp_path / "no.mbs")]) == 2
    for language in ("python", "matlab"):
        assert main(["equations", str(model), "--no-pairs", "--language", language]) == 2
    assert "Traceback" not in capsys.readouterr().err
    model.write_bytes(b"mbsDescR7")
    assert main(["equations", str(model)]) == 1
    assert "not-xml" in capsys.readouterr().err


def test_what_is_not_generated_stops_the_run() -> None:
    """In C, accelred returns a failure, and all functions stop the run."""
    writer = CWriter(read_mbs(convert_text(TINY).data, ""))
    refused = {name: writer.write_function(name, Refused("no")) for name in ("accelred", "dirdyna")}
    assert "int mbs_accelred(" in refused["accelred"]
    assert refused["accelred"].endswith("    return MBS_INFO_FAILURE;\n}\n")
    assert "void mbs_dirdyna(" in refused["dirdyna"]
    assert "return" not in refused["dirdyna"]
    assert all("s->flag_stop = 1;" in text for text in refused.values())
