"""Each order of the passes gives the same file, or is refused: what a pass changed is seen."""

import re
from pathlib import Path
from typing import Any

import pytest

from support.plugin_files import make, passes_of
from support.presets import PRESETS
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.model import Config
from urdf2mbs.engine.order import ConfiguredPass, check_order
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.sections import SECTIONS
from urdf2mbs.hookspecs import Pass, PassEntry
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import convert_text, run_pass

BUILT_IN = {name: found[0].load() for name, found in Plugins(installed=False).passes.items()}


def test_sections_are_the_words_of_the_passes() -> None:
    words = {section for kind in BUILT_IN.values() for section in (*kind.reads, *kind.writes)}
    of_plugins = {"couplings", "base-position"}
    assert words | of_plugins == set(SECTIONS)


A = make("a", lambda c, o: None, writes=("robot",))
B = make("b", lambda c, o: None, reads=("robot",), writes=("bodies",))
C = make("c", lambda c, o: None, reads=("bodies",), writes=("joints",))
D = make("d", lambda c, o: None, reads=("robot",))
E = make("e", lambda c, o: None, writes=("posture",))


@pytest.mark.parametrize(
    ("passes", "code", "said"),
    [
        ([A, B, C], "", ""),
        ([A, B, C, D], "", ""),
        ([A, A, B, C], "", ""),
        ([A, D, A, B], "", ""),
        ([A, B, A], "", "what a pass really changes is seen in the run"),
        ([B], "need-not-given", "pass 'b' reads the robot, which no pass of this pipeline writes"),
        ([B, A], "wrong-order", "pass 'b' reads the robot, which 'a' writes only later"),
        (
            [A, E],
            "need-not-given",
            "writes the posture of the joints and so reads the joints",
        ),
        ([A, E, B, C], "wrong-order", "the joints, which 'c' writes only later"),
        ([A, B, C, E], "", ""),
    ],
)
def test_places_of_passes_of_plugins(passes: list[type[Pass]], code: str, said: str) -> None:
    steps = [
        ConfiguredPass(
            PassEntry(kind.name, "", (), kind=kind), {}, (), Lines(), swapped=False, named=False
        )
        for kind in passes
    ]
    if not code:
        check_order(steps, [], Lines())
        return
    with pytest.raises(ConfigError) as wrong:
        check_order(steps, [], Lines())
    assert (wrong.value.code, said in wrong.value.message) == (code, True), wrong.value.message


def test_one_error_names_all_passes_that_need_what_is_left_out() -> None:
    text = '<robot name="r"><link name="world"/></robot>'
    with pytest.raises(ConfigError, match="need-not-given") as wrong:
        convert_text(text, without=["emit"])
    hint = str(wrong.value.hint)
    needing = re.search(r"without: \[(.*)\]", hint)
    assert needing is not None, hint
    assert "check" in needing[1].split(", ")
    result = convert_text(text, without=["emit", *needing[1].split(", ")])
    assert not result.conversion.files


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
        ("emit", "conversion.mbs.bodies[0].mass = 3.0", "inertias", "emit"),
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


BEND = """
from urdf2mbs.plugin import Pass, hookimpl

class Bend(Pass):
    reads = ("joints",)
    writes = ("posture",)

    def run(self, conversion):
        for step, joint in conversion.single_coordinates():
            joint.q = 0.25

@hookimpl
def urdf2mbs_passes():
    return [Bend]
"""


@pytest.mark.parametrize("preset", PRESETS)
def test_an_honest_pass_is_refused_only_where_its_change_is_too_late(
    preset: str, tmp_path: Path
) -> None:
    """It changes a posture: where there are joints, and before the diagram is drawn of it."""
    file = tmp_path / "bend.py"
    file.write_text(BEND)
    outcomes: dict[str, str] = {}
    messages: dict[str, str] = {}
    for place in passes_of(preset):
        try:
            result = run_pass("bend", file, after=place, pipeline=preset)
            assert result.mbs.joints()["shoulder"].q == 0.25
            assert "undeclared" not in {found.code for found in result.diagnostics}
            outcomes[place] = "taken"
        except ConversionError as error:
            outcomes[place], messages[place] = error.code, error.message
    names = list(outcomes)
    first, last = names.index("decompose-joints"), names.index("layout")
    assert {outcomes[name] for name in names[:first]} == {"wrong-order"}
    assert {outcomes[name] for name in names[first:last]} == {"taken"}
    assert {outcomes[name] for name in names[last:]} <= {"stale", "plugin-output-broken"}
    assert "pass 'bend' changes the posture after pass 'layout' made" in messages["layout"]


def test_a_pass_that_does_not_declare_what_it_changes_is_named(tmp_path: Path) -> None:
    file = tmp_path / "bend.py"
    file.write_text(BEND.replace('writes = ("posture",)', ""))
    found = run_pass("bend", file, after="collect-anchors").diagnostics
    (told,) = [one for one in found if one.code == "undeclared"]
    assert "pass 'bend' of plugin 'bend' changes the posture" in told.message
    assert told.hint == "add to its 'writes': 'posture'"


@pytest.mark.skipif("posture" not in BUILT_IN, reason="the plugin project is away")
def test_our_own_pass_that_changes_what_a_strangers_pass_used_is_refused(tmp_path: Path) -> None:
    """A stranger's pass that makes forces from a posture stands before the pass 'posture'."""
    file = tmp_path / "early.py"
    text = BEND.replace('reads = ("joints",)', 'reads = ("joints", "posture")')
    text = text.replace('writes = ("posture",)', 'writes = ("forces",)').replace("Bend", "Early")
    file.write_text(text.replace("joint.q = 0.25", "joint.q"))
    options = {"posture": {"joints": {"shoulder": 0.5}}}
    late = {"plugins": [file], "passes": options, "after": {"posture": "early"}}
    convert_text(**late)
    with pytest.raises(ConversionError) as wrong:
        convert_text(**late | {"after": {"decompose-joints": "early"}})
    assert wrong.value.code == "stale"
    assert "pass 'posture' changes the posture after pass 'early' made" in wrong.value.message


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
