"""`verify CONFIG` expects the robot that the config's passes make, such as one with a payload."""

import json
from pathlib import Path

import pytest

from support.presets import PRESETS
from urdf2mbs import Config, convert, verify
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY

PASSES = '''
from urdf2mbs.plugin import Pass, hookimpl


class Payload(Pass):
    """Add a payload to the hand."""

    reads = ("robot",)
    writes = ("robot",)
    kg: float = 0.5

    def run(self, conversion):
        conversion.robot.links["hand"].inertial.mass += self.kg


class Secret(Payload):
    writes = ()


class Lock(Pass):
    """Hold a joint at zero."""

    writes = ("joints",)

    def run(self, conversion):
        for step in conversion.steps():
            if step.joint.name == "wrist_roll":
                for joint in step.coordinates:
                    joint.nature, joint.q, joint.symbols = "driven", 0.0, ("q",)
                step.coordinates = []
                conversion.frozen["wrist_roll"] = "locked"


class Rename(Pass):
    """Give a joint of the .mbs a name of the lab."""

    reads = writes = ("joints",)

    def run(self, conversion):
        for step in conversion.steps():
            if step.joint.name == "shoulder":
                step.coordinates[0].name = "j1"


@hookimpl
def urdf2mbs_passes():
    return [Payload, Secret, Lock, Rename]
'''
CONFIG = "source: tiny.urdf\noutput: out/tiny.mbs\nplugins: [lab.py]\n"
PAYLOAD = f"{CONFIG}after: {{expand: payload}}\n"


@pytest.fixture
def lab(here: Path) -> Path:
    """The folder of a robot, of its config with a payload, and of the config's output."""
    (here / "lab.py").write_text(PASSES)
    (here / "lab.yaml").write_text(PAYLOAD)
    assert main(["run", "lab.yaml", "-q"]) == 0
    return here


def test_the_payload_of_a_config_is_no_difference(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["verify", "tiny.urdf", "out/tiny.mbs"]) == 3
    capsys.readouterr()
    for words in (["out/tiny.mbs"], []):
        assert main(["verify", "lab.yaml", *words]) == 0
        told = capsys.readouterr().out
        assert told.endswith("the same robot, but for what payload changed: 1 mass\n")
        assert "the robot is that of lab.yaml; the model is out/tiny.mbs" in told
    assert main(["verify", "out/tiny.mbs", "lab.yaml"]) == 0
    capsys.readouterr()
    assert main(["verify", "lab.yaml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "the same robot, but for what payload changed: 1 mass"
    assert found["model"].endswith("out/tiny.mbs")


def test_a_model_without_the_payload_is_another_robot(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (lab / "plain.mbs").write_bytes(convert("tiny.urdf").data)
    assert main(["verify", "lab.yaml", "plain.mbs"]) == 3
    told = capsys.readouterr().out
    assert "link 'hand': mass is 0.1 in the .mbs" in told
    assert told.endswith("NOT the same robot\n")


def test_what_changes_after_the_run_is_found(lab: Path) -> None:
    """A new payload, a new URDF and an edited model are each another robot."""
    verdict = verify("lab.yaml", passes={"payload": {"kg": 0.7}})
    assert [found.kind for found in verdict.differences] == ["mass"]
    model = lab / "out" / "tiny.mbs"
    text = model.read_text()
    model.write_text(text.replace("<mass>2.0<", "<mass>3.0<"))
    assert not verify("lab.yaml").same
    model.write_text(text)
    assert verify("lab.yaml").same
    (lab / "tiny.urdf").write_text(TINY.replace('<mass value="2"/>', '<mass value="4"/>'))
    assert not verify("lab.yaml").same


def test_a_change_that_no_pass_declares_is_a_difference(lab: Path) -> None:
    (lab / "secret.yaml").write_text(f"{CONFIG}after: {{expand: secret}}\n")
    verdict = verify("secret.yaml", "out/tiny.mbs")
    assert [found.kind for found in verdict.differences] == ["changed"]


def test_a_config_object_will_do(lab: Path) -> None:
    config = Config(source="tiny.urdf", plugins=["lab.py"], after={"expand": "payload"})
    assert verify(config, "out/tiny.mbs").same
    assert verify(Path("lab.yaml"), Path("out", "tiny.mbs")).same


@pytest.mark.parametrize("pass_", ["lock", "rename"])
@pytest.mark.parametrize("preset", sorted({"faithful", "compact"} & set(PRESETS)))
def test_the_verdict_is_that_of_run(pass_: str, preset: str, lab: Path) -> None:
    """Joints that passes hold or rename are known, and so are frames that `compact` moves."""
    text = f"{CONFIG}pipeline: {preset}\nafter: {{decompose-joints: {pass_}}}\n"
    (lab / "other.yaml").write_text(text)
    result = convert("other.yaml")
    result.write(force=True)
    assert verify("other.yaml").verdict == result.report.verdict
    strict = verify("other.yaml", frames=True)
    assert strict.same
    assert not strict.frames


def test_a_model_with_other_names_is_matched_by_those_of_its_joints(lab: Path) -> None:
    (lab / "locked.yaml").write_text(f"{CONFIG}after: {{decompose-joints: lock}}\n")
    text = convert("locked.yaml").data.decode()
    renamed = text.replace(">hand<", ">gripper<")
    assert renamed != text
    (lab / "drawn.mbs").write_text(renamed)
    verdict = verify("locked.yaml", "drawn.mbs")
    assert verdict.verdict == "the same robot, but for joint 'wrist_roll' (held at zero: locked)"


def test_a_base_that_the_config_does_not_have_is_a_difference(lab: Path) -> None:
    (lab / "fixed.mbs").write_bytes(convert("lab.yaml", base="fixed").data)
    assert not verify("lab.yaml", "fixed.mbs").same
    assert verify("lab.yaml", "fixed.mbs", base="fixed").same
    assert not verify("lab.yaml", base="fixed").same


def test_gravity_is_that_of_the_config(lab: Path) -> None:
    (lab / "moon.yaml").write_text(f"{PAYLOAD}gravity: [0, 0, -1.62]\n")
    assert [found.kind for found in verify("moon.yaml").differences] == ["gravity"]


@pytest.mark.parametrize(
    ("words", "message", "hint"),
    [
        ("lab.yaml none.mbs", "cannot read 'none.mbs'", ""),
        ("new.yaml", "no model to compare: 'new.mbs' does not exist", "urdf2mbs run new.yaml"),
        ("tiny.urdf", "no model to compare", "urdf2mbs verify tiny.urdf MODEL.mbs"),
        ("out/tiny.mbs", "no robot to compare", "urdf2mbs verify ROBOT out/tiny.mbs"),
        ("lab.yaml --base fixed", "--base is for a robot without a config", "lab.yaml"),
        ("lab.yaml --gravity 0 0 -9.8", "--gravity is for a robot without a config", "lab.yaml"),
        ("xml.yaml", "this is XML, such as a robot, and no config", "urdf2mbs convert xml.yaml"),
        ("typo.yaml", "typo.yaml:4", "did you mean 'payload'"),
    ],
)
def test_errors_say_what_to_do(
    words: str, message: str, hint: str, lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (lab / "new.yaml").write_text("source: tiny.urdf\noutput: new.mbs\n")
    (lab / "xml.yaml").write_text(TINY)
    (lab / "typo.yaml").write_text(PAYLOAD.replace(": payload", ": paylod"))
    assert main(["verify", *words.split()]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert hint in told


def test_a_config_stands_for_a_robot_on_either_side(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The payload is part of the robot of lab.yaml, and not of tiny.urdf."""
    (lab / "plain.yaml").write_text("source: tiny.urdf\noutput: plain.mbs\n")
    for words in ("tiny.urdf lab.yaml", "lab.yaml tiny.urdf", "lab.yaml plain.yaml"):
        assert main(["verify", *words.split()]) == 3
        assert "mass is" in capsys.readouterr().out
    for words in ("tiny.urdf plain.yaml", "plain.yaml tiny.urdf", "lab.yaml lab.yaml"):
        assert main(["verify", *words.split()]) == 0
        assert "the same robot" in capsys.readouterr().out


def test_from_python_errors_are_the_same(lab: Path) -> None:
    with pytest.raises(ConfigError, match="no model to compare"):
        verify("tiny.urdf")
    with pytest.raises(ConfigError, match="unknown key 'bases'"):
        verify("lab.yaml", bases="fixed")
