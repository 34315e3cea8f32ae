"""Loops: cuts, where they end, and which joints they make dependent."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from descriptions import stand_in
from passes.test_mimic import joint, link

from urdf2mbs import convert
from urdf2mbs.engine.config import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.reader import read
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import convert_text

ROOT = Path(__file__).resolve().parents[2]
LENGTH, RANGE = "loops-length", "value-range"


def at(x: float, y: float, z: float) -> str:
    return f'<origin xyz="{x} {y} {z}"/>'


#: A four-bar linkage in the plane x z: the tips of two chains from the base meet.
FOUR_BAR = (
    '<robot name="four_bar">'
    + "".join(link(name) for name in ("base", "left", "coupler", "right"))
    + joint("crank", "base", "left", at(0, 0, 0))
    + joint("elbow", "left", "coupler", at(0, 0, 1))
    + joint("rocker", "base", "right", at(1, 0, 0))
    + "</robot>"
)
SDF = (
    '<gazebo><joint name="pin" type="revolute"><parent>coupler</parent><child>right</child>'
    "<pose>0 0 1 0 0 0</pose><axis><xyz>0 1 0</xyz></axis></joint></gazebo></robot>"
)
BALL = {"pin": {"ends": [{"link": "coupler", "at": [1, 0, 0]}, {"link": "right", "at": [0, 0, 1]}]}}


def natures(result: Any) -> dict[str, str]:
    return {j.name: j.nature for b in result.mbs.bodies for j in b.joints}


def test_a_ball_makes_two_joints_of_a_four_bar_dependent() -> None:
    result = convert_text(FOUR_BAR, base="fixed", options={"loops": {"cuts": BALL}})
    assert natures(result)["crank"] == "independent"
    assert [k for k, v in natures(result).items() if v == "dependent"] == ["elbow", "rocker"]
    mbs = read(result.data, "four_bar.mbs")
    (cut,) = mbs.cuts
    assert cut.kind == "ball"
    placement = place(mbs)
    for end in (cut.endpoint1, cut.endpoint2):
        assert placement.point(mbs, *end) == pytest.approx((1, 0, 1))
    assert not [found for found in result.diagnostics if found.code == "loop-open"]


def test_dependent_joints_by_name() -> None:
    options = {"cuts": BALL, "dependent": ["crank", "elbow"]}
    result = convert_text(FOUR_BAR, base="fixed", options={"loops": options})
    assert natures(result)["rocker"] == "independent"
    options = {"cuts": BALL, "dependent": ["crank"]}
    with pytest.raises(ConfigError, match="make 2 joints dependent, of which 1"):
        convert_text(FOUR_BAR, base="fixed", options={"loops": options})


def test_motors_stay_independent() -> None:
    options = {"loops": {"cuts": BALL}, "actuators": {"joints": ["rocker"]}}
    result = convert_text(FOUR_BAR, base="fixed", options=options)
    assert natures(result)["rocker"] == "independent"


def test_a_joint_in_gazebo_closes_the_loop() -> None:
    """In a plane, one ball is all that a revolute joint adds; in space it wants another."""
    result = convert_text(FOUR_BAR.replace("</robot>", SDF), base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin_1"]
    assert sum(nature == "dependent" for nature in natures(result).values()) == 2
    skew = FOUR_BAR.replace(
        joint("rocker", "base", "right", at(1, 0, 0)),
        link("carrier")
        + joint("swivel", "base", "carrier", at(1, 0, 0)).replace("0 1 0", "0 0 1")
        + joint("tilt", "carrier", "right", at(0, 0, 0)).replace("0 1 0", "1 0 0"),
    )
    result = convert_text(skew.replace("</robot>", SDF), base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin_1", "pin_2"]


TWO_AXES = "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>{}</xyz></axis2>"


@pytest.mark.parametrize(
    ("kind", "axes", "cuts"),
    [
        ("prismatic", "<axis><xyz>0 1 0</xyz></axis>", []),
        ("universal", TWO_AXES.format("0 1 0.1"), []),
        ("universal", TWO_AXES.format("0 0 1"), ["ball", "rod"]),
    ],
)
def test_a_joint_in_gazebo_that_cannot_become_a_cut_is_told(
    kind: str, axes: str, cuts: list[str]
) -> None:
    sdf = SDF.replace('type="revolute"', f'type="{kind}"')
    sdf = sdf.replace("<axis><xyz>0 1 0</xyz></axis>", axes)
    result = convert_text(FOUR_BAR.replace("</robot>", sdf), base="fixed")
    told = [found.code for found in result.diagnostics if found.code == "loop-left-out"]
    assert told == (["loop-left-out"] if not cuts else [])
    assert {cut.kind for cut in result.mbs.cuts} <= set(cuts)
    assert bool(result.mbs.cuts) == bool(cuts)


def test_a_solid_that_is_turned_is_told_with_its_angle() -> None:
    """At the start the coupler is level, and the rocker is turned by a quarter."""
    cuts = {"pin": {"kind": "solid", **BALL["pin"]}}
    turned = FOUR_BAR.replace(at(1, 0, 0), '<origin xyz="1 0 0" rpy="0 1.5707963267948966 0"/>')
    result = convert_text(turned, base="fixed", options={"loops": {"cuts": cuts}})
    (told,) = [found.message for found in result.diagnostics if found.code == "loop-open"]
    assert "and 1.57 rad" in told


def test_a_follower_in_a_loop_counts_as_its_leader(tmp_path: Path) -> None:
    """The elbow turns back by as much as the crank turns: a parallelogram."""
    mimic = "<mimic joint='crank' multiplier='-1'/></joint>"
    parts = FOUR_BAR.split("</joint>")
    text = parts[0] + "</joint>" + parts[1] + mimic + "</joint>".join(parts[2:])
    (tmp_path / "r.urdf").write_text(text)
    result = convert(
        tmp_path / "r.urdf", project=tmp_path / "r", base="fixed", options={"loops": {"cuts": BALL}}
    )
    # so the coupler stays level: at the start, one of the ball's two equations follows
    found = natures(result)
    assert [found[name] for name in ("crank", "elbow", "rocker")] == [
        "independent", "dependent", "dependent"
    ]  # fmt: skip


def test_a_planar_loop_before_followers_is_warned_of(tmp_path: Path) -> None:
    """MBsysC of 2017 finds no partition where a row of zeros stands before others."""
    limb = link("hand") + joint("wrist", "left", "hand", at(0, 0, 1))
    limb = limb.replace("</joint>", "<mimic joint='crank'/></joint>")
    for text, warned in (
        (FOUR_BAR.replace("</robot>", limb + "</robot>"), True),
        (FOUR_BAR, False),
    ):
        (tmp_path / "r.urdf").write_text(text)
        result = convert(
            tmp_path / "r.urdf", project=tmp_path / "r", language="c", base="fixed",
            options={"loops": {"cuts": BALL}},
        )  # fmt: skip
        assert warned == any(d.code == "loop-row-of-zeros" for d in result.diagnostics)


def test_an_open_loop_is_told_with_its_distance() -> None:
    options = {"loops": {"cuts": BALL}, "posture": {"joints": {"crank": pi / 2}}}
    result = convert_text(FOUR_BAR, base="fixed", options=options)
    (told,) = [found.message for found in result.diagnostics if found.code == "loop-open"]
    # the coupler's end is at (1, 0, -1), the rocker's at (1, 0, 1)
    assert "by 2 m" in told


def test_a_rod_keeps_the_distance_of_the_start() -> None:
    rod = {
        "rod": {"kind": "rod", "ends": [{"link": "coupler"}, {"link": "right", "at": [0, 0, 1]}]}
    }
    result = convert_text(FOUR_BAR, base="fixed", options={"loops": {"cuts": rod}})
    (cut,) = read(result.data, "x").cuts
    assert cut.kind == "rod"
    assert cut.length == pytest.approx(1.0)
    assert sum(nature == "dependent" for nature in natures(result).values()) == 1
    rod["rod"]["length"] = 0.75  # type: ignore[assignment]
    result = convert_text(FOUR_BAR, base="fixed", options={"loops": {"cuts": rod}})
    (told,) = [found.message for found in result.diagnostics if found.code == "loop-open"]
    assert "by 0.25 m" in told


def test_the_chosen_joints_solve_the_constraints() -> None:
    """Against Pinocchio's Jacobian, for a cut between random chains in space."""
    pin = pytest.importorskip("pinocchio")
    from urdf2mbs.proof.dynamics import to_pinocchio

    random = np.random.default_rng(2)
    for _ in range(5):
        names = "abcdefg"
        text = '<robot name="r">' + "".join(link(name) for name in ("root", *names))
        for k, name in enumerate(names):
            parent = "root" if k in (0, 3) else names[k - 1]
            axis = " ".join(map(str, random.normal(size=3)))
            xyz = random.normal(size=3)
            text += joint(f"j{name}", parent, name, at(*xyz)).replace("0 1 0", axis)
        ends = [{"link": "c", "at": [0.1, 0.2, 0.3]}, {"link": "g", "at": [0, 0.5, 0]}]
        cuts = {"ball": {"ends": ends}}
        options = {"loops": {"cuts": cuts}}
        result = convert_text(f"{text}</robot>", base="fixed", options=options)
        mbs = read(result.data, "r.mbs")
        model = to_pinocchio(mbs)
        data = model.createData()
        pin.computeJointJacobians(model, data, np.zeros(model.nq))
        pin.updateFramePlacements(model, data)
        rows = []
        for owner, point in (mbs.cuts[0].endpoint1, mbs.cuts[0].endpoint2):
            frame = model.getFrameId(f"{owner}/{point}")
            world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            rows.append(pin.getFrameJacobian(model, data, frame, world)[:3])
        jacobian = rows[1] - rows[0]
        chosen = [k for k, v in natures(result).items() if v == "dependent"]
        columns = [list(model.names).index(name) - 1 for name in chosen]
        assert len(columns) == 3
        assert np.linalg.cond(jacobian[:, columns]) < 1e4


@pytest.mark.parametrize(
    ("cut", "code"),
    [
        ({"ends": [{"link": "coupler"}, {"link": "rihgt"}]}, "loops-link"),
        ({"ends": [{"link": "coupler"}, {"link": "right"}], "length": 1.0}, LENGTH),
        ({"kind": "rod", "ends": [{"link": "left"}, {"link": "right"}], "length": -1}, RANGE),
    ],
)  # fmt: skip
def test_wrong_cuts(cut: dict[str, Any], code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        convert_text(FOUR_BAR, options={"loops": {"cuts": {"x": cut}}})
    assert caught.value.code == code


def test_cassies_rods_close(shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = ROOT / "configs" / "cassie.yaml"
    folder = shared / "robots" / "cassie" / "cassie_description"
    stand_in(
        monkeypatch, tmp_path, "cassie_description",
        {"urdf/cassie_v4.urdf": folder / "urdf" / "cassie_v4.urdf"},
    )  # fmt: skip
    conversion = Pipeline(*load(config)).run()
    codes = {found.code for found in conversion.diagnostics}
    assert not codes & {"loop-open", "posture-limit"}
    assert conversion.rejected is None
    dependent = [j.name for b in conversion.mbs.bodies for j in b.joints if j.nature == "dependent"]
    assert sorted(dependent) == ["LeftTarsusPitch", "RightTarsusPitch"]


def test_a_loop_that_can_never_close_is_told_as_that() -> None:
    """The bars of a plane that lie one metre apart."""
    cuts = {
        "other": {"kind": "rod", "ends": [{"link": "coupler"}, {"link": "right"}]},
        "pin": {"ends": [{"link": "coupler", "at": [1, 1, 0]}, BALL["pin"]["ends"][1]]},
    }
    result = convert_text(FOUR_BAR, base="fixed", options={"loops": {"cuts": cuts}})
    (told,) = [d for d in result.diagnostics if d.code in ("loop-never-closes", "loop-open")]
    assert told.code == "loop-never-closes"
    assert "'pin'" in told.message
    assert "other" not in told.message


def test_joints_in_gazebo_that_became_cuts_are_not_left_out() -> None:
    result = convert_text(FOUR_BAR.replace("</robot>", SDF), base="fixed")
    assert "extension" not in [found.code for found in result.diagnostics]
