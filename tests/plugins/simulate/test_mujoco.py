"""Simulations beside MuJoCo's, of the same URDF: no code is shared, not even the reader."""

from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from support.folders import SHARED
from support.light_chains import hinge, light_link
from support.standin import make, without_meshes
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

mujoco = pytest.importorskip("mujoco")
SWINGS = '<limit lower="-9" upper="9" effort="0" velocity="1"/><dynamics damping="0.01"/>'
CHAIN = (
    '<robot name="chain"><link name="world"/>'
    + light_link("a", 1.0, 0.01, 0.1)
    + light_link("b", 0.7, 0.005, -0.05)
    + light_link("c", 0.5, 0.003, 0.08)
    + hinge("one", "world", "a", SWINGS)
    + hinge("two", "a", "b", SWINGS, "1 0 0")
    + hinge("three", "b", "c", SWINGS, "0.6 0 0.8")
    + "</robot>"
)
#: Without mimic and loops, which MuJoCo's reader of URDF leaves out.
ROBOTS = {
    "chain": CHAIN,
    "ur5": SHARED / "robots/ur/expanded/ur5.urdf",
    "solo12": SHARED / "robots/solo12/expanded/solo12.urdf",
}
#: MuJoCo is to keep all links, and needs no meshes.
KEEP = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'


def in_mujoco(text: bytes) -> mujoco.MjModel:
    """Return the robot without shapes, on which only gravity and damping act."""
    root = etree.fromstring(text)
    for shape in root.xpath("//visual | //collision | //gazebo | //transmission"):
        shape.getparent().remove(shape)
    root.append(etree.fromstring(KEEP))
    model = mujoco.MjModel.from_xml_string(etree.tostring(root).decode())
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = 1e-4
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_swings_as_in_mujoco(name: str, tmp_path: Path) -> None:
    """After 1 s of a swing with damping, positions and speeds are the same to 1e-6."""
    source = ROBOTS[name]
    if isinstance(source, Path) and not source.is_file():
        pytest.skip("the real robots are not beside the checkout")
    file = source if isinstance(source, Path) else tmp_path / "chain.urdf"
    if isinstance(source, str):
        file.write_text(source)
    project = make(tmp_path, file, base="fixed", pipeline=without_meshes("compact"))
    data = MbsData(project / "dataR" / "robot.mbs")
    for kind in data.user_model.get("joint_forces", {}):
        data.user_model["joint_forces"][kind] = float(kind == "damping")
    model = in_mujoco(file.read_bytes())
    state = mujoco.MjData(model)
    joints = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(model.njnt)]
    numbers = [data.joint_id[joint] for joint in joints]
    assert len(numbers) == data.nqu == model.nv, "MuJoCo has all joints"
    random = np.random.default_rng(5)
    data.q[numbers], data.qd[numbers] = random.uniform(-0.5, 0.5, (2, model.nv))
    state.qpos[:], state.qvel[:] = data.q[numbers], data.qd[numbers]
    start = data.q[numbers]
    dirdyn = MbsDirdyn(data)
    dirdyn.set_options(
        tf=1.0, language="python", integrator="DOP853", rtoler=1e-10, atoler=1e-11, save2file=0
    )
    results = dirdyn.run()
    for _ in range(10_000):
        mujoco.mj_step(model, state)
    assert state.time == pytest.approx(1.0)
    assert np.abs(state.qpos - start).max() > 0.1
    assert np.allclose(results.q[-1, numbers], state.qpos, rtol=0, atol=1e-6)
    assert np.allclose(results.qd[-1, numbers], state.qvel, rtol=0, atol=1e-5)
