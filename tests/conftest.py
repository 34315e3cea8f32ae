"""What holds for all tests: which code they import, how they draw examples, where they write."""

import os
import shutil
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import support.without  # noqa: F401  hides plugins
import urdf2mbs
from support.folders import ROOT, SHARED, TESTS
from support.skips import find_unexpected
from urdf2mbs.testing import TINY

# The processes that tests start import the same code: that of this checkout, unless pytest was told
# to test what is installed (-o pythonpath=tests).
_FOLDERS = [str(TESTS)]
if Path(urdf2mbs.__file__).parent == ROOT / "urdf2mbs":
    _FOLDERS[:0] = [str(ROOT), str(ROOT / "plugins")]
os.environ["PYTHONPATH"] = os.pathsep.join(
    dict.fromkeys([*_FOLDERS, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))])
)

# Options of this run are not those of a pytest that a test starts, on the tests of a plugin, say.
os.environ.pop("PYTEST_ADDOPTS", None)

# How long an example takes depends on the machine, and on what else it does.
settings.register_profile(
    "no-deadline",
    deadline=None,
    suppress_health_check=[
        HealthCheck.too_slow,
        HealthCheck.data_too_large,
        HealthCheck.filter_too_much,
    ],
)
settings.load_profile("no-deadline")

# Threads of BLAS wait for one another longer than they compute: matrices here are small.  It counts
# for the processes that tests start, too, and before numpy is imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
# To optimise C takes longer than all that it computes in a test.
if shutil.which("cc"):
    os.environ.setdefault("CC", str(TESTS / "support" / "cc"))

# zig compiles a C library for pages, which takes a minute, and keeps it: once for all tests.
_CACHES = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
os.environ.setdefault("ZIG_GLOBAL_CACHE_DIR", str(Path(_CACHES, "zig")))

# A shell lets a command in the background ignore Ctrl-C, and with it all commands that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):  # as Windows does not; nohup lets it be ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option by which CI finds tests that its machine could run, and does not."""
    text = "fail if a test is skipped for a reason that tests/support/skips.py does not expect"
    parser.addoption("--strict-skips", action="store_true", help=text)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail for unexpected skips; under xdist, the process that has the terminal does it."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None and session.config.getoption("strict_skips"):
        unexpected = find_unexpected(reporter.stats.get("skipped", []))
        if unexpected:
            reporter.write_line("\nSkipped for a reason that is not expected:", red=True)
            for reason in unexpected:
                reporter.write_line(f"  {reason}")
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(autouse=True)
def environment(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hide the user's ROS packages, and keep caches in a folder of the tests."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to an empty folder with a tiny robot, and return it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    return tmp_path


@pytest.fixture
def tiny(here: Path) -> Path:
    """Return the file of the tiny robot in the current folder."""
    return here / "tiny.urdf"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of real robots and ``.mbs`` samples beside the checkout."""
    if not SHARED.is_dir():
        pytest.skip(f"the real robots are not here: {SHARED} does not exist")
    return SHARED
