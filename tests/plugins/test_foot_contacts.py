"""plugins/urdf2mbs-foot-contacts, used as it is when installed."""

from __future__ import annotations

import json
import shutil
import sys
from importlib import metadata
from math import cos, sin
from pathlib import Path
from typing import Any

import pytest
from installed import FOOT_CONTACTS, install

from urdf2mbs.cli import main
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.plugins import _installed as installed_plugins
from urdf2mbs.mbs.model import Body, Point
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, assert_same_robot, convert_text, run_pass

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.usefixtures("foot_contacts_installed")


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "urdf2mbs_foot_contacts", raising=False)


def contacts(robot: str = TINY, **options: Any) -> Any:
    return run_pass("foot-contacts", after="collect-anchors", options=options, robot=robot)


def body(result: Any, name: str) -> Body:
    found: Body = next(body for body in result.mbs.bodies if body.name == name)
    return found


def added(result: Any, name: str) -> list[Point]:
    return [point for point in body(result, name).points if "_contact_" in point.name]


def test_corners_of_the_collision_box() -> None:
    result = contacts(links=["hand"])
    x, y = 0.03, 0.02
    assert [point.coordinates for point in added(result, "hand")] == [
        (x, y, 0.0), (x, -y, 0.0), (-x, -y, 0.0), (-x, y, 0.0),
    ]  # fmt: skip
    assert_same_robot(result, expected=convert_text())


def test_force_and_sensor_are_in_the_file() -> None:
    mbs = read(contacts(links=["hand"]).data, "x.mbs")
    point = next(p for b in mbs.bodies for p in b.points if p.name == "hand_contact_2")
    assert point.extforce is not None
    assert point.sensor is not None
    assert (point.extforce.name, point.sensor.name) == (
        "hand_contact_2_force", "hand_contact_2_sensor",
    )  # fmt: skip
    assert set(point.extforce.measures) == {"Pos", "Rot", "Vit", "Om", "Acc", "Omp"}
    assert set(point.sensor.measures) == {"Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac"}
    assert point.position is not None
    assert all(p.sensor is p.extforce is None for p in mbs.base.points)


def test_without_sensors() -> None:
    assert all(p.sensor is None for p in added(contacts(links=["hand"], sensor=False), "hand"))


@pytest.mark.parametrize(
    ("down", "corner"),
    [("+z", (0.03, 0.02, 0.1)), ("-x", (-0.03, 0.02, 0.1)), ("+y", (0.03, 0.02, 0.1))],
)
def test_down_is_a_direction_of_the_link(down: str, corner: tuple[float, ...]) -> None:
    first = added(contacts(links=["hand"], down=down), "hand")[0]
    assert first.coordinates == pytest.approx(corner)


def test_a_turned_box() -> None:
    """The face that looks down most, its corners where the turn puts them."""
    text = TINY.replace(
        '<origin xyz="0 0 0.05"/>\n      <geometry><box',
        '<origin xyz="0 0 0.05" rpy="0.3 0 0"/>\n      <geometry><box',
    )
    assert text != TINY
    first = added(contacts(text, links=["hand"]), "hand")[0].coordinates
    y, z = 0.02, -0.05
    expected = (0.03, cos(0.3) * y - sin(0.3) * z, 0.05 + sin(0.3) * y + cos(0.3) * z)
    assert first == pytest.approx(expected)


def test_a_box_upside_down() -> None:
    """Its face that looks down is the one that it calls up."""
    text = TINY.replace(
        '<origin xyz="0 0 0.05"/>\n      <geometry><box',
        '<origin xyz="0 0 0.05" rpy="3.141592653589793 0 0"/>\n      <geometry><box',
    )
    points = added(contacts(text, links=["hand"]), "hand")
    assert [point.coordinates[2] for point in points] == pytest.approx([0.0] * 4)


def test_given_corners_on_a_massless_link_move_to_its_body() -> None:
    """``tool`` is fixed to ``hand``, 0.1 m up and pitched by 90 degrees."""
    result = contacts(links=["tool"], corners=[[0.02, 0.0, 0.0], [0.0, 0.01, 0.0]])
    points = added(result, "hand")
    assert [point.name for point in points] == ["tool_contact_1", "tool_contact_2"]
    assert points[0].coordinates == pytest.approx((0.0, 0.0, 0.08), abs=1e-5)
    assert points[1].coordinates == pytest.approx((0.0, 0.01, 0.1), abs=1e-5)


def test_nothing_on_the_base() -> None:
    with pytest.raises(ConfigError, match="link 'ground' is the base"):
        contacts(links=["ground"], corners=[[0, 0, 0]])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"links": ["foot*"]}, "no link is called 'foot\\*'"),
        ({"links": ["arm"]}, "link 'arm' has no box"),
        ({"links": ["hand"], "down": "z"}, "down is 'z'\n.*-z"),
        ({}, "'passes.foot-contacts.links' must be given\n.*add 'links: ...'"),
        ({"links": ["hand"], "corners": [[1, 2]]}, "corners.*a list of 3"),
    ],
)
def test_what_cannot_be_meant_is_an_error(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        contacts(**options)
    import re

    assert re.search(said, str(caught.value)), str(caught.value)


def test_a_link_without_a_body_is_an_error() -> None:
    with pytest.raises(ConfigError, match="'wrist' moves with a joint only"):
        contacts(links=["wrist"], corners=[[0, 0, 0]])


def test_too_late_is_an_error() -> None:
    with pytest.raises(
        ConfigError, match=r"'foot-contacts' changes the anchors after pass 'time-step' has made"
    ):
        run_pass("foot-contacts", after="layout", options={"links": ["hand"]})


def test_the_biped_from_the_command_line(tmp_path: Path, capsys: Any) -> None:
    output = tmp_path / "biped.mbs"
    command = [
        "convert", str(ROOT / "configs" / "biped.urdf.xacro"), "-o", str(output), "--json",
        "--after", "collect-anchors=foot-contacts", "--set", "foot-contacts.links=*_foot",
    ]  # fmt: skip
    assert main(command) == 0
    report = json.loads(capsys.readouterr().out)
    assert list(report["passes"]["foot-contacts"]) == ["left_foot", "right_foot"]
    names = {p.name for b in read(output.read_bytes(), "").bodies for p in b.points}
    told = [p["name"] for points in report["passes"]["foot-contacts"].values() for p in points]
    assert len(told) == 8
    assert names.issuperset(told)
    assert report["proof"]["same"] is True


def test_explain_says_which_package(tmp_path: Path, capsys: Any) -> None:
    assert main(["passes"]) == 0
    out = capsys.readouterr().out
    assert "foot-contacts of urdf2mbs-foot-contacts 0.1.0 (" in out
    assert "urdf2mbs_foot_contacts.py)" in out


def test_no_plugins_leaves_it_out(tmp_path: Path, capsys: Any) -> None:
    assert main(["passes", "--no-plugins"]) == 0
    assert "foot-contacts" not in capsys.readouterr().out
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "c.yaml").write_text("source: tiny.urdf\nafter: {collect-anchors: foot-contacts}\n")
    assert main(["explain", "--no-plugins", str(tmp_path / "c.yaml")]) == 2
    assert "c.yaml:2: error[unknown-pass]: there is no pass 'foot-contacts'" in (
        capsys.readouterr().err
    )


def test_an_installed_plugin_that_is_broken_names_its_package(tmp_path: Path, capsys: Any) -> None:
    module = tmp_path / "site-packages" / "urdf2mbs_foot_contacts.py"
    for text in ("import nosuch\n", "import sys\nsys.exit()\n"):
        module.write_text(text + "#" * len(text) * 7)
        assert main(["passes"]) == 0
        err = capsys.readouterr().err
        assert (
            "warning[plugin-broken]: the installed plugin 'foot-contacts' "
            "(package urdf2mbs-foot-contacts 0.1.0) is left out: it cannot be loaded"
        ) in err
        assert "--no-plugins" in err
        assert main(["passes", "--no-plugins"]) == 0
        assert capsys.readouterr().err == ""
        sys.modules.pop("urdf2mbs_foot_contacts", None)


HOOK = "from making import hookimpl, make\n"


@pytest.mark.parametrize(
    "text",
    [
        "import nosuch\n",
        "",
        HOOK + "@hookimpl\ndef urdf2mbs_pass(): pass\n",
        HOOK + "@hookimpl\ndef urdf2mbs_passes(): 1 / 0\n",
        HOOK + "@hookimpl\ndef urdf2mbs_passes(): return [make('a', print), make('', print)]\n",
    ],
)
def test_a_broken_installed_plugin_blocks_nothing(
    text: str, tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "urdf2mbs_foot_contacts", raising=False)
    (tmp_path / "site-packages" / "urdf2mbs_foot_contacts.py").write_text(text)
    (tmp_path / "tiny.urdf").write_text(TINY)
    config = tmp_path / "c.yaml"
    config.write_text("source: tiny.urdf\n")
    for command in ("run", "explain"):
        assert main([command, str(config)]) == 0
        err = capsys.readouterr().err
        assert err.count("warning[plugin-broken]: the installed plugin 'foot-contacts'") == 1
    assert set(Plugins().passes) == set(Plugins(installed=False).passes)
    assert [found.code for found in convert_text().diagnostics].count("plugin-broken") == 1
    # what the config asks of it is an error, which says why
    config.write_text("source: tiny.urdf\nafter: {expand: foot-contacts}\n")
    assert main(["run", str(config)]) == 2
    err = capsys.readouterr().err
    assert "error[unknown-pass]: there is no pass 'foot-contacts'" in err
    assert "the installed plugin 'foot-contacts' (package urdf2mbs-foot-contacts 0.1.0)" in err


def test_installed_plugins_are_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    Plugins()
    calls: list[str] = []
    monkeypatch.setattr(metadata, "entry_points", lambda **_: calls.append("entry points"))
    monkeypatch.setattr(metadata, "version", lambda _: calls.append("version"))
    monkeypatch.setattr(
        metadata.Distribution, "metadata", property(lambda _: calls.append("metadata"))
    )
    Plugins()
    assert calls == []


def test_a_package_that_only_importlib_metadata_can_see_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a zip file on the path, and by a finder of its own on ``sys.meta_path``."""
    folder = install(FOOT_CONTACTS, tmp_path / "elsewhere")
    packed = shutil.make_archive(str(tmp_path / "packed"), "zip", folder)
    found = metadata.Distribution.at(folder / "urdf2mbs_foot_contacts-0.1.0.dist-info")

    class Finder:
        def find_spec(self, *_: object) -> None:
            return None

        def find_distributions(self, *_: object) -> list[metadata.Distribution]:
            return [found]

    def seen() -> set[str]:
        installed_plugins.cache_clear()
        return {entry.name for entry, _ in installed_plugins(tuple(sys.path))}

    monkeypatch.setattr(sys, "path", [path for path in sys.path if str(tmp_path) not in path])
    assert "foot-contacts" not in seen()
    with monkeypatch.context() as patch:
        patch.syspath_prepend(packed)
        assert "foot-contacts" in seen()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "meta_path", [*sys.meta_path, Finder()])
        assert "foot-contacts" in seen()
    installed_plugins.cache_clear()
