"""Each order of the passes gives the same file, or is refused: what a pass changed is seen."""

from pathlib import Path
from typing import Any

import pytest

from making import make, passes_of
from presets import PRESETS
from urdf2mbs.config.model import Config, Key, Lines
from urdf2mbs.engine.order import check_order
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.sections import SECTIONS
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import run_pass

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
BUILT_IN = {name: found[0].kind for name, found in Plugins(installed=False).passes.items()}


def test_sections_are_the_words_of_the_passes() -> None:
    words = {section for kind in BUILT_IN.values() for section in (*kind.reads, *kind.writes)}
    assert words == set(SECTIONS)


A = make("a", lambda c, o: None, writes=("robot",))
B = make("b", lambda c, o: None, reads=("robot",), writes=("bodies",))
C = make("c", lambda c, o: None, reads=("bodies",), writes=("joints",))
D = make("d", lambda c, o: None, reads=("robot",))


@pytest.mark.parametrize(
    ("passes", "code", "said"),
    [
        ([A, B, C], "", ""),
        ([A, B, C, D], "", ""),
        ([A, A, B, C], "", ""),
        ([A, D, A, B], "", "a pass that only looks is never stale"),
        ([B], "need-not-given", "pass 'b' reads the robot, which no pass of this pipeline writes"),
        ([B, A], "wrong-order", "pass 'b' reads the robot, which 'a' writes only later"),
        ([A, B, A], "stale", "pass 'a' changes the robot after pass 'b' has made the bodies"),
        ([A, B, C, B], "stale", "pass 'b' changes the bodies after pass 'c' has made the joints"),
    ],
)
def test_places_of_passes_of_plugins(passes: list[type[Pass]], code: str, said: str) -> None:
    keys: list[Key] = [()] * len(passes)
    if not code:
        check_order(passes, [], Lines(), keys)
        return
    with pytest.raises(ConfigError) as wrong:
        check_order(passes, [], Lines(), keys)
    assert (wrong.value.code, said in wrong.value.message) == (code, True), wrong.value.message


LATE = """
from urdf2mbs.plugin import Pass, hookimpl

class Late(Pass):
    def run(self, conversion):
        {change}

@hookimpl
def urdf2mbs_passes():
    return [Late]
"""


@pytest.mark.parametrize(
    ("after", "change", "section", "reader"),
    [
        ("emit", "conversion.mbs.user_models.clear()", "forces", "assign-names"),
        ("emit", "conversion.mbs.bodies[0].mass = 3.0", "inertias", "joint-parameters"),
        ("layout", "conversion.mbs.bodies[0].points.clear()", "anchors", "assign-names"),
        ("decompose-joints", "conversion.segments['arm'].parts.clear()", "bodies", "reframe-"),
        ("check", "conversion.mbs.view = None", "view", "emit"),
    ],
)
def test_a_change_that_comes_too_late_is_seen(
    after: str, change: str, section: str, reader: str, tmp_path: Path
) -> None:
    file = tmp_path / "late.py"
    file.write_text(LATE.format(change=change))
    with pytest.raises(ConversionError) as wrong:
        run_pass("late", file, after=after)
    assert wrong.value.code == "stale"
    assert f"pass 'late' changes the {section} after pass '{reader}" in wrong.value.message
    assert wrong.value.file == str(file)


def test_a_change_in_time_is_none_of_the_order_s_business(tmp_path: Path) -> None:
    file = tmp_path / "late.py"
    file.write_text(LATE.format(change="conversion.mbs.bodies[0].points[0].name = 'socket'"))
    assert b"socket" in run_pass("late", file, after="collect-anchors").data


PRESET = """
from urdf2mbs.plugin import hookimpl

@hookimpl
def urdf2mbs_presets():
    return {
        "ours": {"extends": "compact", "without": ["fit-view"],
                 "passes": {"align-frames": {"tolerance": 1e-8}, "check": {"tolerance": 1e-8}}},
        "more": {"extends": "ours", "passes": {"align-frames": {"tolerance": 1e-6}}},
        "round": {"extends": "trip"}, "trip": {"extends": "round"},
        "lost": {"extends": "compakt"},
    }
"""


@pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")
def test_a_preset_extends_another(tmp_path: Path) -> None:
    (tmp_path / "presets.py").write_text(PRESET)

    def of(name: str) -> dict[str, Any]:
        config = Config(source="tiny.urdf", plugins=["presets.py"], pipeline=name)
        return {
            one.pass_.name: one.pass_ for one in Pipeline(config, Lines(folder=tmp_path)).passes
        }

    for name, tolerance in (("ours", 1e-8), ("more", 1e-6)):
        passes = of(name)
        assert list(passes) == [name for name in passes_of("compact") if name != "fit-view"]
        assert (passes["align-frames"].tolerance, passes["check"].tolerance) == (tolerance, 1e-8)
    for name, said in (("round", "preset-circle"), ("lost", "'compakt', which 'lost' extends")):
        with pytest.raises(ConfigError, match=said):
            of(name)
