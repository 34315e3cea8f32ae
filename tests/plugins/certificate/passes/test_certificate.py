"""The certificate beside an .mbs: its content, when it is written, and when it is removed."""

import json
from pathlib import Path
from typing import Any

import pytest

from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.engine.output import plan
from urdf2mbs.testing import TINY

ALWAYS = {"certificate": {"write": "always"}}


def certificate(result: Any) -> dict[str, Any]:
    path = result.conversion.settings.output.with_suffix(".proof.json")
    data: dict[str, Any] = json.loads(result.conversion.files[path])
    return data


def test_it_has_what_neither_file_has(tiny: Path) -> None:
    tiny.write_text(TINY.replace("0 0.5 0", "0 0.7854 0"))
    passes = {**ALWAYS, "snap": {"angle": 0.001}}
    content = certificate(convert(tiny, passes=passes, gravity=[0, 0, -1.62]))
    assert content["joints"]["shoulder"] == ["shoulder"]
    assert len(content["joints"]["floating_base"]) == 6
    assert content["gravity"] == [0.0, 0.0, -1.62]
    assert content["passes"] == {"snap": {"angle": 0.001}}
    assert ["joint", "shoulder"] in [owner for owner, _ in content["changes"]]
    assert content["edited"] == []


def test_the_same_robot_elsewhere_has_the_same_certificate(tmp_path: Path) -> None:
    certificates = []
    for folder in (tmp_path / "a", tmp_path / "b" / "c"):
        folder.mkdir(parents=True)
        (folder / "tiny.urdf").write_text(TINY)
        certificates.append(certificate(convert(folder / "tiny.urdf", passes=ALWAYS)))
    assert certificates[0] == certificates[1]
    assert str(tmp_path) not in json.dumps(certificates)


def test_a_lone_file_has_one_if_asked_for(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output=tmp_path / "tiny.mbs").write()
    assert not list(tmp_path.glob("*.proof.json"))
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    assert (tmp_path / "tiny.proof.json").is_file()


def test_an_outdated_one_is_removed_unless_it_was_edited(tiny: Path, tmp_path: Path) -> None:
    path = tmp_path / "tiny.proof.json"
    for settings in ({"passes": {"certificate": {"write": "never"}}}, {"without": ["check"]}):
        convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
        later = convert(tiny, output=tmp_path / "tiny.mbs", **settings)
        assert plan(later.conversion)["removed"] == [path]
        later.write()
        assert not path.exists()
    path.write_text("mine\n")
    convert(tiny, output=tmp_path / "tiny.mbs").write()
    assert path.read_text() == "mine\n"


def test_a_rejected_file_has_none_and_the_good_one_keeps_its(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    good = (tmp_path / "tiny.proof.json").read_bytes()
    heavy = write_plugin(
        tmp_path, "heavy", "conversion.mbs.bodies[1].mass *= 2", reads=("inertias",)
    )
    convert(
        tiny,
        output=tmp_path / "tiny.mbs",
        passes=ALWAYS,
        plugins=[heavy],
        after={"reframe-inertia": "heavy"},
    ).write()
    assert (tmp_path / "tiny.rejected.mbs").exists()
    assert [*tmp_path.glob("*.proof.json")] == [tmp_path / "tiny.proof.json"]
    assert (tmp_path / "tiny.proof.json").read_bytes() == good


@pytest.mark.parametrize(("was", "now"), [("0 0 0.3", "0, 0, 0.3"), ("<?xml", " <?xml")])
def test_an_error_that_the_reader_repairs_is_accepted(was: str, now: str, tiny: Path) -> None:
    """The replay may refuse such a URDF, but its certificate is written."""
    tiny.write_text(TINY.replace(was, now))
    assert certificate(convert(tiny, passes=ALWAYS))["joints"]
