"""Ctrl-C and SIGTERM end a command at once: the exit code of the signal, one line, no half file."""

import signal
import sys
from pathlib import Path

import pytest

from support.processes import run
from urdf2mbs.testing import TINY

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


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


@pytest.mark.parametrize(
    ("number", "module"),
    [
        (signal.SIGINT, "argparse"),
        (signal.SIGINT, "lxml.etree"),
        (signal.SIGTERM, "argparse"),
        (signal.SIGHUP, "urdf2mbs.engine.output"),
    ],
)
def test_a_signal_while_python_imports_ends_the_command(
    number: signal.Signals, module: str, tmp_path: Path
) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    done = run(["-c", AT_IMPORT, str(int(number)), module, "convert", "tiny.urdf"], tmp_path)
    assert done.returncode == 128 + number
    assert done.stderr == f"stopped by {number.name}\n"
    assert done.stdout == ""
    assert [file.name for file in tmp_path.iterdir()] == ["tiny.urdf"]


def test_a_command_goes_on_where_the_signal_is_ignored(tmp_path: Path) -> None:
    """As nohup does for SIGHUP, and a shell for Ctrl-C where a command is in the background."""
    (tmp_path / "tiny.urdf").write_text(TINY)
    ignored = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n" + AT_IMPORT
    words = [str(int(signal.SIGHUP)), "msgspec._core", "convert", "tiny.urdf", "-q"]
    assert run(["-c", ignored, *words], tmp_path).returncode == 0
    assert (tmp_path / "tiny.mbs").exists()
