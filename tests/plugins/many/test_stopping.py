"""A sweep that is stopped: robots that were done are whole, and no process stays."""

import os
import shutil
import signal
import sys
from pathlib import Path

import pytest

from support.folders import CONFIGS
from support.processes import run
from urdf2mbs.disk.record import is_ours

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


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


@pytest.mark.parametrize(("workers", "number"), [(1, signal.SIGINT), (2, signal.SIGTERM)])
def test_a_sweep_that_is_stopped(number: signal.Signals, workers: int, tmp_path: Path) -> None:
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
    progress, stopped = done.stderr.splitlines()
    assert "of 5 robots done" in progress
    assert stopped == f"stopped by {number.name}"
    if workers == 1:
        assert "2 of 5" in progress
    for file in (tmp_path / "models").glob("*.mbs"):
        assert is_ours(file)
    assert not (tmp_path / "models" / "0.9.mbs").exists()
    for file in tmp_path.glob("worker-*"):
        with pytest.raises(ProcessLookupError):
            os.kill(int(file.name.partition("-")[2]), 0)
