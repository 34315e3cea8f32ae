"""Loops of any kind are closed by a choice of joints and equations, and move as physics says.

A joint without mass is locked and named, or refused.
"""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from support.loops import FOLLOWS, FREE, arm, four_bar, four_bar_bodies, made
from urdf2mbs import ConversionError, Results, load_equations, simulate
from urdf2mbs.cli import main
from urdf2mbs.mbs.model import BASE, Body
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn, MbsPart

TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-11, "rate": 50.0}


def gaps(results: Results) -> float:
    """Return the largest gap of all constraints, used or not, in all frames."""
    data, worst = results.data, 0.0
    for q in results.q:
        data.q[1:] = q[1:]
        h = np.zeros(99)
        data.mbs_cons_hJ(h, np.zeros((99, data.njoint + 1)), data)
        worst = max(worst, np.abs(h).max())
    assert np.isfinite(worst)
    return worst


def moves(results: Results) -> None:
    """Loops stay closed, energy stays, and something has moved."""
    energy = results.energy().sum(axis=1)
    assert np.abs(energy - energy[0]).max() < 2e-6 * (1 + np.ptp(results.energy()[:, 0]))
    assert gaps(results) < 1e-9
    assert np.ptp(results.q[:, 1:], axis=0).max() > 1e-2


def bennett(tmp_path: Path, follow: int) -> Path:
    """Bennett's loop of four skew hinges: six equations, three of which say all."""
    a, b, alpha = 0.3, 0.5, 0.6
    beta = math.asin(b / a * math.sin(alpha))
    first = 0.9
    ratio = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
    second = 2 * math.atan(ratio / math.tan(first / 2))
    sides = [(a, alpha), (b, beta)] * 2
    turns = [first, second, -first, -second]
    bodies, parent, point = [], BASE, None
    for k, (turn, (length, twist)) in enumerate(zip(turns, sides, strict=True)):
        nature = FOLLOWS if 4 - k <= follow else FREE
        hinge = arm(f"hinge{k}", parent, ("R3", turn, nature), at=point, end=(length, 0.0, 0.0))
        bodies += [hinge, arm(f"twist{k}", hinge.name, ("R1", twist, "driven"), at="end", mass=0.2)]
        parent = f"twist{k}"
    return made(tmp_path, *bodies, cuts=[("solid", ("twist3", None), (None, None))])


def sarrus(tmp_path: Path, follow: int) -> Path:
    """Two hinged legs at right angles hold a plate, which moves straight up: five of six."""
    natures = [FOLLOWS] * follow + [FREE] * 6
    legs, turn = [], 0.7
    for k, (axis, out) in enumerate((("R2", (1.0, 0.0)), ("R1", (0.0, 1.0)))):
        sign, foot = 1 if k == 0 else -1, {f"foot{k}": (out[0] * 0.2, out[1] * 0.2, 0.0)}
        place = natures[3 * k : 3 * k + 3]
        side = (0.0, 0.0, 0.4)
        legs += [
            arm(f"table{k}", BASE, ("R1", 0.3, "driven"), **foot),
            arm(f"low{k}", f"table{k}", (axis, sign * turn, place[0]), at=f"foot{k}", top=side),
            arm(f"high{k}", f"low{k}", (axis, -2 * sign * turn, place[1]), at="top", top=side),
            arm(
                f"plate{k}",
                f"high{k}",
                (axis, sign * turn, place[2]),
                at="top",
                middle=(-out[0] * 0.2, -out[1] * 0.2, 0.0),
            ),
        ]
    return made(tmp_path, *legs, cuts=[("solid", ("plate0", "middle"), ("plate1", "middle"))])


def parallel(tmp_path: Path, follow: int) -> Path:
    """Three equal cranks carry a beam: one of the four equations follows from the others."""
    natures = [FOLLOWS] * follow + [FREE] * 4
    crank = {"tip": (0.0, 0.0, -0.5)}
    first = arm("crank1", BASE, ("R2", 0.4, natures[3]), at="p1", mass=0.3, **crank)
    beam = arm(
        "beam",
        "crank1",
        ("R2", -0.4, natures[0]),
        at="tip",
        speed=None,
        a=(0.6, 0.0, 0.0),
        b=(1.2, 0.0, 0.0),
    )
    followers = [
        arm(f"crank{k}", BASE, ("R2", 0.4, natures[k - 1]), at=f"p{k}", mass=0.3, **crank)
        for k in (2, 3)
    ]
    cuts = [("ball", ("beam", end), (f"crank{k}", "tip")) for k, end in ((2, "a"), (3, "b"))]
    feet = {f"p{k}": (0.6 * (k - 1), 0.0, 0.0) for k in (1, 2, 3)}
    return made(tmp_path, first, beam, *followers, cuts=cuts, **feet)


@pytest.mark.parametrize(
    "language",
    [
        "python",
        pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    ],
)
@pytest.mark.parametrize(
    ("mechanism", "right", "time"),
    [(bennett, 3, 1.0), (sarrus, 5, 0.3), (parallel, 3, 1.0)],
    ids=["bennett", "sarrus", "parallel"],
)
def test_redundant_loops_move_in_one_way(
    mechanism: Any, right: int, time: float, language: str, tmp_path: Path
) -> None:
    """However many joints the .mbs declares; in Python the motion is the same for all."""
    energies = []
    for declared in (right, right - 1, right + 1) if language == "python" else (right + 1,):
        results = simulate(mechanism(tmp_path, declared), time=time, language=language, **TIGHT)
        data = results.data
        assert (data.nqu, data.nqv) == (1, right)
        assert any("they imply the others" in note for note in data._run.notes)
        moves(results)
        energies.append(results.energy()[:, 0])
    assert np.abs(np.array(energies) - energies[0]).max() < 1e-5 * energies[0].max()


def test_a_crank_turns_over_the_poses_at_which_the_choice_is_singular(tmp_path: Path) -> None:
    """The crank moves alike as a dependent and as an independent joint.

    The rocker, on which it depends, stops twice a turn.
    """
    runs: list[Results] = []
    for natures in ([FREE, FOLLOWS, FOLLOWS], [FOLLOWS, FOLLOWS, FREE]):
        data = MbsData(four_bar(tmp_path, natures, 1.0))
        MbsPart(data).run()
        if runs:
            data.q[1:], data.qd[1:] = runs[0].q[0, 1:], runs[0].qd[0, 1:]
        else:
            data.qd[1] = 12.0
        dirdyn = MbsDirdyn(data)
        dirdyn.set_options(
            tf=0.7, integrator="DOP853", rtoler=1e-10, atoler=1e-11, save2file=0, language="python"
        )
        runs.append(dirdyn.run())
    leads, follows = runs
    assert np.ptp(leads.q[:, 1]) > 2 * math.pi
    assert np.abs(leads.q - follows.q).max() < 1e-5
    moves(follows)


@settings(max_examples=6, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(st.data())
def test_random_loops_move_as_physics_says(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Chains of two to five joints along any axes meet at a ball or a rod, whatever is declared."""
    rounded = st.integers(-20, 20).map(lambda x: x / 20)
    kinds = data.draw(st.lists(st.sampled_from(["R1", "R2", "R3", "T1"]), min_size=4, max_size=6))
    bodies: list[Body] = []
    ends: list[str] = []
    for side, some in enumerate((kinds[::2], kinds[1::2])):
        parent, point = BASE, f"foot{side}"
        for k, kind in enumerate(some):
            nature = data.draw(st.sampled_from([FREE, FOLLOWS]))
            place = (0.3 + data.draw(rounded) / 9, data.draw(rounded) / 3, data.draw(rounded) / 3)
            bodies.append(
                arm(
                    f"b{side}{k}",
                    parent,
                    (kind, data.draw(rounded), nature),
                    at=point,
                    tip=place,
                )
            )
            parent, point = f"b{side}{k}", "tip"
        ends.append(parent)
    first, second = ((end, "tip") for end in ends)
    cut = data.draw(st.sampled_from([("ball", first, second), ("rod", first, second, 0.3)]))
    folder = tmp_path_factory.mktemp("random")
    file = made(folder, *bodies, cuts=[cut], foot0=(0.0, 0.0, 0.0), foot1=(0.5, 0.2, 0.0))
    try:
        results = simulate(file, time=0.2, language="python", **TIGHT)
    except SimulationError:  # such as: too far apart, or at a dead point
        return
    energy = results.energy().sum(axis=1)
    assert np.ptp(energy) < 1e-5 * (1 + np.ptp(results.energy()[:, 0]))
    assert gaps(results) < 1e-9


def test_a_start_beside_a_dead_point_moves_as_others_do(tmp_path: Path) -> None:
    """The one joint that is declared hardly moves the rod there."""
    bodies = []
    for side, kinds in enumerate((("R2", "R1", "R1"), ("T1", "R1", "R1"))):
        for k, kind in enumerate(kinds):
            parent, point = (f"b{side}{k - 1}", "tip") if k else (BASE, f"foot{side}")
            nature = FREE if bodies else FOLLOWS
            bodies.append(
                arm(f"b{side}{k}", parent, (kind, 0.0, nature), at=point, tip=(0.3, 0.0, 0.0))
            )
    cut = ("rod", ("b02", "tip"), ("b12", "tip"), 0.3)
    file = made(tmp_path, *bodies, cuts=[cut], foot0=(0.0, 0.0, 0.0), foot1=(0.5, 0.2, 0.0))
    moves(simulate(file, time=0.2, language="python", **TIGHT))


def test_rods_at_their_dead_points_are_closed(tmp_path: Path) -> None:
    """The drawing is closed to a ten-thousandth of a millimetre, and no joint moves the rod."""
    slide = arm("slide", BASE, ("T1", 3e-7, FOLLOWS), tip=(0.0, 0.0, 0.0))
    loop = four_bar_bodies([FREE, FOLLOWS, FOLLOWS], 1.0)
    cuts = [("ball", ("rod", "tip"), ("rocker", "tip"))] + [
        ("rod", ("slide", "tip"), (None, end), 0.5) for end in ("above", "below")
    ]
    file = made(
        tmp_path,
        slide,
        *loop,
        cuts=cuts,
        pivot=(0.6, 0.0, 0.0),
        above=(0.0, 0.0, 0.5),
        below=(0.0, 0.0, -0.5),
    )
    moves(simulate(file, time=0.2, language="python", **TIGHT))


def test_a_rod_that_locks_a_bar_is_named(tmp_path: Path) -> None:
    """Two circles touch from outside: the bar cannot move, though no equation says so at first."""
    swings, stays = [
        simulate(
            made(
                tmp_path,
                arm("bar", BASE, ("R2", 0.0, nature), tip=(0.0, 0.0, 0.5)),
                cuts=[("rod", ("bar", "tip"), (None, "above"), 0.7)],
                above=(0.0, 0.0, 1.2),
            ),
            time=0.1,
            language="python",
        )
        for nature in (FREE, FOLLOWS)
    ]
    (note,) = swings.data._run.notes
    assert note.endswith(
        "at a dead point, rod 'cut_1' would lock the model, and is left out; "
        "it stays with <nature>dependent</nature> in bar_0"
    )
    assert np.ptp(swings.q[:, 1]) > 0.1
    assert "the loops leave no joint free" in stays.data._run.notes[0]
    assert np.ptp(stays.q[:, 1]) == 0.0


def test_a_joint_without_mass_is_held_or_refused(tmp_path: Path) -> None:
    """A pendulum swings as it does without the massless slide at its end.

    A spring that pulls the slide, or a push, is an error that names it.
    """
    bob = arm("bob", BASE, ("R2", 1.0, FREE), end=(0.3, 0.0, 0.0))
    alone = simulate(made(tmp_path, bob), time=0.3, language="python", **TIGHT)
    for kind, more in (("T1", "R3"), ("R2", "R1")):
        end = arm(
            "end",
            "bob",
            (kind, 0.1, FREE),
            (more, 0.0, FREE),
            at="end",
            mass=0.0,
            tip=(0.4, 0.0, 0.0),
        )
        file = made(tmp_path, bob, end)
        held = simulate(file, time=0.3, language="python", **TIGHT)
        assert held.data._run.notes == ["locked, since they move no mass: end_0, end_1"]
        assert np.allclose(held.q[:, 1], alone.q[:, 1], rtol=0, atol=1e-8)
        assert np.ptp(held.q[:, 2:], axis=0).max() == 0.0
        with pytest.raises(ConversionError, match="joint 'end_0', which moves no mass") as caught:
            simulate(file, time=0.3, language="python", push=["tip:4,0,4@0.1..0.2"])
        assert caught.value.code == "joint-without-mass"
        assert 0.1 <= float(str(caught.value).partition("at ")[2].split(" s ")[0]) < 0.12


@pytest.mark.parametrize(
    ("start", "about"),
    [
        ({"R3": 0.4, "R2": 0.3, "R1": 0.2}, "R1"),
        ({"R1": 0.0, "R2": 0.0, "R3": 0.0}, "R2"),
    ],
)
def test_a_rod_on_two_balls_turns_about_itself(
    tmp_path: Path, start: dict[str, float], about: str
) -> None:
    """Three joints turn a thin rod: the one about it is held, and it moves as one of two does."""
    two = {kind: q for kind, q in start.items() if kind != about}
    runs = []
    for turns in (two, start):
        rod = arm("rod", BASE, *((kind, q, FREE) for kind, q in turns.items()))
        rod.com = (0.5, 0.0, 0.0) if about == "R1" else (0.0, 0.5, 0.0)
        xx, yy = (0.0, 1 / 12) if about == "R1" else (1 / 12, 0.0)
        rod.inertia = (xx, 0.0, 0.0, yy, 0.0, 1 / 12)
        runs.append(simulate(made(tmp_path, rod), time=0.5, language="python", **TIGHT))
    assert runs[1].data._run.notes == [
        f"locked, since they move no mass: rod_{[*start].index(about)}"
    ]
    assert np.allclose(runs[0].energy(), runs[1].energy(), rtol=0, atol=1e-7)


def test_what_is_chosen_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, python = {}, ("--language", "python")
    for natures in ([FREE] * 3, [FOLLOWS] * 3, [FREE, FOLLOWS, FOLLOWS]):
        file = four_bar(tmp_path, natures, 1.0)
        assert main(["simulate", str(file), "--time", "0.02", *python]) == 0
        out[natures.count(FOLLOWS)] = capsys.readouterr().out
    line = r"\n  in the \.mbs: <nature>%s</nature> in \1\n"
    assert re.search(r"do not suffice: (\w+, \w+)" + line % FOLLOWS, out[0])
    assert re.search(r"rules them: (\w+); is user_cons_hJ of the .*\?" + line % FREE, out[3])
    assert "<nature>" not in out[2]
    file = four_bar(
        tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0, ("rod", ("crank", "tip"), (None, None), 2.5)
    )
    assert main(["simulate", str(file), *python]) == 1
    assert (
        "rod 'cut_2' is 2.3e+03 mm from closed along the rod, and no joint moves it"
        in capsys.readouterr().err
    )
    never = "ball", ("crank", None), (None, "pivot")
    assert main(["simulate", str(four_bar(tmp_path, [FREE] * 3, 1.0, never)), *python]) == 0
    assert "cut 'cut_2' can never close: its ends are 0.6 m" in capsys.readouterr().out
    props = [("rod", ("crank", "tip"), (None, "pivot"), 0.7)]
    file = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0, *props)
    assert main(["simulate", str(file), *python]) == 0
    assert "the loops leave no joint free, so nothing moves" in capsys.readouterr().out
    robot = load_equations(parallel(tmp_path, 2), language="python")
    assert np.isfinite(robot.forward_dynamics(robot.data.q0[1:], [0.0] * 4, [0.0] * 4)).all()


def test_forces_are_asked_for_after_the_user_has_begun(tmp_path: Path) -> None:
    """MbsPart asks for none, and user_dirdyn_init comes before the first."""
    project = four_bar(tmp_path, [FREE, FOLLOWS, FOLLOWS], 1.0).parent.parent
    user = project / "userfctR"
    user.mkdir()
    (user / "user_dirdyn.py").write_text(
        "def user_dirdyn_init(mbs_data, mbs_dirdyn):\n    mbs_data.mine = 3.0\n"
        "def user_dirdyn_loop(mbs_data, mbs_dirdyn):\n    pass\n"
        "def user_dirdyn_finish(mbs_data, mbs_dirdyn):\n    pass\n"
    )
    (user / "user_JointForces.py").write_text(
        "def user_JointForces(mbs_data, tsim):\n    mbs_data.Qq[1] = mbs_data.mine\n"
    )
    data = MbsData(project / "dataR" / "loops.mbs")
    MbsPart(data).run()
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(tf=0.01, save2file=0, language="python")
    assert dirdyn.run().Qq[-1, 1] == 3.0
