"""All passes of ours say what they change, and stand in one order."""

from pathlib import Path
from typing import Any

import pytest

from support.folders import CONFIGS
from support.plugin_files import passes_of
from support.rich_robot import PASSES, RICH
from support.touches import NAME, record
from urdf2mbs.config.lines import Lines
from urdf2mbs.config.load import typed
from urdf2mbs.config.model import Config
from urdf2mbs.engine.contract import find_stale
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.engine.sections import IMPLIED, compare, take_snapshot
from urdf2mbs.hookspecs import Pass, hookimpl
from urdf2mbs.messages.diagnostics import ConfigError

BUILT_IN = {name: found[0].load() for name, found in Plugins(installed=False).passes.items()}


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
                    "band": {
                        "ends": [{"link": "left_foot"}, {"link": "right_foot"}],
                        "stiffness": 20.0,
                    }
                },
            },
        },
    ),
    # it stands, so that its motors have to hold it
    "standing": (
        CONFIGS / "biped.urdf.xacro",
        {"contacts": {"links": ["*"]}, "posture": {"hold": {"frequency": 10}}},
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
}


def pipeline(robot: str, preset: str | list[str], folder: Path) -> Pipeline:
    source, options = ROBOTS[robot]
    given = {
        "source": str(source),
        "output": {"project": str(folder)},
        "pipeline": preset,
        "passes": options,
    }
    return Pipeline(typed(Config, given, Lines()), Lines())


class Seen:
    """What each pass changes, and what of that came too late."""

    def __init__(self) -> None:
        self.sections: dict[str, set[str]] = {}
        self.ran: list[type[Pass]] = []
        self.stale: list[str] = []

    @hookimpl
    def urdf2mbs_before_pass(self, pass_: Pass, conversion: Any) -> None:
        self.before = take_snapshot(conversion)

    @hookimpl
    def urdf2mbs_after_pass(self, pass_: Pass, conversion: Any) -> None:
        change = compare(self.before, take_snapshot(conversion))
        self.sections.setdefault(pass_.name, set()).update(change.changed)
        found = find_stale(type(pass_), change.altered, self.ran)
        self.stale += [found[0]] if found else []
        self.ran.append(type(pass_))


#: Passes that change no section: they look, write files, or say how to simulate.
ONLY_LOOK = {
    "certificate",
    "check",
    "equations",
    "find-singular",
    "left-out",
    "project",
}


@pytest.mark.parametrize("preset", PRESETS)
def test_built_in_passes_say_what_they_change(
    preset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All that they change, and nothing that they do not."""
    seen, mirrored = Seen(), tmp_path / "mirrored.urdf"
    text = (CONFIGS / "lamp.urdf").read_text().replace("meshes/", f"{CONFIGS}/meshes/")
    mirrored.write_text(text.replace('shade.obj"', 'shade.obj" scale="1 -1 1"'))
    monkeypatch.setitem(ROBOTS, "mirrored", (mirrored, {}))
    rich = tmp_path / "rich.urdf"
    rich.write_text(RICH)
    monkeypatch.setitem(ROBOTS, "rich", (rich, PASSES))
    for robot in ROBOTS:
        whole = pipeline(robot, preset, tmp_path / robot)
        whole.watch(seen)
        seen.ran = []
        whole.run()
    assert seen.stale == [], "our own passes keep the contract among themselves"
    for name, sections in seen.sections.items():
        if name == "merge":  # which has nothing to do where nobody has edited
            continue
        writes = set(BUILT_IN[name].writes)
        implied = {IMPLIED[section] for section in writes if section in IMPLIED}
        assert sections - implied == writes, name
        assert bool(sections) == (name not in ONLY_LOOK), name


#: Passes behind ``emit`` read the file, and with it all that it was made of.
OF_THE_FILE = {"mbs-file", "couplings", "base-position", *BUILT_IN["emit"].reads}


def test_built_in_passes_say_what_they_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All that they use for another section, and nothing that they never use.

    What a pass uses only for what it writes itself, it need not say.
    """
    rich = tmp_path / "rich.urdf"
    rich.write_text(RICH)
    monkeypatch.setitem(ROBOTS, "rich", (rich, PASSES))
    used: dict[str, set[str]] = {}
    for preset in PRESETS:
        for robot in ROBOTS:
            for name, sections in record(pipeline(robot, preset, tmp_path / robot)).items():
                used.setdefault(name, set()).update(sections)
    for name, sections in used.items():
        kind = BUILT_IN[name]
        reads = set(kind.reads)
        implied = OF_THE_FILE if "mbs-file" in reads else set()
        assert sections - {NAME} <= {*reads, *kind.writes} | implied, name
        if NAME in sections:
            sections.add("names")
        if not implied:
            assert reads <= sections, name


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
