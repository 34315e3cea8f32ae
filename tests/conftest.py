"""What several test files share."""

import os
import shutil
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import without  # noqa: F401  hides plugins
from urdf2mbs.testing import TINY

# How long an example takes depends on the machine, and on what else it does.
settings.register_profile(
    "no-deadline",
    deadline=None,
    suppress_health_check=[
        HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much,
    ],
)  # fmt: skip
settings.load_profile("no-deadline")
#: The same examples each time, so that what is red in one place is red everywhere.
reproducible = settings(derandomize=True, database=None)

# Threads of BLAS wait for one another longer than they compute: matrices here are small.  It counts
# for the processes that tests start, too, and before numpy is imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
# To optimise C takes longer than all that it computes in a test.
if shutil.which("cc"):
    os.environ.setdefault("CC", str(Path(__file__).with_name("cc")))

# A shell lets a command in the background ignore Ctrl-C, and with it all commands that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):  # as Windows does not; nohup lets it be ignored
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """What simulations keep goes into a folder of the tests, and not into the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a tiny robot, which is where we are."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.urdf").write_text(TINY)
    return tmp_path


@pytest.fixture
def tiny(here: Path) -> Path:
    """The file of the tiny robot in the folder where we are."""
    return here / "tiny.urdf"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of real robots and .mbs samples beside the checkout."""
    if not SHARED.is_dir():
        pytest.skip(f"the real robots are not here: {SHARED} does not exist")
    return SHARED
