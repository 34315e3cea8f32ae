"""Functions of the equations that Python calls, in Python: for floats and other kinds of numbers.

With the functions of a module such as CasADi, elements are symbols; with those of numpy, they may
be arrays of states.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from urdf2mbs_simulate.data import MbsSensor
from urdf2mbs_simulate.joint_selection import JointSelection, get_arguments, make_singular_error
from urdf2mbs_simulate.python_code import MbsData

#: Functions of the equations whose last argument is the time.
TIMED_FUNCTIONS = frozenset(["dirdyna", "invdyna"])
#: A pivot is 0 if it is this much smaller than its diagonal element of M.
SINGULAR = 1e-13


class EquationsInPython:
    """The equations of a model in Python, with the methods of ``calls.EquationsInC``."""

    def __init__(self, data: MbsData, selection: JointSelection, math: Any = None) -> None:
        """Take the equations of a model.

        Args:
            data: The model.
            selection: The joints of the caller.
            math: The module of other numbers than floats, see ``load_equations``.
        """
        self.data, self.selection, self.math = data, selection, math
        self.dtype: Any = float if math is None else object
        if math is not None:
            data.math = math
            for name in ("q", "qd", "qdd", "Qq"):
                setattr(data, name, np.full(data.njoint + 1, 0.0, object))

    def evaluate(self, name: str, *state: Any) -> Any:
        """Return the output of a function, see ``EquationsInC.evaluate``.

        With ``math``, many states are the last axis of the arguments and of the output.

        Raises:
            ValueError: An argument does not have a number for each joint.
            TypeError: They are not real numbers, without ``math``.
            LinAlgError: The mass matrix is singular.
        """
        return self._evaluate_states(getattr(self, f"_compute_{name}"), name, state)

    def evaluate_place(self, name: str, place: int, point: int, q: Any) -> Any:
        """Return the ``position`` or the ``jacobian`` of a point, see ``EquationsInC``."""

        def compute(_: Any) -> Any:
            return self._compute_point(place, point)[name == "jacobian"]

        return self._evaluate_states(compute, name, (q,))

    def _evaluate_states(
        self, compute: Callable[[Any], Any], name: str, state: Sequence[Any]
    ) -> Any:
        if self.math is not None:
            for values, argument in zip(state, get_arguments(name), strict=False):
                self.selection.check_length(values, argument)
            output = self._evaluate_state(compute, state)
            if isinstance(output, tuple):
                return tuple(map(self._convert, output))
            return self._convert(output)
        states = self.selection.check_states(name, state)
        if states[0].ndim == 1:
            return self._evaluate_state(compute, states)
        outputs = [self._evaluate_state(compute, row) for row in zip(*states, strict=True)]
        if isinstance(outputs[0], tuple):
            return tuple(map(np.stack, zip(*outputs, strict=True)))
        return np.stack(outputs)

    def _evaluate_state(self, compute: Callable[[Any], Any], state: Sequence[Any]) -> Any:
        """Set the state of the data, and return what is computed with it and the last argument."""
        q, qd, last = (*state, None, None)[:3]
        self.selection.spread(q, self.data.q, self.selection.q0)
        self.selection.spread(qd, self.data.qd)
        self.selection.spread(last, self.data.qdd)  # forward dynamics does not read it
        return compute(last)

    def _fill(self, name: str, *shapes: tuple[int, ...]) -> list[Any]:
        """Return the arrays that a function of the equations fills.

        Args:
            name: Of the function, without ``mbs_``.
            *shapes: Of the arrays, with the index 0 that is not used.
        """
        arrays = [np.full(shape, 0.0, self.dtype) for shape in shapes]
        time = (0.0,) if name in TIMED_FUNCTIONS else ()
        getattr(self.data, f"mbs_{name}")(*arrays, self.data, *time)
        return arrays

    def _compute_mass_matrix(self, _: Any) -> Any:
        return self._compute_mass_and_bias()[0]

    def _compute_mass_and_bias(self) -> tuple[Any, Any]:
        n = self.data.njoint + 1
        mass, bias = self._fill("dirdyna", (n, n), (n,))
        return self.selection.reduce(mass, (0, 1)), self.selection.reduce(bias, (0,))

    def _compute_bias(self, _: Any) -> Any:
        return self._compute_inverse_dynamics(None)

    def _compute_inverse_dynamics(self, _: Any) -> Any:
        (force,) = self._fill("invdyna", (self.data.njoint + 1,))
        return self.selection.reduce(force, (0,))

    def _compute_inverse_derivatives(self, _: Any) -> tuple[Any, ...]:
        n = self.data.njoint + 1
        tables = self._fill("derivatives", *[(n, n)] * 3)
        return tuple(self.selection.reduce(table, (0, 1)) for table in tables)

    def _compute_forward_dynamics(self, tau: Any) -> Any:
        mass, bias = self._compute_mass_and_bias()
        force = np.full((self.selection.n_joints, 1), 0.0, self.dtype)
        for k in self.selection.independent:
            force[k, 0] = tau[k] - bias[k]
        return self._solve(mass, force)[:, 0]

    def _compute_forward_derivatives(self, tau: Any) -> tuple[Any, ...]:
        """Return the derivatives of qdd: see the equations in ``calls.c``."""
        qdd = self._compute_forward_dynamics(tau)
        self.selection.spread(qdd, self.data.qdd)
        by_q, by_qd, mass = self._compute_inverse_derivatives(None)
        n = self.selection.n_joints
        unit = np.full((n, n), 0.0, self.dtype)
        np.fill_diagonal(unit, 1.0)
        solution = self._solve(mass, np.hstack([-by_q, -by_qd, unit]))
        return tuple(np.hsplit(solution, 3))

    def _solve(self, mass: Any, columns: Any) -> Any:
        """Return A^-1 X in the rows of the independent joints, and zeros in the others.

        A, the mass matrix of the independent joints, is factorized as L^T D L, which keeps the
        zeros between branches of a tree (Featherstone, Rigid Body Dynamics Algorithms, 2008, 6.5).

        Args:
            mass: (n, n).
            columns: X, (n, any).

        Raises:
            LinAlgError: A is singular.
        """
        independent = self.selection.independent.tolist()
        rows = {k: [mass[k, i] for i in independent if i <= k] for k in independent}
        x = {k: list(columns[k]) for k in independent}
        for k in reversed(independent):
            pivot = rows[k][-1]
            if self.math is None and not pivot > SINGULAR * mass[k, k]:
                raise make_singular_error(self.selection.names[k])
            for n, i in reversed([*enumerate(independent[: len(rows[k]) - 1])]):
                if _is_zero(rows[k][n]):
                    continue
                factor = rows[k][n] / pivot
                _subtract_multiple(rows[i], factor, rows[k])
                _subtract_multiple(x[i], factor, x[k])  # X = L^-T X
                rows[k][n] = factor
        solution = np.full(columns.shape, 0.0, self.dtype)
        for k in independent:  # X = L^-1 D^-1 X
            *factors, pivot = rows[k]
            x[k] = [element if _is_zero(element) else element / pivot for element in x[k]]
            for i, factor in zip(independent, factors, strict=False):
                _subtract_multiple(x[k], factor, x[i])
            for column, element in enumerate(x[k]):
                solution[k, column] = element
        return solution

    def _compute_regressor(self, _: Any) -> Any:
        shape = (self.data.njoint + 1, 10 * len(self.data.body_id) + 1)
        return self.selection.reduce(self._fill("regressor", shape)[0], (0,))

    def _compute_energy(self, _: Any) -> Any:
        return self._fill("energy", (3,))[0][1:]

    def _compute_centre_of_mass(self, _: Any) -> Any:
        return self._fill("com", (4,))[0][1:]

    def _compute_momentum(self, _: Any) -> Any:
        linear, angular = self._fill("momentum", (4,), (4,))
        return np.concatenate([linear[1:], angular[1:]])

    def _compute_point(self, place: int, point: int) -> tuple[Any, Any]:
        """Compute position and Jacobian of a point.

        The point at ``lever`` from the origin P of its body moves with v = v_P + omega x lever.
        """
        jacobian = np.full((7, self.data.njoint + 1), 0.0, self.dtype)
        origin, axes = self._compute_frame(place, jacobian)
        lever = axes.T @ self.data.dpt[1:, point]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            turn = jacobian[4 + i] * lever[j : j + 1] - jacobian[4 + j] * lever[i : i + 1]
            jacobian[1 + k] += turn
        return origin + lever, self.selection.reduce(jacobian, (1,))

    def _compute_frame(self, place: int, jacobian: Any) -> tuple[Any, Any]:
        """Compute the frame after a joint: its origin, and its axes as rows; fill its Jacobian."""
        if not place:  # the base
            return np.zeros(3), np.eye(3)
        sensor = MbsSensor(self.data)
        for name in ("P", "R", "V", "OM", "A", "OMP"):
            setattr(sensor, name, getattr(sensor, name).astype(self.dtype))
        sensor.J = jacobian
        sensor.comp_gen_sensor(place)
        return sensor.P[1:], sensor.R[1:, 1:]

    def _convert(self, array: Any) -> Any:
        """Convert an array to one of ``math``: with numpy and JAX, the states are last."""
        if hasattr(self.math, "vertcat"):  # CasADi
            rows = array if array.ndim == 1 else [self.math.horzcat(*row) for row in array]
            return self.math.vertcat(*rows)
        if not hasattr(self.math, "broadcast_to"):
            return array
        states = np.broadcast_shapes(*map(np.shape, self.data.q))
        elements = [self.math.broadcast_to(element, states) for element in array.ravel()]
        return self.math.stack(elements).reshape(*array.shape, *states) * 1.0


def _is_zero(element: Any) -> bool:
    """Return True for an element that no function of the equations fills, such as 0.0."""
    return isinstance(element, float) and element == 0.0


def _subtract_multiple(row: list[Any], factor: Any, pivot_row: list[Any]) -> None:
    """Set row = row - factor * pivot_row, as far as the row reaches."""
    if _is_zero(factor):
        return
    for k, element in enumerate(pivot_row[: len(row)]):
        if not _is_zero(element):
            row[k] = row[k] - factor * element
