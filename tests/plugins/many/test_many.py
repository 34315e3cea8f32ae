"""Many robots at once: the same bytes as one by one, none lost, none doubled."""

import json
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from support.folders import CONFIGS
from support.plugin_files import write_plugin
from urdf2mbs import convert, convert_many
from urdf2mbs.cli import main
from urdf2mbs.testing import TINY
from urdf2mbs_many.job import Outcome

SWEEP = """\
source: biped.urdf.xacro
output: models/{height}.mbs
sweep:
  xacro_args: {height: [0.7, 0.8, 0.9, 1.0, 1.1, 1.2]}
"""

#: A plugin whose pass ends its process, as the system does where memory runs out: the first
#: ``times`` times that robots of this height come by.
DEADLY = """\
import os, signal
from pathlib import Path
from urdf2mbs.plugin import Pass, hookimpl

class Deadly(Pass):
    def run(self, conversion):
        if conversion.settings.config.xacro_args.get("height") != "0.9":
            return
        for n in range({times}):
            try:
                (Path(__file__).parent / f"died-{{n}}").touch(exist_ok=False)
            except FileExistsError:
                continue
            os.kill(os.getpid(), signal.SIGKILL)

@hookimpl
def urdf2mbs_passes():
    return [Deadly]
"""


#: What two files of one robot differ in: the name of the model.
_NAME = re.compile(rb"<mbsname>.*?</mbsname>")


@pytest.fixture
def sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copy(CONFIGS / "biped.urdf.xacro", tmp_path)
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    return tmp_path / "sweep.yaml"


def deadly(sweep: Path, times: int) -> None:
    (sweep.parent / "deadly.py").write_text(DEADLY.format(times=times))
    sweep.write_text(f"{SWEEP}plugins: [deadly.py]\nafter: {{expand: deadly}}\n")


def assert_all_there(outcomes: list[Outcome], folder: Path) -> None:
    assert sorted(outcome.number for outcome in outcomes) == list(range(6))
    for outcome in outcomes:
        assert outcome.code == 0, outcome
        assert outcome.output is not None
        height = outcome.values["height"]
        assert Path(outcome.output) == folder / "models" / f"{height}.mbs"
        alone = convert(folder / "biped.urdf.xacro", xacro_args={"height": height})
        # the model is named after its file
        made, wanted = (
            _NAME.sub(b"", data) for data in (Path(outcome.output).read_bytes(), alone.data)
        )
        assert made == wanted
    written = {file.name for file in (folder / "models").glob("[!.]*")}
    models = {f"{outcome.values['height']}.mbs" for outcome in outcomes}
    assert written == models | {f"{model}.base" for model in models}


@pytest.mark.parametrize("workers", [1, 2])
def test_a_sweep_is_its_robots_one_by_one(sweep: Path, workers: int) -> None:
    assert_all_there(list(convert_many([sweep], workers=workers)), sweep.parent)


def test_a_process_that_dies_takes_nothing_with_it(sweep: Path) -> None:
    deadly(sweep, times=1)
    assert_all_there(list(convert_many([sweep], workers=2)), sweep.parent)
    assert (sweep.parent / "died-0").exists()


@pytest.mark.slow
def test_a_robot_that_ends_its_process_each_time_is_one_failure(sweep: Path) -> None:
    deadly(sweep, times=9)
    outcomes = sorted(convert_many([sweep], workers=2), key=lambda outcome: outcome.number)
    errors = [outcome.error and (outcome.error.code, outcome.values) for outcome in outcomes]
    assert errors == [None, None, ("worker-died", {"height": "0.9"}), None, None, None]


def test_mappings_and_a_failure_among_them(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.urdf").write_text(TINY)
    Path("bad.urdf").write_text("<robot name='x'>")
    outcomes = list(
        convert_many([{"source": "bad.urdf"}, {"source": "a.urdf", "output": "b/a.mbs"}], workers=1)
    )
    assert [outcome.code for outcome in outcomes] == [1, 0]
    assert Path("b/a.mbs").is_file()
    assert outcomes[0].error is not None
    assert outcomes[0].error.file == str(tmp_path / "bad.urdf")


# --- the command line ------------------------------------------------------------------------


def test_a_folder_carries_on_past_failures(tmp_path: Path, capsys: Any) -> None:
    robots = tmp_path / "robots"
    (robots / "deep").mkdir(parents=True)
    (robots / "a.urdf").write_text(TINY)
    (robots / "a.urdf.xacro").write_text(TINY)
    (robots / "deep" / "b.urdf").write_text("<robot name='b'>")
    (robots / "macros.xacro").write_text("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'/>")
    assert main(["convert", str(robots), "-o", str(tmp_path / "out"), "--workers", "1"]) == 1
    output = capsys.readouterr()
    assert "2 robots done; 1 robot cannot be converted" in output.out
    assert "b.urdf:1: error[xml-truncated]" in output.err
    report = json.loads((tmp_path / "out" / "urdf2mbs-report.json").read_text())
    assert report["code"] == 1
    assert [Path(outcome["source"]).name for outcome in report["robots"]] == [
        "a.urdf",
        "a.urdf.xacro",
        "b.urdf",
    ]
    assert [outcome["code"] for outcome in report["robots"]] == [0, 0, 1]
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        ".urdf2mbs",
        "a_urdf.mbs",
        "a_urdf.mbs.base",
        "a_urdf_xacro.mbs",
        "a_urdf_xacro.mbs.base",
        "urdf2mbs-report.json",
    ]


def test_the_exit_code_is_the_worst_of_all_robots(here: Path, capsys: Any) -> None:
    write_plugin(here, "heavier", "conversion.mbs.bodies[0].mass = 99.0", reads=("inertias",))
    Path("bad.urdf").write_text("<robot name='b'>")
    configs = {
        "good": "source: tiny.urdf",
        "bad": "source: bad.urdf",
        "wrong": "source: tiny.urdf\npasses: {emit: {nothing: 1}}",
        "other": "source: tiny.urdf\nplugins: [heavier.py]\nafter: {reframe-inertia: heavier}",
    }
    for name, text in configs.items():
        Path(f"{name}.yaml").write_text(f"{text}\noutput: o/{name}.mbs\n")
    files = [f"{name}.yaml" for name in configs]
    for worst in (1, 2, 3):
        assert main(["run", *files[: worst + 1], "--workers", "1", "--json"]) == worst
        output = json.loads(capsys.readouterr().out)
        assert [outcome["code"] for outcome in output["robots"]] == [0, 1, 2, 3][: worst + 1]


def test_explain_shows_the_first(sweep: Path, capsys: Any) -> None:
    assert main(["explain", str(sweep)]) == 0
    assert "6 robots; this is the first: height=0.7" in capsys.readouterr().out


def test_an_edited_report_stops_the_run_before_it_begins(sweep: Path, capsys: Any) -> None:
    report = sweep.with_name("r.json")
    report.write_text("mine")
    words = ["run", str(sweep), "--workers", "1", "--report", str(report)]
    assert main(words) == 2
    assert "error[output-not-ours]" in capsys.readouterr().err
    assert not sweep.with_name("models").exists()
    assert main([*words, "--force"]) == 0


# --- on a cluster ----------------------------------------------------------------------------


@pytest.mark.slow
def test_a_worker_that_a_robot_kills(sweep: Path) -> None:
    """Two workers on loopback, each a process of its own; what hangs is ended after two minutes."""
    distributed = pytest.importorskip("distributed")
    import dask

    def too_long(*_: Any) -> None:
        raise TimeoutError("the cluster does not come to an end")

    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(120)
    deadly(sweep, times=1)
    with (
        dask.config.set({"distributed.worker.daemon": True}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        outcomes = list(convert_many([sweep], cluster=cluster.scheduler_address))
    signal.alarm(0)
    assert_all_there(outcomes, sweep.parent)
    assert (sweep.parent / "died-0").exists()


def test_a_cluster_without_a_scheduler_is_an_error(
    sweep: Path, monkeypatch: Any, capsys: Any
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("urdf2mbs_many.cluster.PATIENCE", 0.2)
    assert main(["run", str(sweep), "--cluster", "tcp://127.0.0.1:9"]) == 2
    assert "error[cluster-unreachable]" in capsys.readouterr().err


@pytest.mark.slow
def test_a_script_needs_no_guard(sweep: Path) -> None:
    """Processes do not run the script again, though nothing in it says ``__main__``."""
    script = (
        "import urdf2mbs\n"
        f"print([one.code for one in urdf2mbs.convert_many(['{sweep}'], workers=2)])"
    )
    sweep.with_name("script.py").write_text(script)
    done = subprocess.run(
        [sys.executable, "script.py"], capture_output=True, text=True, cwd=sweep.parent, check=False
    )
    assert (done.stdout, done.stderr) == (f"{[0] * 6}\n", "")
