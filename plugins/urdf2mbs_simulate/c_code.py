"""A project's C: equations and user functions in a library, compiled once, called through ctypes.

The library works on the memory of MbsData and on a Run of its own for each simulation, which ends
with the CCode.  User functions that are in Python are called back.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import BASE, ConversionError
from urdf2mbs_equations.files import FUNCTIONS
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    STATE_MODELS,
    find_state_indices,
)
from urdf2mbs_simulate.compiler import HERE, Source, compile_library, folders_of
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import equations
from urdf2mbs_simulate.memory import (
    HOOKS,
    HooksInC,
    Memory,
    PushInC,
    RunInC,
    integers,
    table,
    vector,
)
from urdf2mbs_simulate.model_code import Code, count_rows
from urdf2mbs_simulate.push import place_pushes
from urdf2mbs_simulate.python_code import changes, default, modules_of

SOURCES = (
    "runtime.c",
    "frame.c",
    "partition.c",
    "elements.c",
    "joint_system.c",
    "slopes.c",
    "linear_system.c",
    "steps.c",
    "turn.c",
    "hooks.c",
)
TYPES = ("T1", "T2", "T3", "R1", "R2", "R3")
TURNED = (
    "its base's second angle passes 90 degrees: the steps go on in turned axes, and Robotran "
    "itself stops there"
)
#: The bristle of friction may be wrong by this part of the most that it bends, with the tolerance
#: ``ATOL``, and by less with smaller ones.
BRISTLE_PART, ATOL = 0.05, 1e-6


class CCode(Code):
    """The functions of a simulation, in C but for user functions that are in Python."""

    def __init__(self, data: MbsData, *, user_in_c: bool = True) -> None:
        files = sorted(data.user_path.glob("*.c")) if user_in_c else []
        self.in_c = bool(files)
        super().__init__(data, count_rows(data))
        self.name = "C" if self.in_c else "C, user functions in Python"
        self.has_loop = self._find_loop()
        self.raised: BaseException | None = None
        self.sources = list_sources(data, self.rows, files)
        self.library = library = compile_library(self.sources, data._run.on_compile)
        library.get_run_size.restype = ctypes.c_size_t
        self.buffer = np.zeros(library.get_run_size() // 8 + 1)
        """The memory of the Run, as long as anything of it is in use."""
        self.run = RunInC.from_buffer(self.buffer.data)
        self.at = ctypes.byref(self.run)
        library.initialize_run(self.at)
        self.memory = Memory(data, self.run.data)
        self.model = self._read_user_models()
        self.run.data.user_model = vector(self.model)
        self.hooks = HooksInC()
        self._set_arrays()
        self._set_hooks()
        self.run.can_turn = can_turn(data, self.rows)
        self.function = library.accelerate
        self.function.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_void_p,
            ctypes.c_void_p,
        ]
        self.repartition(self.kept)

    def _find_loop(self) -> bool:
        """Return True if the user has a loop; one in C that urdf2mbs wrote does nothing."""
        data = self.data
        if not self.in_c:
            return data.user_dirdyn_loop is not default(data, "user_dirdyn_loop")
        file = data.user_path / "user_dirdyn.c"
        return not file.is_file() or changes(data, "c", file.name)

    def _set_arrays(self) -> None:
        """Give C the arrays that the Run points at."""
        data, run = self.data, self.run
        rows = sum(self.rows) + 1
        self.h, self.jac = np.zeros(rows), np.zeros((rows, data.njoint + 1))
        self.phi = np.zeros(data.njoint + 1)
        user = self.rows[1] + 1
        self.user_h, self.user_jdqd = np.zeros((2, user))
        self.user_jac = np.zeros((user, data.njoint + 1))
        run.user_h, run.user_jdqd = vector(self.user_h), vector(self.user_jdqd)
        run.user_J = vector(self.user_jac)
        self.state_scale = find_state_scale(data)
        run.state_scale = vector(self.state_scale)
        self.last_joint = integers(find_last_joints(data))
        run.last_joint = self.last_joint
        pushes = [
            PushInC(joint, (0.0, *at), (0.0, *push.force), push.start, push.stop)
            for push, joint, at in place_pushes(data)
        ]
        self.pushes = (PushInC * (len(pushes) + 1))(*pushes)
        run.pushes = self.pushes

    @property
    def is_turned(self) -> bool:
        """True if the base is in turned axes."""
        return bool(self.run.is_turned)

    def note_turn(self) -> None:
        """Note once that the base has been turned."""
        notes = self.data._run.notes
        if self.is_turned and TURNED not in notes:
            notes.append(TURNED)

    def turn_if_near(self, y: Any) -> bool:
        """Go on in other axes, if the base is near its singular place: ``y`` becomes the state
        there.  Return True if that was so."""
        turned = bool(self.library.turn_if_near(self.at, vector(y)))
        self.note_turn()
        return turned

    @contextmanager
    def model_axes(self) -> Iterator[None]:
        """Show q, qd, qdd and Qq of the base in the model's own axes."""
        force = self.data.Qq[1:7].copy()
        self.library.show_model_axes(self.at)
        self.library.show_joint_forces(self.at)
        try:
            yield
        finally:
            if self.is_turned:
                self.library.hide_model_axes(self.at)
                self.data.Qq[1:7] = force

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Keep what user code gives to set_output: the state is one of a frame."""
        self.run.is_recording = self.data._run.is_recording = True
        try:
            yield
        finally:
            self.run.is_recording = self.data._run.is_recording = False

    def leave_turned_axes(self) -> None:
        """Leave the data in the model's own axes, at the end of a run."""
        data = self.data
        with self.model_axes():
            rows = [row[1:7].copy() for row in (data.q, data.qd, data.qdd, data.Qq)]
        for row, values in zip((data.q, data.qd, data.qdd, data.Qq), rows, strict=True):
            row[1:7] = values
        self.run.is_turned = 0

    def repartition(self, kept: Any) -> None:
        super().repartition(kept)
        if not hasattr(self, "memory"):  # not yet
            return
        data = self.data
        self.memory.take_partition(data)
        self.y, self.f = np.empty((2, 2 * data.nqu + data.Nux))
        self.run.data.guess = vector(self.guess)
        self.buffers = self.y.ctypes.data, self.f.ctypes.data
        if len(kept) == data.nqv:
            self.library.set_partition(self.at, integers(kept + 1))

    def accelerate(self, t: float, y: Any) -> Any:
        """Return the derivative of the state y; not a number where the loops cannot be closed."""
        self.y[:] = y
        self.data.tsim = t
        failed = self.function(self.at, t, *self.buffers)
        self.check()
        return np.full(len(y), np.nan) if failed else self.f.copy()

    def slopes(self, t: float, y: Any, difference: float = 1e-7) -> Any:
        """Return the derivative of ``accelerate`` by the state, by differences: (states, states).

        Implicit integrators that are left to themselves scale their differences by a rate that
        vanishes in a robot at rest: what they then find is rounding, and their steps stay short.
        """
        f, found = self.accelerate(t, y), np.empty((len(y), len(y)))
        for k in range(len(y)):
            moved = y.copy()
            moved[k] += difference * max(1.0, abs(y[k]))
            found[:, k] = (self.accelerate(t, moved) - f) / (moved[k] - y[k])
        return found

    def take_parameters(self) -> None:
        """Take the parameters of user models anew."""
        self.model[:] = self._read_user_models()

    def solve(self) -> bool:
        self.run.data.tsim = self.data.tsim
        failed = bool(self.library.compute_accelerations(self.at))
        self.check()
        return failed

    def constraints(self) -> tuple[Any, Any]:
        self.jac[:] = 0.0
        self.run.data.tsim = self.data.tsim
        self.library.compute_constraints(self.at, vector(self.h), table(self.jac))
        self.check()
        return self.h[1:].copy(), self.jac[1:].copy()

    def inverse(self) -> Any:
        self.library.mbs_invdyna(vector(self.phi), self.at, ctypes.c_double(self.data.tsim))
        return self.phi.copy()

    def call(self, name: str, dirdyn: Any) -> None:
        """Call user_dirdyn_init, _loop or _finish, which are shown the model's own axes."""
        with self.recording(), self.model_axes():
            if not self.in_c:
                with modules_of(self.data):
                    getattr(self.data, name)(self.data, dirdyn)
                return
            self.run.data.tsim = self.data.tsim
            self.library.enter_user_code(self.at)
            at = ctypes.byref(self.run, RunInC.dirdyn.offset)
            getattr(self.library, name)(self.at, at)
        self.check()
        self.data.flag_stop |= self.run.data.flag_stop

    def check(self) -> None:
        """Raise what a function of Python has raised, which C cannot."""
        if self.raised is not None:
            raise self.raised

    def parameters(self) -> list[tuple[str, str]]:
        """Return the model and the name of each number in the struct of ``user_model.h``.

        Raises:
            ConversionError: A parameter is no number.
        """
        found = []
        for model in self.data._run.mbs.user_models if self.in_c else ():
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
                found.append((model.name, parameter.name))
        return found

    def _read_user_models(self) -> Any:
        """Return the struct of ``user_model.h``: the numbers one after the other."""
        values = self.data.user_model
        return np.array([*(values[model][name] for model, name in self.parameters()), 0.0])

    # --- functions in Python ---

    def _set_hooks(self) -> None:
        data = self.data
        outputs = data._run.new_outputs  # C calls this in states that are recorded only
        self._hook("output", lambda value, name: outputs.update({name.decode(): (value,)}))
        if not self.in_c:
            self._set_user_hooks()
        self.run.hooks = self.hooks

    def _set_user_hooks(self) -> None:
        data, point = self.data, self.run.point
        p, v, om, a, omp = (
            np.ctypeslib.as_array(getattr(point, name)) for name in ("P", "V", "OM", "A", "OMP")
        )
        r = np.ctypeslib.as_array(point.R).reshape(4, 4)

        def copied(table: Any, function: Callable[..., Any]) -> Callable[[float, int], None]:
            def call(t: float, number: int) -> None:
                table[number] = function(p, r, v, om, a, omp, data, t, number)

            return call

        if data.user_JointForces is not default(data, "user_JointForces"):
            self._hook("joint_forces", lambda t: data.user_JointForces(data, t))
        self._hook("driven_joints", lambda t: data.user_DrivenJoints(data, t))
        self._hook("derivative", lambda t: data.user_derivatives(data))
        self._hook("ext_forces", copied(data.SWr, data.user_ExtForces))
        self._hook("link_3d_forces", copied(data.l3DWr, data.user_Link3DForces))
        self._hook("link_force", lambda z, zd, t, k: float(data.user_LinkForces(z, zd, data, t, k)))
        self._hook("cons_hJ", lambda t: data.user_cons_hJ(self.user_h, self.user_jac, data, t))
        self._hook("cons_jdqd", lambda t: data.user_cons_jdqd(self.user_jdqd, data))

    def _hook(self, name: str, function: Callable[..., Any]) -> None:
        def call(*arguments: Any) -> Any:
            self.data.tsim = self.run.data.tsim
            try:
                with modules_of(self.data):
                    return function(*arguments)
            except BaseException as error:
                self.raised = self.raised or error
                self.run.data.flag_stop = 1
                return 0.0

        setattr(self.hooks, name, HOOKS[name](call))


def can_turn(data: MbsData, rows: tuple[int, int]) -> bool:
    """Return True if the first six joints are those of a base that nothing ties to the ground, and
    gravity is along z."""
    mbs = data._run.mbs
    first = [*mbs.joints().values()][:6]
    free = [joint.type for joint in first if joint.nature == "independent"] == [*TYPES]
    ties = (*mbs.cuts, *mbs.links)
    tied = any(end[0] is None for tie in ties for end in (tie.endpoint1, tie.endpoint2))
    return free and not tied and not rows[1] and not data.g[1:3].any()


def find_last_joints(data: MbsData) -> list[int]:
    """Return the last joint of the body of each external force, from index 1."""
    found = [0] * (data.Nxfrc + 1)
    for body in data._run.mbs.bodies:
        for point in body.points:
            if point.extforce is not None:
                found[data.extforce_id[point.extforce.name]] = data.body_id[body.name]
    return found


def find_state_scale(data: MbsData) -> Any:
    """Return the absolute tolerance of each user state, in parts of that of positions.

    The bristles of friction bend by less than a millimetre, and their errors fade: what they do to
    the robot is their part of the most that they bend.
    """
    mbs, models, found = data._run.mbs, data.user_model, np.ones(data.Nux + 1)
    law = models.get("contact", {})
    bend = float(law.get("friction", 0.0)) * float(law.get("bristle", 0.0))
    for number in find_state_indices(mbs, CONTACT_STATES).values():
        found[number : number + 3] = max(1.0, BRISTLE_PART * bend / ATOL)
    for joint, number in find_state_indices(mbs, JOINT_STATES).items():
        stiffness = float(models.get("friction_stiffness", {}).get(joint, 0.0))
        friction = float(models.get("friction", {}).get(joint, 0.0))
        bend = friction / stiffness if stiffness > 0.0 else 0.0
        found[number] = max(1.0, BRISTLE_PART * bend / ATOL)
    return found


def list_sources(data: MbsData, rows: tuple[int, int], user: list[Path]) -> list[Source]:
    """Return the files of C of a simulation, with what they are compiled with."""
    counts = {
        "JOINTS": data.njoint,
        "CUTS": rows[0],
        "USER_ROWS": rows[1],
        "FORCES": data.Nxfrc,
        "STATES": data.Nux,
        "LINKS": data.Nlink,
        "LINKS3D": data.Nlink3D,
        "DRIVEN": int(bool(data.nqc)),
    }
    defines = [f"-DRUN_{name}={count}" for name, count in counts.items()]
    own = {name: [*defines] for name in SOURCES}
    own["frame.c"] += [f"-DRUN_TREE={_tree(data)}", f"-DRUN_LINK_ENDS={_link_ends(data)}"]
    own["hooks.c"] += ["-DUSER_IN_C"] * bool(user)
    texts = [file.read_text("utf-8", "replace") for file in (*(HERE / n for n in own), *user)]
    called = re.findall(r"\bmbs_(\w+)\(", re.sub(r"(?s)/\*.*?\*/|//[^\n]*", "", "".join(texts)))
    absent = {"link": data.Nlink, "link3D": data.Nlink3D, "extforces": data.Nxfrc}
    absent |= {"cons_hJ": rows[0], "cons_jdqd": rows[0]}
    names = {*called} & {*FUNCTIONS} - {
        "accelred",
        *(n for n, count in absent.items() if not count),
    }
    folders = folders_of(data.user_path, data.symbolic_path)
    plain = [*equations(data, sorted(names), "c").values(), *user]
    return [
        *(Source(file, folders) for file in plain),
        *(Source(HERE / name, folders, tuple(words)) for name, words in own.items()),
    ]


def _tree(data: MbsData) -> str:
    """Return the rows of ``tree`` in ``frame.c``."""
    rows: list[str] = []
    for body in data._run.mbs.bodies:
        before = 0 if body.parent is None else data.body_id[body.parent]
        point = data.points_id[body.parent or BASE][body.point] if body.point else 0
        for joint in body.joints:
            rows.append(f"{{{TYPES.index(joint.type)}, {before}, {point}}}")
            before, point = len(rows), 0
    return ", ".join(rows)


def _link_ends(data: MbsData) -> str:
    """Return the rows of ``link_ends`` in ``frame.c``."""
    rows = []
    for link in data._run.mbs.links:
        if link.kind == "link":
            ends = (link.endpoint1, link.endpoint2)
            joints = [data.body_id[body] if body else 0 for body, _ in ends]
            points = [data.points_id[body or BASE][name] if name else 0 for body, name in ends]
            rows.append(f"{{{{{joints[0]}, {joints[1]}}}, {{{points[0]}, {points[1]}}}}}")
    return ", ".join(rows)
