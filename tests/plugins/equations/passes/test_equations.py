"""Equations: the pass writes them into the project."""

from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.config.model import parse
from urdf2mbs.engine.output import write_files
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, convert_text


@pytest.mark.parametrize(
    ("options", "said"), [({}, True), ({"fold": True}, True), ({"language": None}, False)]
)
def test_options_without_a_language_are_told(options: dict[str, Any], said: bool) -> None:
    found = convert_text(passes={"equations": options}).diagnostics
    assert ("equations-language" in [each.code for each in found]) == said


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
    with pytest.raises(ConfigError, match="was edited since"):
        write_files(conversion.files)


def test_equations_of_another_model_go_or_are_told(tmp_path: Path) -> None:
    """Ours are removed; what somebody has changed, and Robotran's, stay and are named."""
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
    assert not [found for found in same.diagnostics if found.code == "equations-stale"]
    source.write_text(TINY.replace('axis xyz="0 1 1"', 'axis xyz="0 0 1"'))
    changed = Pipeline(*plain).run()
    assert changed.files_of("obsolete").keys() >= set(ours[1:])
    removed, kept = (d for d in changed.diagnostics if d.code == "equations-stale")
    assert removed.message.startswith(f"{len(ours) - 1} files of equations were of another model")
    assert f"urdf2mbs equations {tmp_path / 'tiny' / 'dataR' / 'tiny.mbs'}" in (removed.hint or "")
    assert kept.message.endswith(f"stay as they were: {mine.name}, mbs_old_tiny.c")
    assert "2 files" in kept.message
