"""Equations that people call: ``load_equations("atlas.mbs").mass_matrix(q)``."""

from __future__ import annotations

import ctypes
import os
from typing import Any

import numpy as np

from urdf2mbs.plugin import BASE, Config, ConfigError
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.compiler import Source, compile_library, compiler, folders_of
from urdf2mbs_simulate.data import MbsSensor
from urdf2mbs_simulate.equations import SimulationError, equations
from urdf2mbs_simulate.memory import Memory, SensorInC, table, vector
from urdf2mbs_simulate.model_code import Code
from urdf2mbs_simulate.partition import part
from urdf2mbs_simulate.project import project_of
from urdf2mbs_simulate.python_code import USER, MbsData, PythonEquations, default, loaded

#: Functions that are also given the time.
TIMED = frozenset(["dirdyna", "invdyna"])
#: The shape of what has one number for each joint.
JOINTS = (None,)
#: Stands for a zero in each joint.
ZERO = object()


def load_equations(
    source: Config | str | os.PathLike[str],
    *,
    language: str | None = None,
    math: Any = None,
    moving: bool = False,
    **fields: Any,
) -> Robot:
    """The equations of motion of an .mbs, a project's folder, a robot or a config.

    ``language``: ``c`` or ``python``; by itself C where there is a compiler.  ``math``: a module
    with ``sin``, ``cos`` and ``sqrt`` for other numbers than floats: ``numpy`` for many states at
    once (q is then (joints, states)), ``casadi``, ``jax.numpy``; the equations are then Python.
    ``moving``: leave out the joints that never move, which stay where they are drawn.  ``fields``
    are as in ``simulate``.  Raises ConversionError.
    """
    if language not in (None, "c", "python"):
        raise ConfigError("usage", f"there is no language '{language}'", hint="c, or python")
    if language == "c" and math is not None:
        raise ConfigError("usage", "C has floats only: leave language or math out")
    model, keep = project_of(source, fields)
    if language is None:
        language = "python" if math is not None or compiler() is None else "c"
    return Robot(MbsData(model), language, math, keep, moving=moving)


class Robot:
    """A model's equations of motion: M qdd + c = tau.

    Positions q, velocities qd, accelerations qdd and forces tau have one number for each joint, in
    the order of ``joints`` (rad or m, their rates, N m or N).  Vectors are in the axes of the base.
    ``mass_matrix``, ``bias`` and ``inverse_dynamics`` are those of the tree: all joints move as
    they are told, and cuts are open.  Only ``forward_dynamics`` closes loops.  Of the project's
    user functions only those for constraints are called.  A wrong number of values is a ValueError.

    With ``math``, results are its own arrays; with numpy and JAX, the states come last.
    """

    def __init__(
        self,
        data: MbsData,
        language: str,
        math: Any = None,
        keep: Any = None,
        *,
        moving: bool = False,
    ) -> None:
        self.data, self.language, self.math, self.keep = data, language, math, keep
        self.kind: Any = float if math is None else object
        if math is not None:
            data.math = math
            for name in ("q", "qd", "qdd", "Qq"):
                setattr(data, name, np.full(data.njoint + 1, 0.0, object))
        joints = data._run.mbs.joints()
        self.moving = np.flatnonzero([not is_fixed(joint) for joint in joints.values()])
        """The indices of the joints that ever move, among all of the model."""
        self.taken = self.moving if moving else np.arange(data.njoint)
        """The indices of those that q, qd, qdd and tau have numbers for."""
        self.left = np.setdiff1d(np.arange(data.njoint), self.taken)
        self.joints = [name for k, name in enumerate(joints) if k in self.taken]
        self.bodies = list(data.body_id)
        for name in USER:
            if not name.startswith("user_cons_"):
                setattr(data, name, default(data, name))
        data.user_JointForces = _keep_forces
        self.memory = Memory(data) if language == "c" else None
        self.functions: dict[str, Any] = {}
        self.code: Code | None = None

    def __repr__(self) -> str:
        moving = f"{len(self.joints)} joints, of which {len(self.moving)} move"
        return f"<Robot {self.data.mbs_name}: {moving}; {len(self.bodies)} bodies>"

    def mass_matrix(self, q: Any) -> Any:
        """M, joints by joints."""
        self._set(q=q, qd=ZERO)
        return self._fill("dirdyna", JOINTS * 2, JOINTS)[0]

    def bias(self, q: Any, qd: Any) -> Any:
        """c: the forces that hold the joints at constant velocities, against gravity."""
        self._set(q=q, qd=qd)
        return self._fill("dirdyna", JOINTS * 2, JOINTS)[1]

    def inverse_dynamics(self, q: Any, qd: Any, qdd: Any) -> Any:
        """The forces of the joints."""
        self._set(q=q, qd=qd, qdd=qdd)
        return self._fill("invdyna", JOINTS)[0]

    def forward_dynamics(self, q: Any, qd: Any, tau: Any) -> Any:
        """The accelerations of the joints.

        Positions and velocities of dependent joints are computed, by Newton's method from the
        ``q`` that is given; their ``qd`` and ``tau`` count for nothing where cuts rule them.
        Driven joints have no acceleration, and their ``tau`` counts for nothing.

        Raises LinAlgError where loops cannot be closed.
        """
        if self.math is not None and self.data.nqv:
            raise TypeError("loops are closed for floats only: leave math out")
        if self.code is None:
            self.code = self._load_code()
            self._set(q=q)
            if len(self.code.kept) != self.data.nqv:
                with loaded(self.data):
                    part(self.code)
        self._set(q=q, qd=qd, Qq=tau, qdd=ZERO)
        with loaded(self.data):
            failed = self.code.solve()
        if failed:
            raise np.linalg.LinAlgError("the loops cannot be closed from these positions")
        return self._result(self.data.qdd[1:][self.taken])

    def inverse_dynamics_derivatives(self, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any, Any]:
        """The derivatives of ``inverse_dynamics`` by q, qd and qdd: a row for each force."""
        self._set(q=q, qd=qd, qdd=qdd)
        by_q, by_qd, by_qdd = self._fill("derivatives", *[JOINTS * 2] * 3)
        return by_q, by_qd, by_qdd

    def regressor(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Y of Y p = tau, for the p of ``parameters``."""
        self._set(q=q, qd=qd, qdd=qdd)
        return self._fill("regressor", (*JOINTS, 10 * len(self.bodies) + 1))[0]

    def parameters(self) -> Any:
        """Ten numbers for each body, in the order of ``bodies``: mass (kg), first moments x, y, z
        (kg m), inertia xx, xy, xz, yy, yz, zz about the body's origin (kg m^2)."""
        data, numbers = self.data, [self.data.body_id[body] for body in self.bodies]
        mass, centre = data.m[numbers], data.l[1:, numbers].T
        outer = centre[:, :, None] * centre[:, None, :]
        about = np.trace(outer, axis1=1, axis2=2)[:, None, None] * np.eye(3) - outer
        inertia = data.In[1:, numbers].T + (mass[:, None, None] * about).reshape(-1, 9)
        first = mass[:, None] * centre
        return np.column_stack([mass, first, inertia[:, [0, 1, 2, 4, 5, 8]]]).ravel()

    def forward_dynamics_derivatives(self, q: Any, qd: Any, tau: Any) -> tuple[Any, Any, Any]:
        """The derivatives of ``forward_dynamics`` by q, qd and tau: a row for each acceleration.

        Rows of driven joints are zero.  Raises ValueError for models with dependent joints.
        """
        if self.data.nqv:
            raise ValueError("the model has dependent joints: derivatives are those of a tree")
        if self.math is not None:
            raise TypeError("forward dynamics is differentiated for floats only: leave math out")
        qdd = self.forward_dynamics(q, qd, tau)
        by_q, by_qd, _ = self.inverse_dynamics_derivatives(q, qd, qdd)
        mass = self.mass_matrix(q)
        free = np.flatnonzero(np.isin(self.taken + 1, self.data.qu[1:]))
        inverse = np.zeros_like(mass)
        inverse[np.ix_(free, free)] = np.linalg.inv(mass[np.ix_(free, free)])
        return -inverse @ by_q, -inverse @ by_qd, inverse

    def position(self, place: str | tuple[str, str], q: Any) -> Any:
        """Where the origin of a body, or a point is (m).

        ``place`` is the name of a body or of a point; (body, point) where names are not unique.
        """
        self._set(q=q, qd=ZERO, qdd=ZERO)
        return self._point(place)[0]

    def jacobian(self, place: str | tuple[str, str], q: Any) -> Any:
        """The velocity of a body's origin or a point, and the spin of the body, by qd: (6, joints).

        Rows 0 to 2 are linear, 3 to 5 angular.
        """
        self._set(q=q, qd=ZERO, qdd=ZERO)
        return self._point(place)[1]

    def energy(self, q: Any, qd: Any) -> Any:
        """Kinetic energy, and that of gravity, which is 0 at the base's origin: two numbers (J)."""
        self._set(q=q, qd=qd)
        return self._fill("energy", (3,))[0]

    def centre_of_mass(self, q: Any) -> Any:
        """The centre of mass (m)."""
        self._set(q=q)
        return self._fill("com", (4,))[0]

    def momentum(self, q: Any, qd: Any) -> Any:
        """Linear momentum (kg m/s), and angular momentum about the centre of mass (kg m^2/s): six
        numbers."""
        self._set(q=q, qd=qd)
        linear, angular = self._fill("momentum", (4,), (4,))
        if hasattr(self.math, "vertcat"):
            return self.math.vertcat(linear, angular)
        return (self.math or np).concatenate([linear, angular])

    # --- calls ---

    def _set(self, **state: Any) -> None:
        """Put values into the data: ZERO, or a number for each joint."""
        count = len(self.joints)
        for name, values in state.items():
            array = getattr(self.data, name)
            if values is ZERO:
                array[1:] = 0.0
                continue
            given = np.asarray(values) if self.math is None else values
            shape = given.shape if hasattr(given, "shape") else (len(given),)
            if shape[0:1] != (count,) or (self.math is None and len(shape) > 1):
                what = "tau" if name == "Qq" else name
                raise ValueError(f"{what} has the shape {shape}, and the model has {count} joints")
            array[1:][self.left] = self.data.q0[1:][self.left] if name == "q" else 0.0
            if self.math is not None:  # such as symbols, or a row of states for each joint
                for k, place in enumerate(self.taken):
                    array[place + 1] = given[k]
            elif given.dtype.kind in "fiu":
                array[1:][self.taken] = given
            else:
                raise TypeError(f"{name} must be real numbers, and is of type {given.dtype}")

    def _result(self, array: Any) -> Any:
        """An array of the kind that ``math`` has: with numpy and JAX, the states are last."""
        if hasattr(self.math, "vertcat"):  # CasADi
            rows = array if array.ndim == 1 else [self.math.horzcat(*row) for row in array]
            return self.math.vertcat(*rows)
        if not hasattr(self.math, "broadcast_to"):
            return array
        states = np.broadcast_shapes(*map(np.shape, self.data.q))
        every = [self.math.broadcast_to(one, states) for one in array.ravel()]
        return self.math.stack(every).reshape(*array.shape, *states) * 1.0

    def _fill(self, name: str, *shapes: tuple[int | None, ...]) -> list[Any]:
        """What a function of the equations fills, from index 0; None is one for each joint."""
        arrays = [
            np.full([self.data.njoint + 1 if n is None else n for n in shape], 0.0, self.kind)
            for shape in shapes
        ]
        time = (0.0,) if name in TIMED else ()
        if self.memory is None:
            getattr(self.data, f"mbs_{name}")(*arrays, self.data, *time)
        else:
            given = [vector(array) if array.ndim == 1 else table(array) for array in arrays]
            self._c(name)(*given, self.memory.at, *map(ctypes.c_double, time))
        return [
            self._result(
                array[np.ix_(*[self.taken + 1 if n is None else np.arange(1, n) for n in shape])]
            )
            for array, shape in zip(arrays, shapes, strict=True)
        ]

    def _c(self, name: str) -> Any:
        """A function of the equations in C, compiled when it is first asked for."""
        if name not in self.functions:
            folders = folders_of(self.data.user_path, self.data.symbolic_path)
            files = equations(self.data, [name], "c").values()
            library = compile_library([Source(file, folders) for file in files])
            self.functions[name] = getattr(library, f"mbs_{name}")
        return self.functions[name]

    def _load_code(self) -> Code:
        data = self.data
        python = (data.user_path / "user_cons_hJ.py").is_file()
        if not python and (data.user_path / "user_cons_hJ.c").is_file():
            raise SimulationError(
                "usage", "the constraints of this project's user functions are in C only",
                file=str(data.user_path), hint="write user_cons_hJ.py and user_cons_jdqd.py, too",
            )  # fmt: skip
        with loaded(data):
            return PythonEquations(data) if self.memory is None else CCode(data, user_in_c=False)

    def _point(self, place: str | tuple[str, str]) -> tuple[Any, Any]:
        """Position and Jacobian of a place."""
        body, at = self._find(place)
        jac = np.full((7, self.data.njoint + 1), 0.0, self.kind)
        if body is None:
            return at, self._result(jac[1:, 1:][:, self.taken])
        sensor: Any = MbsSensor(self.data)
        number = self.data.body_id[body]
        if self.memory is None:
            for name in ("P", "R", "V", "OM", "A", "OMP"):
                setattr(sensor, name, getattr(sensor, name).astype(self.kind))
            sensor.J = jac
            sensor.comp_gen_sensor(number)
            origin, axes = sensor.P[1:], sensor.R[1:, 1:]
        else:
            sensor = SensorInC()
            sensor.J = table(jac)
            self._c("gensensor")(ctypes.byref(sensor), self.memory.at, number)
            origin = np.array(sensor.P[1:])
            axes = np.array(sensor.R).reshape(4, 4)[1:, 1:]
        arm = axes.T @ at
        jac = jac[1:, 1:]
        for k in range(3):  # the spin x arm
            i, j = (k + 1) % 3, (k + 2) % 3
            jac[k] += jac[3 + i] * arm[j : j + 1] - jac[3 + j] * arm[i : i + 1]
        return self._result(origin + arm), self._result(jac[:, self.taken])

    def _find(self, place: str | tuple[str, str]) -> tuple[str | None, Any]:
        """The body that a place is on (None: the base), and where it is in its axes (m)."""
        data = self.data
        if place in data.body_id:
            return str(place), np.zeros(3)
        found = [
            (body, number)
            for body, numbers in data.points_id.items()
            for name, number in numbers.items()
            if place in (name, (body, name))
        ]
        if len(found) != 1:
            if found:
                raise ValueError(f"the model has {len(found)} points '{place}': give (body, point)")
            known = ", ".join(self.bodies)
            raise ValueError(f"the model has no body and no point '{place}'; its bodies: {known}")
        body, number = found[0]
        return None if body == BASE else body, data.dpt[1:, number].copy()


def _keep_forces(data: MbsData, tsim: float) -> None:
    """Leave the forces of the joints as they are given, where no user function computes them."""
