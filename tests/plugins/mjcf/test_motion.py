"""A project of an MJCF moves as MuJoCo does, with contacts, limits and actuators off."""

from pathlib import Path

import numpy as np
import pytest

from support.mjcf import with_parts
from urdf2mbs import convert
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

mujoco = pytest.importorskip("mujoco")

#: Equalities as stiff as the time step allows; then MuJoCo keeps them to about 1e-8.
STIFF = 'solref="4e-5 1" solimp="0.9999 0.9999 0.001 0.5 2"'
STEP, DURATION = 2e-5, 0.1
TREE = with_parts(
    joints='<joint name="in" type="slide" axis="1 0 1" ref=".1" springref=".3" stiffness="40"/>'
).replace('name="two"', 'name="two" armature=".3" damping=".2"')
MIMIC = with_parts(
    after=f'<equality><joint joint1="two" joint2="one" polycoef="0 -1.5 0 0 0" {STIFF}/></equality>'
)
FOUR_BAR = f"""<mujoco model="four">
  <compiler angle="radian"/>
  <worldbody>
    <body name="left" pos="0 0 1">
      <joint name="a" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 .4" size=".02"/>
      <body name="top" pos="0 0 .4">
        <joint name="b" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .6 0 .2" size=".02"/>
      </body>
    </body>
    <body name="right" pos=".5 0 1">
      <joint name="c" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 .1 0 .6" size=".02"/>
    </body>
  </worldbody>
  <equality><connect body1="top" body2="right" anchor=".6 0 .2" {STIFF}/></equality>
</mujoco>
"""


@pytest.mark.parametrize(
    ("text", "moved"),
    [
        pytest.param(TREE, 0.04, id="tree"),
        pytest.param(MIMIC, 0.01, id="mimic", marks=pytest.mark.slow),
        pytest.param(FOUR_BAR, 0.01, id="loop", marks=pytest.mark.slow),
    ],
)
def test_it_moves_as_in_mujoco(text: str, moved: float, tmp_path: Path) -> None:
    source = tmp_path / "robot.xml"
    source.write_text(text)
    written = convert(source, output={"project": tmp_path / "made"}).write()
    data = MbsData(written)
    joint_forces = data.user_model.get("joint_forces", {})
    for law in ("stops", "friction"):
        joint_forces[law] = 0.0
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=DURATION, language="python", integrator="DOP853", rtoler=1e-11, atoler=1e-12, save2file=0
    )
    results = dirdyn.run()
    model = mujoco.MjModel.from_xml_path(str(source))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, STEP
    model.opt.iterations, model.opt.tolerance = 200, 0.0
    for flag in ("CONTACT", "LIMIT", "FRICTIONLOSS", "ACTUATION"):
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
    state = mujoco.MjData(model)
    for _ in range(round(DURATION / STEP)):
        mujoco.mj_step(model, state)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(model.njnt)]
    numbers = [data.joint_id[name] for name in names]
    positions = state.qpos - model.qpos0
    assert np.abs(positions).max() > moved
    assert np.allclose(results.q[-1, numbers], positions, rtol=0, atol=1e-6)
