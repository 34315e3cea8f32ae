"""Equations that people call: ``load_equations("atlas.mbs").mass_matrix(q)``."""

from __future__ import annotations

import ctypes
import os
from typing import Any

import numpy as np

from urdf2mbs.plugin import BASE, Config, ConfigError
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.compiler import Source, compile_library, compiler, list_header_folders
from urdf2mbs_simulate.data import MbsSensor
from urdf2mbs_simulate.equations import SimulationError, find_equations
from urdf2mbs_simulate.memory import SensorInC, SharedData, as_c_table, as_c_vector
from urdf2mbs_simulate.model_code import Code
from urdf2mbs_simulate.partition import choose_partition
from urdf2mbs_simulate.project import resolve_model
from urdf2mbs_simulate.python_code import (
    USER_FUNCTIONS,
    MbsData,
    PythonEquations,
    get_default_function,
    user_code,
)

#: Functions of the equations whose last argument is the time.
TIMED_FUNCTIONS = frozenset(["dirdyna", "invdyna"])
#: The shape of an array with a number for each joint.
JOINTS = (None,)
#: The state of all joints whose numbers are 0.
ZEROS = object()


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
    model, temporary_folder = resolve_model(source, fields)
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
    the order of ``joints`` (rad or m, their rates, N m or N).  Vectors are in the axes of the base.
    ``mass_matrix``, ``bias`` and ``inverse_dynamics`` are those of the tree: all joints are
    independent, and cuts are open.  Only ``forward_dynamics`` closes loops.  Of the project's user
    functions, only those for constraints are called.  A wrong number of values is a ValueError.

    With ``math``, results are arrays of that module; with numpy and JAX, the states come last.
    """

    def __init__(
        self, data: MbsData, language: str, math: Any = None, *, moving: bool = False
    ) -> None:
        """Take the equations of a model, see ``load_equations``."""
        self.data, self.language, self.math = data, language, math
        self.temporary_folder: Any = None
        """A folder that is removed with the robot."""
        self.dtype: Any = float if math is None else object
        if math is not None:
            data.math = math
            for name in ("q", "qd", "qdd", "Qq"):
                setattr(data, name, np.full(data.njoint + 1, 0.0, object))
        joints = data._run.mbs.joints()
        self.moving = np.flatnonzero([not is_fixed(joint) for joint in joints.values()])
        """The indices of the joints that may move, among all of the model."""
        self.selected = self.moving if moving else np.arange(data.njoint)
        """The indices of the joints of q, qd, qdd and tau, among all of the model."""
        self.omitted = np.setdiff1d(np.arange(data.njoint), self.selected)
        self.joints = [name for k, name in enumerate(joints) if k in self.selected]
        self.bodies = list(data.body_id)
        for name in USER_FUNCTIONS:
            if not name.startswith("user_cons_"):
                setattr(data, name, get_default_function(data, name))
        data.user_JointForces = _keep_forces
        self.shared_data = SharedData(data) if language == "c" else None
        self.c_functions: dict[str, Any] = {}
        self.code: Code | None = None

    def __repr__(self) -> str:
        moving = f"{len(self.joints)} joints, of which {len(self.moving)} move"
        return f"<Robot {self.data.mbs_name}: {moving}; {len(self.bodies)} bodies>"

    def mass_matrix(self, q: Any) -> Any:
        """Compute M: (joints, joints)."""
        self._set(q=q, qd=ZEROS)
        return self._evaluate("dirdyna", JOINTS * 2, JOINTS)[0]

    def bias(self, q: Any, qd: Any) -> Any:
        """Compute c: the forces at constant velocities, against gravity."""
        self._set(q=q, qd=qd)
        return self._evaluate("dirdyna", JOINTS * 2, JOINTS)[1]

    def inverse_dynamics(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Compute the forces tau of the joints."""
        self._set(q=q, qd=qd, qdd=qdd)
        return self._evaluate("invdyna", JOINTS)[0]

    def forward_dynamics(self, q: Any, qd: Any, tau: Any) -> Any:
        """Compute the accelerations of the joints.

        Positions and velocities of dependent joints are computed, by Newton's method from their
        ``q``; their ``qd``, and their ``tau`` where cuts rule them, are ignored.  Driven joints
        have no acceleration, and their ``tau`` is ignored.

        Raises:
            LinAlgError: The loops cannot be closed.
        """
        if self.math is not None and self.data.nqv:
            raise TypeError("loops are closed for floats only: leave math out")
        if self.code is None:
            self.code = self._load_code()
            self._set(q=q)
            if len(self.code.used_rows) != self.data.nqv:
                with user_code(self.data):
                    choose_partition(self.code)
        self._set(q=q, qd=qd, Qq=tau, qdd=ZEROS)
        with user_code(self.data):
            failed = self.code.compute_accelerations()
        if failed:
            raise np.linalg.LinAlgError("the loops cannot be closed from these positions")
        return self._convert(self.data.qdd[1:][self.selected])

    def inverse_dynamics_derivatives(self, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any, Any]:
        """Compute the derivatives of ``inverse_dynamics`` by q, qd and qdd.

        Returns:
            Three arrays (joints, joints): a row for each force.
        """
        self._set(q=q, qd=qd, qdd=qdd)
        dtau_dq, dtau_dqd, dtau_dqdd = self._evaluate("derivatives", *[JOINTS * 2] * 3)
        return dtau_dq, dtau_dqd, dtau_dqdd

    def regressor(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Compute Y of Y p = tau, for the p of ``parameters``."""
        self._set(q=q, qd=qd, qdd=qdd)
        return self._evaluate("regressor", (*JOINTS, 10 * len(self.bodies) + 1))[0]

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

    def forward_dynamics_derivatives(self, q: Any, qd: Any, tau: Any) -> tuple[Any, Any, Any]:
        """Compute the derivatives of ``forward_dynamics`` by q, qd and tau.

        Returns:
            A row for each acceleration; those of driven joints are zero.

        Raises:
            ValueError: The model has dependent joints.
        """
        if self.data.nqv:
            raise ValueError("the model has dependent joints: derivatives are those of a tree")
        if self.math is not None:
            raise TypeError("forward dynamics is differentiated for floats only: leave math out")
        qdd = self.forward_dynamics(q, qd, tau)
        dtau_dq, dtau_dqd, _ = self.inverse_dynamics_derivatives(q, qd, qdd)
        mass = self.mass_matrix(q)
        free = np.flatnonzero(np.isin(self.selected + 1, self.data.qu[1:]))
        inverse = np.zeros_like(mass)
        inverse[np.ix_(free, free)] = np.linalg.inv(mass[np.ix_(free, free)])
        return -inverse @ dtau_dq, -inverse @ dtau_dqd, inverse

    def position(self, place: str | tuple[str, str], q: Any) -> Any:
        """Compute the position (m) of the origin of a body, or of a point.

        Args:
            place: The name of a body or of a point; (body, point) where names are not unique.
            q: The positions of the joints.
        """
        self._set(q=q, qd=ZEROS, qdd=ZEROS)
        return self._compute_point(place)[0]

    def jacobian(self, place: str | tuple[str, str], q: Any) -> Any:
        """Compute the Jacobian of a body's origin, or of a point.

        Args:
            place: As in ``position``.
            q: The positions of the joints.

        Returns:
            (6, joints): rows 0 to 2 are linear, 3 to 5 angular.
        """
        self._set(q=q, qd=ZEROS, qdd=ZEROS)
        return self._compute_point(place)[1]

    def energy(self, q: Any, qd: Any) -> Any:
        """Compute the kinetic energy, and that of gravity, which is 0 at the base's origin (J)."""
        self._set(q=q, qd=qd)
        return self._evaluate("energy", (3,))[0]

    def centre_of_mass(self, q: Any) -> Any:
        """Compute the centre of mass (m)."""
        self._set(q=q)
        return self._evaluate("com", (4,))[0]

    def momentum(self, q: Any, qd: Any) -> Any:
        """Compute linear momentum (kg m/s), and angular momentum about the centre of mass.

        Returns:
            Six numbers, the last three in kg m^2/s.
        """
        self._set(q=q, qd=qd)
        linear, angular = self._evaluate("momentum", (4,), (4,))
        if hasattr(self.math, "vertcat"):
            return self.math.vertcat(linear, angular)
        return (self.math or np).concatenate([linear, angular])

    # --- calls of the equations ---

    def _set(self, **state: Any) -> None:
        """Set members of the data: to ZEROS, or a number for each joint.

        Raises:
            ValueError: There are more or fewer numbers than joints.
            TypeError: They are not real numbers.
        """
        count = len(self.joints)
        for name, values in state.items():
            array = getattr(self.data, name)
            if values is ZEROS:
                array[1:] = 0.0
                continue
            numbers = np.asarray(values) if self.math is None else values
            shape = numbers.shape if hasattr(numbers, "shape") else (len(numbers),)
            if shape[0:1] != (count,) or (self.math is None and len(shape) > 1):
                argument = "tau" if name == "Qq" else name
                message = f"{argument} has the shape {shape}, and the model has {count} joints"
                raise ValueError(message)
            array[1:][self.omitted] = self.data.q0[1:][self.omitted] if name == "q" else 0.0
            if self.math is not None:  # such as symbols, or a row of states for each joint
                for k, joint in enumerate(self.selected):
                    array[joint + 1] = numbers[k]
            elif numbers.dtype.kind in "fiu":
                array[1:][self.selected] = numbers
            else:
                raise TypeError(f"{name} must be real numbers, and is of type {numbers.dtype}")

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

    def _evaluate(self, name: str, *shapes: tuple[int | None, ...]) -> list[Any]:
        """Return the arrays that a function of the equations fills.

        Args:
            name: Of the function, without ``mbs_``.
            *shapes: Of the arrays, with the index 0 that is not used; None: one for each joint.
        """
        arrays = [
            np.full([self.data.njoint + 1 if n is None else n for n in shape], 0.0, self.dtype)
            for shape in shapes
        ]
        time = (0.0,) if name in TIMED_FUNCTIONS else ()
        if self.shared_data is None:
            getattr(self.data, f"mbs_{name}")(*arrays, self.data, *time)
        else:
            outputs = [as_c_vector(x) if x.ndim == 1 else as_c_table(x) for x in arrays]
            function = self._load_c_function(name)
            function(*outputs, self.shared_data.address, *map(ctypes.c_double, time))
        joints = self.selected + 1
        return [
            self._convert(array[np.ix_(*[joints if n is None else np.arange(1, n) for n in shape])])
            for array, shape in zip(arrays, shapes, strict=True)
        ]

    def _load_c_function(self, name: str) -> Any:
        """Return a function of the equations in C, which is compiled when it is first used."""
        if name not in self.c_functions:
            folders = list_header_folders(self.data.user_path, self.data.symbolic_path)
            files = find_equations(self.data, [name], "c").values()
            library = compile_library([Source(file, folders) for file in files])
            self.c_functions[name] = getattr(library, f"mbs_{name}")
        return self.c_functions[name]

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
            if self.shared_data is None:
                return PythonEquations(data)
            return CCode(data, user_in_c=False)

    def _compute_point(self, place: str | tuple[str, str]) -> tuple[Any, Any]:
        """Compute position and Jacobian of a body's origin, or of a point.

        The point at ``lever`` from the origin P of its body moves with v = v_P + omega x lever.
        """
        body, point = self._find_place(place)
        jacobian = np.full((7, self.data.njoint + 1), 0.0, self.dtype)
        if body is None:
            return point, self._convert(jacobian[1:, 1:][:, self.selected])
        origin, axes = self._compute_frame(self.data.body_id[body], jacobian)
        lever = axes.T @ point
        jacobian = jacobian[1:, 1:]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            jacobian[k] += jacobian[3 + i] * lever[j : j + 1] - jacobian[3 + j] * lever[i : i + 1]
        return self._convert(origin + lever), self._convert(jacobian[:, self.selected])

    def _compute_frame(self, joint: int, jacobian: Any) -> tuple[Any, Any]:
        """Compute the frame after a joint: its origin, and its axes as rows; fill its Jacobian."""
        if self.shared_data is not None:
            c_sensor = SensorInC()
            c_sensor.J = as_c_table(jacobian)
            compute = self._load_c_function("gensensor")
            compute(ctypes.byref(c_sensor), self.shared_data.address, joint)
            return np.array(c_sensor.P[1:]), np.array(c_sensor.R).reshape(4, 4)[1:, 1:]
        sensor = MbsSensor(self.data)
        for name in ("P", "R", "V", "OM", "A", "OMP"):
            setattr(sensor, name, getattr(sensor, name).astype(self.dtype))
        sensor.J = jacobian
        sensor.comp_gen_sensor(joint)
        return sensor.P[1:], sensor.R[1:, 1:]

    def _find_place(self, place: str | tuple[str, str]) -> tuple[str | None, Any]:
        """Find a place.

        Returns:
            The body (None: the base), and the point in its frame (m).

        Raises:
            ValueError: The model has no such place, or several.
        """
        data = self.data
        if place in data.body_id:
            return str(place), np.zeros(3)
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
        body, number = matches[0]
        return None if body == BASE else body, data.dpt[1:, number].copy()


def _keep_forces(data: MbsData, tsim: float) -> None:
    """Replace user_JointForces: the forces of the joints stay as they are given."""
