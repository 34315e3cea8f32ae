"""Colours and files of the visuals; test_random_robots.py proves their sizes and poses."""

from pathlib import Path

import pytest

from urdf2mbs import convert
from urdf2mbs.mbs.model import GREY, Shape
from urdf2mbs.passes.convert_visuals import choose_stem

ROBOT = """<robot name="coloured">
  <material name="blue"><color rgba="0 0.2 1 0.25"/></material>
  <link name="body">
    <inertial><mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual name="shown"><geometry><sphere radius="0.1"/></geometry>{material}</visual>
    <visual name="other"><geometry><box size="1 2 3"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material></visual>
  </link>
</robot>"""


def shape(folder: Path, material: str) -> Shape:
    robot = folder / "robot.urdf"
    robot.write_text(ROBOT.format(material=material))
    return convert(robot).mbs.bodies[0].shapes[0]


@pytest.mark.parametrize(
    ("material", "color", "transparency"),
    [
        ("", GREY, 0.0),
        ('<material name="blue"/>', (0, 51, 255), 0.75),  # a global one, by name
        ('<material name="red"/>', (255, 0, 0), 0.0),  # defined in place elsewhere
        ('<material name="own"><color rgba="0 1 0 1"/></material>', (0, 255, 0), 0.0),
        ('<material name="blue"><color rgba="1 1 1 1"/></material>', (255, 255, 255), 0.0),
        ('<material name=""><color rgba="2 -1 0 5"/></material>', (255, 0, 0), 0.0),
        ('<material name="nowhere"/>', GREY, 0.0),
    ],
)
def test_a_visual_has_the_colour_of_its_material(
    tmp_path: Path, material: str, color: tuple[int, int, int], transparency: float
) -> None:
    found = shape(tmp_path, material)
    assert found.color == color
    assert found.transparency == transparency


def visuals(folder: Path, *elements: str) -> list[Shape]:
    robot = folder / "robot.urdf"
    inside = "".join(f"<visual>{element}</visual>" for element in elements)
    robot.write_text(
        ROBOT.format(material="").replace('<visual name="shown">', inside + "<visual>")
    )
    return convert(robot).mbs.bodies[0].shapes[: len(elements)]


def test_meshes_whose_names_differ_in_case_only_become_two_files(tmp_path: Path) -> None:
    """They would be one file on some systems."""
    meshes = [
        f'<geometry><mesh filename="{name}"/></geometry>'
        for name in ("a.stl", "b/A.STL", "b/a.dae", "a.stl")
    ]
    found = [shape.url.rpartition("/")[2] for shape in visuals(tmp_path, *meshes)]
    assert found == ["a.wrl", "A_2.wrl", "a_3.wrl", "a.wrl"]


@pytest.mark.parametrize(
    ("files", "stems"),
    [
        (["a b.stl", "A_B.dae"], ["a_b", "A_B_2"]),
        ([r"c:\x\arm.1.stl", "con.stl", "con.obj"], ["arm_1", "con_mesh", "con_mesh_2"]),
        ([".stl", "///"], ["_stl", "mesh"]),
        (["x" * 300 + ".stl"], ["x" * 150]),
    ],
)
def test_names_of_mesh_files_suit_every_system(files: list[str], stems: list[str]) -> None:
    chosen: list[str] = []
    for file in files:
        chosen.append(choose_stem(file, set(chosen)))
    assert chosen == stems


def test_a_capsule_is_a_cylinder_and_two_spheres(tmp_path: Path) -> None:
    """The length is that of the cylinder, whose axis is z of a turned visual."""
    source = tmp_path / "robot.urdf"
    capsule = (
        '<visual name="rod"><origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/><geometry>'
        '<capsule radius="0.1" length="0.6"/></geometry></visual>'
    )
    source.write_text(ROBOT.format(material="").replace("<visual", f"{capsule}<visual", 1))
    cylinder, *balls = convert(source).mbs.bodies[0].shapes[:3]
    assert (cylinder.kind, cylinder.radius, cylinder.height) == ("cylinder", 0.1, 0.6)
    assert cylinder.position == pytest.approx((1.0, 2.0, 3.0))
    assert [(ball.kind, ball.radius) for ball in balls] == [("sphere", 0.1)] * 2
    ends = sorted(ball.position for ball in balls)
    assert ends[0] == pytest.approx((0.7, 2.0, 3.0))
    assert ends[1] == pytest.approx((1.3, 2.0, 3.0))


def test_a_capsule_with_the_prefix_of_drake_is_read(tmp_path: Path) -> None:
    source = tmp_path / "robot.urdf"
    capsule = '<drake:capsule radius="0.1" length="0.6"/>'
    text = ROBOT.format(material="").replace('<sphere radius="0.1"/>', capsule)
    source.write_text(text.replace("<robot", '<robot xmlns:drake="http://drake.mit.edu"'))
    result = convert(source)
    assert [shape.kind for shape in result.mbs.bodies[0].shapes] == [
        "cylinder",
        "sphere",
        "sphere",
        "box",
    ]
    assert not [diagnostic for diagnostic in result.diagnostics if diagnostic.level == "warning"]
