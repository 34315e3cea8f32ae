"""Inertia tensors: as matrices, drawn by hypothesis, and in a robot of two links."""

from typing import Any

import numpy as np
from hypothesis import strategies as st

from urdf2mbs.spatial import Sym

numbers = st.floats(-10, 10, allow_subnormal=False)


tensors = st.tuples(*[numbers] * 6)


def tensor_matrix(tensor: Sym) -> Any:
    xx, xy, xz, yy, yz, zz = tensor
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def second_moment(tensor: Sym) -> Any:
    full = tensor_matrix(tensor)
    return np.eye(3) * np.trace(full) / 2 - full


def two_links(mass: str, moments: str) -> str:
    return (
        '<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
        f'ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="b"><inertial>'
        f'<origin xyz="0 0 1" rpy="0 0 1"/><mass value="{mass}"/><inertia {moments}/></inertial>'
        '</link><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
        "</robot>"
    )
