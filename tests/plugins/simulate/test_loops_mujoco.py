"""Simulations of models with loops beside MuJoCo's, of the same .mbs: no code is shared."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from support.oracle.mjcf import TIME_STEP, write_mjcf
from urdf2mbs.mbs.model import Base, Body, Connection, Joint, Mbs, Point
from urdf2mbs.mbs.writer import write
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

mujoco = pytest.importorskip("mujoco")

DURATION = 0.05
#: About the centre of mass, with products of inertia (kg m^2).
INERTIA = (0.02, 0.002, -0.001, 0.03, 0.003, 0.025)


def make_body(name: str, parent: str | None, point: str | None, *joints: Joint) -> Body:
    """Return a body of 1.5 kg with a point 'end', 0.5 m along x."""
    body = Body(name, parent, point, [*joints], 1.5, (0.2, 0.01, 0.03), INERTIA)
    body.points = [Point("end", (0.5, 0.0, 0.0))]
    return body


def make_four_bar() -> Mbs:
    """Return a planar four-bar, which a ball closes; a driven joint tilts its plane.

    The frame slides, too: MuJoCo gets two joints in a body, with a constant rotation between.
    """
    frame = make_body(
        "frame",
        None,
        "rail",
        Joint("slide", "T2"),
        Joint("tilt", "R1", "driven", q=0.4),
        Joint("swing", "R3", q=0.2, qd=0.5),
        Joint("shift", "T1", "driven", q=0.1),
    )
    frame.points = [Point("left", (0.0, 0.0, 0.1)), Point("right", (0.6, 0.0, 0.1))]
    crank = make_body("crank", "frame", "left", Joint("crank_turn", "R2", q=-1.3, qd=2.0))
    coupler = make_body("coupler", "crank", "end", Joint("coupler_turn", "R2", "dependent", q=1.2))
    rocker = make_body("rocker", "frame", "right", Joint("rocker_turn", "R2", "dependent", q=-1.4))
    base = Base(gravity=(0.5, -1.0, -9.0), points=[Point("rail", (0.1, 0.2, 1.0))])
    loop = Connection("ball", "loop", ("coupler", "end"), ("rocker", "end"))
    return Mbs("four_bar", base=base, bodies=[frame, crank, coupler, rocker], cuts=[loop])


def make_spatial_loop() -> Mbs:
    """Return two arms with three and four joints about skew axes, tied by a ball."""
    near = make_body(
        "near",
        None,
        None,
        Joint("near1", "R1", q=0.3, qd=1.0),
        Joint("near2", "R2", q=-0.5, qd=-1.0),
        Joint("near3", "R3", "dependent", q=0.6),
    )
    far = make_body("far", None, "pin", Joint("far1", "R3", q=2.4, qd=0.5), Joint("far2", "R2"))
    hand = make_body(
        "hand", "far", "end", Joint("far3", "R2", "dependent"), Joint("far4", "T1", "dependent")
    )
    base = Base(points=[Point("pin", (1.0, 0.2, 0.1))])
    ball = Connection("ball", "knot", ("near", "end"), ("hand", "end"))
    return Mbs("spatial", base=base, bodies=[near, far, hand], cuts=[ball])


def make_rod() -> Mbs:
    """Return a double pendulum in space whose end a rod ties to the ground."""
    upper = make_body("upper", None, None, Joint("a", "R2", qd=1.0), Joint("b", "R3", qd=-2.0))
    lower = make_body("lower", "upper", "end", Joint("c", "R2", "dependent", q=0.5))
    base = Base(points=[Point("hook", (1.1, 0.2, 0.3))])
    rod = Connection("rod", "strut", ("lower", "end"), (None, "hook"), length=0.6)
    return Mbs("held_arm", base=base, bodies=[upper, lower], cuts=[rod])


@pytest.mark.parametrize("make_model", [make_four_bar, make_spatial_loop, make_rod])
def test_loops_move_as_in_mujoco(make_model: Callable[[], Mbs], tmp_path: Path) -> None:
    """After 0.05 s, positions are the same to 1e-7, and velocities to 1e-6."""
    file = tmp_path / "model.mbs"
    file.write_bytes(write(make_model()))
    data = MbsData(file)
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=DURATION, language="python", integrator="DOP853", rtoler=1e-11, atoler=1e-12, save2file=0
    )
    results = dirdyn.run()

    model = mujoco.MjModel.from_xml_string(write_mjcf(file.read_bytes()))
    state = mujoco.MjData(model)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(model.njnt)]
    numbers = [data.joint_id[name] for name in names]
    state.qpos[:], state.qvel[:] = results.q[0, numbers], results.qd[0, numbers]
    mujoco.mj_forward(model, state)
    assert np.abs(state.efc_pos).max() < 1e-9, "the loop is closed in both"
    for _ in range(round(DURATION / TIME_STEP)):
        mujoco.mj_step(model, state)

    assert state.time == pytest.approx(DURATION)
    assert np.abs(state.qpos - results.q[0, numbers]).max() > 0.05
    assert np.allclose(results.q[-1, numbers], state.qpos, rtol=0, atol=1e-7)
    assert np.allclose(results.qd[-1, numbers], state.qvel, rtol=0, atol=1e-6)
