"""Many robots at once: the same bytes as one by one, none lost, none doubled."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert, convert_many
from urdf2mbs.cli import main
from urdf2mbs.disk import files
from urdf2mbs.many import convert as many
from urdf2mbs.many import job as job_module
from urdf2mbs.many.job import Job, Outcome
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

CONFIGS = Path(__file__).parents[2] / "configs"

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


#: What two files of one robot differ in: the name of the model, and so the seal.
_NAME = re.compile(rb"<mbsname>.*?</mbsname>|<!-- sealed by .* -->")


@pytest.fixture(autouse=True)
def _one_environment() -> Iterator[None]:
    """pytest writes into a variable what it is at; the first look at them holds for a process."""
    job_module._machine.cache_clear()
    job_module._machine()
    yield
    job_module._machine.cache_clear()


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
    assert sorted(one.number for one in outcomes) == list(range(6))
    for one in outcomes:
        assert one.code == 0, one
        assert one.output is not None
        height = one.values["height"]
        assert Path(one.output) == folder / "models" / f"{height}.mbs"
        alone = convert(folder / "biped.urdf.xacro", xacro_args={"height": height})
        # the model is named after its file
        made, wanted = (
            _NAME.sub(b"", data) for data in (Path(one.output).read_bytes(), alone.data)
        )
        assert made == wanted
    written = {file.name for file in (folder / "models").iterdir()}
    models = {f"{one.values['height']}.mbs" for one in outcomes}
    assert written == models | {f"{model}.base" for model in models}


@pytest.mark.parametrize("workers", [1, 2])
def test_a_sweep_is_its_robots_one_by_one(sweep: Path, workers: int) -> None:
    assert_all_there(list(convert_many([sweep], workers=workers)), sweep.parent)


def test_a_process_that_dies_takes_nothing_with_it(sweep: Path) -> None:
    deadly(sweep, times=1)
    assert_all_there(list(convert_many([sweep], workers=2)), sweep.parent)
    assert (sweep.parent / "died-0").exists()


def test_a_robot_that_ends_its_process_each_time_is_one_failure(sweep: Path) -> None:
    deadly(sweep, times=9)
    outcomes = list(convert_many([sweep], workers=2))
    assert sorted(one.number for one in outcomes) == list(range(6))
    (bad,) = [one for one in outcomes if one.code]
    assert bad.values == {"height": "0.9"}
    assert bad.error is not None
    assert bad.error.code == "worker-died"


def test_mappings_and_a_failure_among_them(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.urdf").write_text(TINY)
    Path("bad.urdf").write_text("<robot name='x'>")
    outcomes = list(
        convert_many([{"source": "bad.urdf"}, {"source": "a.urdf", "output": "b/a.mbs"}], workers=1)
    )
    assert [one.code for one in outcomes] == [1, 0]
    assert Path("b/a.mbs").is_file()
    assert outcomes[0].error is not None
    assert outcomes[0].error.file == str(tmp_path / "bad.urdf")


def test_two_of_one_output_are_refused_before_anything_is_made(tmp_path: Path) -> None:
    one = {"source": "a.urdf", "output": str(tmp_path / "a.mbs")}
    with pytest.raises(ConfigError, match="would be written twice"):
        convert_many([one, one])


# --- the command line ------------------------------------------------------------------------


def test_a_folder_carries_on_past_failures(tmp_path: Path, capsys: Any) -> None:
    robots = tmp_path / "robots"
    (robots / "deep").mkdir(parents=True)
    (robots / "a.urdf").write_text(TINY)
    (robots / "a.urdf.xacro").write_text(TINY)
    (robots / "deep" / "b.urdf").write_text("<robot name='b'>")
    (robots / "macros.xacro").write_text("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'/>")
    assert main(["convert", str(robots), "-o", str(tmp_path / "out"), "--workers", "1"]) == 1
    said = capsys.readouterr()
    assert "2 robots done; 1 robot cannot be converted" in said.out
    assert "b.urdf:1: error[xml-truncated]" in said.err
    report = json.loads((tmp_path / "out" / "urdf2mbs-report.json").read_text())
    assert report["code"] == 1
    assert [Path(one["source"]).name for one in report["robots"]] == [
        "a.urdf", "a.urdf.xacro", "b.urdf",
    ]  # fmt: skip
    assert [one["code"] for one in report["robots"]] == [0, 0, 1]
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        ".urdf2mbs", "a_urdf.mbs", "a_urdf.mbs.base", "a_urdf_xacro.mbs", "a_urdf_xacro.mbs.base",
        "urdf2mbs-report.json",
    ]  # fmt: skip


def test_the_worst_exit_code(tmp_path: Path, capsys: Any) -> None:
    for name, text in {"good": TINY, "bad": "<robot name='b'>"}.items():
        (tmp_path / f"{name}.urdf").write_text(text)
    texts = {
        "good": "source: good.urdf\noutput: o/good.mbs",
        "bad": "source: bad.urdf\noutput: o/bad.mbs",
        "wrong": "source: good.urdf\noutput: o/wrong.mbs\npasses: {emit: {nothing: 1}}",
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    good, bad, wrong = (str(tmp_path / f"{name}.yaml") for name in texts)
    assert main(["run", good, bad, "--workers", "1"]) == 1
    assert main(["run", wrong, bad, good, "--workers", "1", "--json"]) == 2
    said = json.loads(capsys.readouterr().out.partition("{")[2].join(["{", ""]))
    assert [one["code"] for one in said["robots"]] == [2, 1, 0]


@pytest.mark.parametrize(
    "words",
    [
        ["run", "sweep.yaml", "--workers", "0"],
        ["run", "sweep.yaml", "--stop-after", "expand"],
        ["run", "sweep.yaml", "--dump", "d"],
        ["convert", "biped.urdf.xacro", "--workers", "2"],
        ["convert", "."],
        ["convert", ".", "-o", "sweep.yaml"],
        ["convert", "empty", "-o", "out"],
        ["report", "sweep.yaml"],
    ],
)
def test_wrong_words(sweep: Path, words: list[str], capsys: Any) -> None:
    Path("empty").mkdir()
    assert main(words) == 2
    assert "error[" in capsys.readouterr().err


def test_explain_shows_the_first(sweep: Path, capsys: Any) -> None:
    assert main(["explain", str(sweep)]) == 0
    assert "6 robots; this is the first: height=0.7" in capsys.readouterr().out


# --- interrupted -----------------------------------------------------------------------------


def interrupt(sweep: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a sweep that Ctrl-C ends after three robots."""
    plain = many.run

    def run(jobs: list[Job], **more: Any) -> Iterator[Outcome]:
        for done, outcome in enumerate(plain(jobs, **more)):
            if done == 3:
                raise KeyboardInterrupt
            yield outcome

    with monkeypatch.context() as patch:
        patch.setattr("urdf2mbs.commands.many.run", run)
        assert main(["run", str(sweep), "--workers", "1"]) == 130


@pytest.fixture
def interrupted(sweep: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Path:
    interrupt(sweep, monkeypatch)
    said = capsys.readouterr().err
    assert said == "stopped by SIGINT: 3 of 6 robots done; the same command goes on\n"
    return sweep


@pytest.fixture
def interrupted_srdf(sweep: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Path:
    """The start posture of its robots is in a file of its own."""
    joint = convert("biped.urdf.xacro").names.joints
    name = next(name for name in joint if "knee" in name)
    (sweep.parent / "biped.srdf").write_text(
        f'<robot name="biped"><group_state name="stand" group="legs">'
        f'<joint name="{name}" value="0.1"/></group_state></robot>'
    )
    sweep.write_text(f"{SWEEP}passes: {{posture: {{srdf: biped.srdf, state: stand}}}}\n")
    interrupt(sweep, monkeypatch)
    capsys.readouterr()
    return sweep


def again(sweep: Path, capsys: Any, kept: int) -> dict[str, Any]:
    assert main(["run", str(sweep), "--workers", "1"]) == 0
    said = capsys.readouterr()
    assert "6 robots done" in said.out
    assert (f"({kept} of them before)" in said.out) == (kept > 0)
    report: dict[str, Any] = json.loads(
        (sweep.parent / "models" / "urdf2mbs-report.json").read_text()
    )
    assert [one["values"]["height"] for one in report["robots"]] == [
        "0.7", "0.8", "0.9", "1.0", "1.1", "1.2",
    ]  # fmt: skip
    assert not list((sweep.parent / "models").glob("*.part"))
    return report


def test_it_goes_on_where_it_was(interrupted: Path, capsys: Any) -> None:
    gone_on = again(interrupted, capsys, kept=3)
    assert gone_on == again(interrupted, capsys, kept=0), "a whole run begins anew"


def test_what_changed_since_is_made_anew(interrupted: Path, capsys: Any) -> None:
    robot = interrupted.with_name("biped.urdf.xacro")
    robot.write_text(robot.read_text().replace('default="12.0"', 'default="13.0"'))
    report = again(interrupted, capsys, kept=0)
    masses = {one["report"]["mass"] for one in report["robots"]}
    assert len(masses) == 1
    assert masses.pop() > 13.0


def test_an_output_that_is_gone_is_made_anew(interrupted: Path, capsys: Any) -> None:
    (interrupted.parent / "models" / "0.8.mbs").unlink()
    again(interrupted, capsys, kept=2)
    assert (interrupted.parent / "models" / "0.8.mbs").is_file()


def test_another_config_is_made_anew(interrupted: Path, capsys: Any) -> None:
    interrupted.write_text(f"{SWEEP}gravity: [0, 0, -1.62]\n")
    report = again(interrupted, capsys, kept=0)
    assert all(one["report"]["gravity"][2] == -1.62 for one in report["robots"])


def test_a_journal_that_was_cut_off(interrupted: Path, capsys: Any) -> None:
    journal = interrupted.parent / "models" / "urdf2mbs-report.json.part"
    journal.write_bytes(journal.read_bytes()[:-100])
    again(interrupted, capsys, kept=2)


def test_another_environment_is_made_anew(
    interrupted: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot may ask for any variable: ``$(env NAME)``."""
    monkeypatch.setenv("LEG_MASS", "3")
    job_module._machine.cache_clear()
    again(interrupted, capsys, kept=0)


@pytest.mark.parametrize(("angle", "kept"), [("0.1", 3), ("0.2", 0)])
def test_a_file_that_a_pass_reads_is_known(
    angle: str, kept: int, interrupted_srdf: Path, capsys: Any
) -> None:
    srdf = interrupted_srdf.with_name("biped.srdf")
    srdf.write_text(srdf.read_text().replace("0.1", angle))
    again(interrupted_srdf, capsys, kept=kept)


def test_what_a_plugin_made_is_made_anew(sweep: Path, capsys: Any, monkeypatch: Any) -> None:
    """It may depend on a helper, or on any other file."""
    (sweep.parent / "idle.py").write_text(DEADLY.format(times=0))
    sweep.write_text(f"{SWEEP}plugins: [idle.py]\nafter: {{expand: deadly}}\n")
    interrupt(sweep, monkeypatch)
    assert capsys.readouterr().err == "stopped by SIGINT: 3 of 6 robots done\n"
    again(sweep, capsys, kept=0)


@pytest.mark.parametrize(("name", "kept"), [("other.stl", 3), ("foot.stl", 0)])
def test_a_file_that_was_not_there_is_known(
    name: str, kept: int, sweep: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = sweep.with_name("biped.urdf.xacro")
    mesh = '<visual><geometry><mesh filename="foot.stl"/></geometry></visual></link>'
    robot.write_text(robot.read_text().replace("</link>", mesh, 1))
    sweep.write_text(
        SWEEP.replace("output: models/{height}.mbs", "output: {project: 'models/{height}'}")
    )
    interrupt(sweep, monkeypatch)
    capsys.readouterr()
    sweep.with_name(name).write_bytes(bytes(84))
    again(sweep, capsys, kept=kept)


@pytest.mark.parametrize("there", [False, True])
def test_a_file_that_is_saved_while_it_is_used(there: bool, tmp_path: Path) -> None:
    """What was read is known, and not what is there afterwards."""
    file = tmp_path / "part.xacro"
    if there:
        file.write_text("old")
    with files.noting() as noted, suppress(OSError):
        files.read(file)
    file.write_text("new")
    assert noted.keys() == {str(file)}
    assert noted[str(file)] != files.digest(str(file))
    with files.noting() as noted:
        files.read(file)
        file.write_text("newer")
        files.read(file)
    assert noted == {str(file): "changed"}


def test_which_files_match_a_pattern_is_known(tmp_path: Path) -> None:
    pattern = str(tmp_path / "*.xacro")
    with files.noting() as noted:
        files.note(pattern)
    assert noted[pattern] == files.digest(pattern)
    (tmp_path / "new.xacro").touch()
    assert noted[pattern] != files.digest(pattern)


# --- on a cluster ----------------------------------------------------------------------------


@pytest.fixture
def cluster() -> Iterator[Any]:
    """A scheduler and two workers on loopback, each worker a process of its own.

    What hangs is ended after two minutes.
    """
    distributed = pytest.importorskip("distributed")
    import dask

    def too_long(*_: Any) -> None:
        raise TimeoutError("the cluster does not come to an end")

    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(120)
    with (
        dask.config.set({"distributed.worker.daemon": True}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        yield cluster
    signal.alarm(0)


def test_a_worker_that_is_killed_loses_and_doubles_nothing(sweep: Path, cluster: Any) -> None:
    with cluster.get_client() as client:
        workers = client.run(os.getpid)
        assert len(workers) == 2
        outcomes = []
        for outcome in convert_many([sweep], cluster=cluster.scheduler_address):
            if not outcomes:  # in mid-run
                os.kill(next(iter(workers.values())), signal.SIGKILL)
            outcomes.append(outcome)
        left = set(client.run(os.getpid).values())
    assert_all_there(outcomes, sweep.parent)
    assert not set(workers.values()) <= left


def test_a_worker_that_a_robot_kills(sweep: Path, cluster: Any) -> None:
    deadly(sweep, times=1)
    outcomes = list(convert_many([sweep], cluster=cluster.scheduler_address))
    assert_all_there(outcomes, sweep.parent)
    assert (sweep.parent / "died-0").exists()


def test_no_scheduler(sweep: Path, monkeypatch: Any, capsys: Any) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("urdf2mbs.many.cluster.PATIENCE", 0.2)
    assert main(["run", str(sweep), "--cluster", "tcp://127.0.0.1:9"]) == 2
    assert "error[cluster-unreachable]" in capsys.readouterr().err
