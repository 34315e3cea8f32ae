"""Hooks by which anybody's plugin takes part in lint, doctor, verify and the names of Python."""

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

import urdf2mbs
from support.installed import install_file
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY

PLUGIN = """
from contextlib import contextmanager

from urdf2mbs.plugin import Intent, hookimpl


def weigh(robot):
    return sum(link.inertial.mass for link in robot.links.values() if link.inertial)


@hookimpl
def urdf2mbs_api():
    return {"weigh_links": f"{__name__}:weigh"}


@hookimpl
def urdf2mbs_find_faults(conversion):
    for link in conversion.robot.links.values():
        if link.inertial and link.inertial.mass > 1:
            conversion.warn("too-heavy", "this lab lifts no more than 1 kg", link=link.name)


@hookimpl
def urdf2mbs_doctor():
    return {"crane": "out of order"}


@hookimpl
def urdf2mbs_observe_verify(robot, arguments):
    return observe(robot)


@contextmanager
def observe(robot):
    def take(verdict):
        print(f"{robot}: {len(verdict.differences)} differences")
        return True

    yield take


@hookimpl
def urdf2mbs_intent(model):
    return Intent(passes={"estimate-inertia": {"density": 1000.0}})
"""


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a robot and its model; the plugin is installed."""
    site = tmp_path / "site"
    (tmp_path / "lab_hooks.py").write_text(PLUGIN)
    install_file(site, tmp_path / "lab_hooks.py")
    monkeypatch.chdir(tmp_path)
    Path("tiny.urdf").write_text(TINY)
    assert main(["convert", "tiny.urdf", "-q"]) == 0
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "lab_hooks", raising=False)
    importlib.invalidate_caches()
    return tmp_path


def test_lint_asks_the_plugins_for_faults(lab: Path, capsys: Any) -> None:
    assert main(["lint", "tiny.urdf"]) == 0
    assert "warning[too-heavy]: this lab lifts no more than 1 kg" in capsys.readouterr().out
    assert main(["lint", "tiny.urdf", "--no-plugins"]) == 0
    assert "too-heavy" not in capsys.readouterr().out


def test_doctor_shows_the_lines_of_plugins(lab: Path, capsys: Any) -> None:
    assert main(["doctor"]) == 0
    assert "out of order" in capsys.readouterr().out


def test_a_plugin_may_print_the_verdict(lab: Path, capsys: Any) -> None:
    assert main(["verify", "tiny.urdf", "tiny.mbs"]) == 0
    assert capsys.readouterr().out == "tiny.urdf: 0 differences\n"
    assert main(["verify", "tiny.urdf", "tiny.mbs", "--no-plugins"]) == 0
    assert "joints match by name" in capsys.readouterr().out


def test_a_plugin_knows_what_was_changed_on_purpose(lab: Path) -> None:
    text = TINY.replace("</robot>", "")
    text += (
        '<link name="box"><collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>'
        '<joint name="to_box" type="continuous"><parent link="hand"/><child link="box"/></joint>'
        "</robot>"
    )
    Path("box.urdf").write_text(text)
    options = {"estimate-inertia": {"density": 1000.0}}
    urdf2mbs.convert("box.urdf", passes=options).write()
    verdict = urdf2mbs.verify("box.urdf", "box.mbs")
    assert verdict.same, verdict.differences
    assert any("estimate-inertia" in reason for reason in verdict.but_for)


def test_names_of_plugins_are_names_of_the_package(lab: Path) -> None:
    robot = urdf2mbs.convert("tiny.urdf").robot
    try:
        assert urdf2mbs.weigh_links(robot) > 0  # type: ignore[attr-defined]
    finally:
        vars(urdf2mbs).pop("weigh_links", None)
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = urdf2mbs.no_such_name  # type: ignore[attr-defined]
