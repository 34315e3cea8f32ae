"""A project's C: equations and user functions in a library, compiled once, called through ctypes.

The library works on the memory of MbsData, and on a Run (``runtime.h``) that belongs to one
simulation and ends with its CCode.  User functions that are in Python are called back.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from urdf2mbs.plugin import ConversionError
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    STATE_MODELS,
    find_state_indices,
)
from urdf2mbs_simulate.c_sources import JOINT_TYPES, list_sources
from urdf2mbs_simulate.compiler import compile_library
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.memory import (
    HOOKS,
    HooksInC,
    PushInC,
    RunInC,
    SharedData,
    as_c_integers,
    as_c_table,
    as_c_vector,
)
from urdf2mbs_simulate.model_code import Code, RowCounts, count_rows
from urdf2mbs_simulate.push import place_pushes
from urdf2mbs_simulate.python_code import get_default_function, has_user_changes, show_modules

TURNED_NOTE = (
    "its base's second angle passes 90 degrees: the steps go on in turned axes, and Robotran "
    "itself stops there"
)
#: Error of a bristle of friction, relative to the largest deflection, at the tolerance ``ATOL``;
#: it is smaller with smaller tolerances.
BRISTLE_ERROR, ATOL = 0.05, 1e-6
#: The step of a numerical derivative by a state, relative to its size if that is above 1.
DIFFERENCE = 1e-7


class CCode(Code):
    """The functions of a simulation, in C but for user functions that are in Python."""

    def __init__(self, data: MbsData, *, user_in_c: bool = True) -> None:
        """Compile the functions, and begin a Run.

        Args:
            data: The model.
            user_in_c: True to use the user functions in C, if there are any.

        Raises:
            ConversionError: A file does not compile, or C cannot use a parameter.
        """
        user_files = sorted(data.user_path.glob("*.c")) if user_in_c else []
        self.has_user_c = bool(user_files)
        super().__init__(data, count_rows(data))
        self.name = "C" if self.has_user_c else "C, user functions in Python"
        self.has_loop = self._has_user_loop()
        self.user_error: BaseException | None = None
        """What a function of Python has raised while C called it."""
        self.sources = list_sources(data, self.row_counts, user_files)
        self.library = library = compile_library(self.sources, data._run.on_compile)
        library.get_run_size.restype = ctypes.c_size_t
        self.run_memory = np.zeros(library.get_run_size() // 8 + 1)
        """It lives as long as anything in it is used."""
        self.run = RunInC.from_buffer(self.run_memory.data)
        self.run_address = ctypes.byref(self.run)
        library.initialize_run(self.run_address)
        self.shared_data = SharedData(data, self.run.data)
        self.user_model = self._read_user_model()
        self.run.data.user_model = as_c_vector(self.user_model)
        self.hooks = HooksInC()
        self._set_arrays()
        self._set_hooks()
        self.run.can_turn = can_turn(data, self.row_counts)
        self.c_accelerate = library.accelerate
        self.c_accelerate.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_void_p,
            ctypes.c_void_p,
        ]
        self.set_partition(self.used_rows)

    def _has_user_loop(self) -> bool:
        """Return True if the user has a loop; the one in C that urdf2mbs writes does nothing."""
        data = self.data
        if not self.has_user_c:
            return data.user_dirdyn_loop is not get_default_function(data, "user_dirdyn_loop")
        file = data.user_path / "user_dirdyn.c"
        return not file.is_file() or has_user_changes(data, "c", file.name)

    def _set_arrays(self) -> None:
        """Allocate the arrays that the Run points at."""
        data, run = self.data, self.run
        n_rows = sum(self.row_counts) + 1
        self.h, self.jacobian = np.zeros(n_rows), np.zeros((n_rows, data.njoint + 1))
        self.inverse_dynamics = np.zeros(data.njoint + 1)
        n_user_rows = self.row_counts.user + 1
        self.user_h, self.user_jdqd = np.zeros((2, n_user_rows))
        self.user_jacobian = np.zeros((n_user_rows, data.njoint + 1))
        run.user_h, run.user_jdqd = as_c_vector(self.user_h), as_c_vector(self.user_jdqd)
        run.user_J = as_c_vector(self.user_jacobian)
        self.state_scale = compute_state_scale(data)
        run.state_scale = as_c_vector(self.state_scale)
        self.last_joint = as_c_integers(list_last_joints(data))
        run.last_joint = self.last_joint
        pushes = [
            PushInC(data.body_id[body], (0.0, *point), (0.0, *push.force), push.start, push.stop)
            for push, body, point in place_pushes(data)
        ]
        self.pushes = (PushInC * (len(pushes) + 1))(*pushes)
        run.pushes = self.pushes

    # --- the axes of the base, see turn.c ---

    @property
    def is_turned(self) -> bool:
        """True if the base is in turned axes."""
        return bool(self.run.is_turned)

    def note_turn(self) -> None:
        """Note once that the base has been turned."""
        notes = self.data._run.notes
        if self.is_turned and TURNED_NOTE not in notes:
            notes.append(TURNED_NOTE)

    def turn_if_near(self, y: Any) -> bool:
        """Change the axes of the base if it is near its singular orientation.

        Args:
            y: The state, which is replaced by that in the other axes.

        Returns:
            True if the axes have changed.
        """
        has_turned = bool(self.library.turn_if_near(self.run_address, as_c_vector(y)))
        self.note_turn()
        return has_turned

    @contextmanager
    def model_axes(self) -> Iterator[None]:
        """Show q, qd, qdd and Qq of the base in the model's own axes."""
        force = self.data.Qq[1:7].copy()
        self.library.show_model_axes(self.run_address)
        self.library.show_joint_forces(self.run_address)
        try:
            yield
        finally:
            if self.is_turned:
                self.library.hide_model_axes(self.run_address)
                self.data.Qq[1:7] = force

    def leave_turned_axes(self) -> None:
        """Leave the data in the model's own axes, at the end of a run."""
        data = self.data
        with self.model_axes():
            rows = [row[1:7].copy() for row in (data.q, data.qd, data.qdd, data.Qq)]
        for row, values in zip((data.q, data.qd, data.qdd, data.Qq), rows, strict=True):
            row[1:7] = values
        self.run.is_turned = 0

    # --- states and their derivatives ---

    def set_partition(self, used_rows: Any) -> None:
        """Take the natures of the joints from the data, see ``Code``."""
        super().set_partition(used_rows)
        if not hasattr(self, "shared_data"):  # the first call, by Code, comes before the library
            return
        data = self.data
        self.shared_data.set_partition(data)
        self.y, self.dy_dt = np.empty((2, 2 * data.nqu + data.Nux))
        self.y_address, self.dy_dt_address = self.y.ctypes.data, self.dy_dt.ctypes.data
        self.run.data.guess = as_c_vector(self.guess)
        if len(used_rows) == data.nqv:
            self.library.set_partition(self.run_address, as_c_integers(used_rows + 1))

    def accelerate(self, t: float, y: Any) -> Any:
        """Return dy/dt of the state y at a time (s); NaN where the loops cannot be closed."""
        self.y[:] = y
        self.data.tsim = t
        failed = self.c_accelerate(self.run_address, t, self.y_address, self.dy_dt_address)
        self.raise_user_error()
        return np.full(len(y), np.nan) if failed else self.dy_dt.copy()

    def differentiate(self, t: float, y: Any, difference: float = DIFFERENCE) -> Any:
        """Return the derivative of ``accelerate`` by the state, by one-sided differences.

        Implicit integrators that use their own scale differences by a rate, which vanishes in a
        robot at rest: they would find rounding errors, and their steps would stay short.

        Args:
            t: The time (s).
            y: The state.
            difference: Of a state below 1; of larger ones, relative to them.

        Returns:
            (states, states): a row for each rate.
        """
        dy_dt, jacobian = self.accelerate(t, y), np.empty((len(y), len(y)))
        for k in range(len(y)):
            moved = y.copy()
            moved[k] += difference * max(1.0, abs(y[k]))
            jacobian[:, k] = (self.accelerate(t, moved) - dy_dt) / (moved[k] - y[k])
        return jacobian

    def compute_accelerations(self) -> bool:
        """Set qdd, and q and qd of dependent joints; return True if it failed."""
        self.run.data.tsim = self.data.tsim
        failed = bool(self.library.compute_accelerations(self.run_address))
        self.raise_user_error()
        return failed

    def compute_constraints(self) -> tuple[Any, Any]:
        """Compute h and J of all constraints, see ``Code``."""
        self.jacobian[:] = 0.0
        self.run.data.tsim = self.data.tsim
        self.library.compute_constraints(
            self.run_address, as_c_vector(self.h), as_c_table(self.jacobian)
        )
        self.raise_user_error()
        return self.h[1:].copy(), self.jacobian[1:].copy()

    def compute_inverse_dynamics(self) -> Any:
        """Return M qdd + c of the present state and accelerations."""
        time = ctypes.c_double(self.data.tsim)
        self.library.mbs_invdyna(as_c_vector(self.inverse_dynamics), self.run_address, time)
        return self.inverse_dynamics.copy()

    # --- user functions ---

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record what user code gives to set_output: the state is that of a frame."""
        self.run.is_recording = self.data._run.is_recording = True
        try:
            yield
        finally:
            self.run.is_recording = self.data._run.is_recording = False

    def call_user_function(self, name: str, dirdyn: Any) -> None:
        """Call user_dirdyn_init, _loop or _finish, with the base in the model's own axes."""
        with self.recording(), self.model_axes():
            if not self.has_user_c:
                with show_modules(self.data):
                    getattr(self.data, name)(self.data, dirdyn)
                return
            self.run.data.tsim = self.data.tsim
            self.library.enter_user_code(self.run_address)
            dirdyn_address = ctypes.byref(self.run, RunInC.dirdyn.offset)
            getattr(self.library, name)(self.run_address, dirdyn_address)
        self.raise_user_error()
        self.data.flag_stop |= self.run.data.flag_stop

    def raise_user_error(self) -> None:
        """Raise what a function of Python has raised, as C cannot pass it on."""
        if self.user_error is not None:
            raise self.user_error

    def list_parameters(self) -> list[tuple[str, str]]:
        """List the numbers in the struct of ``user_model.h``, by model and parameter.

        Raises:
            ConversionError: A parameter is not a number.
        """
        parameters = []
        for model in self.data._run.mbs.user_models if self.has_user_c else ():
            for parameter in model.parameters if model.name not in STATE_MODELS else ():
                is_number = parameter.type == "scalar" or (
                    parameter.type == "state" and len(parameter.values) == 1
                )
                if not is_number:
                    raise ConversionError(
                        "user-model-in-c",
                        f"'{model.name}.{parameter.name}' is a {parameter.type} of "
                        f"{len(parameter.values)} values, and C user functions get numbers only",
                        file=str(self.data._run.file),
                        hint="take user functions in Python",
                    )
                parameters.append((model.name, parameter.name))
        return parameters

    def update_user_model(self) -> None:
        """Copy changed parameters of user models to C."""
        self.user_model[:] = self._read_user_model()

    def _read_user_model(self) -> Any:
        """Return the struct of ``user_model.h``: its numbers one after the other."""
        values = self.data.user_model
        return np.array([*(values[model][name] for model, name in self.list_parameters()), 0.0])

    def _set_hooks(self) -> None:
        """Let C call set_output, and the user functions that are in Python."""
        outputs = self.data._run.new_outputs  # C calls the hook in recorded states only
        self._set_hook("output", lambda value, name: outputs.update({name.decode(): (value,)}))
        if not self.has_user_c:
            self._set_user_hooks()
        self.run.hooks = self.hooks

    def _set_user_hooks(self) -> None:
        data, point = self.data, self.run.point
        p, v, om, a, omp = (
            np.ctypeslib.as_array(getattr(point, name)) for name in ("P", "V", "OM", "A", "OMP")
        )
        r = np.ctypeslib.as_array(point.R).reshape(4, 4)

        def store_wrench(wrenches: Any, function: Callable[..., Any]) -> Callable[..., None]:
            def call(t: float, number: int) -> None:
                wrenches[number] = function(p, r, v, om, a, omp, data, t, number)

            return call

        def compute_link_force(z: float, zd: float, t: float, number: int) -> float:
            return float(data.user_LinkForces(z, zd, data, t, number))

        def compute_cons_hj(t: float) -> None:
            data.user_cons_hJ(self.user_h, self.user_jacobian, data, t)

        if data.user_JointForces is not get_default_function(data, "user_JointForces"):
            self._set_hook("joint_forces", lambda t: data.user_JointForces(data, t))
        self._set_hook("driven_joints", lambda t: data.user_DrivenJoints(data, t))
        self._set_hook("derivative", lambda t: data.user_derivatives(data))
        self._set_hook("ext_forces", store_wrench(data.SWr, data.user_ExtForces))
        self._set_hook("link_3d_forces", store_wrench(data.l3DWr, data.user_Link3DForces))
        self._set_hook("link_force", compute_link_force)
        self._set_hook("cons_hJ", compute_cons_hj)
        self._set_hook("cons_jdqd", lambda t: data.user_cons_jdqd(self.user_jdqd, data))

    def _set_hook(self, name: str, function: Callable[..., Any]) -> None:
        """Let C call a function of Python, whose first exception is kept."""

        def call(*arguments: Any) -> Any:
            self.data.tsim = self.run.data.tsim
            try:
                with show_modules(self.data):
                    return function(*arguments)
            except BaseException as error:
                self.user_error = self.user_error or error
                self.run.data.flag_stop = 1
                return 0.0

        setattr(self.hooks, name, HOOKS[name](call))


def can_turn(data: MbsData, row_counts: RowCounts) -> bool:
    """Return True if the base may change its axes, see ``turn.c``.

    The first six joints are those of a free base, nothing ties a body to the ground, and gravity
    is along z.
    """
    mbs = data._run.mbs
    first = [*mbs.joints().values()][:6]
    types = [joint.type for joint in first if joint.nature == "independent"]
    connections = (*mbs.cuts, *mbs.links)
    is_tied = any(None in (tie.endpoint1[0], tie.endpoint2[0]) for tie in connections)
    is_free = types == [*JOINT_TYPES] and not is_tied and not row_counts.user
    return is_free and not data.g[1:3].any()


def list_last_joints(data: MbsData) -> list[int]:
    """Return the last joint of the body of each external force, from index 1; 0 for the base."""
    last_joints = [0] * (data.Nxfrc + 1)
    for body in data._run.mbs.bodies:
        for point in body.points:
            if point.extforce is not None:
                last_joints[data.extforce_id[point.extforce.name]] = data.body_id[body.name]
    return last_joints


def compute_state_scale(data: MbsData) -> Any:
    """Compute the absolute tolerance of each user state, relative to that of positions.

    The bristles of friction deflect by less than a millimetre, and their errors fade: the force
    that they change is proportional to the error relative to their largest deflection.

    Returns:
        (user states + 1), at least 1.
    """
    mbs, models, scale = data._run.mbs, data.user_model, np.ones(data.Nux + 1)
    law = models.get("contact", {})
    deflection = float(law.get("friction", 0.0)) * float(law.get("bristle", 0.0))
    for number in find_state_indices(mbs, CONTACT_STATES).values():
        scale[number : number + 3] = max(1.0, BRISTLE_ERROR * deflection / ATOL)
    for joint, number in find_state_indices(mbs, JOINT_STATES).items():
        stiffness = float(models.get("friction_stiffness", {}).get(joint, 0.0))
        friction = float(models.get("friction", {}).get(joint, 0.0))
        deflection = friction / stiffness if stiffness > 0.0 else 0.0
        scale[number] = max(1.0, BRISTLE_ERROR * deflection / ATOL)
    return scale
