"""Frames as MuJoCo has them: a position (m) and a quaternion that begins with w."""

from __future__ import annotations

from typing import NamedTuple

from urdf2mbs.plugin import Rot, Vec, add, rotate, spatial
from urdf2mbs_mjcf.model import Quaternion

NO_TURN: Quaternion = (1.0, 0.0, 0.0, 0.0)


class Frame(NamedTuple):
    """A frame in another one."""

    xyz: Vec = (0.0, 0.0, 0.0)
    quat: Quaternion = NO_TURN

    @property
    def rot(self) -> Rot:
        """The rotation matrix."""
        w, x, y, z = self.quat
        return spatial.from_quaternion(x, y, z, w)

    def compose(self, inner: Frame) -> Frame:
        """Return a frame that is given in this one, in the outer frame."""
        return Frame(self.place(inner.xyz), _multiply(self.quat, inner.quat))

    def place(self, point: Vec) -> Vec:
        """Return a point of this frame in the outer frame (m)."""
        if self.quat == NO_TURN:
            return add(self.xyz, point)
        return add(self.xyz, rotate(self.rot, point))

    def inverse(self) -> Frame:
        """Return the outer frame in this one."""
        w, x, y, z = self.quat
        turn = (w, -x, -y, -z)
        return Frame(Frame(quat=turn).place(negate(self.xyz)), turn)


def negate(vector: Vec) -> Vec:
    """Return the opposite vector, without negative zeros."""
    return (0.0 - vector[0], 0.0 - vector[1], 0.0 - vector[2])


def _multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the product of two quaternions."""
    if b == NO_TURN:
        return a
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )
