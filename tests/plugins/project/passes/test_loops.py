"""Loops: cuts, where they end, and which joints they make dependent."""

from math import dist, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.descriptions import stand_in
from support.folders import ROOT
from support.project_robots import BALL, FOUR_BAR, origin_at, unit_link, y_joint
from support.proving import codes
from urdf2mbs.config.load import load
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.mbs.kinematics import compute_placement
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.spatial import Pose, from_rpy
from urdf2mbs.testing import convert_text
from urdf2mbs.urdf.model import ClosingJoint
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.passes.loops import (
    SINGULAR,
    Cut,
    choose_independent_columns,
    compute_cut_jacobian,
    name_cuts,
    replace_sdf_joint,
)
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_project.simulation import Simulation

SDF = (
    '<gazebo><joint name="pin" type="revolute"><parent>coupler</parent><child>right</child>'
    "<pose>0 0 1 0 0 0</pose><axis><xyz>0 1 0</xyz></axis></joint></gazebo></robot>"
)


def natures(result: Any) -> dict[str, str]:
    return {j.name: j.nature for b in result.mbs.bodies for j in b.joints}


@pytest.mark.parametrize(
    ("passes", "free"),
    [
        ({}, "crank"),
        ({"loops": {"cuts": BALL, "dependent": ["crank", "elbow"]}}, "rocker"),
        ({"actuators": {"joints": ["rocker"]}}, "rocker"),
    ],
)
def test_a_ball_makes_two_joints_of_a_four_bar_dependent(passes: dict[str, Any], free: str) -> None:
    """Those that are named, else those without motors, further out first."""
    result = convert_text(FOUR_BAR, base="fixed", passes={"loops": {"cuts": BALL}, **passes})
    actual = natures(result)
    wanted = [name for name in ("crank", "elbow", "rocker") if name != free]
    assert [name for name, nature in actual.items() if nature == "dependent"] == wanted
    assert actual[free] == "independent"
    mbs = read_mbs(result.data, "four_bar.mbs")
    (cut,) = mbs.cuts
    assert cut.kind == "ball"
    placement = compute_placement(mbs)
    for end in (cut.endpoint1, cut.endpoint2):
        assert compute_point_position(placement, mbs, *end) == pytest.approx((1, 0, 1))
    assert "loop-open" not in codes(result)


def test_as_many_joints_must_be_named_as_become_dependent() -> None:
    options = {"cuts": BALL, "dependent": ["crank"]}
    with pytest.raises(ConfigError, match="make 2 joints dependent, of which 1"):
        convert_text(FOUR_BAR, base="fixed", passes={"loops": options})


def test_a_joint_in_gazebo_closes_the_loop() -> None:
    """In a plane, one ball is all that a revolute joint adds; in space it wants another."""
    result = convert_text(FOUR_BAR.replace("</robot>", SDF), base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin_1"]
    assert sum(nature == "dependent" for nature in natures(result).values()) == 2
    skew = FOUR_BAR.replace(
        y_joint("rocker", "base", "right", origin_at(1, 0, 0)),
        unit_link("carrier")
        + y_joint("swivel", "base", "carrier", origin_at(1, 0, 0)).replace("0 1 0", "0 0 1")
        + y_joint("tilt", "carrier", "right", origin_at(0, 0, 0)).replace("0 1 0", "1 0 0"),
    )
    result = convert_text(skew.replace("</robot>", SDF), base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin_1", "pin_2"]


@pytest.mark.parametrize(
    ("angle", "expected"),
    [
        (pi / 2, ["1.41 m and 1.57 rad"]),
        (pi, ["2 m and 3.14 rad"]),
        (5e-6, ["5e-06 m and 5e-06 rad"]),
        (5e-7, []),
        (0.0, []),
    ],
)
def test_a_solid_that_is_turned_is_told_with_its_angle(angle: float, expected: list[str]) -> None:
    """At the start the coupler is level, and the rocker is turned."""
    cuts = {"pin": {"kind": "solid", **BALL["pin"]}}
    turned = FOUR_BAR.replace(origin_at(1, 0, 0), f'<origin xyz="1 0 0" rpy="0 {angle!r} 0"/>')
    result = convert_text(turned, base="fixed", passes={"loops": {"cuts": cuts}})
    told = [
        diagnostic.message for diagnostic in result.diagnostics if diagnostic.code == "loop-open"
    ]
    assert [text.partition(", by ")[2].partition(":")[0] for text in told] == expected
    if angle == pi / 2:  # where the points meet, the angle alone is told
        cuts["pin"]["ends"] = [{"link": "coupler"}, {"link": "right", "at": [-1, 0, -1]}]
        result = convert_text(turned, base="fixed", passes={"loops": {"cuts": cuts}})
        (text,) = [
            diagnostic.message
            for diagnostic in result.diagnostics
            if diagnostic.code == "loop-open"
        ]
        assert text.partition(" m and ")[2].startswith("1.57 rad")
        assert float(text.partition(", by ")[2].partition(" m")[0]) < 1e-9


def test_a_follower_in_a_loop_counts_as_its_leader(tmp_path: Path) -> None:
    """The elbow turns back by as much as the crank turns: a parallelogram."""
    mimic = "<mimic joint='crank' multiplier='-1'/></joint>"
    parts = FOUR_BAR.split("</joint>")
    text = parts[0] + "</joint>" + parts[1] + mimic + "</joint>".join(parts[2:])
    loops = {"loops": {"cuts": BALL}}
    result = convert_text(text, output={"project": tmp_path / "r"}, base="fixed", passes=loops)
    # so the coupler stays level: at the start, one of the ball's two equations follows
    actual = natures(result)
    assert [actual[name] for name in ("crank", "elbow", "rocker")] == [
        "independent",
        "dependent",
        "dependent",
    ]


@pytest.mark.parametrize("follows", [True, False])
def test_a_planar_loop_before_followers_is_warned_of(tmp_path: Path, follows: bool) -> None:
    """MBsysC of 2017 finds no partition where a row of zeros stands before others."""
    limb = unit_link("hand") + y_joint("wrist", "left", "hand", origin_at(0, 0, 1))
    limb = limb.replace("</joint>", "<mimic joint='crank'/></joint>")
    result = convert_text(
        FOUR_BAR.replace("</robot>", limb * follows + "</robot>"),
        base="fixed",
        output={"project": tmp_path / "r", "language": "c"},
        passes={"loops": {"cuts": BALL}},
    )
    assert ("loop-row-of-zeros" in codes(result)) == follows


def test_a_rod_keeps_the_distance_of_the_start() -> None:
    rod = {
        "rod": {"kind": "rod", "ends": [{"link": "coupler"}, {"link": "right", "at": [0, 0, 1]}]}
    }
    result = convert_text(FOUR_BAR, base="fixed", passes={"loops": {"cuts": rod}})
    (cut,) = read_mbs(result.data, "x").cuts
    assert cut.kind == "rod"
    assert cut.length == pytest.approx(1.0)
    assert "loop-open" not in codes(result)
    assert sum(nature == "dependent" for nature in natures(result).values()) == 1
    rod["rod"]["length"] = 0.75  # type: ignore[assignment]
    result = convert_text(FOUR_BAR, base="fixed", passes={"loops": {"cuts": rod}})
    (told,) = [
        diagnostic.message for diagnostic in result.diagnostics if diagnostic.code == "loop-open"
    ]
    assert "by 0.25 m" in told


@pytest.mark.parametrize("kind", ["ball", "rod", "solid"])
def test_the_rows_of_a_cut_are_its_derivatives(kind: str, tmp_path: Path) -> None:
    """Of a cut between random chains in space, with sliders, leaders and followers in them and
    beside them."""
    random = np.random.default_rng(4)
    text = '<robot name="r">' + "".join(unit_link(name) for name in ("root", *"abcdefgh"))
    leaders = {"e": "g", "f": "b", "h": "a"}
    for k, name in enumerate("abcdefgh"):
        axis, xyz = (" ".join(map(str, random.normal(size=3))) for _ in range(2))
        parent = "root" if k in (0, 3, 6, 7) else "abcdefgh"[k - 1]
        more = f'<mimic joint="j{leaders[name]}" multiplier="-2"/>' if name in leaders else ""
        kind_of = "prismatic" if name in "bdfg" else "continuous"
        part = y_joint(f"j{name}", parent, name, f'<origin xyz="{xyz}"/>{more}', kind_of)
        text += part.replace("0 1 0", axis)
    at_ends = [{"link": "c", "at": [0.1, 0.2, 0.3]}, {"link": "f", "at": [0, 0.5, 0]}]
    options = {
        "loops": {"cuts": {"cut": {"kind": kind, "ends": at_ends}}},
        "posture": {"joints": {f"j{name}": random.normal() for name in "abcdg"}},
    }
    project = {"project": tmp_path / "p"}
    result = convert_text(f"{text}</robot>", output=project, base="fixed", passes=options)
    conversion, mbs = result.conversion, result.mbs
    (cut,) = mbs.cuts
    ends = (cut.endpoint1, cut.endpoint2)

    def state() -> tuple[Any, ...]:
        for coupling in conversion.state(Simulation).couplings:
            coupling.update_follower()
        placement = compute_placement(mbs)
        first, two = (np.array(compute_point_position(placement, mbs, *end)) for end in ends)
        turned = [np.array(placement.bodies[body].rot).reshape(3, 3) for body, _ in ends]
        return two - first, *turned

    gap, *turned = state()
    placement = compute_placement(mbs)
    jacobian = compute_cut_jacobian(conversion, MassModel(mbs))
    assert len(jacobian) == {"rod": 1, "ball": 3, "solid": 6}[kind]
    wanted = np.zeros_like(jacobian)
    for k, (placed, *_) in enumerate(placement.joints):
        if placed.nature == "driven" or placed.name in ("je", "jf", "jh"):
            continue
        q, sides = placed.q or 0.0, []
        for placed.q in (q + 1e-6, q - 1e-6, q):
            sides.append(state())
        direction, *turning = ((a - b) / 2e-6 for a, b in zip(*sides[:2], strict=True))
        first, two = (speed @ rot.T for speed, rot in zip(turning, turned, strict=True))
        spin = two - first
        if kind == "rod":
            wanted[0, k] = gap @ direction / np.linalg.norm(gap)
        else:
            wanted[:, k] = [*direction, spin[2, 1], spin[0, 2], spin[1, 0]][: len(wanted)]
    assert jacobian == pytest.approx(wanted, abs=1e-6)
    assert np.abs(jacobian).sum(axis=1).min() > 0.1


def test_cassies_rods_close(shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = ROOT / "configs" / "cassie.yaml"
    folder = shared / "robots" / "cassie" / "cassie_description"
    stand_in(
        monkeypatch,
        tmp_path,
        "cassie_description",
        {"urdf/cassie_v4.urdf": folder / "urdf" / "cassie_v4.urdf"},
    )
    conversion = Pipeline(*load(config)).run()
    codes = {diagnostic.code for diagnostic in conversion.diagnostics}
    assert not codes & {"loop-open", "posture-limit"}
    assert conversion.checked.rejected is None
    dependent = [j.name for b in conversion.mbs.bodies for j in b.joints if j.nature == "dependent"]
    assert sorted(dependent) == ["LeftTarsusPitch", "RightTarsusPitch"]


def test_a_loop_that_can_never_close_is_told_as_that() -> None:
    """The bars of a plane that lie one metre apart."""
    cuts = {
        "other": {"kind": "rod", "ends": [{"link": "coupler"}, {"link": "right"}]},
        "pin": {"ends": [{"link": "coupler", "at": [1, 1, 0]}, BALL["pin"]["ends"][1]]},
    }
    result = convert_text(FOUR_BAR, base="fixed", passes={"loops": {"cuts": cuts}})
    (told,) = [d for d in result.diagnostics if d.code in ("loop-never-closes", "loop-open")]
    assert told.code == "loop-never-closes"
    assert "'pin'" in told.message
    assert "other" not in told.message


def test_columns_are_as_many_as_the_rank_and_independent() -> None:
    """Of sparse rows, some of them sums of others; the first in order are taken."""
    random = np.random.default_rng(6)
    for _ in range(50):
        block = random.normal(size=(4, 6)) * (random.random((4, 6)) < 0.5)
        matrix = np.vstack([block, random.integers(-1, 2, size=(2, 4)) @ block])
        matrix = matrix[random.permutation(6)]
        order = list(random.permutation(6))
        chosen = choose_independent_columns(matrix, order)
        rank = np.linalg.matrix_rank(matrix, tol=1e-9)
        assert len(chosen) == rank
        assert np.linalg.matrix_rank(matrix[:, chosen], tol=1e-9) == rank
    for rows, chosen in (
        ([[1.0, 1.0, 2.0]], [0]),
        ([[5e-3, 1.0, 0.0]], [1]),
        ([[2e-2, 1.0, 0.0]], [0]),
        ([[2 * SINGULAR, 0.0], [0.0, 1.0]], [1, 0]),
        ([[SINGULAR / 2, 0.0], [0.0, 1.0]], [1]),
        ([[0.0, 0.0], [SINGULAR / 9, 0.0]], [0]),
        ([[1.0, 1.0], [-1.0, 1.0]], [0, 1]),
        (np.zeros((0, 3)), []),
        ([[0.0, 0.0]], []),
    ):
        matrix = np.array(rows)
        assert choose_independent_columns(matrix, range(matrix.shape[1])) == chosen


def test_a_cut_has_a_name_of_its_own() -> None:
    text = FOUR_BAR.replace("</robot>", SDF.replace('"revolute"', '"ball"'))
    sdf = text.replace('name="pin"', 'name="left"')
    result = convert_text(sdf, base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["left_2"]
    assert [d.code for d in result.diagnostics if "renamed" in d.code] == ["loop-renamed"]
    result = convert_text(text, base="fixed")
    assert [cut.name for cut in result.mbs.cuts] == ["pin"]
    assert "loop-renamed" not in codes(result)
    assert "extension" not in codes(result), "the joint is used"


def test_the_ends_of_the_cuts_of_a_joint_in_gazebo() -> None:
    """At its point, and a tenth of a metre along its axes; both links see them at one place."""
    conversion = convert_text(FOUR_BAR, base="fixed").conversion
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    pose = Pose((0.25, 0.5, 1.0), from_rpy((0.0, pi / 2, 0.0)))  # its z is the link's x
    at_centre, at_x, at_y, at_z = (
        (0.25, 0.5, 1.0),
        (0.35, 0.5, 1.0),
        (0.25, 0.6, 1.0),
        (0.25, 0.5, 1.1),
    )
    for kind, axes, wanted, rest in (
        ("ball", [], [("ball", at_centre, at_centre)], []),
        ("fixed", [y], [("solid", at_centre, at_centre)], []),
        ("revolute", [y], [("ball", at_centre, at_centre), ("ball", at_y, at_y)], ["pin_2"]),
        ("continuous", [], [("ball", at_centre, at_centre), ("ball", at_x, at_x)], ["pin_2"]),
        ("universal", [y, z], [("ball", at_centre, at_centre), ("rod", at_y, at_z)], ["pin_2"]),
        (
            "universal",
            [(0.0, 3.0, 0.1), x],
            [("ball", at_centre, at_centre), ("rod", at_y, at_x)],
            ["pin_2"],
        ),
        ("universal", [y], [], []),
        ("universal", [y, (0.0, -1.0, 0.1)], [], []),
        ("universal", [y, (0.0, 1.0, 1.0)], [], []),
        ("screw", [y], [], []),
    ):
        cuts: dict[str, Cut] = {}
        closing = ClosingJoint("pin", kind, "coupler", "right", pose, list(axes))
        replacement = replace_sdf_joint(conversion, closing)
        optional = name_cuts(conversion, closing, replacement.cuts, cuts)
        assert bool(replacement.reason) != bool(wanted)
        assert list(cuts) == [["pin"], ["pin_1", "pin_2"]][len(wanted) - 1][: len(wanted)]
        assert sorted(optional) == rest
        for cut, (form, in_parent, in_child) in zip(cuts.values(), wanted, strict=True):
            assert (cut.kind, cut.ends[0].link, cut.ends[1].link) == (form, "coupler", "right")
            # the coupler is 1 m above the base, the rocker 1 m beside it
            seen = (in_parent[0] + 1.0, in_parent[1], in_parent[2] - 1.0)
            assert cut.ends[0].at == pytest.approx(seen, abs=4e-3)
            assert cut.ends[1].at == pytest.approx(in_child, abs=4e-3)
            assert cut.length == (
                pytest.approx(dist(in_parent, in_child), rel=0.03) if form == "rod" else None
            )
