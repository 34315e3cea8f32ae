"""Ctrl-C and SIGTERM end a command at once: the exit code of the signal, one line, no half file."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from urdf2mbs.disk.record import is_ours
from urdf2mbs.testing import TINY

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")

CONFIGS = Path(__file__).parents[2] / "configs"

#: Runs the command line, and sends a signal at an event of Python: the import of a module.
AT_IMPORT = """
import os, sys
number, module = int(sys.argv.pop(1)), sys.argv.pop(1)
def hook(event, given):
    if event == "import" and given[0] == module:
        os.kill(os.getpid(), number)
sys.addaudithook(hook)
from urdf2mbs.cli import main
sys.exit(main())
"""

#: A pass that sends a signal where one robot of a sweep comes by, and then waits to be ended.
SENDING = """\
import os, signal
from urdf2mbs.plugin import Pass, hookimpl

class Sending(Pass):
    def run(self, conversion):
        height = conversion.settings.config.xacro_args["height"]
        if height == "0.9":
            os.kill({whom}, {number})
        while height >= "0.9" and {whom} != os.getpid():
            signal.pause()

@hookimpl
def urdf2mbs_passes():
    return [Sending]
"""


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words],
        check=False,
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=120,
    )


@pytest.mark.parametrize(
    ("number", "module"),
    [(signal.SIGINT, "argparse"), (signal.SIGINT, "lxml.etree"), (signal.SIGTERM, "argparse"),
     (signal.SIGHUP, "urdf2mbs.engine.output")],
)  # fmt: skip
def test_while_python_imports(number: signal.Signals, module: str, tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    done = run(["-c", AT_IMPORT, str(int(number)), module, "convert", "tiny.urdf"], tmp_path)
    assert done.returncode == 128 + number
    assert done.stderr == f"stopped by {number.name}\n"
    assert done.stdout == ""
    assert [file.name for file in tmp_path.iterdir()] == ["tiny.urdf"]


def test_who_ignores_a_signal_goes_on(tmp_path: Path) -> None:
    """As nohup does for SIGHUP, and a shell for Ctrl-C where a command is in the background."""
    (tmp_path / "tiny.urdf").write_text(TINY)
    ignored = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n" + AT_IMPORT
    words = [str(int(signal.SIGHUP)), "msgspec._core", "convert", "tiny.urdf", "-q"]
    assert run(["-c", ignored, *words], tmp_path).returncode == 0
    assert (tmp_path / "tiny.mbs").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("workers", [1, 2])
def test_a_sweep(number: signal.Signals, workers: int, tmp_path: Path) -> None:
    """Robots that were done are whole, and no process stays."""
    shutil.copy(CONFIGS / "biped.urdf.xacro", tmp_path)
    whom = "os.getpid()" if workers == 1 else "os.getppid()"
    (tmp_path / "sending.py").write_text(
        SENDING.format(whom=whom, number=int(number))
        + "open('worker-' + str(os.getpid()), 'w').close()\n" * (workers == 2)
    )
    (tmp_path / "sweep.yaml").write_text(
        "source: biped.urdf.xacro\noutput: models/{height}.mbs\n"
        "sweep: {xacro_args: {height: [0.7, 0.8, 0.9, 1.0, 1.1]}}\n"
        "plugins: [sending.py]\nafter: {expand: sending}\n"
    )
    words = ["-m", "urdf2mbs", "run", "sweep.yaml", "-q", "--workers", str(workers)]
    done = run(words, tmp_path)
    assert (done.returncode, done.stdout) == (128 + number, "")
    at, stopped = done.stderr.splitlines()
    assert "of 5 robots done" in at
    assert stopped == f"stopped by {number.name}"
    if workers == 1:
        assert "2 of 5" in at
    for file in (tmp_path / "models").glob("*.mbs"):
        assert is_ours(file)
    assert not (tmp_path / "models" / "0.9.mbs").exists()
    for file in tmp_path.glob("worker-*"):
        with pytest.raises(ProcessLookupError):
            os.kill(int(file.name.partition("-")[2]), 0)
