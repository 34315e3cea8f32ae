"""Inputs of kinds that public bug reports have: each loss is named, or what is stated is read."""

from pathlib import Path

import numpy as np
import pytest

from support.folders import SHARED
from urdf2mbs import Result, convert, verify
from urdf2mbs.disk import files

#: The code of the only warning of each file (of ../shared/reports), and words of its message.
WARNINGS = {
    "damp_neg": ("number-negative", "damping of <dynamics> is below zero"),
    "dj_omni_arm": ("mechanics-unread", "<drake:damping> in <joint>"),
    "drake_ballc": ("mechanics-unread", "<drake:ball_constraint> in <robot>"),
    "drake_rotor": ("rotors-left-out", "joint 'j1' 1 kg m^2"),
    "dyn_static": ("mechanics-unread", "<damping>, <friction> in <dynamics>"),
    "gz_grav0": ("mechanics-unread", "<gravity> of <gazebo>"),
    "k_spring_neg": ("number-negative", "<springStiffness> of <gazebo>"),
    "lim_neg_eff": ("number-negative", "effort of <limit>"),
    "lim_only_upper": ("limit-zero", "lower of <limit> is missing, which means 0"),
    "lim_zero": ("limit-zero", "by URDF, the joint is locked there"),
    "link_in_link": ("mechanics-unread", "<link> in <link>"),
    "mass_unit": ("mechanics-unread", "'unit' of <mass>"),
    "mimic_sdf": ("mechanics-unread", "<multiplier>, <offset> in <mimic>"),
    "origin_child_xyz": ("mechanics-unread", "<xyz> in <origin>"),
    "origin_pos": ("mechanics-unread", "'pos', 'quat' of <origin>"),
    "pose_payload": ("mechanics-unread", "<pose> in <joint>"),
    "pose_xyz_joint": ("mechanics-unread", "<pose> in <joint>"),
    "rc_conflict": ("mimic-conflict", "right = left, and right = -left"),
    "rc_mimic_typo": ("mimic-left-out", "'left_typo' is no joint"),
    "tr_diff": ("mechanics-unread", "(DifferentialTransmission) couples joints"),
    "tr_shared": ("mechanics-unread", "an actuator of several transmissions couples"),
    "txt_limit": ("mechanics-unread", "<lower>, <upper>, <effort> in <limit>"),
}


@pytest.fixture
def reports() -> Path:
    folder = SHARED / "reports"
    if not folder.is_dir():
        pytest.skip(f"the inputs of reports are not here: {folder} does not exist")
    return folder


def convert_report(folder: Path, name: str, **settings: object) -> Result:
    return convert(folder / f"{name}.urdf", **settings)


@pytest.mark.parametrize("name", WARNINGS)
def test_what_is_lost_is_named(reports: Path, name: str) -> None:
    code, words = WARNINGS[name]
    found = convert_report(reports, name).diagnostics
    told = [one.message for one in found if one.code == code and one.level == "warning"]
    assert any(words in message for message in told), found


@pytest.mark.parametrize("name", ["static_true", "gzworld_fixed"])
def test_a_base_that_is_tied_to_the_world_is_fixed(reports: Path, name: str) -> None:
    result = convert_report(reports, name)
    assert not result.conversion.base.floating
    assert not [one for one in result.diagnostics if one.level == "warning"]


@pytest.mark.parametrize(("name", "count"), [("dj_omni_arm", 4), ("dj_world_implied", 3)])
def test_a_planar_joint_of_drake_moves_in_a_plane(reports: Path, name: str, count: int) -> None:
    joints = convert_report(reports, name).mbs.joints().values()
    assert sum(joint.nature == "independent" for joint in joints) == count


def test_a_follower_of_ros2_control_is_coupled(reports: Path) -> None:
    result = convert_report(reports, "rc_mimic_param", output={"project": "p"})
    assert result.report.passes["mimic"]
    assert str(result.robot.joints["right"].mimic) == "-left"


def test_the_rotor_of_drake_counts(reports: Path) -> None:
    """1e-4 kg m^2 behind a gear of 100 beside the 0.022 kg m^2 of the arm."""
    from urdf2mbs_project.mass import MassModel
    from urdf2mbs_project.simulation import Simulation
    from urdf2mbs_project.stability import compute_reduction

    result = convert_report(
        reports, "drake_rotor", output={"project": "p"}, passes={"rotors": {"from_urdf": True}}
    )
    mass = MassModel(result.mbs)
    simulation = result.conversion.state(Simulation)
    reduced = compute_reduction(mass, simulation)
    matrix = reduced.T @ np.array(mass.matrix) @ reduced
    assert matrix.shape == (1, 1)
    assert matrix[0, 0] == pytest.approx(1.022, rel=1e-12)


def test_a_capsule_is_read(reports: Path) -> None:
    result = convert_report(reports, "capsule12")
    assert [shape.kind for shape in result.mbs.bodies[0].shapes] == ["cylinder", "sphere", "sphere"]
    assert not [one for one in result.diagnostics if one.level == "warning"]


def test_a_mesh_in_another_case_is_found(reports: Path, tmp_path: Path) -> None:
    source = tmp_path / "me_case.urdf"
    source.write_bytes(files.read_bytes(reports / "me_case.urdf"))
    mesh = tmp_path / "Meshes" / "w.stl"
    mesh.parent.mkdir()
    mesh.write_text(
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid\n"
    )
    result = convert(source, output={"project": tmp_path / "p"})
    assert result.report.passes["convert-meshes"]["converted"] == 1


def test_verify_finds_a_payload_that_is_elsewhere(reports: Path) -> None:
    """The payload of 0.5 kg is 0.3, 0, 0.8 m from where its <pose> says, which nothing reads."""
    verdict = verify(reports / "pose_payload_ok.urdf", reports / "pose_payload.urdf")
    assert not verdict.same
    told = " ".join(difference.message for difference in verdict.differences)
    assert "link 'camera': centre is (0, 0, 0) in pose_payload.urdf; expected (0.3" in told
