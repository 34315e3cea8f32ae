"""Small robots whose projects are tested: mimic joints, a four-bar linkage, a box."""

from support.build import link, solid


def unit_link(name: str) -> str:
    """Return a link of 1 kg and 1 kg m^2."""
    return link(name, solid())


def y_joint(name: str, parent: str, child: str, more: str = "", kind: str = "continuous") -> str:
    """Return a joint about y or along it, without limits."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 1 0"/>{more}</joint>'
    )


MIMIC_CHAIN = (
    '<robot name="chain">'
    + "".join(unit_link(name) for name in "abcde")
    + y_joint("one", "a", "b")
    + y_joint("two", "b", "c", '<mimic joint="one" multiplier="2" offset="0.5"/>')
    + y_joint("three", "c", "d", '<mimic joint="two" multiplier="-3" offset="0.25"/>')
    + y_joint("four", "d", "e")
    + "</robot>"
)


def origin_at(x: float, y: float, z: float) -> str:
    return f'<origin xyz="{x} {y} {z}"/>'


#: A four-bar linkage in the plane x z: the tips of two chains from the base meet.
FOUR_BAR = (
    '<robot name="four_bar">'
    + "".join(unit_link(name) for name in ("base", "left", "coupler", "right"))
    + y_joint("crank", "base", "left", origin_at(0, 0, 0))
    + y_joint("elbow", "left", "coupler", origin_at(0, 0, 1))
    + y_joint("rocker", "base", "right", origin_at(1, 0, 0))
    + "</robot>"
)


BALL = {"pin": {"ends": [{"link": "coupler", "at": [1, 0, 0]}, {"link": "right", "at": [0, 0, 1]}]}}


BOX = (
    '<robot name="box"><link name="box"><inertial><mass value="2"/><inertia ixx="0.02" iyy="0.03" '
    'izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size="0.3 0.2 0.1"/>'
    "</geometry></collision></link></robot>"
)
