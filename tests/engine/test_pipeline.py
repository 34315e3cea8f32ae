"""The pipeline: its order is checked, its passes run between hooks, nothing is half written."""

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest

from support.pipelines import NINE, RAN, WORK, pipeline_of
from support.plugin_files import write_plugin
from urdf2mbs import convert
from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass, hookimpl
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY, assert_same_robot, convert_text
from urdf2mbs.urdf.model import Robot

#: Two passes, and those of plugins that say their place behind the two.
JOINED = {"expand", "snap", "estimate-inertia", "compare-mujoco", "insert-base", "rotors"}


def marks(tmp_path: Path, *names: str) -> Path:
    """A plugin whose passes write their names into the report."""
    file = tmp_path / "marks.py"
    file.write_text(
        "from support.plugin_files import hookimpl, make\n"
        "def marker(name):\n"
        "  def run(conversion, options): conversion.report.setdefault('ran', []).append(name)\n"
        "  return make(name, run)\n"
        f"@hookimpl\ndef urdf2mbs_passes(): return [marker(name) for name in {names!r}]\n"
    )
    return file


@pytest.mark.parametrize(
    ("settings", "code", "hint"),
    [
        ("pipeline: [insert-base, expand]", "wrong-order", "put 'expand' before"),
        ("pipeline: [expand, insert_base]", "unknown-pass", "'insert-base'"),
        ("pipeline: [expand, expand]", "pass-doubled", ""),
        ("pipeline: [faithful]", "unknown-pass", "a preset's name stands alone"),
        ("pipeline: faithfull", "unknown-preset", "'faithful'"),
        ("after: {nosuch: a}", "unknown-pass", ""),
        ("after: {c: a}", "unknown-pass", "puts it in"),
        ("after: {emit: d}", "unknown-pass", ""),
        ("after: {emit: expand}", "pass-doubled", ""),
        ("after: {emit: a, a: a}", "pass-doubled", ""),
        ("after: {emit: a, a: b, b: a}", "pass-doubled", ""),
        ("passes: {c: {}}", "unknown-pass", "puts it in"),
        ("passes: {check: {tolerence: 1}}", "unknown-key", "'tolerance'"),
    ],
)
def test_a_pipeline_that_cannot_be_is_refused_with_its_line(
    settings: str, code: str, hint: str, tmp_path: Path
) -> None:
    """It is told with its line, before anything runs."""
    plugin = marks(tmp_path, "a", "b", "c")
    with pytest.raises(ConfigError) as caught:
        pipeline_of(tmp_path, f"plugins: [{plugin.name}]\n{settings}\n")
    assert (caught.value.code, caught.value.line) == (code, 3)
    assert hint in (caught.value.hint or "")


def test_passes_are_put_after_another_in_the_order_given(tmp_path: Path) -> None:
    plugin = marks(tmp_path, "a", "b", "c")
    result = convert_text(plugins=[plugin], after={"emit": ["b", "c"], "b": "a"})
    assert result.report.passes["ran"] == ["b", "a", "c"]


class Watcher:
    def __init__(self) -> None:
        self.seen: list[tuple[str, str]] = []

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Conversion) -> None:
        self.seen.append(("before", pass_.name))

    @hookimpl
    def urdf2mbs_progress(self, text: str) -> None:
        self.seen.append(("at", text))

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Conversion, seconds: float) -> None:
        assert seconds >= 0.0
        self.seen.append(("after", pass_.name))


def test_a_pass_behind_one_that_is_left_out_keeps_its_line(tmp_path: Path) -> None:
    passes = "[expand,\n  insert-base,\n  nosuch]\nwithout: [insert-base]\n"
    with pytest.raises(ConfigError, match="unknown-pass") as wrong:
        pipeline_of(tmp_path, f"pipeline: {passes}")
    assert wrong.value.line == 4


def test_hooks_are_called_around_every_pass(tmp_path: Path) -> None:
    """And where a pass says what it is at."""
    write_plugin(tmp_path, "slow", "conversion.progress('half')")
    pipeline = pipeline_of(tmp_path, "plugins: [slow.py]\nafter: {expand: slow}")
    watcher = Watcher()
    pipeline.watch(watcher)
    pipeline.run()
    around = [(when, name) for name in RAN for when in ("before", "after")]
    slow = [("before", "slow"), ("at", "half"), ("after", "slow")]
    assert watcher.seen == [*around[:2], *slow, *around[2:]]


def test_who_watches_one_pipeline_sees_no_other(tmp_path: Path) -> None:
    """Without files of a config, all have the same plugins."""
    watched, other, watcher = pipeline_of(tmp_path), pipeline_of(tmp_path), Watcher()
    assert watched.plugins is other.plugins
    watched.watch(watcher)
    other.run()
    assert watcher.seen == []


def test_a_run_stops_after_a_pass(tmp_path: Path) -> None:
    pipeline = pipeline_of(tmp_path)
    conversion = pipeline.run(stop_after="prune-massless")
    assert conversion.segments
    assert not conversion.mbs.bodies[0].joints
    assert not conversion.files
    with pytest.raises(ConfigError, match="to stop after\n  did you mean 'layout'"):
        pipeline.run(stop_after="layuot")
    # also at a pass of a plugin that has no work with this robot
    for name in [name for name in NINE[: NINE.index("emit")] if name not in WORK][:1]:
        assert not pipeline.run(stop_after=name).files


def test_a_preset_that_was_used_before_is_no_other_config_s(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(
        "from urdf2mbs.hookspecs import hookimpl\n@hookimpl\n"
        "def urdf2mbs_presets(): return {'faithful': {'pipeline': ['expand', 'insert-base']}}\n"
    )
    for text, wanted, joints in (
        ("passes: {prune-massless: {keep: ['*']}}", NINE, ["*"]),
        (
            "plugins: [own.py]",
            [name for name in NINE if name in JOINED],
            None,
        ),
        ("without: [left-out]", [name for name in NINE if name != "left-out"], []),
        ("", NINE, []),
    ):
        found: dict[str, Any] = {
            one.pass_.name: one.pass_ for one in pipeline_of(tmp_path, text).passes
        }
        assert list(found) == wanted
        assert joints is None or found["prune-massless"].keep == joints


def test_convert_writes_nothing(here: Path) -> None:
    result = convert("tiny.urdf")
    assert [file.name for file in here.iterdir()] == ["tiny.urdf"]
    assert isinstance(result.mbs, Mbs)
    assert isinstance(result.robot, Robot)
    assert result.data.startswith(b"<?xml")
    assert result.names.bodies["arm"] == "arm"
    assert result.frames["tool"].body == "hand"
    assert result.frozen == {}
    report = json.loads(json.dumps(msgspec.to_builtins(result.report)))
    assert (report["bodies"], report["proof"]["same"]) == (3, True)
    assert {d.code for d in result.diagnostics} >= {"joint-dynamics", "collision", "extension"}


def test_the_tiny_robot_has_what_it_promises() -> None:
    result = convert_text()
    assert_same_robot(result)
    assert len(next(b for b in result.mbs.bodies if b.name == "hand").joints) == 4
    assert convert_text(base="fixed").conversion.base.floating is False


def test_another_robot_is_not_the_same() -> None:
    heavier = TINY.replace('<mass value="0.5"/>', '<mass value="0.6"/>')
    with pytest.raises(AssertionError, match=r"mass is 0.5 in the .mbs; expected 0.6"):
        assert_same_robot(convert_text(), expected=convert_text(heavier))


# --- dumps -----------------------------------------------------------------------------------
