"""Each part of an MJCF becomes what it is in MuJoCo, or is named as lost."""

from math import radians
from pathlib import Path
from typing import Any

import pytest

from support.mjcf import ARM, with_parts
from urdf2mbs import convert
from urdf2mbs.api import Result
from urdf2mbs.cli import main
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs_mjcf import is_mjcf

pytest.importorskip("mujoco")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def make(text: str, **fields: Any) -> Result:
    Path("robot.xml").write_text(text)
    return convert("robot.xml", **fields)


def make_project(text: str, **passes: Any) -> Result:
    return make(text, output={"project": "made"}, passes=passes)


def messages(result: Result) -> dict[str, str]:
    return {said.code: said.message for said in result.diagnostics if said.code.startswith("mjcf")}


def test_a_tree_with_all_joints_is_the_robot_of_mujoco() -> None:
    result = make(ARM)
    assert result.report.verdict.startswith("the same robot, and as MuJoCo computes it, to 1e-1")
    robot = result.robot
    types = {name: joint.type for name, joint in robot.joints.items()}
    assert types | {"tip_fixed": "fixed"} == types
    assert types["root"] == "floating"
    assert [types[f"wrist_R{k}"] for k in (1, 2, 3)] == ["continuous"] * 3
    shoulder, slide = robot.joints["shoulder"], robot.joints["slide"]
    assert shoulder.limit is not None
    assert (shoulder.limit.lower, shoulder.limit.upper) == (radians(-30), radians(60))
    assert shoulder.dynamics is not None
    assert shoulder.dynamics.damping == 1.0
    assert slide.type == "prismatic"
    assert slide.dynamics is not None
    assert slide.dynamics.spring_stiffness == 5.0
    assert slide.dynamics.spring_reference == pytest.approx(0.2)  # from ref
    assert result.mbs.base.gravity == (0.0, 0.0, -3.0)
    assert result.mbs.joints()["root_T3"].q == 1.0
    assert result.report.robot_settings == {"gravity": [0.0, 0.0, -3.0]}
    assert messages(result).keys() == {"mjcf-frame", "mjcf-soft"}
    assert "(2): upper, lower" in messages(result)["mjcf-frame"]


def test_messages_name_the_line_of_the_mjcf() -> None:
    (said,) = [said for said in make(ARM).diagnostics if said.code == "joint-ball"]
    assert said.file is not None
    assert (Path(said.file).name, said.line) == (
        "robot.xml",
        1 + ARM[: ARM.index('<joint name="wrist"')].count("\n"),
    )
    with pytest.raises(ConversionError, match=r"robot\.xml:10: error\[mjcf-invalid\].*joynt"):
        make(with_parts().replace('<joint name="two"', '<joynt name="two"'))


def test_sensors_of_a_site_become_sensors() -> None:
    result = make_project(ARM)
    sensors = [point.sensor for point in result.mbs.points().values() if point.sensor]
    assert len(sensors) == 1


def test_a_flag_takes_the_gravity_away() -> None:
    result = make(with_parts(option='<option><flag gravity="disable"/></option>'))
    assert result.mbs.base.gravity == (0.0, 0.0, 0.0)
    assert "as MuJoCo computes it" in result.report.verdict
    assert make(with_parts(), gravity=(0, 0, -1)).mbs.base.gravity == (0.0, 0.0, -1.0)


def test_the_keyframe_home_is_the_start() -> None:
    keys = '<keyframe><key name="x" qpos="1 2"/><key name="home" qpos=".3 -.2"/></keyframe>'
    result = make(with_parts(after=keys))
    joints = result.mbs.joints()
    assert [joints[name].q for name in ("one", "two")] == pytest.approx([0.3, -0.2])
    assert make(with_parts(after=keys), passes={"posture": {"joints": {"one": 0.7}}}).mbs.joints()[
        "one"
    ].q == pytest.approx(0.7)


def test_an_equality_of_joints_is_a_mimic() -> None:
    equality = '<equality><joint joint1="two" joint2="one" polycoef=".1 -2 0 0 0"/></equality>'
    mimic = make(with_parts(after=equality)).robot.joints["two"].mimic
    assert mimic is not None
    assert (mimic.joint, mimic.multiplier, mimic.offset) == ("one", -2.0, 0.1)


@pytest.mark.parametrize(
    ("equality", "said"),
    [
        ('<joint joint1="two" joint2="one" polycoef="0 1 2 0 0"/>', "polynomial"),
        ('<joint joint1="two" joint2="one" active="false"/>', "not active"),
        ('<joint joint1="two"/>', "constant position"),
        (
            '<joint joint1="two" joint2="one"/><joint name="back" joint1="one" joint2="two"/>',
            "follows another already: back",
        ),
        ('<connect body1="a" body2="b" anchor="0 0 0" active="false"/>', "not active"),
    ],
)
def test_other_couplings_are_named(equality: str, said: str) -> None:
    result = make(with_parts(after=f"<equality>{equality}</equality>"))
    assert said in messages(result)["mjcf-coupling"]


def cuts_of(result: Result) -> list[str]:
    return [cut.kind for cut in result.mbs.cuts]


def test_connect_weld_and_a_tendon_become_cuts() -> None:
    connect = '<equality><connect name="tie" body1="b" anchor=".6 0 0"/></equality>'
    result = make(with_parts(after=connect))
    assert cuts_of(result) == ["ball"]
    assert "loop-open" not in {said.code for said in result.diagnostics}
    assert result.report.robot_settings["passes"]["loops"]["cuts"].keys() == {"tie"}
    weld = '<equality><weld body1="b"/></equality>'
    assert cuts_of(make(with_parts(after=weld))) == ["solid"]
    # bodies with other axes
    turned = with_parts(after=weld).replace(
        '<body name="b" pos=', '<body name="b" euler=".1 .2 .3" pos='
    )
    assert cuts_of(make(turned)) == ["ball", "rod", "rod", "rod"]
    tendon = (
        '<tendon><spatial name="rope"><site site="end"/><site site="post"/></spatial></tendon>'
        '<equality><tendon name="rod" tendon1="rope"/></equality>'
    )
    text = with_parts(after=tendon).replace(
        "<worldbody>", '<worldbody><site name="post" pos=".6 0 .4"/>'
    )
    result = make(text)
    (cut,) = result.mbs.cuts
    assert (cut.kind, cut.length) == ("rod", pytest.approx((0.5**2 + 0.4**2) ** 0.5))
    assert "mjcf-tendon" not in messages(result)


def test_a_weld_to_a_moving_target_is_no_cut() -> None:
    hand = '<body name="target" mocap="true" pos=".5 0 0"><geom size=".01" contype="0"/></body>'
    text = with_parts(after='<equality><weld name="drag" body1="target" body2="b"/></equality>')
    result = make(text.replace("<worldbody>", f"<worldbody>{hand}"))
    assert cuts_of(result) == []
    warnings = [said.message for said in result.diagnostics if said.code == "mjcf-mocap"]
    assert len(warnings) == 2
    assert any("drag" in warning for warning in warnings)


def test_armature_is_that_of_rotors_in_a_project() -> None:
    text = with_parts().replace('name="one"', 'name="one" armature=".4"')
    result = make_project(text)
    assert result.report.passes["rotors"] == {"one": 0.4}
    assert not any(joint.actuated for joint in result.mbs.joints().values())  # it is no motor
    result = make(text)
    assert "rotors" not in result.report.passes
    assert "rotors-left-out" in {said.code for said in result.diagnostics}
    assert "rotors" not in make_project(text, rotors={"from_urdf": False}).report.passes


def test_position_actuators_hold_and_others_are_motors() -> None:
    motors = (
        '<actuator><position joint="one" kp="30" kv="2" gear="2" forcerange="-5 5"/>'
        '<motor joint="two" gear="3" ctrlrange="-1 2" ctrllimited="true"/></actuator>'
    )
    result = make_project(with_parts(after=motors))
    models = {model.name: model for model in result.mbs.user_models}
    gains = [
        {parameter.name: parameter.values for parameter in models[name].parameters}
        for name in ("hold_stiffness", "hold_damping")
    ]
    assert gains == [{"one": ("120.0",)}, {"one": ("8.0",)}]
    assert all(result.mbs.joints()[name].actuated for name in ("one", "two"))
    limits = [result.robot.joints[name].limit for name in ("one", "two")]
    assert [limit.effort for limit in limits if limit] == [10.0, 6.0]
    free = make_project(with_parts(after=motors), posture={"hold": None})
    assert "hold" not in {model.name for model in free.mbs.user_models}


@pytest.mark.parametrize(
    ("parts", "code", "said"),
    [
        (
            {"after": '<tendon><fixed name="t"><joint joint="one" coef="1"/></fixed></tendon>'},
            "mjcf-tendon",
            "t",
        ),
        (
            {"after": '<actuator><muscle name="m" joint="one" lengthrange="0 1"/></actuator>'},
            "mjcf-actuator",
            "state",
        ),
        ({"option": '<option density="1.2"/>'}, "mjcf-fluid", "density"),
        ({"option": '<option><flag limit="disable"/></option>'}, "mjcf-flag", "limit"),
        (
            {"after": '<sensor><framelinvel objtype="body" objname="b"/></sensor>'},
            "mjcf-sensor",
            "framelinvel",
        ),
        ({"after": '<contact><pair geom1="ga" geom2="gb"/></contact>'}, "mjcf-contact", "pairs"),
        (
            {
                "after": '<extension><plugin plugin="mujoco.pid"/></extension>'
                '<actuator><plugin joint="one" plugin="mujoco.pid" actdim="1">'
                '<config key="ki" value="1"/></plugin></actuator>'
            },
            "mjcf-plugin",
            "plugins",
        ),
        (
            {
                "after": '<worldbody><flexcomp name="cloth" type="grid" count="3 3 1" dim="2" '
                'spacing=".1 .1 .1" radius=".01" mass="1" pos="0 0 1"/></worldbody>'
            },
            "mjcf-soft-body",
            "flex",
        ),
        ({"after": '<keyframe><key qvel="1 0"/></keyframe>'}, "mjcf-start", "velocities"),
    ],
)
def test_what_has_no_counterpart_is_named(parts: dict[str, str], code: str, said: str) -> None:
    assert said in messages(make(with_parts(**parts)))[code]


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ('<body name="b"', '<body name="b" gravcomp="1"', "mjcf-law", "gravcomp): b"),
        ('name="gb" type="box"', 'name="gb" type="ellipsoid"', "mjcf-shape", "ellipsoid: gb"),
        (
            '<joint name="two" axis="0 1 0"/>',
            '<joint name="two" type="ball" damping="1"/>',
            "mjcf-limit",
            "ball joints: two",
        ),
        ('name="one"', 'name="one" range="-1 1"', "mjcf-soft", "limits (1)"),
    ],
)
def test_laws_without_a_counterpart_are_named(old: str, new: str, code: str, said: str) -> None:
    text = with_parts()
    assert old in text
    assert said in messages(make(text.replace(old, new)))[code]


def test_names_that_are_taken_or_missing_get_others() -> None:
    text = with_parts().replace(' name="two"', "").replace('name="end"', 'name="a"')
    robot = make(text).robot
    assert {"a", "a_2", "b"} <= robot.links.keys()
    assert "joint1" in robot.joints


def test_commands_take_an_mjcf(capsys: Any) -> None:
    Path("robot.xml").write_text(with_parts())
    for command in ("convert", "lint", "init", "report"):
        assert main([command, "robot.xml"]) == 0, capsys.readouterr().err
    assert main(["verify", "robot.xml", "robot.mbs"]) == 0
    assert "the same robot, and as MuJoCo computes it, to 1e-13" in capsys.readouterr().out
    assert main(["run", "pair.yaml", "--force"]) == 0
    for command in ("equations", "diagram"):
        assert main([command, "robot.xml"]) == 0, capsys.readouterr().err
    words = ["--time", "0.01", "--language", "python", "-o", "moved/"]
    assert main(["simulate", "robot.xml", *words]) == 0, capsys.readouterr().err


@pytest.mark.slow
def test_armature_is_no_difference_where_a_model_has_no_rotors(capsys: Any) -> None:
    """Only a project has rotors, and its certificate says so."""
    Path("robot.xml").write_text(with_parts().replace('name="two"', 'name="two" armature=".3"'))
    assert main(["convert", "robot.xml", "-o", "robot.mbs"]) == 0
    assert main(["init", "robot.xml"]) == 0
    assert "rotors" not in Path("pair.yaml").read_text(), "the MJCF asks for them already"
    assert main(["run", "pair.yaml"]) == 0
    capsys.readouterr()
    for model in ("robot.mbs", "robot.xml", "pair", "pair.yaml"):
        assert main(["verify", "robot.xml", model]) == 0, model
        assert capsys.readouterr().out.count("as MuJoCo computes it") == 1


def test_without_mujoco_the_message_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("urdf2mbs_mjcf.process.find_spec", lambda name: None)
    with pytest.raises(ConversionError, match=r"pip install 'urdf2mbs\[mjcf\]'"):
        make(with_parts())


def test_the_same_mjcf_gives_the_same_bytes() -> None:
    first = make(ARM)
    assert make(ARM).data == first.data
    assert make(ARM).conversion.expanded == first.conversion.expanded


def test_a_urdf_with_many_comments_is_soon_known() -> None:
    """Not after as many steps as there are ways to split its comments."""
    comments = b"<!-- a --> " * 200_000
    assert is_mjcf(b"<?xml version='1.0'?>" + comments + b"<mujoco model='r'/>")
    assert not is_mjcf(comments + b"<robot><mujoco/></robot>" + comments)
    assert is_mjcf(b"\xef\xbb\xbf<!DOCTYPE mujoco>\n<mujoco>")
    assert not is_mjcf(b"<!-- <mujoco> ")


#: Three bars on the world, and a pivot that closes the loop of them.
FOUR_BARS = """<mujoco model="four"><worldbody>
  <body name="a"><joint name="ja" axis="0 1 0"/><geom size=".1" mass="1"/>
    <body name="b" pos="0 0 .3"><joint name="jb" axis="0 1 0"/><geom size=".1" mass="1"/></body>
  </body>
  <body name="c" pos=".4 0 0"><joint name="jc" axis="0 1 0"/><geom size=".1" mass="1"/></body>
</worldbody><equality><connect body1="b" body2="c" anchor=".4 0 0"/></equality></mujoco>"""


def test_cuts_of_an_mjcf_are_compared_with_those_of_a_model(capsys: Any) -> None:
    """A loop that the MJCF closes is its own; elsewhere, or open, it is a difference."""
    Path("four.xml").write_text(FOUR_BARS)
    Path("moved.xml").write_text(FOUR_BARS.replace('anchor=".4 0 0"', 'anchor=".3 0 0"'))
    Path("open.xml").write_text(FOUR_BARS.replace("connect", "weld active='false'"))
    for name in ("four", "open"):
        assert main(["convert", f"{name}.xml", "-o", f"{name}.mbs"]) == 0
    out = capsys.readouterr().out
    assert "not compared: cut 'equality0' (ball) (in four.xml, whose ends are not read here)" in out
    assert "but for" not in out

    assert main(["verify", "four.xml", "four.mbs"]) == 0
    assert capsys.readouterr().out.endswith("as MuJoCo computes it, to 1e-13\n")
    assert main(["verify", "moved.xml", "four.mbs"]) == 3
    out = capsys.readouterr().out
    assert "that 'equality0' closes in the first robot has no ball there in the .mbs; the" in out
    assert "'equality0', is 0.1 m off" in out
    assert main(["verify", "four.xml", "open.mbs"]) == 3
    assert "closes in the first robot has no ball there in the .mbs\n" in capsys.readouterr().out
    assert main(["verify", "open.xml", "four.mbs"]) == 0
    assert "but for cut 'equality0' (ball) (not in the robot's file)" in capsys.readouterr().out
