"""What `doctor` lists, and completion of commands in a shell."""

import json
import re
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from support.installed import install
from urdf2mbs.cli import main


def test_doctor_lists_versions_and_folders(
    capsys: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert main(["doctor", "--json"]) == 0
    tables = json.loads(capsys.readouterr().out)
    assert tables["urdf2mbs"]["lxml"] == version("lxml")
    assert tables["ROS packages"]["AMENT_PREFIX_PATH"] == str(tmp_path)
    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.version_of", lambda name: "")
    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.version", lambda name: "0")
    assert main(["doctor"]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^  distributed +not installed, for ", output, re.M)
    assert re.search(r"^  lxml +MISSING$", output, re.M)


COMMAND_ALONE = """
from urdf2mbs.plugin import Command, hookimpl

@hookimpl
def urdf2mbs_commands():
    return [Command("weigh", "weigh a robot", "renaming")]
"""


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (None, r"^  rename +renaming 0\.1\.0 \(SITE/renaming\.py\)$"),
        (COMMAND_ALONE, r"^  rename +renaming 0\.1\.0 \(SITE/renaming\.py\)$"),
        (
            "import nowhere_at_all\n",
            r"^  rename +renaming 0\.1\.0 is BROKEN\n +.*warning\[plugin-broken\].*nowhere_at_all",
        ),
    ],
)
def test_doctor_lists_all_plugins(
    text: str | None,
    shown: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.syspath_prepend(install(tmp_path, text))
    monkeypatch.delitem(sys.modules, "renaming", raising=False)
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert re.search(shown.replace("SITE", re.escape(str(tmp_path))), out, re.M)
    assert re.search(r"^  setup +urdf2mbs$", out, re.M)
    assert main(["doctor", "--no-plugins"]) == 0
    out = capsys.readouterr().out
    assert "renaming" not in out
    assert re.search(r"^  others +left out by --no-plugins$", out, re.M)


def test_doctor_says_that_no_package_brings_a_plugin(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("urdf2mbs_setup.commands.doctor.entry_points", lambda group: ())
    assert main(["doctor"]) == 0
    told = r"^  others +none: no installed package has an entry point 'urdf2mbs'$"
    assert re.search(told, capsys.readouterr().out, re.M)


def test_shtab_completes_commands_and_options() -> None:
    """README has this line; it needs no extra of urdf2mbs."""
    pytest.importorskip("shtab")
    line = ["-m", "shtab", "--shell=bash", "urdf2mbs.commands.parser"]
    done = subprocess.run([sys.executable, *line], check=True, capture_output=True, text=True)
    assert all(word in done.stdout for word in ("new-pass", "doctor", "tolerance", "gravity"))


@pytest.mark.skipif(sys.platform == "win32", reason="a pipe of POSIX")
def test_who_reads_no_further_sees_no_traceback() -> None:
    command = f"{shlex.quote(sys.executable)} -m urdf2mbs schema | head -c 10"
    done = subprocess.run(command, shell=True, check=False, capture_output=True)
    assert done.stdout.startswith(b"{")
    assert done.stderr == b""
