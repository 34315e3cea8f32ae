"""The core stands alone: its commands work, with the same bytes, where a plugin of ours is away."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.folders import TESTS
from urdf2mbs.engine.entry_points import find_own_plugins
from urdf2mbs.testing import TINY

#: The names of our own plugins.
OWN = sorted(find_own_plugins(tuple(sys.path)))

#: Calls the commands of the core, without the plugins that are named.
PROGRAM = """
from urdf2mbs.cli import main
for words in ("convert plain.urdf", "run plain.yaml", "verify plain.urdf plain.mbs",
              "verify plain.urdf plain.urdf"):
    assert main(words.split()) == 0, words
main(["--help"])
"""


def environment(away: str) -> dict[str, str]:
    start = str(TESTS / "support" / "start")
    folders = os.pathsep.join([start, os.environ["PYTHONPATH"]])
    return {**os.environ, "PYTHONPATH": folders, "URDF2MBS_WITHOUT": away}


def files_of(folder: Path, away: str) -> tuple[dict[str, bytes], str]:
    """The models that the commands write, and the help."""
    folder.mkdir()
    (folder / "plain.urdf").write_text(TINY)
    (folder / "plain.yaml").write_text("source: plain.urdf\noutput: run.mbs\n")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=folder,
        env=environment(away),
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return {file.name: file.read_bytes() for file in folder.glob("*.mbs")}, done.stdout


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return files_of(tmp_path_factory.mktemp("whole") / "all", "")[0]


@pytest.mark.parametrize(
    "away", ["all", *(pytest.param(name, marks=pytest.mark.slow) for name in OWN)]
)
def test_the_commands_of_the_core_need_no_plugin(
    away: str, whole: dict[str, bytes], tmp_path: Path
) -> None:
    models, said = files_of(tmp_path / "some", away)
    assert models.keys() == {"plain.mbs", "run.mbs"}
    assert models == whole
    for command in ("run", "convert", "verify"):
        assert f"  {command} " in said


@pytest.mark.parametrize(
    ("plugin", "inside", "says"),
    [
        ("project", "", "error[plugin-missing]: no plugin writes the code of a Robotran project"),
        ("xacro", "<xacro:arm/>", "is xacro, for which the plugin 'xacro' is missing\n  install"),
    ],
)
def test_work_without_its_plugin_is_an_error(
    plugin: str, inside: str, says: str, tmp_path: Path
) -> None:
    xmlns = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    text = TINY.replace("</robot>", f"{inside}</robot>").replace("<robot ", f"<robot {xmlns} ")
    (tmp_path / "plain.urdf").write_text(text)
    done = subprocess.run(
        [sys.executable, "-m", "urdf2mbs", "convert", "plain.urdf", "-o", "p/"],
        cwd=tmp_path,
        env=environment(plugin),
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    assert says in done.stderr
    assert not (tmp_path / "p").exists()


@pytest.mark.slow
@pytest.mark.parametrize("away", ["equations", "meshes", "project", "report"])
def test_the_tests_of_the_core_need_no_plugin(away: str, tmp_path: Path) -> None:
    """Those of the rooms that see plugins, without a plugin that others need; `.ci/run` runs all of
    them without any plugin."""
    folders = [str(TESTS / room) for room in ("commands", "config", "engine")]
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-m",
            "not slow",
            "-p",
            "no:cacheprovider",
            f"--basetemp={tmp_path}",
            *folders,
            f"--ignore={Path(__file__).resolve()}",
        ],
        cwd=TESTS.parent,
        env=environment(away),
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
