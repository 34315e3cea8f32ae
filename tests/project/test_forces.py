"""Forces of the generated code: in joints, from the ground, at points, of springs."""

from __future__ import annotations

from math import tanh
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from making import passes_of
from project.standin import MbsData, from1, make, user_functions

from urdf2mbs.diagnostics import ConfigError
from urdf2mbs.mbs.kinematics import place
from urdf2mbs.mbs.reader import read
from urdf2mbs.passes.joint_parameters import moved_inertias
from urdf2mbs.spatial import add, dot, rotate
from urdf2mbs.testing import TINY, convert_text

ROOT = Path(__file__).resolve().parents[2]
BIPED = ROOT / "configs" / "biped.urdf.xacro"
STANCE = {"*_hip_pitch": -0.3, "*_knee": 0.6, "*_ankle": -0.3}

FRICTION = TINY.replace('<dynamics damping="0.1"/>', '<dynamics damping="0.1" friction="0.4"/>')


def joint_forces(project: Path, user: Any, state: dict[str, tuple[float, float]]) -> dict[str, Any]:
    data = MbsData(project / "dataR" / f"{project.name}.mbs")
    for name, (q, qd) in state.items():
        data.q[data.joint_id[name]], data.qd[data.joint_id[name]] = q, qd
    data.Qq[1:] = 7.0  # what was there before counts for nothing
    user["user_JointForces"].user_JointForces(data, 0.0)
    return {"data": data, **{name: data.Qq[k] for name, k in data.joint_id.items()}}


def test_damping_friction_and_stops(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION)
    with user_functions(project) as user:
        found = joint_forces(project, user, {"shoulder": (0.3, 0.05)})
        model = found["data"].user_model
        speed = model["friction_speed"]["shoulder"]
        assert found["shoulder"] == pytest.approx(-0.1 * 0.05 - 0.4 * tanh(0.05 / speed))
        assert found["wrist_pitch"] == found["wrist_roll"] == 0.0

        # beyond a limit it pushes back, harder on the way in, and never pulls
        k = model["stop_stiffness"]["wrist_pitch"]
        for q, qd, wanted in (
            (1.02, 0.0, -k * 0.02),
            (1.02, 0.5, -k * 0.02 * 1.5),
            (1.02, -0.5, -k * 0.02 * 0.5),
            (1.02, -2.0, 0.0),
            (-1.02, 0.0, k * 0.02),
            (-1.02, -0.5, k * 0.02 * 1.5),
            (-1.02, 2.0, 0.0),
            (0.99, 2.0, 0.0),
        ):
            found = joint_forces(project, user, {"wrist_pitch": (q, qd)})
            assert found["wrist_pitch"] == pytest.approx(wanted, abs=1e-12)


def test_a_limit_on_one_side(tmp_path: Path) -> None:
    project = make(tmp_path, TINY.replace('lower="-1.5" upper="1.5"', 'lower="-inf" upper="1.5"'))
    with user_functions(project) as user:
        assert joint_forces(project, user, {"shoulder": (-50.0, 0.0)})["shoulder"] == 0.0
        assert joint_forces(project, user, {"shoulder": (1.6, 0.0)})["shoulder"] < 0.0


def test_each_kind_can_be_switched_off(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION)
    with user_functions(project) as user:
        for kind in ("damping", "friction", "stops"):
            data = MbsData(project / "dataR" / "robot.mbs")
            for other in ("damping", "friction", "stops"):
                data.user_model["joint_forces"][other] = 0.0
            joint = data.joint_id["shoulder"]
            data.q[joint], data.qd[joint] = 1.6, 0.1
            user["user_JointForces"].user_JointForces(data, 0.0)
            assert data.Qq[joint] == 0.0
            data.user_model["joint_forces"][kind] = 1.0
            user["user_JointForces"].user_JointForces(data, 0.0)
            assert data.Qq[joint] < 0.0


def test_user_models_hold_what_the_urdf_states() -> None:
    robot = TINY.replace(
        '<dynamics damping="0.1"/>',
        '<dynamics damping="0.1" friction="0.4"/><calibration rising="0.3"/><safety_controller '
        'soft_lower_limit="-1" soft_upper_limit="1.25" k_position="15" k_velocity="10"/>',
    )
    result = convert_text(robot)
    models = {
        model.name: {p.name: float(p.values[0]) for p in model.parameters}
        for model in read(result.data, "robot.mbs").user_models
    }
    assert models["q_min"] == {"shoulder": -1.5, "wrist_pitch": -1.0}
    assert models["q_max"] == {"shoulder": 1.5, "wrist_pitch": 1.0}
    assert models["effort"] == {"shoulder": 10.0, "wrist_pitch": 1.0}
    assert models["velocity"] == {"shoulder": 2.0, "wrist_pitch": 2.0}
    assert models["damping"] == {"shoulder": 0.1}
    assert models["friction"] == {"shoulder": 0.4}
    assert models["soft_q_min"] == {"shoulder": -1.0}
    assert models["soft_q_max"] == {"shoulder": 1.25}
    assert models["k_position"] == {"shoulder": 15.0}
    assert models["k_velocity"] == {"shoulder": 10.0}
    assert models["calibration_rising"] == {"shoulder": 0.3}
    codes = {found.code for found in result.diagnostics}
    assert not codes & {"limit", "safety-controller", "calibration"}
    assert "joint-dynamics" in codes, "nothing applies them in a plain .mbs"


def test_renamed_joints_keep_their_parameters(tmp_path: Path) -> None:
    project = make(tmp_path, FRICTION.replace("shoulder", "shoulder/1"))
    with user_functions(project) as user:
        found = joint_forces(project, user, {"shoulder_1": (0.0, 50.0)})
        assert found["shoulder_1"] == pytest.approx(-5.4)


def test_the_moved_inertia_is_the_diagonal_of_the_mass_matrix() -> None:
    pin = pytest.importorskip("pinocchio")
    from urdf2mbs.proof.dynamics import to_pinocchio

    result = convert_text(TINY, options={"posture": {"joints": {"*": 0.4}}})
    model = to_pinocchio(result.mbs)
    names = list(model.names)[1:]
    start = {j.name: j.q or 0.0 for b in result.mbs.bodies for j in b.joints}
    mass = pin.crba(model, model.createData(), np.array([start[name] for name in names]))
    found = moved_inertias(result.mbs, names)
    assert [found[name] for name in names] == pytest.approx(list(np.diag(mass)), rel=1e-12)


# --- the ground ---


def test_the_robot_stands_on_its_lowest_points(tmp_path: Path) -> None:
    passes = {"posture": {"joints": STANCE}, "contacts": {"links": ["*_foot"]}}
    project = make(tmp_path, BIPED, passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    placement = place(data.mbs)
    heights = []
    for _, owner, point in data.forces:
        pose = placement.bodies[owner]
        heights.append(add(pose.xyz, rotate(pose.rot, point.coordinates))[2])
    assert len(heights) == 8
    assert min(heights) == pytest.approx(0.0, abs=1e-12)
    assert max(heights) < 1e-9, "the feet are level in this position"


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 9.81), (0.0, -9.81, 0.0)])
def test_up_is_against_gravity(tmp_path: Path, gravity: tuple[float, float, float]) -> None:
    passes = {"contacts": {"links": ["*_foot"], "ground": 0.25}}
    project = make(tmp_path, BIPED, passes=passes, gravity=list(gravity))
    data = MbsData(project / "dataR" / "robot.mbs")
    placement = place(data.mbs)
    x, y, z = (-c / 9.81 for c in gravity)
    heights = [
        dot((x, y, z), add(placement.bodies[o].xyz, rotate(placement.bodies[o].rot, p.coordinates)))
        for _, o, p in data.forces
    ]
    assert min(heights) == pytest.approx(0.25, abs=1e-12)


def test_the_contact_law(tmp_path: Path) -> None:
    options = {"links": ["*_foot"], "depth": 0.001, "speed": 0.1, "slip_speed": 0.02}
    project = make(tmp_path, BIPED, passes={"contacts": options})
    data = MbsData(project / "dataR" / "robot.mbs")
    law = data.user_model["contact"]
    total = sum(body.mass or 0.0 for body in data.mbs.bodies) * 9.81
    assert law["stiffness"] * 0.001 * 8 == pytest.approx(total, rel=0.05)
    R = from1(3, 3)
    random = np.random.default_rng(1)
    with user_functions(project) as user:

        def force(point: Any, speed: Any, number: int = 2) -> Any:
            P, V, none = from1(3), from1(3), from1(3)
            P[1:4], V[1:4] = point, speed
            row = user["user_ExtForces"].user_ExtForces(
                P, R, V, none, none, none, data, 0.0, number
            )
            assert np.shares_memory(row, data.SWr), "the row of SWr itself is to be returned"
            where = data.dpt[1:4, data.xfidpt[number]]
            assert np.array_equal(np.array(row)[7:], np.array(where))
            assert np.array_equal(np.array(row)[4:7], np.zeros(3))
            return np.array(row)[1:4]

        assert np.array_equal(force((0, 0, 1e-9), (1, 1, -1)), np.zeros(3))
        k = law["stiffness"]
        assert force((1, 2, -0.002), (0, 0, 0)) == pytest.approx([0, 0, k * 0.002])
        assert force((0, 0, -0.002), (0, 0, -0.1)) == pytest.approx([0, 0, 2 * k * 0.002])
        assert np.array_equal(force((0, 0, -0.002), (0, 0, 0.11)), np.zeros(3)), "it never pulls"
        for _ in range(20):
            V = random.normal(size=3) * 0.05
            fx, fy, fz = force((0, 0, -0.002), V)
            slip = np.hypot(V[0], V[1])
            assert np.hypot(fx, fy) == pytest.approx(0.8 * fz * tanh(slip / 0.02))
            assert fx * V[0] + fy * V[1] <= 0.0, "friction does not drive"
            assert fx * V[1] == pytest.approx(fy * V[0], abs=1e-12)
        robot = user["user_ExtForces"].robot
        force((0, 0, -0.002), (0, 0, 0), 1)
        assert robot.contact_force(data, "left_foot")[2] == pytest.approx(
            sum(data.SWr[number, 3] for number in (1, 2, 3, 4))
        )


SHAPES = {
    '<sphere radius="0.1"/>': [(0.0, 0.0, -0.1)],
    '<cylinder radius="0.1" length="0.4"/>': [
        (0.1, 0.0, -0.2), (0.0, 0.1, -0.2), (-0.1, 0.0, -0.2), (0.0, -0.1, -0.2),
    ],
    '<box size="0.2 0.4 0.6"/>': [
        (0.1, 0.2, -0.3), (0.1, -0.2, -0.3), (-0.1, -0.2, -0.3), (-0.1, 0.2, -0.3),
    ],
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES)
def test_points_of_shapes(tmp_path: Path, shape: str) -> None:
    robot = TINY.replace('<box size="0.2 0.1 0.3"/>', shape)
    project = make(tmp_path, robot, passes={"contacts": {"links": ["body"]}})
    data = MbsData(project / "dataR" / "robot.mbs")
    found = [point.coordinates for _, _, point in data.forces]
    assert found == [pytest.approx(point, abs=1e-15) for point in SHAPES[shape]]


def test_a_lying_cylinder_touches_along_its_lowest_line(tmp_path: Path) -> None:
    robot = TINY.replace(
        '<geometry><box size="0.2 0.1 0.3"/>',
        '<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.1" length="0.4"/>',
    )
    project = make(tmp_path, robot, passes={"contacts": {"links": ["body"]}})
    data = MbsData(project / "dataR" / "robot.mbs")
    found = sorted(point.coordinates for _, _, point in data.forces)
    assert found[0] == pytest.approx((0.0, -0.2, -0.1), abs=1e-12) or found[0] == pytest.approx(
        (0.0, 0.2, -0.1), abs=1e-12
    )
    assert {round(y, 9) for _, y, _ in found} == {-0.2, 0.2}
    assert [z for _, _, z in found] == pytest.approx([-0.1, -0.1])


def test_corners_of_a_mesh(tmp_path: Path) -> None:
    """A sole with a pointed heel, and an ankle far above it that does not count."""
    corners = ["0 0 0", "0.2 0.05 0", "0.2 -0.05 0", "-0.1 0.03 0", "-0.1 -0.03 0", "0 0 0.3"]
    (tmp_path / "foot.obj").write_text(
        "".join(f"v {corner}\n" for corner in corners) + "f 1 2 3\nf 1 4 5\nf 1 2 6\n"
    )
    robot = TINY.replace('<box size="0.2 0.1 0.3"/>', '<mesh filename="foot.obj" scale="1 2 1"/>')
    project = make(tmp_path, robot, passes={"contacts": {"links": ["body"]}})
    data = MbsData(project / "dataR" / "robot.mbs")
    found = sorted(point.coordinates for _, _, point in data.forces)
    assert found == [
        pytest.approx(point)
        for point in [(-0.1, -0.06, 0), (-0.1, 0.06, 0), (0.2, -0.1, 0), (0.2, 0.1, 0)]
    ]


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"links": ["*_fot"]}, "contacts-links"),
        ({"links": ["tool"], "stiffness": -1.0}, "value-range"),
        ({"links": ["tool"]}, "contacts-shape"),
        ({"links": ["wrist"]}, "contacts-body"),
    ],
)
def test_wrong_contacts(options: dict[str, Any], code: str) -> None:
    with pytest.raises(ConfigError) as caught:
        convert_text(TINY, options={"contacts": options})
    assert caught.value.code == code


# --- forces and springs ---


def test_wrenches_and_springs(tmp_path: Path) -> None:
    passes = {
        "forces": {
            "wrenches": {
                "hand": {"link": "hand", "at": [0, 0, 0.1], "force": [1, 2, 3],
                         "torque": [4, 5, 6], "start": 0.5, "stop": 1.0},
            },
            "springs": {
                "band": {"ends": [{"link": "body"}, {"link": "arm", "at": [0, 0, 0.3]}],
                         "stiffness": 100, "damping": 5},
            },
        }
    }  # fmt: skip
    project = make(tmp_path, TINY, passes=passes)
    data = MbsData(project / "dataR" / "robot.mbs")
    assert data.extforce_id == {"hand_force": 1}, "the body keeps its name"
    assert "hand" in data.body_id
    with user_functions(project) as user:
        P, R = from1(3), from1(3, 3)
        for t, wanted in ((0.0, [0.0] * 6), (0.5, [1, 2, 3, 4, 5, 6]), (1.0, [0.0] * 6)):
            row = user["user_ExtForces"].user_ExtForces(P, R, P, P, P, P, data, t, 1)
            assert np.array_equal(np.array(row)[1:7], wanted)
        rest = data.user_model["link_length"]["band"]
        placement = place(data.mbs)
        (link,) = data.mbs.links
        ends = [placement.point(data.mbs, *end) for end in (link.endpoint1, link.endpoint2)]
        assert rest == pytest.approx(np.linalg.norm(np.subtract(*ends)))
        pull = user["user_LinkForces"].user_LinkForces(rest + 0.02, 0.1, data, 0.0, 1)
        assert pull == pytest.approx(100 * 0.02 + 5 * 0.1)
        assert user["user_LinkForces"].user_LinkForces(1.0, 0.0, data, 0.0, 9) == 0.0


@pytest.mark.parametrize("name", ["contacts", "sensors", "loops", "forces"])
def test_points_that_come_after_the_diagram_are_an_error(name: str) -> None:
    pipeline = [one for one in passes_of("faithful") if one != name]
    with pytest.raises(ConfigError) as caught:
        convert_text(pipeline=pipeline, after={"layout": name})
    assert caught.value.code == "stale"
    assert name in caught.value.message
