"""A project's C: equations and user functions in a library, compiled once, called through ctypes.

The library works on the memory of MbsData.  User functions that are in Python are called back.
"""

from __future__ import annotations

import ctypes
import os
import platform
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.mbs.model import BASE
from urdf2mbs.messages.diagnostics import ConfigError, ConversionError
from urdf2mbs_equations.c import CWriter
from urdf2mbs_equations.files import FUNCTIONS
from urdf2mbs_project.code.c import STATES
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import HEADERS, cache_folder, equations, keep
from urdf2mbs_simulate.push import places
from urdf2mbs_simulate.python_code import PythonCode, add_on, changes, default
from urdf2mbs_simulate.turn import TYPES, tell_of_turn

HERE = Path(__file__).parent
#: Equations of 2025 and later call ``user_call_X``: here ``user_X``, or ``run_X`` of ``turn.c``,
#: which calls it.
FLAGS = (
    "-std=gnu99", "-O2", "-w", "-D__thread=",
    *(f"-Duser_call_{name}=run_{name}" for name in (
        "ExtForces", "Link3DForces", "LinkForces", "DrivenJoints")),
    *(f"-Duser_call_{name}=user_{name}" for name in ("cons_hJ", "cons_jdqd")),
)  # fmt: skip
LIBRARY = ("-shared", "-fPIC", "-fno-semantic-interposition")
SOURCES = ("runtime.c", "frame.c", "slopes.c", "steps.c", "turn.c", "hooks.c")

_double, _int = ctypes.c_double, ctypes.c_int
_row = ctypes.POINTER(_double)
_table = ctypes.POINTER(_row)

ROWS = ("q", "qd", "qdd", "q0", "Qq", "Qc", "ux", "uxd")
MORE_ROWS = ("m", "lrod", "Z", "Zd", "Fl")
TABLES = ("l", "In", "frc", "trq")


class _Data(ctypes.Structure):
    """MbsData of ``mbsysc/mbs_data.h``."""

    _fields_ = [
        ("njoint", _int), ("process", _int), ("flag_stop", _int),
        *((name, _row) for name in ROWS),
        ("dpt", _row * 4), ("xfidpt", ctypes.POINTER(_int)), ("SWr", _table), ("l3DWr", _table),
        ("g", _double * 4), ("user_model", _row), ("DonePart", _int), ("tsim", _double),
        *((name, _row) for name in MORE_ROWS), *((name, _table) for name in TABLES),
        ("nqu", _int), ("nqv", _int), ("Nux", _int),
        ("qu", ctypes.POINTER(_int)), ("qv", ctypes.POINTER(_int)), ("guess", _row),
        ("qd0", _row), ("Lambda", _row),
    ]  # fmt: skip


_AT: Any = ctypes.CFUNCTYPE(None, _double)
_AT_POINT: Any = ctypes.CFUNCTYPE(None, _double, _int)


#: The functions that ``runtime.c`` calls in Python.
_HOOKS: dict[str, Any] = {
    "output": ctypes.CFUNCTYPE(None, _double, ctypes.c_char_p),
    "joint_forces": _AT, "driven_joints": _AT, "derivative": _AT,
    "ext_forces": _AT_POINT, "link_3d_forces": _AT_POINT,
    "link_force": ctypes.CFUNCTYPE(_double, _double, _double, _double, _int),
    "cons_hJ": _AT, "cons_jdqd": _AT,
}  # fmt: skip


class _Hooks(ctypes.Structure):
    _fields_ = list(_HOOKS.items())


class _Push(ctypes.Structure):
    """Push of ``runtime.c``."""

    _fields_ = [
        ("joint", _int), ("at", _double * 4), ("force", _double * 4), ("start", _double),
        ("stop", _double),
    ]  # fmt: skip


class SensorInC(ctypes.Structure):
    """MbsSensor of ``mbsysc/mbs_sensor.h``."""

    _fields_ = [
        *((name, _double * size)
          for name, size in (("P", 4), ("R", 16), ("V", 4), ("OM", 4), ("A", 4), ("OMP", 4))),
        ("J", _row * 7),
    ]  # fmt: skip


@cache
def compiler() -> str | None:
    """The C compiler: ``$CC``, else cc, gcc or clang, else zig of the package ziglang, which the
    extra ``live`` brings; None where there is none."""
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    return next(filter(None, [*map(shutil.which, names), zig()]), None)


def zig() -> str | None:
    """The compiler of the package ziglang, which compiles for a page, too."""
    package = find_spec("ziglang")
    folders = package.submodule_search_locations if package else None
    return shutil.which("zig", path=folders[0]) if folders else None


def vector(array: Any) -> Any:
    """An array in C."""
    return array.ctypes.data_as(_row)


def table(array: Any) -> Any:
    """A table in C."""
    return (_row * len(array))(*map(vector, array))


class Memory:
    """The arrays of MbsData as C has them."""

    def __init__(self, data: MbsData) -> None:
        self.kept = dict(vars(data))  # C works on these arrays, whatever user code puts there
        self.c = c = _Data(njoint=data.njoint, Nux=data.Nux, DonePart=1)
        self.at = ctypes.byref(c)
        for name in (*ROWS, *MORE_ROWS, "qd0"):
            setattr(c, name, vector(getattr(data, name)))
        for name in (*TABLES, "SWr", "l3DWr"):
            setattr(c, name, table(getattr(data, name)))
        c.xfidpt = (_int * len(data.xfidpt))(*map(int, data.xfidpt))
        c.dpt = table(data.dpt)
        c.g = (_double * 4)(*data.g)
        data.g = np.ctypeslib.as_array(c.g)  # user code may change it
        self.take_partition(data)

    def take_partition(self, data: MbsData) -> None:
        self.c.nqu, self.c.nqv, self.c.Lambda = data.nqu, data.nqv, vector(data.Lambda)
        for name in ("qu", "qv"):
            numbers = getattr(data, name)
            setattr(self.c, name, (_int * len(numbers))(*map(int, numbers)))


class CCode(PythonCode):
    """The functions of a simulation, in C but for user functions that are in Python."""

    steps_in_c = True

    def __init__(self, data: MbsData, *, user_in_c: bool = True) -> None:
        sources = sorted(data.user_path.glob("*.c")) if user_in_c else []
        self.in_c = bool(sources)
        super().__init__(data)
        self.name = "C" if self.in_c else "C, user functions in Python"
        self.raised: BaseException | None = None
        self.sources = _sources(data, self.rows, sources)
        self.library = compiled(data, *self.sources)
        self.memory = memory = Memory(data)
        self.c, self.at = memory.c, memory.at
        # arguments that are made once, since this is called some ten thousand times a second
        self.jac = np.zeros((sum(self.rows) + 1, data.njoint + 1))
        self.h, self.phi = np.zeros(sum(self.rows) + 1), np.zeros(data.njoint + 1)
        self.model = self._user_models()
        self.c.user_model = vector(self.model)
        self.repartition(self.kept)
        self.rows_at, self.phi_at = (vector(self.h), table(self.jac)), vector(self.phi)
        self.function = self.library.accelerate
        self.function.argtypes = [ctypes.c_void_p, _double, _row, _row]
        self.hooks = _Hooks.in_dll(self.library, "hooks")
        ctypes.memset(ctypes.byref(self.hooks), 0, ctypes.sizeof(self.hooks))  # of an earlier run
        self._set_hooks()
        self._find_bodies()
        pushes = [
            _Push(joint, (0.0, *at), (0.0, *push.force), push.start, push.stop)
            for push, joint, at in places(data)
        ]
        self.pushes = (_Push * (len(pushes) + 1))(*pushes)
        ctypes.POINTER(_Push).in_dll(self.library, "pushes").contents = self.pushes[0]
        self.take_axes()

    def find_loop(self) -> bool:
        """True if the user has a loop; one in C that urdf2mbs wrote does nothing."""
        if not self.in_c:
            return super().find_loop()
        file = self.data.user_path / "user_dirdyn.c"
        return not file.is_file() or changes(self.data, "c", file.name)

    def take_axes(self) -> None:
        """Tell C in which axes the base is."""
        _int.in_dll(self.library, "can_turn").value = self.data.can_turn
        _int.in_dll(self.library, "turned").value = self.data.turned
        (_double * 3).in_dll(self.library, "own_angles")[:] = [*map(float, self.data.own_angles)]

    def find_axes(self) -> None:
        """Take over in which axes C has gone on."""
        turned = bool(_int.in_dll(self.library, "turned").value)
        if turned:
            tell_of_turn(self.data)
            self.data.own_angles = np.array((_double * 3).in_dll(self.library, "own_angles"))
        self.data.turned = turned

    def repartition(self, kept: Any) -> None:
        super().repartition(kept)
        if not hasattr(self, "c"):  # not yet
            return
        self.memory.take_partition(self.data)
        self.y, self.f = np.empty((2, 2 * self.data.nqu + self.data.Nux))
        self.c.guess, self.buffers = vector(self.guess), (vector(self.y), vector(self.f))
        if len(kept) == self.data.nqv:
            self.library.set_partition(self.at, (_int * len(kept))(*map(int, kept + 1)))

    def accelerate(self, t: float, y: Any) -> Any:
        self.y[:] = y
        self.data.tsim = t
        failed = self.function(self.at, t, *self.buffers)
        self.check()
        return np.full(len(y), np.nan) if failed else self.f.copy()

    def take_parameters(self) -> None:
        self.model[:] = self._user_models()

    def _find_bodies(self) -> None:
        """Say which body each external force acts on."""
        self.last_joint = (_int * (self.data.Nxfrc + 1)).in_dll(self.library, "last_joint")
        for body in self.data.mbs.bodies:
            for point in body.points:
                if point.extforce is not None:
                    number = self.data.extforce_id[point.extforce.name]
                    self.last_joint[number] = self.data.body_id[body.name]

    def solve(self) -> bool:
        failed = bool(self.library.kept_accelred(self.at, _double(self.data.tsim)))
        self.check()
        return failed

    def constraints(self) -> tuple[Any, Any]:
        self.jac[:] = 0.0
        self.library.constrain(self.at, *self.rows_at)
        self.check()
        return self.h[1:].copy(), self.jac[1:].copy()

    def inverse(self) -> Any:
        self.library.mbs_invdyna(self.phi_at, self.at, _double(self.data.tsim))
        return self.phi.copy()

    def call(self, name: str, dirdyn: Any) -> None:
        if not self.in_c:
            super().call(name, dirdyn)
            return
        self.c.tsim = self.data.tsim
        given = ctypes.c_void_p.in_dll(self.library, "dirdyn")
        getattr(self.library, name)(self.at, ctypes.byref(given))
        self.check()
        self.data.flag_stop |= self.c.flag_stop

    def check(self) -> None:
        """Raise what a function of Python has raised, which C cannot."""
        if self.raised is not None:
            raise self.raised

    def parameters(self) -> list[tuple[str, str]]:
        """The model and the name of each number in the struct of ``user_model.h``.

        Raises ConversionError where it has more than numbers.
        """
        found = []
        for model in self.data.mbs.user_models if self.in_c else ():
            for parameter in model.parameters if model.name not in STATES else ():
                if parameter.type != "scalar":
                    raise ConversionError(
                        "user-model-in-c",
                        f"'{model.name}.{parameter.name}' is a {parameter.type}, and C user "
                        "functions get numbers only",
                        file=str(self.data.mbs_file), hint="take user functions in Python",
                    )  # fmt: skip
                found.append((model.name, parameter.name))
        return found

    def _user_models(self) -> Any:
        """The struct of ``user_model.h``: the numbers one after the other."""
        values = self.data.user_model
        return np.array([*(values[model][name] for model, name in self.parameters()), 0.0])

    # --- functions in Python ---

    def _set_hooks(self) -> None:
        data = self.data
        self._hook("output", lambda value, name: data.set_output(value, name.decode()))
        if self.in_c:
            return
        motion = SensorInC.in_dll(self.library, "motion")
        p, v, om, a, omp = (
            np.ctypeslib.as_array(getattr(motion, name)) for name in ("P", "V", "OM", "A", "OMP")
        )
        r = np.ctypeslib.as_array(motion.R).reshape(4, 4)

        def copied(table: Any, function: Callable[..., Any]) -> Callable[[float, int], None]:
            def call(t: float, number: int) -> None:
                table[number] = function(p, r, v, om, a, omp, data, t, number)

            return call

        user = self.rows[1] + 1
        h, jdqd, jac = (
            np.ctypeslib.as_array((_double * size).in_dll(self.library, name))
            for name, size in (
                ("rows_h", user), ("rows_jdqd", user), ("rows_jac", user * (data.njoint + 1)),
            )
        )  # fmt: skip
        jac = jac.reshape(user, data.njoint + 1)
        if data.pushes and data.user_JointForces is default(data, "user_JointForces"):
            self._hook("joint_forces", lambda t: data.Qq.fill(0.0))  # the last pushes are in Qq
        else:
            self._hook("joint_forces", lambda t: data.user_JointForces(data, t))
        self._hook("driven_joints", lambda t: data.user_DrivenJoints(data, t))
        self._hook("derivative", lambda t: data.user_derivatives(data))
        self._hook("ext_forces", copied(data.SWr, data.user_ExtForces))
        self._hook("link_3d_forces", copied(data.l3DWr, data.user_Link3DForces))
        self._hook("link_force", lambda z, zd, t, k: float(data.user_LinkForces(z, zd, data, t, k)))
        self._hook("cons_hJ", lambda t: data.user_cons_hJ(h, jac, data, t))
        self._hook("cons_jdqd", lambda t: data.user_cons_jdqd(jdqd, data))

    def _hook(self, name: str, function: Callable[..., Any]) -> None:
        def call(*words: Any) -> Any:
            self.data.tsim = self.c.tsim
            try:
                return function(*words)
            except BaseException as error:
                self.raised = self.raised or error
                return 0.0

        setattr(self.hooks, name, _HOOKS[name](call))


def _sources(
    data: MbsData, rows: tuple[int, int], user: list[Path]
) -> tuple[list[Path], list[str]]:
    """The files of a simulation, with accelred for any partition, and what they are compiled
    with."""
    facts = {**CWriter(data.mbs).facts(), "ANY_DRIVEN": bool(data.nqc)}
    words = ", ".join(f"{name} = {int(value)}" for name, value in facts.items())
    defines = [f"-DRUN_JOINTS={data.njoint}", f"-DRUN_CUTS={rows[0]}", f"-DRUN_USER_ROWS={rows[1]}"]
    defines += [f"-DRUN_FORCES={data.Nxfrc}", f"-DRUN_STATES={data.Nux}", f"-DRUN_FACTS={words}"]
    defines.append(f"-DRUN_TREE={_tree(data)}")
    defines += ["-DUSER_IN_C"] * bool(user)
    text = (HERE / "partition.c").read_text().replace(
        '#include "accelred.c"',
        CWriter(data.mbs).sections("info", "calls", "forces", "loops", "accelred"),
    )  # fmt: skip
    partition = cache_folder() / "equations" / f"{sha256(text.encode()).hexdigest()[:32]}.c"
    if not partition.is_file():
        keep(partition, text.encode())
    own = [HERE / name for name in SOURCES]
    own += [partition, *user]
    texts = [file.read_text("utf-8", "replace") for file in own]
    called = re.findall(r"\bmbs_(\w+)\(", re.sub(r"(?s)/\*.*?\*/|//[^\n]*", "", "".join(texts)))
    files = equations(data, sorted({*called} & {*FUNCTIONS} - {"accelred"}), "c")
    return [*files.values(), *own], defines


def _tree(data: MbsData) -> str:
    """The rows of ``tree`` in ``frame.c``."""
    rows: list[str] = []
    for body in data.mbs.bodies:
        before = 0 if body.parent is None else data.body_id[body.parent]
        point = data.points_id[body.parent or BASE][body.point] if body.point else 0
        for joint in body.joints:
            rows.append(f"{{{TYPES.index(joint.type)}, {before}, {point}}}")
            before, point = len(rows), 0
    return ", ".join(rows)


def compiled(data: MbsData, sources: list[Path], defines: Sequence[str] = ()) -> Any:
    """C files as a library."""
    found = compiler()
    if found is None:
        raise ConfigError(
            "usage", "there is no C compiler: neither cc nor gcc nor clang nor ziglang",
            hint="'pip install ziglang' is one; or take Python: --language python",
        )  # fmt: skip
    # zig compiles for the processor that it runs on, and machines may share the cache
    portable = ["-mcpu=baseline"] * (Path(found).stem == "zig")
    flags = [*LIBRARY, *portable, *defines]
    return ctypes.CDLL(str(build(data, sources, flags, found, ".so")))


def build(
    data: MbsData, sources: list[Path], flags: Sequence[str], compiler: str, suffix: str
) -> Path:
    """C files, compiled; what comes of them is kept in the cache by its checksum."""
    headers = [HERE / "runtime.h", *HEADERS.glob("*.h"), *data.user_path.glob("*.h")]
    key = sha256(" ".join([compiler, platform.machine(), *FLAGS, *flags]).encode())
    for file in (*sources, *sorted(headers)):
        key.update(b"\0" + file.read_bytes())
    kept = cache_folder() / "libraries" / f"{key.hexdigest()[:32]}{suffix}"
    if not kept.is_file():
        with tempfile.TemporaryDirectory(prefix="urdf2mbs-") as folder:
            made = Path(folder, kept.name)
            folders = [f"-I{at}" for at in (HERE, HEADERS, data.user_path, data.symbolic_path)]
            command = [compiler, "cc"] if Path(compiler).stem == "zig" else [compiler]
            done = subprocess.run(
                [*command, *FLAGS, *flags, *folders, "-o", made, *sources, "-lm"],
                check=False, capture_output=True, text=True, encoding="utf-8", errors="replace",
            )  # fmt: skip
            if done.returncode:
                raise _not_compiled(done.stderr)
            keep(kept, made.read_bytes())
    return kept


def _not_compiled(said: str) -> ConversionError:
    """The compiler's first error, with its file and line."""
    found = re.search(r"(?m)^(.+?):(\d+):(?:\d+:)? (?:fatal )?error: (.*)$", said)
    if found is None:
        return ConversionError("not-compiled", f"the C compiler says: {said.strip()[-500:]}")
    hint = None
    if header := re.match(r"'?([\w./]+\.h)'?(: No such file| file not found)", found[3]):
        hint = add_on(header[1])
        if hint is None and header[1].lower().startswith("mbs"):
            hint = "it is of Robotran's MBsysC, of which this runtime has a part"
    return ConversionError("not-compiled", found[3], file=found[1], line=int(found[2]), hint=hint)
