"""The structs of ``runtime.h`` and ``mbsysc`` for ctypes: members in the order of the headers."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from urdf2mbs_simulate.data import MbsData

c_double, c_int = ctypes.c_double, ctypes.c_int
_vector = ctypes.POINTER(c_double)
_table = ctypes.POINTER(_vector)
_integers = ctypes.POINTER(c_int)

#: Members of MbsData that are vectors of joints or states.
STATE_VECTORS = ("q", "qd", "qdd", "q0", "Qq", "Qc", "ux", "uxd")
#: Members that are vectors of other lengths.
OTHER_VECTORS = ("m", "lrod", "Z", "Zd", "Fl")
#: Members that are tables: pointers to rows.
TABLES = ("l", "In", "frc", "trq")


class DataInC(ctypes.Structure):
    """MbsData of ``mbsysc/mbs_data.h``."""

    _fields_ = [
        ("njoint", c_int),
        ("process", c_int),
        ("flag_stop", c_int),
        *((name, _vector) for name in STATE_VECTORS),
        ("dpt", _vector * 4),
        ("xfidpt", _integers),
        ("SWr", _table),
        ("l3DWr", _table),
        ("g", c_double * 4),
        ("user_model", _vector),
        ("DonePart", c_int),
        ("tsim", c_double),
        *((name, _vector) for name in OTHER_VECTORS),
        *((name, _table) for name in TABLES),
        ("nqu", c_int),
        ("nqv", c_int),
        ("Nux", c_int),
        ("qu", _integers),
        ("qv", _integers),
        ("guess", _vector),
        ("qd0", _vector),
        ("Lambda", _vector),
    ]


class SensorInC(ctypes.Structure):
    """MbsSensor of ``mbsysc/mbs_sensor.h``."""

    _fields_ = [
        ("P", c_double * 4),
        ("R", c_double * 16),
        ("V", c_double * 4),
        ("OM", c_double * 4),
        ("A", c_double * 4),
        ("OMP", c_double * 4),
        ("J", _vector * 7),
    ]


_OF_TIME: Any = ctypes.CFUNCTYPE(None, c_double)
_OF_TIME_AND_NUMBER: Any = ctypes.CFUNCTYPE(None, c_double, c_int)
#: The functions of Python that C calls.
HOOKS: dict[str, Any] = {
    "output": ctypes.CFUNCTYPE(None, c_double, ctypes.c_char_p),
    "joint_forces": _OF_TIME,
    "driven_joints": _OF_TIME,
    "derivative": _OF_TIME,
    "ext_forces": _OF_TIME_AND_NUMBER,
    "link_3d_forces": _OF_TIME_AND_NUMBER,
    "link_force": ctypes.CFUNCTYPE(c_double, c_double, c_double, c_double, c_int),
    "cons_hJ": _OF_TIME,
    "cons_jdqd": _OF_TIME,
}


class HooksInC(ctypes.Structure):
    """Hooks of ``runtime.h``."""

    _fields_ = list(HOOKS.items())


class PushInC(ctypes.Structure):
    """Push of ``runtime.h``."""

    _fields_ = [
        ("joint", c_int),
        ("point", c_double * 4),
        ("force", c_double * 4),
        ("start", c_double),
        ("stop", c_double),
    ]


class IntegrationInC(ctypes.Structure):
    """Integration of ``runtime.h``."""

    _fields_ = [
        ("t", c_double),
        ("h", c_double),
        ("end", c_double),
        ("max_step", c_double),
        ("rtol", c_double),
        ("atol", c_double),
        ("max_steps", c_int),
        ("calls_loop", c_int),
        ("y", _vector),
        ("frame_time", _vector),
        ("n_frames", c_int),
        ("n_passed", c_int),
        ("frame_y", _vector),
    ]


class RunInC(ctypes.Structure):
    """Run of ``runtime.h``, up to the line below which only C uses its members."""

    _fields_ = [
        ("data", DataInC),
        ("hooks", HooksInC),
        ("pushes", ctypes.POINTER(PushInC)),
        ("last_joint", _integers),
        ("user_h", _vector),
        ("user_jdqd", _vector),
        ("user_J", _vector),
        ("state_scale", _vector),
        ("point", SensorInC),
        ("dirdyn", ctypes.c_void_p * 2),
        ("damping", c_double),
        ("is_time_frozen", c_int),
        ("can_turn", c_int),
        ("is_turned", c_int),
        ("shown_angles", c_double * 3),
        ("is_recording", c_int),
    ]


class CouplingInC(ctypes.Structure):
    """Coupling of ``calls.c``."""

    _fields_ = [("follower", c_int), ("leader", c_int), ("factor", c_double)]


class JointRunInC(ctypes.Structure):
    """JointRun of ``calls.c``."""

    _fields_ = [("index", c_int), ("number", c_int), ("length", c_int)]


class CallInC(ctypes.Structure):
    """Call of ``calls.c``."""

    _fields_ = [
        ("s", ctypes.POINTER(DataInC)),
        ("n_all", c_int),
        ("n", c_int),
        ("n_runs", c_int),
        ("run", ctypes.POINTER(JointRunInC)),
        ("n_couplings", c_int),
        ("coupling", ctypes.POINTER(CouplingInC)),
        ("q0", _vector),
        ("zeros", _vector),
        ("n_independent", c_int),
        ("independent", _integers),
        ("place", c_int),
        ("point", c_int),
        ("n_parameters", c_int),
        ("n_states", c_int),
        ("n_numbers", c_int),
        ("input", _vector * 3),
        ("output", _vector * 3),
        ("table", _table * 3),
        ("matrix", _vector * 3),
        ("vector", _vector),
        ("bias", _vector),
        ("factors", _vector),
        ("columns", _vector),
        ("singular", c_int),
    ]


def as_c_vector(array: Any) -> Any:
    """Return a pointer to the numbers of an array, which it does not keep alive."""
    return array.ctypes.data_as(_vector)


def as_c_table(array: Any) -> Any:
    """Return pointers to the rows of an array, which they do not keep alive."""
    return (_vector * len(array))(*map(as_c_vector, array))


def as_c_integers(values: Any) -> Any:
    """Return a copy of whole numbers, as an array of C."""
    return (c_int * len(values))(*map(int, values))


class SharedData:
    """The struct of C that shares the arrays of an MbsData."""

    def __init__(self, data: MbsData, struct: DataInC | None = None) -> None:
        """Let a struct, by default a new one, point at the arrays of the data."""
        self.struct = struct = DataInC() if struct is None else struct
        self.address = ctypes.byref(struct)
        self.arrays: dict[str, Any] = {}
        """Kept alive while C works on them, even if user code binds their names anew."""
        struct.njoint, struct.Nux, struct.DonePart = data.njoint, data.Nux, 1
        for name in (*STATE_VECTORS, *OTHER_VECTORS, "qd0"):
            self.arrays[name] = getattr(data, name)
            setattr(struct, name, as_c_vector(self.arrays[name]))
        for name in (*TABLES, "SWr", "l3DWr"):
            array = getattr(data, name)
            rows = as_c_table(array)
            self.arrays[name] = array, rows
            setattr(struct, name, rows)
        self.arrays["xfidpt"] = struct.xfidpt = as_c_integers(data.xfidpt)
        self.arrays["dpt"] = data.dpt
        struct.dpt = as_c_table(data.dpt)
        struct.g = (c_double * 4)(*data.g)
        data.g = np.ctypeslib.as_array(struct.g)  # user code may change it
        self.set_partition(data)

    def set_partition(self, data: MbsData) -> None:
        """Take the natures of the joints from the data."""
        struct = self.struct
        struct.nqu, struct.nqv = data.nqu, data.nqv
        self.arrays["Lambda"] = data.Lambda
        struct.Lambda = as_c_vector(data.Lambda)
        for name in ("qu", "qv"):
            self.arrays[name] = as_c_integers(getattr(data, name))
            setattr(struct, name, self.arrays[name])
