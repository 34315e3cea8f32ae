"""Equations: the pass writes them into the project."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.config.load import parse
from urdf2mbs.engine.output import write, write_files
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text


@pytest.mark.parametrize(
    ("options", "is_warned"), [({}, True), ({"fold": True}, True), ({"language": None}, False)]
)
def test_options_without_a_language_are_a_warning(options: dict[str, Any], is_warned: bool) -> None:
    actual = convert_text(passes={"equations": options}).diagnostics
    assert ("equations-language" in [each.code for each in actual]) == is_warned


def test_the_pass_works_where_it_is_asked_to(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    asked = "source: tiny.urdf\noutput: {project: tiny}\npasses:\n  equations: {language: c}\n"
    for text, expected in (("source: tiny.urdf\n", 0), (asked, 11)):
        conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
        files = [path for path in conversion.files if path.parent.name == "symbolicR"]
        assert len(files) == expected
    write_files(conversion.files)
    (tmp_path / "tiny" / "symbolicR" / "mbs_link_tiny.c").write_text("mine")
    conversion = Pipeline(*parse(asked, tmp_path / "tiny.yaml")).run()
    with pytest.raises(ConfigError, match="was edited since"):
        write_files(conversion.files)


@pytest.mark.parametrize(
    ("output", "endings"),
    [
        ("{project: tiny}", {".py"}),
        ("{project: tiny, language: c}", {".c"}),
        ("{project: tiny, language: both}", {".c", ".py"}),
        ("tiny.mbs", set()),
    ],
)
def test_the_languages_of_the_project(tmp_path: Path, output: str, endings: set[str]) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    text = f"source: tiny.urdf\noutput: {output}\npasses: {{equations: {{language: project}}}}\n"
    conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
    files = [path for path in conversion.files if path.name.startswith("mbs_")]
    assert {path.suffix for path in files} == endings


def test_each_run_warns_until_there_are_equations_again(tmp_path: Path) -> None:
    source = tmp_path / "tiny.urdf"
    source.write_text(TINY)
    text = "source: tiny.urdf\noutput: {project: tiny, language: both}\n"
    config, model = tmp_path / "tiny.yaml", tmp_path / "tiny" / "dataR" / "tiny.mbs"
    config.write_text(text)

    def run() -> list[str]:
        conversion = Pipeline(*parse(text, config)).run()
        write(conversion)
        return [d.message for d in conversion.diagnostics if d.code == "equations-stale"]

    assert run() == []  # nobody has asked for equations
    assert main(["equations", str(model), "--language", "c"]) == 0
    assert run() == []
    source.write_text(TINY.replace('axis xyz="0 1 1"', 'axis xyz="0 0 1"'))
    (removed,) = run()
    assert removed.startswith("11 files of equations were of another model, and are removed")
    for _ in range(2):
        (missing,) = run()
        assert missing.startswith("the equations in C were of another model and are removed")
    assert main(["equations", str(model)]) == 0
    assert run() == []


def test_data_for_matlab_and_formulas_are_of_the_numbers(tmp_path: Path) -> None:
    """A new mass makes them stale, and no other file; a file of the user is not ours."""
    source, text = tmp_path / "tiny.urdf", "source: tiny.urdf\noutput: {project: tiny}\n"
    folder = tmp_path / "tiny" / "symbolicR"

    def run() -> list[str]:
        conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
        write(conversion)
        return [d.message for d in conversion.diagnostics if d.code == "equations-stale"]

    source.write_text(TINY)
    assert run() == []
    for language in ("matlab", "latex"):
        assert main(["equations", str(tmp_path / "tiny"), "--language", language]) == 0
    assert run() == []
    (folder / "tiny_2_data.m").write_text("% of the user\n")
    source.write_text(TINY.replace('mass value="2"', 'mass value="1.5"', 1))
    (message,) = run()
    assert message.startswith("2 files of equations")
    assert message.endswith("tiny_data.m, tiny_equations.tex")
    assert not (folder / "tiny_data.m").exists()
    assert (folder / "tiny_example.m").is_file()


def test_equations_of_robotran_for_other_joints_are_named_each_time(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    text = "source: tiny.urdf\noutput: {project: tiny}\n"
    conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
    write(conversion)
    n_joints = len(conversion.mbs.numbers())
    file = tmp_path / "tiny" / "symbolicR" / "mbs_dirdyna_tiny.py"
    for stated, n_warnings in ((n_joints, 0), (n_joints + 1, 1), (n_joints + 1, 1)):
        file.write_text(f"#  ==> Number of joints : {stated}\n")
        conversion = Pipeline(*parse(text, tmp_path / "tiny.yaml")).run()
        write(conversion)
        codes = [d.code for d in conversion.diagnostics]
        assert codes.count("equations-stale") == n_warnings


def test_equations_of_another_model_are_removed_or_named(tmp_path: Path) -> None:
    """Files of urdf2mbs are removed; edited files and those of Robotran are named."""
    source = tmp_path / "tiny.urdf"
    source.write_text(TINY)
    asked = "source: tiny.urdf\noutput: {project: tiny}\npasses: {equations: {language: python}}\n"
    write_files(Pipeline(*parse(asked, tmp_path / "tiny.yaml")).run().files)
    folder = tmp_path / "tiny" / "symbolicR"
    ours = sorted(folder.glob("mbs_*.py"))
    mine = ours[0]
    mine.write_text(mine.read_text() + "# mine\n")
    (folder / "mbs_old_tiny.c").write_text("/* by Robotran */")
    plain = parse(asked.partition("passes")[0], tmp_path / "tiny.yaml")
    same = Pipeline(*plain).run()
    assert not same.files_of("obsolete").keys() & set(ours)
    assert not [actual for actual in same.diagnostics if actual.code == "equations-stale"]
    source.write_text(TINY.replace('axis xyz="0 1 1"', 'axis xyz="0 0 1"'))
    changed = Pipeline(*plain).run()
    assert changed.files_of("obsolete").keys() >= set(ours[1:])
    removed, kept = (d for d in changed.diagnostics if d.code == "equations-stale")
    assert removed.message.startswith(f"{len(ours) - 1} files of equations were of another model")
    assert f"urdf2mbs equations {tmp_path / 'tiny' / 'dataR' / 'tiny.mbs'}" in (removed.hint or "")
    assert kept.message.endswith(f"stay as they were: {mine.name}, mbs_old_tiny.c")
    assert "2 files" in kept.message
