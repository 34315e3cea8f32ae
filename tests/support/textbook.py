"""Robots of textbooks as URDF, and the formulas that the books have for them.

The formulas are in our symbols, as Python: ``c23`` is the cosine of q_2 + q_3, and ``qd1`` a
velocity.  A book's own abbreviations are written out.
"""

import math
from dataclasses import dataclass, field

Vector = tuple[float, float, float]
ORIGIN: Vector = (0.0, 0.0, 0.0)
X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
#: Rotates z into -y: a planar arm that gravity pulls.
UPRIGHT: Vector = (math.pi / 2, 0.0, 0.0)


def make_link(name: str, mass: float, centre: Vector, inertia: Vector = ORIGIN) -> str:
    """Return a link whose inertia has these principal moments."""
    xx, yy, zz = inertia
    return (
        f'<link name="{name}"><inertial><origin xyz="{_write(centre)}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def make_joint(
    name: str, kind: str, links: str, axis: Vector, xyz: Vector = ORIGIN, rpy: Vector = ORIGIN
) -> str:
    """Return a joint between two links: ``"parent child"``."""
    parent, child = links.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_write(xyz)}" rpy="{_write(rpy)}"/><axis xyz="{_write(axis)}"/>'
        '<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
    )


def _write(vector: Vector) -> str:
    return " ".join(map(repr, vector))


def make_robot(name: str, *parts: str) -> str:
    """Return a robot on the link ``base``, which is fixed."""
    return f'<robot name="{name}"><link name="base"/>{"".join(parts)}</robot>'


@dataclass
class Textbook:
    """A robot and its formulas in a book; elements of M that are zero are left out."""

    urdf: str
    mass_matrix: dict[tuple[int, int], str]
    coriolis: dict[int, str] = field(default_factory=dict)
    gravity: dict[int, str] = field(default_factory=dict)


PENDULUM = Textbook(
    make_robot(
        "pendulum",
        make_link("rod", 2.0, (0.0, 0.0, -0.3), (0.15, 0.2, 0.06)),
        make_joint("pivot", "continuous", "base rod", Y),
    ),
    {(1, 1): "m*l_c**2 + I"},
    {1: "0"},
    {1: "m*g*l_c*s1"},
)

ARM = (
    make_link("upper", 2.0, (0.25, 0.0, 0.0), (0.1, 0.2, 0.25)),
    make_link("lower", 1.5, (0.2, 0.0, 0.0), (0.1, 0.2, 0.15)),
    make_joint("elbow", "continuous", "upper lower", Z, (0.5, 0.0, 0.0)),
)
#: Spong, Hutchinson, Vidyasagar, Robot Modeling and Control, 2006, section 7.4.
DOUBLE_PENDULUM = Textbook(
    make_robot(
        "double_pendulum",
        *ARM,
        make_joint("shoulder", "continuous", "base upper", Z, rpy=UPRIGHT),
    ),
    {
        (1, 1): "m_1*l_c1**2 + m_2*(l_1**2 + l_c2**2 + 2*l_1*l_c2*c2) + I_1 + I_2",
        (1, 2): "m_2*(l_c2**2 + l_1*l_c2*c2) + I_2",
        (2, 2): "m_2*l_c2**2 + I_2",
    },
    {
        1: "-m_2*l_1*l_c2*s2*qd2*qd1 - m_2*l_1*l_c2*s2*(qd1 + qd2)*qd2",
        2: "m_2*l_1*l_c2*s2*qd1**2",
    },
    {1: "(m_1*l_c1 + m_2*l_1)*g*c1 + m_2*l_c2*g*c12", 2: "m_2*l_c2*g*c12"},
)

#: Tedrake, Underactuated Robotics, 2023, section 3.2, with the inertia of the pole.
CART_POLE = Textbook(
    make_robot(
        "cart_pole",
        make_link("cart", 3.0, ORIGIN),
        make_link("pole", 1.0, (0.0, 0.0, 0.4), (0.03, 0.04, 0.01)),
        make_joint("rail", "prismatic", "base cart", X),
        make_joint("hinge", "continuous", "cart pole", Y),
    ),
    {(1, 1): "m_1 + m_2", (1, 2): "m_2*l_c2*c2", (2, 2): "m_2*l_c2**2 + I_2"},
    {1: "-m_2*l_c2*qd2**2*s2", 2: "0"},
    {1: "0", 2: "-m_2*g*l_c2*s2"},
)

#: Asada, Slotine, Robot Analysis and Control, 1986, chapter 6, for three links.
PLANAR_3R = Textbook(
    make_robot(
        "planar",
        *ARM,
        make_link("hand", 1.0, (0.1, 0.0, 0.0), (0.1, 0.11, 0.05)),
        make_joint("shoulder", "continuous", "base upper", Z),
        make_joint("wrist", "continuous", "lower hand", Z, (0.4, 0.0, 0.0)),
    ),
    {
        (1, 1): "I_1 + I_2 + I_3 + m_1*l_c1**2 + m_2*(l_1**2 + l_c2**2 + 2*l_1*l_c2*c2)"
        " + m_3*(l_1**2 + l_2**2 + l_c3**2 + 2*l_1*l_2*c2 + 2*l_1*l_c3*c23 + 2*l_2*l_c3*c3)",
        (1, 2): "I_2 + I_3 + m_2*(l_c2**2 + l_1*l_c2*c2)"
        " + m_3*(l_2**2 + l_c3**2 + l_1*l_2*c2 + l_1*l_c3*c23 + 2*l_2*l_c3*c3)",
        (1, 3): "I_3 + m_3*(l_c3**2 + l_1*l_c3*c23 + l_2*l_c3*c3)",
        (2, 2): "I_2 + I_3 + m_2*l_c2**2 + m_3*(l_2**2 + l_c3**2 + 2*l_2*l_c3*c3)",
        (2, 3): "I_3 + m_3*(l_c3**2 + l_2*l_c3*c3)",
        (3, 3): "I_3 + m_3*l_c3**2",
    },
    gravity={1: "0", 2: "0", 3: "0"},
)

#: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, section 4.3.
SCARA = Textbook(
    make_robot(
        "scara",
        *ARM,
        make_link("quill", 1.0, ORIGIN, (0.1, 0.1, 0.05)),
        make_link("tool", 0.7, (0.0, 0.0, -0.2), (0.1, 0.1, 0.02)),
        make_joint("shoulder", "continuous", "base upper", Z, (0.0, 0.0, 0.5)),
        make_joint("wrist", "continuous", "lower quill", Z, (0.4, 0.0, 0.0)),
        make_joint("lift", "prismatic", "quill tool", Z),
    ),
    {
        (1, 1): "I_1 + l_c1**2*m_1 + l_1**2*m_2 + l_1**2*m_3 + l_1**2*m_4"
        " + I_2 + I_3 + I_4 + l_2**2*m_3 + l_2**2*m_4 + m_2*l_c2**2"
        " + 2*(l_1*l_2*m_3 + l_1*l_2*m_4 + l_1*m_2*l_c2)*c2",
        (1, 2): "I_2 + I_3 + I_4 + l_2**2*m_3 + l_2**2*m_4 + m_2*l_c2**2"
        " + (l_1*l_2*m_3 + l_1*l_2*m_4 + l_1*m_2*l_c2)*c2",
        (1, 3): "I_3 + I_4",
        (2, 2): "I_2 + I_3 + I_4 + l_2**2*m_3 + l_2**2*m_4 + m_2*l_c2**2",
        (2, 3): "I_3 + I_4",
        (3, 3): "I_3 + I_4",
        (4, 4): "m_4",
    },
    gravity={1: "0", 2: "0", 3: "0", 4: "m_4*g"},
)

#: Craig, Introduction to Robotics, 3rd edition, 2005, section 6.7.
POLAR = Textbook(
    make_robot(
        "polar",
        make_link("column", 2.0, (0.25, 0.0, 0.0), (0.1, 0.2, 0.25)),
        make_link("boom", 1.5, ORIGIN, (0.1, 0.2, 0.15)),
        make_joint("turn", "continuous", "base column", Z, rpy=UPRIGHT),
        make_joint("reach", "prismatic", "column boom", X),
    ),
    {(1, 1): "m_1*l_c1**2 + I_1 + I_2 + m_2*q_2**2", (2, 2): "m_2"},
    {1: "2*m_2*q_2*qd1*qd2", 2: "-m_2*q_2*qd1**2"},
    {1: "(m_1*l_c1 + m_2*q_2)*g*c1", 2: "m_2*g*s1"},
)

#: Siciliano and others, Robotics: Modelling, Planning and Control, 2009, by section 7.3.
CYLINDRICAL = Textbook(
    make_robot(
        "cylindrical",
        make_link("column", 2.0, (0.0, 0.0, 0.2), (0.15, 0.15, 0.25)),
        make_link("carriage", 1.5, ORIGIN, (0.1, 0.2, 0.15)),
        make_link("boom", 1.0, ORIGIN, (0.1, 0.2, 0.15)),
        make_joint("turn", "continuous", "base column", Z),
        make_joint("lift", "prismatic", "column carriage", Z),
        make_joint("reach", "prismatic", "carriage boom", X),
    ),
    {(1, 1): "I_1 + I_2 + I_3 + m_3*q_3**2", (2, 2): "m_2 + m_3", (3, 3): "m_3"},
    {1: "2*m_3*q_3*qd1*qd3", 2: "0", 3: "-m_3*q_3*qd1**2"},
    {1: "0", 2: "(m_2 + m_3)*g", 3: "0"},
)

#: Murray, Li, Sastry, 1994, example 4.4.
SPHERICAL_PENDULUM = Textbook(
    make_robot(
        "spherical_pendulum",
        '<link name="ring"/>',
        make_link("bob", 1.5, (0.0, 0.0, -0.7)),
        make_joint("azimuth", "continuous", "base ring", Z),
        make_joint("swing", "continuous", "ring bob", Y),
    ),
    {(1, 1): "m*l_c**2*s2**2", (2, 2): "m*l_c**2"},
    {1: "2*m*l_c**2*s2*c2*qd1*qd2", 2: "-m*l_c**2*s2*c2*qd1**2"},
    {1: "0", 2: "m*g*l_c*s2"},
)

#: Murray, Li, Sastry, 1994, section 4.3: the first three joints of the PUMA, without offset.
PUMA = Textbook(
    make_robot(
        "puma",
        make_link("trunk", 2.0, (0.0, 0.0, 0.2), (0.15, 0.15, 0.25)),
        make_link("upper", 1.5, (0.2, 0.0, 0.0), (0.1, 0.2, 0.25)),
        make_link("lower", 1.0, (0.15, 0.0, 0.0), (0.1, 0.2, 0.15)),
        make_joint("waist", "continuous", "base trunk", Z),
        make_joint("shoulder", "continuous", "trunk upper", (0.0, -1.0, 0.0), (0.0, 0.0, 0.5)),
        make_joint("elbow", "continuous", "upper lower", (0.0, -1.0, 0.0), (0.4, 0.0, 0.0)),
    ),
    {
        (1, 1): "I_2xx*s2**2 + I_3xx*s23**2 + I_1 + I_2zz*c2**2 + I_3zz*c23**2"
        " + m_2*l_c2**2*c2**2 + m_3*(l_2*c2 + l_c3*c23)**2",
        (2, 2): "I_2yy + I_3yy + m_3*l_2**2 + m_2*l_c2**2 + m_3*l_c3**2 + 2*m_3*l_2*l_c3*c3",
        (2, 3): "I_3yy + m_3*l_c3**2 + m_3*l_2*l_c3*c3",
        (3, 3): "I_3yy + m_3*l_c3**2",
    },
    {
        3: "m_3*l_2*l_c3*s3*qd2**2 - (I_3xx - I_3zz - m_3*l_c3**2)*c23*s23*qd1**2"
        " + m_3*l_2*l_c3*c2*s23*qd1**2"
    },
    {1: "0", 2: "(m_2*l_c2 + m_3*l_2)*g*c2 + m_3*l_c3*g*c23", 3: "m_3*l_c3*g*c23"},
)

TEXTBOOKS = {
    "pendulum": PENDULUM,
    "double pendulum": DOUBLE_PENDULUM,
    "cart and pole": CART_POLE,
    "planar 3R": PLANAR_3R,
    "SCARA": SCARA,
    "polar": POLAR,
    "cylindrical": CYLINDRICAL,
    "spherical pendulum": SPHERICAL_PENDULUM,
    "PUMA": PUMA,
}
