"""The evaluator, which judges the conversions, judged itself: by pinocchio and by hand."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np
import pytest
from evaluator import Evaluator, Inertia, lump, rotation, translation

if TYPE_CHECKING:
    from pathlib import Path

pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")

#: A floating body; on it a slide along a driven-turned y; on that a turn, with a second body
#: beside it that turns about x. All inertias are full, and nothing is aligned by chance.
CHAIN = """
<mbsDescR7>
  <base>
    <gravity><coordinates><x>0.3</x><y>-0.2</y><z>-9.7</z></coordinates></gravity>
    <baseBodyName>ground</baseBodyName>
    <point><pointname>start</pointname>
      <coordinates><x>0.1</x><y>0.2</y><z>0.3</z></coordinates></point>
  </base>
  <bodytree>
    <body><bodyname>trunk</bodyname>
      <parent><bodyname>base</bodyname><pointname>start</pointname></parent>
      {joints}
      <mass>3.5</mass>
      <com><coordinates><x>0.02</x><y>-0.03</y><z>0.05</z></coordinates></com>
      <inertia><Ixx>0.11</Ixx><Ixy>0.012</Ixy><Ixz>-0.013</Ixz><Iyy>0.12</Iyy><Iyz>0.017</Iyz>
        <Izz>0.14</Izz></inertia>
      <point><pointname>side</pointname>
        <coordinates><x>-0.4</x><y>0.5</y><z>0.6</z></coordinates></point>
    </body>
    <body><bodyname>slide</bodyname>
      <parent><bodyname>trunk</bodyname><pointname>side</pointname></parent>
      <joint><jointname>tilt</jointname><type>R1</type><nature>driven</nature>
        <initialvalue><q>0.7</q></initialvalue></joint>
      <joint><jointname>along</jointname><type>T2</type><nature>independent</nature></joint>
      <joint><jointname>swing</jointname><type>R3</type><nature>independent</nature></joint>
      <mass>1.25</mass>
      <com><coordinates><x>-0.1</x><y>0.2</y><z>0.15</z></coordinates></com>
      <inertia><Ixx>0.02</Ixx><Ixy>-0.002</Ixy><Ixz>0.001</Ixz><Iyy>0.03</Iyy><Iyz>-0.004</Iyz>
        <Izz>0.025</Izz></inertia>
    </body>
    <body><bodyname>wheel</bodyname>
      <parent><bodyname>trunk</bodyname><pointname>origin</pointname></parent>
      <joint><jointname>spin</jointname><type>R2</type><nature>independent</nature></joint>
      <mass>0.4</mass>
      <inertia><Ixx>0.005</Ixx><Iyy>0.008</Iyy><Izz>0.006</Izz></inertia>
    </body>
  </bodytree>
</mbsDescR7>
""".format(
    joints="".join(
        f"<joint><jointname>{t}</jointname><type>{t}</type><nature>independent</nature></joint>"
        for t in ("T1", "T2", "T3", "R1", "R2", "R3")
    )
).encode()
ORDER = ["T1", "T2", "T3", "R1", "R2", "R3", "along", "swing", "spin"]


def se3(xyz=(0.0, 0.0, 0.0), rot=None):
    return pin.SE3(np.eye(3) if rot is None else rot, np.array(xyz, dtype=float))


def chain_in_pinocchio():
    """The same chain built joint by joint through pinocchio's own interface."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0.3, -0.2, -9.7]), np.zeros(3))
    at, joint = se3((0.1, 0.2, 0.3)), 0
    for name in ORDER[:6]:
        kind = {"T": "P", "R": "R"}[name[0]] + "XYZ"[int(name[1]) - 1]
        joint = model.addJoint(joint, getattr(pin, f"JointModel{kind}")(), at, name)
        at = se3()
    trunk = joint
    tensor = np.array([[0.11, 0.012, -0.013], [0.012, 0.12, 0.017], [-0.013, 0.017, 0.14]])
    model.appendBodyToJoint(trunk, pin.Inertia(3.5, np.array([0.02, -0.03, 0.05]), tensor), se3())
    tilt = pin.AngleAxis(0.7, np.array([1.0, 0, 0])).toRotationMatrix()
    joint = model.addJoint(trunk, pin.JointModelPY(), se3((-0.4, 0.5, 0.6), tilt), "along")
    joint = model.addJoint(joint, pin.JointModelRZ(), se3(), "swing")
    tensor = np.array([[0.02, -0.002, 0.001], [-0.002, 0.03, -0.004], [0.001, -0.004, 0.025]])
    model.appendBodyToJoint(joint, pin.Inertia(1.25, np.array([-0.1, 0.2, 0.15]), tensor), se3())
    joint = model.addJoint(trunk, pin.JointModelRY(), se3(), "spin")
    wheel = pin.Inertia(0.4, np.zeros(3), np.diag([0.005, 0.008, 0.006]))
    model.appendBodyToJoint(joint, wheel, se3())
    assert list(model.names)[1:] == ORDER
    return model


@pytest.mark.parametrize("seed", range(5))
def test_a_chain_is_as_pinocchio_has_it(seed: int) -> None:
    mbs, model = Evaluator(CHAIN), chain_in_pinocchio()
    data = model.createData()
    rng = np.random.default_rng(seed)
    q, qd, qdd = rng.uniform(-3, 3, (3, len(ORDER)))
    named, rates, accelerations = (dict(zip(ORDER, v, strict=True)) for v in (q, qd, qdd))

    pin.forwardKinematics(model, data, q)
    poses = mbs.positions(named)
    for name in ORDER:
        wanted = data.oMi[model.getJointId(name)].homogeneous
        np.testing.assert_allclose(poses.joint(name), wanted, atol=1e-14)
    wanted = data.oMi[model.getJointId("swing")].homogeneous
    np.testing.assert_allclose(poses.body("slide"), wanted, atol=1e-14)

    upper = np.triu(pin.crba(model, data, q))
    matrix = upper + np.triu(upper, 1).T
    np.testing.assert_allclose(mbs.mass_matrix(named, ORDER), matrix, atol=1e-13)
    gravity = pin.computeGeneralizedGravity(model, data, q)
    np.testing.assert_allclose(mbs.gravity_forces(named, ORDER), gravity, atol=1e-12)
    force = pin.rnea(model, data, q, qd, qdd)
    found = mbs.inverse_dynamics(named, rates, accelerations, ORDER)
    np.testing.assert_allclose(found, force, atol=1e-12)


def test_a_part_of_the_joints_in_any_order() -> None:
    mbs = Evaluator(CHAIN)
    some = ["spin", "T2", "swing"]
    q = {"swing": 0.4, "R2": 1.0, "along": -0.2}
    at = [ORDER.index(name) for name in some]

    full = mbs.mass_matrix(q, ORDER)

    np.testing.assert_array_equal(mbs.mass_matrix(q, some), full[np.ix_(at, at)])
    assert mbs.total_mass() == 3.5 + 1.25 + 0.4
    assert mbs.moving == ORDER
    assert mbs.driven == {"tilt": 0.7}
    assert mbs.mover("slide") == "swing"
    assert mbs.mover("slide", "tilt") == "R3"


def test_what_moves_a_driven_joint_is_asked_for() -> None:
    mbs = Evaluator(CHAIN)
    turned = mbs.positions({"tilt": -0.1}).joint("tilt")
    np.testing.assert_allclose(turned[:3, :3], rotation((1, 0, 0), -0.1), atol=1e-15)


def test_minimal_sample_by_hand(shared: Path) -> None:
    mbs = Evaluator((shared / "mbs-samples" / "minimal.mbs").read_bytes())

    poses = mbs.positions({"base_T3": 2.0, "base_R3": pi / 2, "shoulder": pi})

    # a quarter turn about z takes the anchor (0, 0.2, 0.3) to (-0.2, 0, 0.3), two up
    np.testing.assert_allclose(poses.point("torso", "to_arm"), (-0.2, 0, 2.3), atol=1e-15)
    arm = poses.body("arm")
    np.testing.assert_allclose(arm[:3, 3], (-0.2, 0, 2.3), atol=1e-15)
    # then the driven 1.5708 about z, a bit more than a quarter; then half a turn about x
    wanted = rotation((0, 0, 1), pi / 2 + 1.5708) @ np.diag((1.0, -1.0, -1.0))
    np.testing.assert_allclose(arm[:3, :3], wanted, atol=1e-15)
    assert mbs.total_mass() == 12.0
    assert list(mbs.bodies) == ["base", "torso", "arm", "empty", "hand"]
    assert [shape.kind for shape in mbs.bodies["torso"].shapes] == ["box", "cylinder"]
    assert mbs.bodies["arm"].shapes[0].url == "PRJPATH/animationR/vrml/arm.wrl"
    # held still, the floating base carries all of the weight
    np.testing.assert_allclose(mbs.gravity_forces({}, ["base_T3"]), [12.0 * 9.81])


def test_walkman_sample_reads(shared: Path) -> None:
    mbs = Evaluator((shared / "mbs-samples" / "walkman_robotran.mbs").read_bytes())
    assert mbs.total_mass() == pytest.approx(117.754, abs=1e-3)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("<bodyname>wheel</bodyname>", "<bodyname>trunk</bodyname>"),
        ("<jointname>spin</jointname>", "<jointname>swing</jointname>"),
        ("<jointname>spin</jointname>", "<jointname>wheel</jointname>"),
        ("<bodyname>wheel</bodyname>", "<bodyname>ground</bodyname>"),
        ("<pointname>side</pointname>", "<pointname>origin</pointname>"),
        ("<pointname>origin</pointname>", "<pointname>nowhere</pointname>"),
        ("<bodyname>trunk</bodyname><pointname>origin", "<bodyname>wheel</bodyname><pointname>o"),
        ("<type>R2</type>", "<type>R4</type>"),
        ("<nature>driven</nature>", "<nature>forced driven</nature>"),
        ("<mass>0.4</mass>", "<mass/>"),
        ("<mass>0.4</mass>", "<mass>nan</mass>"),
        ("<mass>0.4</mass>", "<mass>0,4</mass>"),
        ("<q>0.7</q>", "<q/>"),
        ("<Ixy>0.012</Ixy>", "<Ixy/>"),
        ("<x>0.02</x>", ""),
        ("mbsDescR7", "mbsDesc"),
        ("<jointname>spin</jointname>", "<!-- a --><type>R2</type><jointname>s</jointname>"),
    ],
)
def test_what_robotran_would_drop_in_silence_is_an_error(wrong: str, right: str) -> None:
    text = CHAIN.decode()
    assert wrong in text
    with pytest.raises(ValueError, match=r"."):
        Evaluator(text.replace(wrong, right).encode())


def test_lumps_are_pinocchio_s() -> None:
    rng = np.random.default_rng(0)
    parts, total = [], pin.Inertia.Zero()
    for _ in range(4):
        pose = translation(rng.uniform(-1, 1, 3))
        pose[:3, :3] = rotation((0.6, 0.0, 0.8), rng.uniform(-3, 3))
        tensor = np.diag(rng.uniform(1, 1.5, 3))
        mass, com = rng.uniform(1, 2), rng.uniform(-1, 1, 3)
        parts.append(Inertia(mass, com, tensor).seen_from(pose))
        placed = pin.SE3(pose[:3, :3], pose[:3, 3])
        total += placed.act(pin.Inertia(mass, com, tensor))
    found = lump(parts)
    assert found.mass == pytest.approx(total.mass, rel=1e-14)
    np.testing.assert_allclose(found.com, total.lever, atol=1e-14)
    np.testing.assert_allclose(found.tensor, total.inertia, atol=1e-13)
