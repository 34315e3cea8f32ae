"""The joints that a caller gives numbers for, among all joints of a model.

With u of the caller's joints, and q of all joints::

    q = T u + q0           q' = T u'            q'' = T u''         T and q0 are constant

A caller's joint is itself in q; followers are multiples of others; joints that are left out stay at
q0.  Forces do the same work along u as along q, so that what belongs to u is reduced::

    f = T^T f_q            M = T^T M_q T        J = J_q T

Results of Python are arrays of any numbers, such as symbols: they are reduced element by element,
without products with the zeros of T.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_simulate.couplings import find_followers
from urdf2mbs_simulate.python_code import MbsData

#: The arguments of functions that differ from others.
ARGUMENTS = dict.fromkeys(("forward_dynamics", "forward_derivatives"), ("q", "qd", "tau"))


def get_arguments(name: str) -> tuple[str, str, str]:
    """Return the arguments of a function of the equations, for messages."""
    return ARGUMENTS.get(name, ("q", "qd", "qdd"))


def make_singular_error(joint: str) -> np.linalg.LinAlgError:
    """Return an error for a mass matrix with a pivot 0 at a joint."""
    return np.linalg.LinAlgError(
        f"the mass matrix is singular: no mass resists the force of joint '{joint}' here; give "
        "mass and inertia to the links that it moves, or let estimate-inertia do so"
    )


class JointSelection:
    """The joints of a caller: all of a model, but for followers and those that are left out."""

    def __init__(self, data: MbsData, *, moving: bool) -> None:
        """Select the joints of a model.

        Args:
            data: The model.
            moving: True to leave out the joints that never move.

        Raises:
            ConversionError: A user function with constraints fails.
        """
        joints = data._run.mbs.joints()
        self.followers: list[Follower] = find_followers(data)
        following = {follower.joint for follower in self.followers}
        fixed = {number for number, joint in enumerate(joints.values(), 1) if is_fixed(joint)}
        left_out = following | fixed if moving else following
        self.numbers = np.array([k for k in range(1, data.njoint + 1) if k not in left_out], int)
        """(n): the numbers of the caller's joints in the model."""
        self.n_joints = len(self.numbers)
        self.names = [name for k, name in enumerate(joints, 1) if k not in left_out]
        leaders = [k for k in range(1, data.njoint + 1) if k not in following]
        self.moving = np.flatnonzero(~np.isin(leaders, [*fixed]))
        """The indices of the joints that may move, among all that do not follow."""
        self.independent = np.flatnonzero(np.isin(self.numbers, data.qu[1:]))
        """The indices of the caller's joints that are neither driven nor dependent."""
        self.q0 = np.where(np.isin(np.arange(data.njoint + 1), [*left_out]), data.q0, 0.0)
        """(all joints + 1): the positions for u = 0 (rad, m)."""
        for follower in self.followers:
            self.q0[follower.joint] = follower.offset

    def check_states(self, name: str, state: Sequence[Any]) -> list[Any]:
        """Return the arguments of a function as arrays: all (joints), or all (states, joints).

        Args:
            name: The function.
            state: Its arguments; one state among many is that of all of them.

        Raises:
            ValueError: An argument does not have a number for each joint.
            TypeError: It is not of real numbers.
        """
        arrays = []
        for values, argument in zip(state, get_arguments(name), strict=False):
            array = np.asarray(values)
            if array.ndim not in (1, 2) or array.shape[-1] != self.n_joints:
                raise ValueError(self._describe_shape(argument, array.shape))
            if array.dtype.kind not in "fiu":
                message = f"{argument} must be real numbers, and is of type {array.dtype}"
                raise TypeError(message)
            arrays.append(array.astype(float))
        n_states = {len(array) for array in arrays if array.ndim == 2}
        if len(n_states) > 1:
            counts = " and ".join(map(str, sorted(n_states)))
            raise ValueError(f"{name} got {counts} states; expected as many of each argument")
        return [np.ascontiguousarray(array) for array in np.broadcast_arrays(*arrays)]

    def check_length(self, values: Any, argument: str) -> None:
        """Check that an argument has a number, of any kind, for each joint.

        Raises:
            ValueError: It does not.
        """
        shape = values.shape if hasattr(values, "shape") else (len(values),)
        if shape[0:1] != (self.n_joints,):
            raise ValueError(self._describe_shape(argument, shape))

    def _describe_shape(self, argument: str, shape: tuple[int, ...]) -> str:
        return f"{argument} has the shape {shape}, and the model has {self.n_joints} joints"

    def spread(self, values: Any, x: Any, x0: Any = None) -> None:
        """Set x = T u + x0, in an array (all joints + 1) of any numbers.

        Args:
            values: u, a number for each joint of the caller; None: zeros.
            x: The array, which is changed.
            x0: For u = 0; by default, zeros.
        """
        x[:] = 0.0 if x0 is None else x0
        for k, number in enumerate(self.numbers):
            x[number] = 0.0 if values is None else values[k]
        for follower in self.followers:
            for leader, factor in follower.factors.items():
                x[follower.joint] = x[follower.joint] + factor * x[leader]

    def reduce(self, array: Any, joint_axes: Collection[int]) -> Any:
        """Return an array for the caller's joints.

        Args:
            array: With the index 0, which is not used, in all axes; it is changed.
            joint_axes: The axes that have an element for each joint of the model.
        """
        for axis in joint_axes:
            rows = np.moveaxis(array, axis, 0)
            for follower in self.followers:
                for leader, factor in follower.factors.items():
                    rows[leader] = rows[leader] + factor * rows[follower.joint]
        return array[
            np.ix_(
                *(
                    self.numbers if axis in joint_axes else np.arange(1, length)
                    for axis, length in enumerate(array.shape)
                )
            )
        ]
