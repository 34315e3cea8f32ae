"""A file of edits, by `edits` and by the pass: base and overlay give what was edited."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any

import pytest
import yaml
from merge import edits

from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.diff.changes import differences
from urdf2mbs.mbs.reader import read
from urdf2mbs.mbs.writer import write

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
#: What stands in a file by itself, and where a file of edits has it.
ALL = [edit for edit in edits.BESIDE + edits.MECHANICS if edit is not edits.places]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.yaml").write_text(f"source: {CONFIGS / 'arm.urdf.xacro'}\noutput: arm.mbs\n")
    return tmp_path


def edit(*made: Any, seed: int = 1) -> None:
    path = Path("arm.mbs")
    mbs = read(edits.as_saved(path.read_bytes()), "arm.mbs")
    for change in made:
        change(mbs, Random(seed))
    path.write_bytes(write(mbs))


def apply(output: str = "again.mbs", *words: str) -> int:
    Path("again.yaml").write_text(
        Path("arm.yaml").read_text().replace("arm.mbs", output)
        + "passes: {apply-edits: {file: edits.yaml}}\n"
    )
    return main(["run", "again.yaml", "-q", *words])


def same(one: str, other: str) -> list[Any]:
    first, second = (read(Path(file).read_bytes(), file) for file in (one, other))
    second.name = first.name
    return [c for c in differences(first, second).changes if "graphics" not in c.field]


@pytest.mark.parametrize("made", ALL, ids=lambda made: made.__name__)
def test_an_edit_is_made_again(made: Any, here: Path) -> None:
    assert main(["run", "arm.yaml", "-q"]) == 0
    edit(made)
    assert main(["edits", "arm.mbs", "-o", "edits.yaml", "-q"]) == 0
    assert apply() == 0
    assert same("arm.mbs", "again.mbs") == []


def test_many_edits_are_made_again_and_named_in_the_verdict(here: Path, capsys: Any) -> None:
    assert main(["run", "arm.yaml", "-q"]) == 0
    edit(edits.sensor, edits.link, edits.mass, edits.renamed_joint, edits.renamed_body)
    assert main(["edits", "arm.mbs", "-o", "edits.yaml"]) == 0
    assert "edits written to edits.yaml" in capsys.readouterr().out
    text = Path("edits.yaml").read_text()
    assert "# link 'my_link' added: link between" in text
    assert isinstance(next(iter(yaml.safe_load_all(text))), list)
    Path("again.yaml").write_text("")
    assert apply("again.mbs", "--dump", "d") == 0
    assert main(["run", "again.yaml", "--json"]) == 0
    assert "as edited in edits.yaml" in capsys.readouterr().out
    assert same("arm.mbs", "again.mbs") == []


def test_links_are_where_they_were_by_their_new_names(here: Path) -> None:
    source, called = CONFIGS / "arm.urdf.xacro", {"hand": "my_hand", "wrist_roll": "my_roll"}
    Path("edits.yaml").write_text("".join(
        f"- {{change: renamed, kind: {kind}, name: {name}, owner: {owner}, field: name, "
        f"before: {name}, after: {called[name]}}}\n"
        for kind, name, owner in (("body", "hand", "''"), ("joint", "wrist_roll", "body 'hand'"))
    ))  # fmt: skip
    plain = convert(source, output="r.mbs")
    edited = convert(
        source, output="r.mbs", passes={"apply-edits": {"file": str(here / "edits.yaml")}}
    )
    for link, frame in plain.frames.items():
        frame.body = called.get(frame.body or "", frame.body)
        frame.joint = called.get(frame.joint or "", frame.joint)
        assert edited.frames[link] == frame


def test_later_edits_stand_behind_those_that_were_applied(here: Path) -> None:
    assert main(["run", "arm.yaml", "-q"]) == 0
    edit(edits.sensor, edits.renamed_joint)
    assert main(["edits", "arm.mbs", "-o", "edits.yaml", "-q"]) == 0
    assert apply("arm.mbs") == 0  # a merge with what is there already
    edit(edits.link, edits.camera)
    assert main(["edits", "arm.mbs", "-o", "edits.yaml", "-q"]) == 0
    assert main(["edits", "arm.mbs", "-o", "edits.yaml", "-q"]) == 0
    assert len(list(yaml.safe_load_all(Path("edits.yaml").read_text()))) == 2
    assert apply() == 0
    assert same("arm.mbs", "again.mbs") == []


def test_what_is_gone_is_named(here: Path, capsys: Any) -> None:
    Path("edits.yaml").write_text(
        "- {change: changed, kind: joint, name: nosuch, owner: body 'hand', field: q, after: 1.0}\n"
    )
    assert apply() == 0
    said = capsys.readouterr().err
    assert "warning[edit-left-out]: joint 'nosuch' of body 'hand': initial position" in said


@pytest.mark.parametrize("text", ["a: [", "- nothing", "- {change: added, kind: body, name: a}"])
def test_what_is_no_file_of_edits(text: str, here: Path, capsys: Any) -> None:
    Path("edits.yaml").write_text(text)
    assert apply() == 2
    assert "error[edits-unreadable]" in capsys.readouterr().err


JOINT = "kind: joint, name: wrist_roll, owner: body 'hand'"


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (f"changed, {JOINT}, field: q, after: '1'", "initial position none -> 1: Expected"),
        (f"changed, {JOINT}, field: q, after: true", "got `bool`"),
        (f"changed, {JOINT}, field: actuated, after: 'yes'", "Expected `bool`, got `str`"),
        (f"changed, {JOINT}, field: symbols, after: q", "Expected `array | null`, got `str`"),
        (f"changed, {JOINT}, field: origin, after: 3", "got `int`"),
        (f"renamed, {JOINT}, before: wrist_roll, after: 3", "Expected `str`, got `int`"),
        ("changed, kind: body, name: hand, field: drawing.position, after: [1]", "length 2"),
        ("changed, kind: view, name: '', field: background, after: [1.5, 2, 3]", "`int`"),
        (f"changed, {JOINT}, field: q, afer: 1", "unknown field `afer`"),
        ("changed, kind: point, name: hand, owner: body 'pitch', field: coordinates", "got `null`"),
        ("removed, kind: model, name: arm", "no 'model' can be removed"),
        ("removed, kind: base, name: ground", "no 'base' can be removed"),
    ],
)
def test_a_value_of_another_type_is_refused(made: str, said: str, here: Path, capsys: Any) -> None:
    Path("edits.yaml").write_text(f"- {{change: {made}}}\n")
    assert apply() == 2
    message = capsys.readouterr().err
    assert "edits.yaml: error[edits-unreadable]" in message
    assert said in message
    assert not Path("again.mbs").exists()


def test_a_number_may_have_no_point(here: Path) -> None:
    Path("edits.yaml").write_text(f"- {{change: changed, {JOINT}, field: q, after: 1e-3}}\n")
    assert apply() == 0
    assert read(Path("again.mbs").read_bytes(), "").joints()["wrist_roll"].q == 0.001


def test_without_a_base_there_are_no_edits(here: Path, capsys: Any) -> None:
    assert main(["run", "arm.yaml", "-q"]) == 0
    Path("arm.mbs.base").unlink()
    assert main(["edits", "arm.mbs"]) == 2
    assert "error[edits-no-base]" in capsys.readouterr().err


def test_names_follow_edits_and_what_was_otherwise_or_is_unknown_is_told(here: Path) -> None:
    body = "kind: body, name: upper_arm"
    for text, codes, mass, called, edited in (
        (f"- {{change: renamed, {body}, field: name, before: upper_arm, after: bone}}\n"
         f"- {{change: changed, {body}, field: mass, before: 1.0, after: 9.0}}\n",
         ["merge-conflict-won"], 9.0, "bone", ["edits.yaml"]),
        (f"- {{change: changed, {body}, field: mass, before: 3.2, after: 9.0}}\n",
         [], 9.0, "upper_arm", ["edits.yaml"]),
        (f"- {{change: changed, {body}, field: colour, before: 1.0, after: 9.0}}\n",
         ["edit-left-out"], 3.2, "upper_arm", []),
        ("- {change: renamed, kind: joint, name: shoulder_origin_R2, owner: body 'upper_arm', "
         "field: name, before: shoulder_origin_R2, after: tilt}\n",
         [], 3.2, "tilt", ["edits.yaml"]),
    ):  # fmt: skip
        Path("edits.yaml").write_text(text)
        result = convert(
            CONFIGS / "arm.urdf.xacro", passes={"apply-edits": {"file": here / "edits.yaml"}}
        )
        told = [found.code for found in result.diagnostics]
        assert [code for code in told if code in ("merge-conflict-won", "edit-left-out")] == codes
        assert list(result.conversion.edited) == edited
        bodies = {body.name: body.mass for body in read(result.data, "arm.mbs").bodies}
        assert mass == bodies["bone" if called == "bone" else "upper_arm"]
        names = (result.names.bodies["upper_arm"], *result.names.joints["shoulder"])
        assert called in names
