"""Equations that people call: ``load_equations("atlas.mbs").mass_matrix(q)``."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from urdf2mbs.plugin import BASE, Config, ConfigError, some
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.calls import EquationsInC
from urdf2mbs_simulate.compiler import compiler
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.joint_selection import JointSelection
from urdf2mbs_simulate.model_code import Code
from urdf2mbs_simulate.partition import choose_partition
from urdf2mbs_simulate.project import resolve_model
from urdf2mbs_simulate.python_calls import EquationsInPython
from urdf2mbs_simulate.python_code import (
    USER_FUNCTIONS,
    MbsData,
    PythonEquations,
    get_default_function,
    user_code,
)


class Place(NamedTuple):
    """A point of a body, by numbers of the model."""

    joint: int
    """The last joint of the body; 0 is the base."""
    point: int
    """0 is the origin of the body."""


def load_equations(
    source: Config | str | os.PathLike[str],
    *,
    language: str | None = None,
    math: Any = None,
    moving: bool = False,
    **fields: Any,
) -> Robot:
    """Load the equations of motion of an .mbs, a project's folder, a robot or a config.

    Args:
        source: As in ``simulate``.
        language: ``c`` or ``python``; by default C where there is a compiler.
        math: A module with ``sin``, ``cos`` and ``sqrt`` for other numbers than floats: ``numpy``
            for many states at once (q is then (joints, states)), ``casadi``, ``jax.numpy``; the
            equations are then Python.  ``sympy`` makes formulas of small robots, in which data are
            symbols, too: a ``SymbolicRobot``.
        moving: True to leave out the joints that never move, which stay where they are drawn.
        **fields: Fields of the config, as in ``convert``.

    Raises:
        ConversionError: The robot cannot be converted, or the equations cannot be made.
    """
    if language not in (None, "c", "python"):
        raise ConfigError("usage", f"there is no language '{language}'", hint="c, or python")
    if language == "c" and math is not None:
        raise ConfigError("usage", "C has floats only: leave language or math out")
    model, temporary_folder, _ = resolve_model(source, fields)
    if getattr(math, "__name__", "") == "sympy":
        from urdf2mbs_simulate.symbolic_robot import SymbolicRobot

        symbolic = SymbolicRobot(MbsData(model), math)
        symbolic.temporary_folder = temporary_folder
        return symbolic
    if language is None:
        language = "python" if math is not None or compiler() is None else "c"
    robot = Robot(MbsData(model), language, math, moving=moving)
    robot.temporary_folder = temporary_folder
    return robot


class Robot:
    """A model's equations of motion: M qdd + c = tau.

    Positions q, velocities qd, accelerations qdd and forces tau have one number for each joint, in
    the order of ``joints`` (rad or m, their rates, N m or N).  With many states they are (states,
    joints), and in the results, the states come first.  Vectors are in the axes of the base.

    Joints that follow others (``<mimic>``) are not among ``joints``: they move with their leaders,
    which feel their masses.  Other loops are closed by ``forward_dynamics`` only; all else is that
    of the tree, in which all other joints are independent, and cuts are open.  Of the project's
    user functions, only those for constraints are called.

    With ``math``, results are arrays of that module; with numpy and JAX, the states come last.
    """

    def __init__(
        self, data: MbsData, language: str, math: Any = None, *, moving: bool = False
    ) -> None:
        """Take the equations of a model, see ``load_equations``."""
        self.data, self.language, self.math = data, language, math
        self.temporary_folder: Any = None
        """A folder that is removed with the robot."""
        self.selection = selection = JointSelection(data, moving=moving)
        self.joints: list[str] = selection.names
        self.moving = selection.moving
        """The indices of the joints that may move, among all that do not follow others."""
        self.followers = self._name_joints(follower.joint for follower in selection.followers)
        """The joints that follow others."""
        self.bodies = list(data.body_id)
        for name in USER_FUNCTIONS:
            if not name.startswith("user_cons_"):
                setattr(data, name, get_default_function(data, name))
        data.user_JointForces = _keep_forces
        self.functions: EquationsInC | EquationsInPython = (
            EquationsInC(data, selection)
            if language == "c"
            else EquationsInPython(data, selection, math)
        )
        self.code: Code | None = None
        """The functions that close loops."""

    def __repr__(self) -> str:
        moving = f"{len(self.joints)} joints, of which {len(self.moving)} move"
        n = len(self.followers)
        following = f", and {n} that follow{'s' * (n == 1)}" if n else ""
        return f"<Robot {self.data.mbs_name}: {moving}{following}; {len(self.bodies)} bodies>"

    def mass_matrix(self, q: Any) -> Any:
        """Compute M: (joints, joints)."""
        return self.functions.evaluate("mass_matrix", q)

    def bias(self, q: Any, qd: Any) -> Any:
        """Compute c: the forces at constant velocities, against gravity."""
        return self.functions.evaluate("bias", q, qd)

    def inverse_dynamics(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Compute the forces tau of the joints."""
        return self.functions.evaluate("inverse_dynamics", q, qd, qdd)

    def forward_dynamics(self, q: Any, qd: Any, tau: Any) -> Any:
        """Compute the accelerations of the joints.

        Positions and velocities of the dependent joints of loops are computed, by Newton's method
        from their ``q``; their ``qd``, and their ``tau`` where cuts rule them, are ignored.  Driven
        joints have no acceleration, and their ``tau`` is ignored.

        Raises:
            LinAlgError: The loops cannot be closed, or no mass resists a force.
            TypeError: The model has loops, and there is ``math``.
        """
        loops = self._describe_loops()
        if loops is None:
            return self.functions.evaluate("forward_dynamics", q, qd, tau)
        if self.math is not None:
            raise TypeError(f"{loops}, and loops are closed for floats only: leave math out")
        states = self.selection.check_states("forward_dynamics", (q, qd, tau))
        if states[0].ndim == 1:
            return self._accelerate_with_loops(*states)
        return np.stack([self._accelerate_with_loops(*row) for row in zip(*states, strict=True)])

    def inverse_dynamics_derivatives(self, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any, Any]:
        """Compute the derivatives of ``inverse_dynamics`` by q, qd and qdd.

        Returns:
            Three arrays (joints, joints): a row for each force.
        """
        dtau_dq, dtau_dqd, dtau_dqdd = self.functions.evaluate("inverse_derivatives", q, qd, qdd)
        return dtau_dq, dtau_dqd, dtau_dqdd

    def forward_dynamics_derivatives(self, q: Any, qd: Any, tau: Any) -> tuple[Any, Any, Any]:
        """Compute the derivatives of ``forward_dynamics`` by q, qd and tau.

        Returns:
            Three arrays (joints, joints): a row for each acceleration; those of driven joints are
            zero.

        Raises:
            ValueError: The model has loops.
            LinAlgError: No mass resists a force.
        """
        loops = self._describe_loops()
        if loops is not None:
            raise ValueError(
                f"{loops}, and derivatives of accelerations are those of a tree: take differences "
                "of forward_dynamics, or inverse_dynamics_derivatives, with the loop open"
            )
        by_q, by_qd, by_tau = self.functions.evaluate("forward_derivatives", q, qd, tau)
        return by_q, by_qd, by_tau

    def regressor(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Compute Y of Y p = tau, for the p of ``parameters``."""
        return self.functions.evaluate("regressor", q, qd, qdd)

    def parameters(self) -> Any:
        """Return the inertial parameters p of ``regressor``.

        Returns:
            Ten numbers for each body, in the order of ``bodies``: mass (kg), first moments x, y, z
            (kg m), inertia xx, xy, xz, yy, yz, zz about the body's origin (kg m^2).
        """
        data, numbers = self.data, [self.data.body_id[body] for body in self.bodies]
        mass, centre = data.m[numbers], data.l[1:, numbers].T
        # I about the origin = I about the centre of mass + m (r'r 1 - r r')
        outer = centre[:, :, None] * centre[:, None, :]
        steiner = np.trace(outer, axis1=1, axis2=2)[:, None, None] * np.eye(3) - outer
        inertia = data.In[1:, numbers].T + (mass[:, None, None] * steiner).reshape(-1, 9)
        first_moments = mass[:, None] * centre
        return np.column_stack([mass, first_moments, inertia[:, [0, 1, 2, 4, 5, 8]]]).ravel()

    def position(self, place: str | tuple[str, str], q: Any) -> Any:
        """Compute the position (m) of the origin of a body, or of a point.

        Args:
            place: The name of a body or of a point; (body, point) where names are not unique.
            q: The positions of the joints.
        """
        return self.functions.evaluate_place("position", *self._find_place(place), q)

    def jacobian(self, place: str | tuple[str, str], q: Any) -> Any:
        """Compute the Jacobian of a body's origin, or of a point.

        Args:
            place: As in ``position``.
            q: The positions of the joints.

        Returns:
            (6, joints): rows 0 to 2 are linear, 3 to 5 angular.
        """
        return self.functions.evaluate_place("jacobian", *self._find_place(place), q)

    def energy(self, q: Any, qd: Any) -> Any:
        """Compute the kinetic energy, and that of gravity, which is 0 at the base's origin (J)."""
        return self.functions.evaluate("energy", q, qd)

    def centre_of_mass(self, q: Any) -> Any:
        """Compute the centre of mass (m)."""
        return self.functions.evaluate("centre_of_mass", q)

    def momentum(self, q: Any, qd: Any) -> Any:
        """Compute linear momentum (kg m/s), and angular momentum about the centre of mass.

        Returns:
            Six numbers, the last three in kg m^2/s.
        """
        return self.functions.evaluate("momentum", q, qd)

    def _find_place(self, place: str | tuple[str, str]) -> Place:
        """Find a body or a point.

        Raises:
            ValueError: The model has no such place, or several.
        """
        data = self.data
        if place in data.body_id:
            return Place(data.body_id[place], 0)
        matches = [
            (body, number)
            for body, numbers in data.points_id.items()
            for name, number in numbers.items()
            if place in (name, (body, name))
        ]
        if len(matches) > 1:
            raise ValueError(f"the model has {len(matches)} points '{place}': give (body, point)")
        if not matches:
            bodies = ", ".join(self.bodies)
            raise ValueError(f"the model has no body and no point '{place}'; its bodies: {bodies}")
        body, point = matches[0]
        return Place(0 if body == BASE else data.body_id[body], point)

    # --- loops ---

    def _name_joints(self, numbers: Iterable[int]) -> list[str]:
        names = list(self.data.joint_id)
        return [names[number - 1] for number in numbers]

    def _describe_loops(self) -> str | None:
        """Return which joints and cuts close loops, for a message; None of a tree."""
        data = self.data
        cuts = data._run.mbs.cuts
        if not cuts and data.nqv == len(self.followers):
            return None
        dependent = set(self._name_joints(data.qv[1:])) - set(self.followers)
        names = some(f"'{name}'" for name in data.joint_id if name in dependent)
        joints = f"{'joint' if len(dependent) == 1 else 'joints'} {names}"
        if not cuts:
            verb = "depends" if len(dependent) == 1 else "depend"
            return f"{joints} {verb} on others by a constraint that is not linear"
        loops = some(f"{cut.kind} '{cut.name}'" for cut in cuts)
        closes = "closes a loop" if len(cuts) == 1 else "close loops"
        return f"{loops} {closes}" + (f" with {joints}" if dependent else "")

    def _accelerate_with_loops(self, q: Any, qd: Any, tau: Any) -> Any:
        """Return the accelerations of a model with loops, in one state."""
        data, selection = self.data, self.selection
        if self.code is None:
            self.code = self._load_code()
            selection.spread(q, data.q, selection.q0)
            if len(self.code.used_rows) != data.nqv:
                with user_code(data):
                    choose_partition(self.code)
        selection.spread(q, data.q, selection.q0)
        selection.spread(qd, data.qd)
        data.qdd[:] = 0.0
        data.Qq[:] = 0.0
        data.Qq[selection.numbers] = tau
        with user_code(data):
            failed = self.code.compute_accelerations()
        if failed:
            raise np.linalg.LinAlgError("the loops cannot be closed from these positions")
        return data.qdd[selection.numbers]

    def _load_code(self) -> Code:
        """Load the functions that close loops.

        Raises:
            SimulationError: User constraints are in C only.
        """
        data = self.data
        has_python = (data.user_path / "user_cons_hJ.py").is_file()
        if not has_python and (data.user_path / "user_cons_hJ.c").is_file():
            raise SimulationError(
                "usage",
                "the constraints of this project's user functions are in C only",
                file=str(data.user_path),
                hint="write user_cons_hJ.py and user_cons_jdqd.py, too",
            )
        with user_code(data):
            if self.language == "python":
                return PythonEquations(data)
            return CCode(data, user_in_c=False)


def _keep_forces(data: MbsData, tsim: float) -> None:
    """Replace user_JointForces: the forces of the joints stay as they are given."""
