"""`merge`: three versions of a file become one, in the real histories and as git calls it."""

import os
import subprocess
import sys
from pathlib import Path
from random import Random
from typing import Any

import pytest

from support.edits import body_on_a_new_point, mass, no_leaf, renamed_body
from support.folders import SHARED
from urdf2mbs.cli import main
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.mbs.writer import write
from urdf2mbs_edits.diff.changes import find_differences
from urdf2mbs_edits.diff.table import list_entities
from urdf2mbs_edits.merge.merge import merge

SAMPLES = SHARED / "mbs-samples"
needs_samples = pytest.mark.skipif(not SAMPLES.is_dir(), reason="the samples are not there")


def changes(before: Path | bytes, after: Path | bytes, *, physics: bool = False) -> list[str]:
    data = [file if isinstance(file, bytes) else file.read_bytes() for file in (before, after)]
    models = [read_mbs(file, "m") for file in data]
    changes_found = find_differences(models[0], models[1], physics=physics).changes
    return [
        f"{change.change} {change.kind} {change.name} {change.field}" for change in changes_found
    ]


@needs_samples
@pytest.mark.parametrize("change", [mass, body_on_a_new_point, renamed_body, no_leaf])
@pytest.mark.parametrize(
    ("name", "year"),
    [
        ("biped", "2014"),
        ("ur5", "2016"),
        *(
            pytest.param(name, year, marks=pytest.mark.slow)
            for name in ("nao", "cassie")
            for year in ("2014", "2016")
        ),
    ],
)
def test_what_mbsyspad_saved_follows_the_urdf(name: str, year: str, change: Any) -> None:
    """A changed mass, a new, a renamed and a removed link: nothing is taken for an edit."""
    written = (SAMPLES / f"saved/{name}.written.mbs").read_bytes()
    new = read_mbs(written, "new")
    for entity in list_entities(new):
        if hasattr(entity.part, "origin"):
            entity.part.origin = None
    change(new, Random(name + year))
    saved = read_mbs((SAMPLES / f"saved/{name}.saved-{year}.mbs").read_bytes(), "saved")
    merged = merge(read_mbs(written, "base"), saved, new)
    assert merged.plan.updated
    assert merged.plan.kept == merged.plan.conflicts == merged.plan.orphaned == []
    assert changes(write(new), merged.data, physics=True) == []


@needs_samples
def test_the_merge_that_git_could_do(tmp_path: Path) -> None:
    files = [
        str(SAMPLES / f"emecdelam-suspension.{side}.mbs") for side in ("base", "ours", "theirs")
    ]
    merged = tmp_path / "m.mbs"
    assert main(["merge", *files, "-o", str(merged), "-q"]) == 0
    assert changes(SAMPLES / "emecdelam-suspension.merged.mbs", merged) == []


@needs_samples
def test_the_merge_on_which_students_lost_a_shape(tmp_path: Path) -> None:
    files = [SAMPLES / f"ovankerm-Jeep.{side}.mbs" for side in ("base", "ours", "theirs")]
    merged = tmp_path / "m.mbs"
    assert main(["merge", *map(str, files), "-o", str(merged), "-q"]) == 0
    # all that ours says beyond the base, the box among it, and all that theirs says
    assert "added shape New_Shape " in changes(files[2], merged)
    assert "added parameter Bumpy " in changes(files[2], merged, physics=True)
    assert changes(files[1], merged, physics=True) == changes(files[0], files[2], physics=True)


@needs_samples
@pytest.mark.parametrize("pair", ["emecdelam-Jpp", "emecdelam-suspension"])
def test_the_next_version_of_students_on_a_base_that_changed(pair: str) -> None:
    before, after = ((SAMPLES / f"{pair}.{side}.mbs").read_bytes() for side in ("before", "after"))
    new = read_mbs(before, "new")
    base = write(new)
    new.bodies[0].mass = 123.5
    new.origin = None
    merged = merge(read_mbs(base, "base"), read_mbs(after, "edited"), new)
    assert changes(after, merged.data) == [f"changed body {new.bodies[0].name} mass"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    from support.mbs_models import everything

    monkeypatch.chdir(tmp_path)
    for side in ("base", "ours", "theirs"):
        (tmp_path / f"{side}.mbs").write_bytes(write(everything()))
    return tmp_path


def change(file: str, old: str, new: str) -> None:
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new, 1))


def test_a_conflict_is_named_and_ours_stays(folder: Path, capsys: Any) -> None:
    change("ours.mbs", "<type>T3</type>", "<type>T1</type>")
    change("theirs.mbs", "<type>T3</type>", "<type>T2</type>")
    change("theirs.mbs", "<type>R3</type>", "<type>R2</type>")
    assert main(["merge", "base.mbs", "ours.mbs", "theirs.mbs", "--path", "arm.mbs"]) == 1
    output = capsys.readouterr()
    conflict = "joint 'lift' of body 'trunk': type 'T3' -> 'T1'; theirs has 'T2'; ours is used"
    assert f"arm.mbs: conflict: {conflict}\n" in output.err
    text = (folder / "ours.mbs").read_text()
    assert "<type>T1</type>" in text
    assert text.count("<type>R2</type>") == 3


def test_what_theirs_added_comes_with_all_that_stands_in_it(folder: Path) -> None:
    change(
        "theirs.mbs",
        "<user_model>",
        "<user_model><name>B</name><!-- why --><unit>m</unit></user_model><user_model>",
    )
    change("ours.mbs", "<bodytree>", "<bodytree><!-- mine -->")
    assert main(["merge", "base.mbs", "ours.mbs", "theirs.mbs", "-q"]) == 0
    text = (folder / "ours.mbs").read_text()
    assert "<unit>m</unit>" in text
    assert "<!-- mine -->" in text


def test_what_nobody_knows_and_both_changed_is_a_conflict(folder: Path, capsys: Any) -> None:
    for side, unit in (("base", "m"), ("ours", "cm"), ("theirs", "mm")):
        change(f"{side}.mbs", "<user_model>", f"<user_model><unit>{unit}</unit>")
    assert main(["merge", "base.mbs", "ours.mbs", "theirs.mbs", "-q"]) == 1
    assert "unit" in capsys.readouterr().err


def test_changes_that_do_not_fit_together_are_listed_and_ours_stays(
    folder: Path, capsys: Any
) -> None:
    for side, x in (("ours", 1), ("theirs", 2)):
        place = f"<coordinates><x>{x}</x><y>0</y><z>0</z></coordinates>"
        point = f"<point><pointname>new</pointname>{place}</point>"
        change(f"{side}.mbs", "</body>", f"{point}</body>")
    ours = (folder / "ours.mbs").read_bytes()
    assert main(["merge", "base.mbs", "ours.mbs", "theirs.mbs", "--path", "arm.mbs"]) == 1
    assert capsys.readouterr().err.splitlines()[0] == (
        "arm.mbs: error[merge-inconsistent]: "
        "theirs and ours each gave a point the name 'new' in body 'trunk'"
    )
    assert (folder / "ours.mbs").read_bytes() == ours


def test_a_file_that_is_none_is_trouble(folder: Path) -> None:
    (folder / "theirs.mbs").write_text("<<<<<<< HEAD")
    ours = (folder / "ours.mbs").read_bytes()
    assert main(["merge", "base.mbs", "ours.mbs", "theirs.mbs", "-q"]) == 2
    assert (folder / "ours.mbs").read_bytes() == ours


@pytest.mark.slow
def test_git_merges_by_it(folder: Path) -> None:
    def git(*words: str, code: int = 0) -> str:
        made = subprocess.run(["git", *words], capture_output=True, text=True, check=False)
        assert made.returncode == code, made.stdout + made.stderr
        return made.stdout

    base = (folder / "base.mbs").read_text()
    git("init", "-q", ".")
    git("config", "user.email", "a@b.c")
    git("config", "user.name", "a")
    driver = f"'{sys.executable}' -m urdf2mbs merge %O %A %B --path %P"
    git("config", "merge.urdf2mbs.driver", driver)
    Path(".gitattributes").write_text("*.mbs merge=urdf2mbs\n")
    Path("arm.mbs").write_text(base)
    git("add", ".gitattributes", "arm.mbs")
    git("commit", "-qm", "base")
    git("checkout", "-qb", "other")
    change("arm.mbs", "<type>T3</type>", "<type>T2</type>")
    git("commit", "-qam", "theirs")
    git("checkout", "-q", "-")
    change("arm.mbs", "<type>R3</type>", "<type>R2</type>")
    git("commit", "-qam", "ours")
    git("merge", "-q", "other", "-m", "both")
    text = Path("arm.mbs").read_text()
    assert "<type>T2</type>" in text
    assert text.count("<type>R2</type>") == 3


def test_the_same_merge_gives_the_same_bytes_in_each_process(folder: Path) -> None:
    """Python hashes words differently in each process; signals are a set of words."""
    change(
        "theirs.mbs",
        '<sensor name="touch"/>',
        '<sensor name="touch" Pos="true" Jac="true" Om="true" Acc="true"/>',
    )
    merged = []
    for seed in "12":
        subprocess.run(
            [
                sys.executable,
                "-m",
                "urdf2mbs",
                "merge",
                "base.mbs",
                "ours.mbs",
                "theirs.mbs",
                "-o",
                f"{seed}.mbs",
                "-q",
            ],
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        merged.append((folder / f"{seed}.mbs").read_bytes())
    assert b'<sensor name="touch" Pos="true" Jac="true" Om="true" Acc="true"/>' in merged[0]
    assert len(set(merged)) == 1
