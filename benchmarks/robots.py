"""The robots that the benchmarks convert: real ones without their meshes, and generated ones."""

from __future__ import annotations

from math import pi
from pathlib import Path
from random import Random

from lxml import etree

ROBOTS = Path(__file__).resolve().parents[2] / "shared" / "robots"
REAL = {
    "cassie": "cassie/cassie_description/urdf/cassie_v4.urdf",
    "atlas": "atlas/expanded/atlas_v5.urdf",
    "nao": "nao/nao_description/urdf/naoV50_generated_urdf/nao.urdf",
    "walkman": "walkman/robotran_edu_2017/bigman.urdf",
    "icub": "icub/iCub/robots/iCubGazeboV2_5/model.urdf",
}
#: Arms on a fixed base.
ARMS = {"fr3": "franka/expanded/fr3_nohand.urdf", "ur5": "ur/expanded/ur5.urdf"}

#: Arms whose operations are published, by the rows alpha (quarter turns), d and r (m) of modified
#: Denavit-Hartenberg parameters (Khalil, Dombre: Modeling, Identification and Control of Robots);
#: of the Stanford arm, the third joint slides.
DH = {
    "puma": [(0, 0, 0), (-1, 0, 0.2435), (0, 0.4318, -0.0934), (1, -0.0203, 0.4331), (-1, 0, 0),
             (1, 0, 0)],
    "stanford": [(0, 0, 0), (-1, 0, 0.154), (1, 0, 0), (0, 0, 0), (-1, 0, 0), (1, 0, 0)],
    "rx90": [(0, 0, 0), (1, 0, 0), (0, 0.45, 0), (-1, 0, 0.45), (1, 0, 0), (-1, 0, 0)],
}  # fmt: skip

LINK = """\
  <link name="link_{i}">
    <inertial>
      <origin xyz="{x} 0.02 0.1" rpy="0.1 0.2 0.3"/>
      <mass value="{mass}"/>
      <inertia ixx="{ixx}" ixy="0.001" ixz="0.0005" iyy="0.012" iyz="0.0004" izz="0.013"/>
    </inertial>
    <visual>
      <origin xyz="0 0 0.1" rpy="0 0 0"/>
      <geometry><box size="0.05 0.05 0.2"/></geometry>
      <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
    </visual>
  </link>
"""
JOINT = """\
  <joint name="joint_{i}" type="revolute">
    <origin xyz="0 0.01 {z}" rpy="{rpy}"/>
    <parent link="link_{parent}"/>
    <child link="link_{i}"/>
    <axis xyz="{axis}"/>
    <limit lower="-1.5" upper="1.5" effort="100" velocity="2"/>
  </joint>
"""
AXES = ("1 0 0", "0 1 0", "0 0 1", "0 -1 0", "0 0.6 0.8")
RPYS = ("0 0 0", "0 0 0", "1.5708 0 0", "0.1 0.2 0.3")


def generated(shape: str, links: int) -> bytes:
    """A ``chain``; a ``tree`` in which every link carries three others; a ``star``, in which the
    first one carries all; or a ``mixed`` tree, of which no two links are alike."""
    parts = [f'<?xml version="1.0"?>\n<robot name="{shape}">\n']
    random = Random(1)
    x, mass, ixx, z = 0.01, 1.5, 0.011, 0.2
    for i in range(links):
        axis, rpy = AXES[i % len(AXES)], RPYS[i % len(RPYS)]
        if shape == "mixed":
            x, mass, ixx, z = (round(random.uniform(a, 2 * a), 9) for a in (0.01, 1.5, 0.011, 0.2))
            rpy = " ".join(str(round(random.uniform(-3, 3), 9)) for _ in range(3))
        parts.append(LINK.format(i=i, x=x, mass=mass, ixx=ixx))
        if i:
            parent = {"chain": i - 1, "tree": (i - 1) // 3, "star": 0, "mixed": (i - 1) // 3}[shape]
            parts.append(JOINT.format(i=i, parent=parent, axis=axis, rpy=rpy, z=z))
    parts.append("</robot>\n")
    return "".join(parts).encode()


def by_dh(name: str) -> str:
    """The URDF of an arm, whose bodies have no number that is zero."""
    text = f'<robot name="{name}"><link name="link_0"/>'
    for i, (turns, d, r) in enumerate(DH[name], start=1):
        kind = "prismatic" if (name, i) == ("stanford", 3) else "continuous"
        inertia = {"ixx": 0.1, "ixy": 0.001, "ixz": 0.002, "iyy": 0.14, "iyz": -0.0015, "izz": 0.12}
        tensor = " ".join(f'{key}="{i * value}"' for key, value in inertia.items())
        text += f"""
  <link name="link_{i}"><inertial>
    <origin xyz="{0.01 * i} {0.02 * i} {0.03 * i}"/><mass value="{8 - i}"/><inertia {tensor}/>
  </inertial></link>
  <joint name="joint_{i}" type="{kind}">
    <parent link="link_{i - 1}"/><child link="link_{i}"/><axis xyz="0 0 1"/>
    <origin xyz="{d} {-turns * r} {r * (1 - abs(turns))}" rpy="{turns * pi / 2} 0 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>"""
    return f"{text}\n</robot>"


def without_meshes(source: Path) -> bytes:
    """The URDF less its visuals and collisions that need a mesh file."""
    root = etree.fromstring(source.read_bytes())
    for mesh in root.findall(".//mesh"):
        shown = mesh.getparent().getparent()
        if shown.getparent() is not None:
            shown.getparent().remove(shown)
    return etree.tostring(root, xml_declaration=True, encoding="utf-8")


def real(robots: dict[str, str] = REAL) -> dict[str, bytes]:
    """By name; those that are here."""
    paths = {name: ROBOTS / path for name, path in robots.items()}
    return {name: without_meshes(path) for name, path in paths.items() if path.is_file()}
