"""Robots by name: found in the cache of robot_descriptions, and told plainly where they are not."""

import sys
from pathlib import Path

import pytest

from support.descriptions import offline, stand_in
from support.folders import CONFIGS
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.config.load import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import TINY
from urdf2mbs_xacro import descriptions

XACRO = """<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="ur_type" default=""/>
  <link name="$(arg ur_type)"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""


@pytest.fixture(autouse=True)
def _forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test leaves an imported description to the next."""
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if name.startswith("robot_descriptions.") and name.endswith("_description"):
            del sys.modules[name]


def test_a_robot_of_robot_descriptions_is_read_from_its_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = stand_in(monkeypatch, tmp_path, "cassie_description", {"urdf/cassie_v4.urdf": TINY})
    result = convert("robot_descriptions:cassie_description")
    assert result.robot.name == "tiny"
    assert result.conversion.settings.source == folder / "urdf" / "cassie_v4.urdf"
    # what is written goes where the user is, and never into the cache
    assert result.conversion.settings.output == Path.cwd() / "cassie_v4.mbs"


def test_the_arguments_of_an_xacro_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = "Universal_Robots_ROS2_Description"
    stand_in(monkeypatch, tmp_path, name, {"urdf/ur.urdf.xacro": XACRO})
    described = descriptions.locate("robot_descriptions:ur5e_description")
    assert described.xacro_args["ur_type"] == "ur5e"
    result = convert("robot_descriptions:ur5e_description", base="fixed")
    assert "ur5e" in result.robot.links
    second = convert("robot_descriptions:ur5e_description", xacro_args={"ur_type": "mine"})
    assert "mine" in second.robot.links


@pytest.mark.parametrize(
    ("name", "code", "hint"),
    [
        ("atlas_v4_descriptoin", "unknown-description", "did you mean 'atlas_v4_description'?"),
        ("atlas", "unknown-description", "there are: atlas_drc_description, atlas_v4_description"),
        ("../evil", "unknown-description", ""),
        ("cassie_mj_description", "description-no-urdf", "did you mean 'cassie_description'?"),
        ("nextage_description", "description-unreachable", "connect to the network once"),
    ],
)
def test_no_such_robot(
    name: str, code: str, hint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    offline(monkeypatch, tmp_path)
    if code == "description-no-urdf":
        stand_in(monkeypatch, tmp_path, "mujoco_menagerie", {"agility_cassie/cassie.xml": "x"})
    with pytest.raises(ConfigError) as caught:
        convert(f"robot_descriptions:{name}")
    assert caught.value.code == code
    assert hint in (caught.value.hint or "")


#: Config: repository, the robot's file there, the file here that stands for it.
OURS = {
    "atlas": (
        "roboschool",
        "roboschool/models_robot/atlas_description/urdf/atlas_v4_with_multisense.urdf",
        "atlas/expanded/atlas_v4.urdf",
    ),
    "icub": ("icub-models", "iCub/robots/iCubGazeboV2_5/model.urdf", "icub/{}"),
    "cassie": ("cassie_description", "urdf/cassie_v4.urdf", "cassie/cassie_description/{}"),
}


@pytest.mark.parametrize("name", OURS)
def test_our_configs_run_by_name(
    name: str, shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    repository, file, part = OURS[name]
    robot = shared / "robots" / part.format(file)
    stand_in(monkeypatch, tmp_path, repository, {file: robot})
    conversion = Pipeline(*load(CONFIGS / f"{name}.yaml")).run()
    assert conversion.checked.proof is not None
    assert conversion.checked.proof.same


@pytest.mark.parametrize(
    ("name", "variable", "folder"),
    [("nao", "NAO_ROBOT", "nao"), ("walkman", "WALKMAN", "walkman/robotran_edu_2017")],
)
def test_our_configs_run_by_a_variable(
    name: str,
    variable: str,
    folder: str,
    shared: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv(variable, raising=False)
    assert main(["explain", str(CONFIGS / f"{name}.yaml")]) == 2
    output = capsys.readouterr().err
    assert "error[variable-unset]" in output
    assert f"export {variable}=" in output
    monkeypatch.setenv(variable, str(shared / "robots" / folder))
    conversion = Pipeline(*load(CONFIGS / f"{name}.yaml")).run()
    assert conversion.checked.proof is not None
    assert conversion.checked.proof.same


def test_home_in_a_config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    (tmp_path / "tiny.urdf").write_text(TINY)
    config = tmp_path / "elsewhere" / "tiny.yaml"
    config.parent.mkdir()
    config.write_text("source: ~/tiny.urdf\noutput: ~/out/tiny.mbs\npackages: {us: ~/elsewhere}\n")
    settings = Pipeline(*load(config)).settings
    assert settings.source == tmp_path / "tiny.urdf"
    assert settings.output == tmp_path / "out" / "tiny.mbs"
    assert settings.packages == {"us": config.parent}
