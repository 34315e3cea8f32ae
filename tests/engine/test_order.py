"""Each order of the passes gives the same file, or is refused: what a pass changed is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from making import make, passes_of
from urdf2mbs.config.model import Config, Key, Lines, typed
from urdf2mbs.engine.order import check_order
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.sections import SECTIONS, find_changed, look
from urdf2mbs.hookspecs import Pass, hookimpl
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs.testing import run_pass

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
BUILT_IN = {name: found[0].kind for name, found in Plugins(installed=False).passes.items()}
PRESETS = ("faithful", "compact")

#: Robots of ours, and options with which all passes have something to do.
ROBOTS: dict[str, tuple[Path, dict[str, dict[str, Any]]]] = {
    "biped": (
        CONFIGS / "biped.urdf.xacro",
        {
            "contacts": {"links": ["*foot*"]},
            "posture": {"joints": {"*_knee": 0.6}, "hold": {"stiffness": 300, "damping": 4}},
            "prune-massless": {"keep": ["*_hip_*"]},
            "rotors": {"armature": {"*_knee": 0.1}},
            "equations": {"language": "python"},
            "sensors": {"links": ["imu"]},
            "forces": {
                "wrenches": {"push": {"link": "chest", "force": [10, 0, 0], "stop": 0.1}},
                "springs": {
                    "band": {"ends": [{"link": "left_foot"}, {"link": "right_foot"}],
                             "stiffness": 20.0}
                },
            },
        },
    ),
    # a loop that <gazebo> closes, and a mesh
    "lamp": (
        CONFIGS / "lamp.urdf",
        {
            "posture": {"hold": {}},
            "estimate-inertia": {"density": 500.0},
            "force-torque": {"joints": ["desk"]},
            "actuators": {"joints": ["front"]},
        },
    ),
    # a finger that follows the other
    "arm": (
        CONFIGS / "arm.urdf.xacro",
        {"posture": {"joints": {"elbow": 0.5}}, "snap": {"angle": 1e-4}},
    ),
}  # fmt: skip


def pipeline(robot: str, preset: str | list[str], folder: Path) -> Pipeline:
    source, options = ROBOTS[robot]
    given = {
        "source": str(source), "output": {"project": str(folder)}, "pipeline": preset,
        "passes": options,
    }  # fmt: skip
    return Pipeline(typed(Config, given, Lines()), Lines())


class Seen:
    """What each pass changes."""

    def __init__(self) -> None:
        self.sections: dict[str, set[str]] = {}

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Any) -> None:
        self.before = look(conversion)

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Any) -> None:
        now = find_changed(self.before, look(conversion))
        self.sections.setdefault(pass_.name, set()).update(now)


#: Passes that change no section: they look, write files, or say how to simulate.
ONLY_LOOK = {
    "certificate", "check", "equations", "find-singular", "left-out", "project",
}  # fmt: skip


@pytest.mark.parametrize("preset", PRESETS)
def test_built_in_passes_say_what_they_change(
    preset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All that they change, and nothing that they do not."""
    seen, mirrored = Seen(), tmp_path / "mirrored.urdf"
    text = (CONFIGS / "lamp.urdf").read_text().replace("meshes/", f"{CONFIGS}/meshes/")
    mirrored.write_text(text.replace('shade.obj"', 'shade.obj" scale="1 -1 1"'))
    monkeypatch.setitem(ROBOTS, "mirrored", (mirrored, {}))
    for robot in ROBOTS:
        whole = pipeline(robot, preset, tmp_path / robot)
        whole.watch(seen)
        whole.run()
    for name, sections in seen.sections.items():
        if name == "merge":  # which has nothing to do where nobody has edited
            continue
        assert sections == set(BUILT_IN[name].writes), name
        assert bool(sections) == (name not in ONLY_LOOK), name


def test_sections_are_the_words_of_the_passes() -> None:
    words = {section for kind in BUILT_IN.values() for section in (*kind.reads, *kind.writes)}
    assert words == set(SECTIONS)


@pytest.mark.parametrize("preset", PRESETS)
def test_each_order_gives_the_same_bytes_or_is_refused(preset: str, tmp_path: Path) -> None:
    names = passes_of(preset)
    refused = 0
    for name in names:
        rest = [other for other in names if other != name]
        for place in range(len(names)):
            order = [*rest[:place], name, *rest[place:]]
            if order == names:
                pipeline("biped", order, tmp_path)
                continue
            with pytest.raises(ConfigError) as wrong:
                pipeline("biped", order, tmp_path)
            assert wrong.value.code == "wrong-order"
            assert wrong.value.hint
            refused += 1
    assert refused == len(names) * (len(names) - 1)


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
                 "passes": {"align-frames": {"tolerance": 1e-8}, "snap": {"angle": 1e-4}}},
        "more": {"extends": "ours", "passes": {"align-frames": {"tolerance": 1e-6}}},
        "round": {"extends": "trip"}, "trip": {"extends": "round"},
        "lost": {"extends": "compakt"},
    }
"""


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
        assert (passes["align-frames"].tolerance, passes["snap"].angle) == (tolerance, 1e-4)
    for name, said in (("round", "preset-circle"), ("lost", "'compakt', which 'lost' extends")):
        with pytest.raises(ConfigError, match=said):
            of(name)
