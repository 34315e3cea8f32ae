"""What a robot's own file says of a config lies beneath the user's config, key by key."""

import json
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs import convert, verify
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

READER = """
from typing import Annotated

from msgspec import Meta

from urdf2mbs.plugin import ConfigError, Expansion, Pass, hookimpl
from urdf2mbs.testing import TINY


class Seen:
    mass = 0.0


@hookimpl
def urdf2mbs_read(source, data):
    if source.suffix == ".moon":
        seen = Seen()
        seen.mass = 7.0
        return Expansion(TINY.encode(), [str(source)], [], {settings!r}, {{Seen: seen}})


class LookAtIt(Pass):
    after = ("expand",)
    reads = ("robot",)

    weights: dict[str, Annotated[float, Meta(gt=0.0)]] = {{}}

    def run(self, conversion):
        if "nothing" in self.weights:
            raise ConfigError("look", "there is no link 'nothing'")
        conversion.report["seen"] = [conversion.state(Seen).mass, self.weights]


@hookimpl
def urdf2mbs_passes():
    return [LookAtIt]
"""
MOON = {
    "gravity": [0, 0, -1.62],
    "passes": {
        "look-at-it": {"weights": {"arm": 0.3, "hand": 0.1}},
        "layout": {"style": "tree"},
        "no-such-pass": {"x": 1},
    },
}


@pytest.fixture
def moon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_reader(MOON)
    Path("robot.moon").write_text("a robot on the moon")
    return Path("robot.moon")


def write_reader(settings: dict[str, Any]) -> None:
    Path("reader.py").write_text(READER.format(settings=settings))


def convert_moon(**fields: Any) -> Any:
    return convert("robot.moon", plugins=["reader.py"], **fields)


def test_the_settings_of_the_robot_are_used_and_named(moon: Path) -> None:
    result = convert_moon()
    assert result.mbs.base.gravity == (0, 0, -1.62)
    assert result.report.passes["seen"] == [7.0, {"arm": 0.3, "hand": 0.1}]
    used = {name: MOON["passes"][name] for name in ("look-at-it", "layout")}
    assert result.report.robot_settings == {"gravity": [0, 0, -1.62], "passes": used}
    (note,) = [said for said in result.diagnostics if said.code == "robot-settings"]
    assert "gravity 0 0 -1.62, look-at-it.weights (2), layout.style" in note.message
    assert result.report.verdict == "the same robot"


def test_the_config_overrules_key_by_key(moon: Path) -> None:
    passes = {"look-at-it": {"weights": {"arm": 0.4}}}
    result = convert_moon(passes=passes, gravity=(0, 0, -9.81))
    assert result.mbs.base.gravity == (0, 0, -9.81)  # also where it is the default
    assert result.report.passes["seen"] == [7.0, {"arm": 0.4, "hand": 0.1}]
    used = {"look-at-it": {"weights": {"hand": 0.1}}, "layout": {"style": "tree"}}
    assert result.report.robot_settings == {"passes": used}
    used = convert_moon(without=["look-at-it"]).report.robot_settings["passes"]
    assert used.keys() == {"layout"}
    config = Path("moon.yaml")
    config.write_text(
        "source: robot.moon\nplugins: [reader.py]\ngravity: [0, 0, -9.81]\n"
        "passes: {look-at-it: {weights: {arm: 0.5}}}\n"
    )
    result = convert(config)
    assert result.mbs.base.gravity == (0, 0, -9.81)
    assert result.report.passes["seen"] == [7.0, {"arm": 0.5, "hand": 0.1}]


def test_commands_say_what_the_robot_has_set(moon: Path, capsys: Any) -> None:
    words = ["convert", "robot.moon", "--plugin", "reader.py"]
    said = "set by robot.moon, unless the config says otherwise: gravity 0 0 -1.62, look-at-it"
    assert main([*words, "--plan"]) == 0
    assert said in capsys.readouterr().out
    assert main([*words, "--plan", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["robot_settings"]["gravity"] == [0, 0, -1.62]
    assert main(words) == 0
    assert said in capsys.readouterr().out
    Path("moon.yaml").write_text("source: robot.moon\nplugins: [reader.py]\n")
    assert verify("moon.yaml", "robot.moon.mbs").same
    Path("earth.urdf").write_text(TINY)
    convert("earth.urdf").write()
    differences = verify("moon.yaml", "earth.mbs").differences
    assert [difference.kind for difference in differences] == ["gravity"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"output": "x.mbs"}, "'output'; expected base, gravity, passes"),
        ({"gravity": 9.81}, "gravity"),
        ({"passes": {"layout": {"stile": "tree"}}}, "unknown key 'passes.layout.stile'"),
        ({"passes": {"look-at-it": {"weights": {"arm": -1.0}}}}, "look-at-it.weights.arm"),
    ],
)
def test_settings_that_no_config_has_are_errors(
    moon: Path, settings: dict[str, Any], said: str
) -> None:
    write_reader(settings)
    with pytest.raises(ConversionError, match=r"robot\.moon") as caught:
        convert_moon()
    assert caught.value.code == "robot-settings-invalid"
    assert said in caught.value.message


def test_an_error_about_an_option_names_the_file_that_set_it(moon: Path) -> None:
    write_reader({"passes": {"look-at-it": {"weights": {"nothing": 1.0}}}})
    with pytest.raises(ConversionError) as caught:
        convert_moon()
    assert caught.value.hint == "robot.moon sets 'look-at-it.weights'; the config overrules it"


def test_a_second_opinion_is_part_of_the_verdict(moon: Path) -> None:
    Path("opinion.py").write_text("""
from urdf2mbs.plugin import Difference, Pass, SecondOpinions, hookimpl


class AskAnother(Pass):
    after = ("expand",)
    reads = ("robot",)

    differs: bool = False

    def run(self, conversion):
        opinions = conversion.state(SecondOpinions)
        if self.differs:
            opinions.differences.append(Difference("other", "another program says 3 kg"))
        else:
            opinions.confirmed.append("as another program computes it")


@hookimpl
def urdf2mbs_passes():
    return [AskAnother]
""")
    Path("tiny.urdf").write_text(TINY)
    result = convert("tiny.urdf", plugins=["opinion.py"])
    said = "the same robot, and as another program computes it"
    assert result.report.verdict == said
    result.write()
    config = Path("tiny.yaml")
    config.write_text("source: tiny.urdf\nplugins: [opinion.py]\n")
    assert verify(config).verdict == said
    config.write_text(f"{config.read_text()}passes: {{ask-another: {{differs: true}}}}\n")
    assert [each.message for each in verify(config).differences] == ["another program says 3 kg"]
    assert convert(config).conversion.checked.rejected is not None
