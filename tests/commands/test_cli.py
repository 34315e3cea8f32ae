"""The commands: what they print, write and return."""

import contextlib
import json
import os
import subprocess
import sys
from argparse import Namespace
from importlib.metadata import version
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from support import build
from support.processes import loaded
from urdf2mbs.cli import main
from urdf2mbs.commands.progress import Progress, estimate_end
from urdf2mbs.config.load import load
from urdf2mbs.disk.version import find_version
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.hookspecs import hookimpl
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.testing import TINY


@pytest.fixture
def folder(here: Path) -> Path:
    """A folder with a tiny robot and its config, which is where we are."""
    (here / "tiny.yaml").write_text("source: tiny.urdf\n")
    return here


def test_run_says_in_three_lines_what_it_wrote(folder: Path, capsys: Any) -> None:
    assert main(["run", "tiny.yaml"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [
        "tiny: written to tiny.mbs (floating base, 3 bodies, 9 independent joints, 2.6 kg)",
        "  the same robot; 1 warning, 4 notes (-v shows the notes)",
        "Next: open tiny.mbs in MBSysPad, or draw it: urdf2mbs diagram tiny.mbs",
    ]
    assert "warning[base-guessed]" in said.err
    assert "note[" not in said.err
    assert len(read_mbs((folder / "tiny.mbs").read_bytes(), "").bodies) == 3
    assert {file.name for file in folder.iterdir()} - {"tiny.mbs.base"} == {
        ".urdf2mbs",
        "tiny.mbs",
        "tiny.urdf",
        "tiny.yaml",
    }
    assert main(["run", "-v", "tiny.yaml"]) == 0
    said = capsys.readouterr()
    assert " ms  decompose-joints\n" in said.err
    assert "note[collision]" in said.err
    assert "  5 links -> 3 bodies, " in said.out


def test_warnings_of_one_cause_are_one_line(folder: Path, capsys: Any) -> None:
    """Warnings of one code are one, a text that is nowhere has no lines."""
    names = ("dynamic", "limits", "axs", "mimc", "orign", "safty_controller", "calibraton")
    wrong = "".join(
        f'<link name="l_{name}"/><joint name="j_{name}" type="fixed"><parent link="tool"/>'
        f'<child link="l_{name}"/><{name}/></joint>'
        for name in names
    )
    (folder / "tiny.urdf").write_text(TINY.replace("</robot>", f"{wrong}</robot>"))
    assert main(["convert", "tiny.urdf", "-o", "a.mbs"]) == 0
    said = capsys.readouterr()
    first, *others = [line for line in said.err.splitlines() if "warning[" in line]
    assert "-v shows the notes" in said.out
    assert first.startswith("tiny.urdf:")
    assert "warning[misspelt]" in first
    assert "orign" in first
    assert "safty" not in first
    assert "and 2 more (-v shows them)" in first
    assert "misspelt" not in "".join(others)
    assert main(["convert", "tiny.urdf", "-o", "a.mbs", "-v"]) == 0
    assert capsys.readouterr().err.count("warning[misspelt]") == 7


def test_json_has_names_numbers_and_messages(folder: Path, capsys: Any) -> None:
    assert main(["run", "--json", "tiny.yaml"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["names"]["coordinates"]["wrist_pitch"] == ["wrist_pitch"]
    assert report["numbers"]["floating_base_T1"] == 1
    assert report["left_out"] == {}  # limits and damping are in user models
    assert {found["code"] for found in report["diagnostics"]} >= {"collision", "joint-dynamics"}


def test_help_imports_no_heavy_package() -> None:
    heavy = {"numpy", "lxml", "yaml", "xacro", "urdf2mbs.conversion"}
    assert loaded("from urdf2mbs.cli import main; main(['--help'])") & heavy == set()


@pytest.mark.parametrize(
    ("program", "most"),
    [
        ("from urdf2mbs import convert", 75),
        ("import urdf2mbs; urdf2mbs.convert('plain.urdf').write()", 150),
    ],
)
def test_a_conversion_starts_fast(program: str, most: int, folder: Path) -> None:
    """It imports few modules of ours, no numpy, and starts no other process."""
    (folder / "plain.urdf").write_text(build.robot(build.link("a", build.solid())))
    modules = loaded(program) - loaded("import lxml.etree, msgspec, pluggy, pluggy._manager")
    ours = {name for name in modules if name.startswith("urdf2mbs")}
    assert len(ours) <= most
    others = {name.split(".")[0] for name in modules - ours} - sys.stdlib_module_names
    assert others == set()
    assert modules & {"ctypes", "multiprocessing", "concurrent.futures", "subprocess"} == set()


class Ear:
    """Standard error, which lets a run go on when it has heard where the run is."""

    def __init__(self) -> None:
        self.text = ""
        self.heard = Event()

    def write(self, text: str) -> None:
        self.text += text
        if "at the end" in self.text:
            self.heard.set()

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Any, conversion: Any) -> None:
        if pass_.name == "emit":
            conversion.progress("at the end")
            assert self.heard.wait(10.0)


@pytest.mark.parametrize("verbose", [False, True])
def test_a_run_that_lasts_says_where_it_is(
    verbose: bool, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ear = Ear()
    monkeypatch.setattr(sys, "stderr", ear)
    monkeypatch.setattr(Progress, "LOG_PATIENCE", 0.001)
    pipeline = Pipeline(*load(folder / "tiny.yaml"))
    with Progress(Namespace(verbose=verbose)) as progress:
        pipeline.watch(progress)
        pipeline.watch(ear)
        pipeline.run()
    assert "... emit: at the end\n" in ear.text
    assert (" ms  emit\n" in ear.text) == verbose


@pytest.mark.parametrize(("is_terminal", "interval"), [(True, 2.0), (False, 10.0)])
def test_a_log_gets_fewer_lines_than_a_terminal(
    is_terminal: bool, interval: float, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    """A text that stays says how long; a count says how long it still takes."""
    intervals: list[float] = []
    progress = Progress(Namespace(verbose=False))
    texts = iter(["loading", "loading", "compiling"])

    class Ended:
        """Ends the thread after three lines; nobody waits."""

        def wait(self, seconds: float) -> bool:
            intervals.append(seconds)
            progress.at = next(texts, "")
            return not progress.at

    monkeypatch.setattr(progress, "ended", Ended())
    monkeypatch.setattr(sys, "__stderr__", Namespace(isatty=lambda: is_terminal))
    progress.print_lines()
    assert set(intervals) == {interval}
    assert capsys.readouterr().err.splitlines() == [
        "... loading",
        f"... loading, for {interval:.0f} s",
        "... compiling",
    ]


def test_the_end_of_a_pass_that_counts_is_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([0.0, 100.5, 130.0, 140.0])
    monkeypatch.setattr("urdf2mbs.commands.progress.monotonic", lambda: next(now))
    progress = Progress(Namespace(verbose=False))
    progress.urdf2mbs_before_pass(Namespace(name="convert-meshes"))
    for text, expected in (
        ("a.stl (4 of 13)", "a.stl (4 of 13), about 98 s to go"),
        ("b.stl (1 of 13)", "b.stl (1 of 13)"),
        ("of 13", "of 13"),
    ):
        progress.urdf2mbs_progress(text)
        assert progress.at == f"convert-meshes: {expected}"
    assert estimate_end(1.0, 4.0, 0.5) == ""


@pytest.mark.parametrize("command_line", [["--version"], ["-v", "--version"]])
def test_the_version_is_that_of_the_package(command_line: list[str], capsys: Any) -> None:
    with contextlib.suppress(SystemExit):  # argparse ends the program, where it reads the options
        assert main(command_line) == 0
    assert capsys.readouterr().out == f"urdf2mbs {version('urdf2mbs')}\n"


def test_version_imports_nothing_else() -> None:
    imported = loaded("from urdf2mbs.cli import main; main(['--version'])") - loaded("pass")
    allowed = {"__future__", "urdf2mbs", "urdf2mbs.cli", "urdf2mbs.disk", "urdf2mbs.disk.version"}
    assert imported <= allowed


def test_the_version_is_found_without_a_folder_of_that_name(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where no folder has the version in its name, importlib.metadata reads it."""
    metadata = here / "urdf2mbs.egg-info"
    metadata.mkdir()
    (metadata / "PKG-INFO").write_text("Metadata-Version: 2.1\nName: urdf2mbs\nVersion: 7.8\n")
    monkeypatch.setattr(sys, "path", [str(here / "nowhere"), str(here)])
    assert find_version() == "7.8"
    (here / "urdf2mbs-9.1.dist-info").mkdir()
    assert find_version() == "9.1"


def test_versions_in_file_names_stay(folder: Path) -> None:
    for name in ("panda_v1.0.urdf", "panda_v1.1.URDF", "a.b.urdf.xacro", ".urdf"):
        (folder / name).write_text(TINY)
        assert main(["convert", name]) == 0
    assert {file.name for file in folder.glob("*.mbs")} | {".urdf.mbs"} == {
        "panda_v1.0.mbs",
        "panda_v1.1.mbs",
        "a.b.mbs",
        ".urdf.mbs",
    }


@pytest.mark.parametrize(("encoding", "more"), [("cp1252", []), ("ascii", ["--json"])])
def test_letters_that_a_pipe_does_not_have_are_escaped(
    folder: Path, encoding: str, more: list[str]
) -> None:
    (folder / "r.urdf").write_text(TINY.replace('"tiny"', '"机器人"'), "utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "urdf2mbs", "convert", "r.urdf", *more],
        check=False,
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": encoding},
    )
    assert done.returncode == 0, done.stderr
    assert rb"\u673a\u5668\u4eba" in done.stdout


def test_verify_needs_no_output(folder: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf"]) == 0
    (folder / "tiny.urdf.mbs").mkdir()
    assert main(["verify", "tiny.urdf", "tiny.mbs"]) == 0
