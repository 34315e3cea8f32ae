"""The certificate beside an .mbs: what stands in it, where there is one, and when it goes."""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert
from urdf2mbs.disk.output import plan
from urdf2mbs.testing import TINY

BIPED = Path(__file__).parents[2] / "configs" / "biped.urdf.xacro"
ALWAYS = {"certificate": {"write": "always"}}


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    source = tmp_path / "tiny.urdf"
    source.write_text(TINY)
    return source


def certificate(project: Path) -> dict[str, Any]:
    (found,) = (project / "dataR").glob("*.proof.json")
    data: dict[str, Any] = json.loads(found.read_text())
    return data


def test_it_is_a_statement_of_in_toto_about_every_file_made(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output={"project": tmp_path / "p", "language": ["python", "c"]}).write()
    said = certificate(tmp_path / "p")
    assert said["_type"] == "https://in-toto.io/Statement/v1"
    assert said["predicateType"] == "https://in-toto.io/attestation/test-result/v0.1"
    predicate = said["predicate"]
    assert predicate["result"] == "PASSED"
    assert predicate["configuration"][0]["name"] == "tiny.urdf"
    for file in said["subject"]:
        data = (tmp_path / "p" / file["name"]).read_bytes()
        assert file["digest"] == {"sha256": hashlib.sha256(data).hexdigest()}, file["name"]
    names = [file["name"] for file in said["subject"]]
    assert names[0] == "dataR/p.mbs"
    assert {"userfctR/p_robot.py", "userfctR/p_robot.c"} <= {*names}
    (source,) = predicate["configuration"]
    assert source["digest"]["sha256"] == hashlib.sha256(tiny.read_bytes()).hexdigest()


def test_a_merged_file_is_certified_as_it_is_written(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output={"project": tmp_path / "p"}).write()
    model = tmp_path / "p" / "dataR" / "p.mbs"
    model.write_text(re.sub(r"<x>\d+\.0</x>", "<x>77.0</x>", model.read_text(), count=1))
    convert(tiny, output={"project": tmp_path / "p"}).write()
    assert "<x>77.0</x>" in model.read_text()
    assert certificate(tmp_path / "p")["subject"][0] == {
        "name": "dataR/p.mbs",
        "digest": {"sha256": hashlib.sha256(model.read_bytes()).hexdigest()},
    }


def test_the_plan_names_one_that_goes(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    later = convert(tiny, output=tmp_path / "tiny.mbs")
    assert plan(later.conversion)["removed"] == [tmp_path / "tiny.proof.json"]


def test_it_has_the_numbers_of_each_rigid_group(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output={"project": tmp_path / "p"}).write()
    groups = {
        group["coordinate"]: group
        for group in certificate(tmp_path / "p")["predicate"]["urdf2mbs"]["groups"]
    }
    said = certificate(tmp_path / "p")["predicate"]["urdf2mbs"]
    assert list(said["versions"]) == ["urdf2mbs"]
    assert said["changed"] == []
    shoulder = groups["shoulder"]
    assert shoulder["parent"] == "floating_base[R3]"
    assert (shoulder["mbs"], shoulder["turns"]) == ("shoulder", True)
    assert shoulder["axis"] == [0.0, 0.0, 1.0]
    assert shoulder["mass"] == 0.5
    assert 0.0 <= shoulder["deviation"] < 1e-12
    assert [row[3] for row in shoulder["place"]] == [0.1, 0.0, 0.15, 1.0]


def test_the_same_robot_elsewhere_has_the_same_certificate(tmp_path: Path) -> None:
    texts = []
    for folder in (tmp_path / "a", tmp_path / "b" / "c"):
        folder.mkdir(parents=True)
        robot = folder / "robot.urdf.xacro"
        robot.write_bytes(BIPED.read_bytes())
        result = convert(
            robot, output={"project": folder / "p"}, packages={"none": folder},
            plugins=[str(_nothing(folder))], after={"expand": "nothing"},
        )  # fmt: skip
        (path,) = (path for path in result.conversion.files if path.name.endswith(".proof.json"))
        texts.append(result.conversion.files[path])
        versions = json.loads(texts[-1])["predicate"]["urdf2mbs"]["versions"]
        assert sorted(versions) == ["urdf2mbs", "xacro"]
        assert str(tmp_path).encode() not in texts[-1]
    assert texts[0] == texts[1]


def _nothing(folder: Path) -> Path:
    plugin = folder / "nothing.py"
    plugin.write_text(
        "from making import hookimpl, make\n"
        "@hookimpl\ndef urdf2mbs_passes():\n"
        "    return [make('nothing', lambda conversion, options: None)]\n"
    )
    return plugin


def test_what_a_plugin_changed_is_named(tiny: Path, tmp_path: Path) -> None:
    (tmp_path / "heavy.py").write_text(
        "from making import hookimpl, make\n"
        "def run(conversion, options):\n"
        "    conversion.robot.links['arm'].inertial.mass *= 2\n"
        "@hookimpl\ndef urdf2mbs_passes():\n"
        "    return [make('heavy', run, writes=('robot',))]\n"
    )
    convert(
        tiny,
        output={"project": tmp_path / "p"},
        plugins=[tmp_path / "heavy.py"],
        after={"expand": "heavy"},
    ).write()
    predicate = certificate(tmp_path / "p")["predicate"]
    assert predicate["result"] == "WARNED"
    assert "heavy (plugin 'heavy') changed of the robot" in predicate["urdf2mbs"]["changed"][0]
    assert predicate["urdf2mbs"]["options"]["plugins"] == ["heavy.py"]


@pytest.mark.skipif(sys.platform != "linux", reason="the system has no such names of files")
def test_a_name_of_a_file_may_be_no_text(tiny: Path, tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"odd\xff.urdf")
    odd.write_text(TINY)
    convert(odd, output={"project": tmp_path / "p"}).write()
    (source,) = certificate(tmp_path / "p")["predicate"]["configuration"]
    assert source["name"] == odd.name


def test_a_lone_file_has_one_if_asked_for(tiny: Path, tmp_path: Path) -> None:
    convert(tiny, output=tmp_path / "tiny.mbs").write()
    assert not list(tmp_path.glob("*.proof.json"))
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    said = json.loads((tmp_path / "tiny.proof.json").read_text())
    assert [file["name"] for file in said["subject"]] == ["tiny.mbs"]


def test_one_that_fits_no_more_goes_unless_it_was_edited(tiny: Path, tmp_path: Path) -> None:
    path = tmp_path / "tiny.proof.json"
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    convert(
        tiny, output=path.with_name("tiny.mbs"), passes={"certificate": {"write": "never"}}
    ).write()
    assert not path.exists()
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    convert(tiny, output=path.with_name("tiny.mbs"), without=["check"]).write()
    assert not path.exists()
    path.write_text("mine\n")
    convert(tiny, output=tmp_path / "tiny.mbs").write()
    assert path.read_text() == "mine\n"


def test_a_rejected_file_has_none_and_the_good_one_keeps_its_own(
    tiny: Path, tmp_path: Path
) -> None:
    convert(tiny, output=tmp_path / "tiny.mbs", passes=ALWAYS).write()
    good = (tmp_path / "tiny.proof.json").read_bytes()
    (tmp_path / "heavy.py").write_text(
        "from making import hookimpl, make\n"
        "def run(conversion, options):\n"
        "    conversion.mbs.bodies[1].mass *= 2\n"
        "@hookimpl\ndef urdf2mbs_passes():\n"
        "    return [make('heavy', run, reads=('inertias',))]\n"
    )
    convert(
        tiny,
        output=tmp_path / "tiny.mbs",
        passes=ALWAYS,
        plugins=[tmp_path / "heavy.py"],
        after={"reframe-inertia": "heavy"},
    ).write()
    assert (tmp_path / "tiny.rejected.mbs").exists()
    assert sorted(tmp_path.glob("*.proof.json")) == [tmp_path / "tiny.proof.json"]
    assert (tmp_path / "tiny.proof.json").read_bytes() == good


@pytest.mark.parametrize(("was", "now"), [("0 0 0.3", "0, 0, 0.3"), ("<?xml", " <?xml")])
def test_a_slip_that_the_reader_mends_is_no_error(
    was: str, now: str, tiny: Path, tmp_path: Path
) -> None:
    """The replay cannot read such a URDF, but its certificate is written."""
    tiny.write_text(TINY.replace("0 0.5 0", "0 0.7854 0").replace(was, now))
    convert(tiny, output={"project": tmp_path / "p"}, passes={"snap": {"angle": 0.001}}).write()
    predicate = certificate(tmp_path / "p")["predicate"]
    assert ["joint", "shoulder", "origin"] in [
        where for where, *_ in predicate["urdf2mbs"]["changes"]
    ]
