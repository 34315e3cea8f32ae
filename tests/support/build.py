"""Elements of URDF as text: the one way in which tests make a robot."""

#: A solid whose frame is turned, so that no number of it is zero.
SOLID = (
    '<inertial><origin xyz="0.1 -0.2 0.3" rpy="0.3 -0.2 0.1"/><mass value="2"/>'
    '<inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.04" iyz="0.003" izz="0.05"/></inertial>'
)
BOX = (
    '<visual><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/>'
    '<geometry><box size="1 2 3"/></geometry></visual>'
)


def robot(*elements: str, name: str = "r") -> str:
    """Return a robot of links, joints and other elements."""
    return f'<robot name="{name}">{"".join(elements)}</robot>'


def link(name: str, *content: str) -> str:
    """Return a link; without content it is massless."""
    return f'<link name="{name}">{"".join(content)}</link>'


def solid(
    mass: float = 1.0,
    moment: float | tuple[float, float, float] = 1.0,
    *,
    xyz: str = "0 0 0",
    rpy: str = "0 0 0",
) -> str:
    """Return the ``<inertial>`` of a solid without products of inertia.

    Args:
        mass: Its mass (kg).
        moment: Its moment of inertia about each axis through its centre, or one for each
            (kg m^2).
        xyz: Its centre in the link's frame (m).
        rpy: How its frame is turned (rad).
    """
    xx, yy, zz = moment if isinstance(moment, tuple) else (moment,) * 3
    return (
        f'<inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial>'
    )


def limit(lower: float = -1, upper: float = 1, *, effort: float = 1, velocity: float = 1) -> str:
    """Return the ``<limit>`` of a joint (rad or m, N m or N, rad/s or m/s)."""
    return f'<limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}"/>'


def joint(
    parent: str,
    child: str,
    kind: str = "continuous",
    *content: str,
    xyz: str = "0 0 0",
    rpy: str = "0 0 0",
    axis: str = "0 0 1",
    limited: bool = True,
    name: str = "",
) -> str:
    """Return a joint between two links.

    Args:
        parent: The parent link.
        child: The child link.
        kind: The joint's type.
        content: More elements; without a ``<limit>`` among them, its limits are -1 and 1.
        xyz: Where the joint is in the parent's frame (m).
        rpy: How the joint's frame is turned (rad).
        axis: The axis, in the joint's frame.
        limited: False: without a ``<limit>`` in ``content`` it has no limits.
        name: Its name; the default is ``PARENT_to_CHILD``.
    """
    more = "".join(content)
    if limited and "<limit" not in more:
        more += limit()
    return (
        f'<joint name="{name or f"{parent}_to_{child}"}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        f"{more}</joint>"
    )
