"""The structs of ``runtime.h`` and ``mbsysc``, as ctypes has them."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from urdf2mbs_simulate.data import MbsData

c_double, c_int = ctypes.c_double, ctypes.c_int
_row = ctypes.POINTER(c_double)
_table = ctypes.POINTER(_row)
_integers = ctypes.POINTER(c_int)

#: Members of MbsData: arrays of joints and states, arrays of other lengths, and tables.
ROWS = ("q", "qd", "qdd", "q0", "Qq", "Qc", "ux", "uxd")
MORE_ROWS = ("m", "lrod", "Z", "Zd", "Fl")
TABLES = ("l", "In", "frc", "trq")


class DataInC(ctypes.Structure):
    """MbsData of ``mbsysc/mbs_data.h``."""

    _fields_ = [
        ("njoint", c_int),
        ("process", c_int),
        ("flag_stop", c_int),
        *((name, _row) for name in ROWS),
        ("dpt", _row * 4),
        ("xfidpt", _integers),
        ("SWr", _table),
        ("l3DWr", _table),
        ("g", c_double * 4),
        ("user_model", _row),
        ("DonePart", c_int),
        ("tsim", c_double),
        *((name, _row) for name in MORE_ROWS),
        *((name, _table) for name in TABLES),
        ("nqu", c_int),
        ("nqv", c_int),
        ("Nux", c_int),
        ("qu", _integers),
        ("qv", _integers),
        ("guess", _row),
        ("qd0", _row),
        ("Lambda", _row),
    ]


class SensorInC(ctypes.Structure):
    """MbsSensor of ``mbsysc/mbs_sensor.h``."""

    _fields_ = [
        *(
            (name, c_double * size)
            for name, size in (("P", 4), ("R", 16), ("V", 4), ("OM", 4), ("A", 4), ("OMP", 4))
        ),
        ("J", _row * 7),
    ]


_AT: Any = ctypes.CFUNCTYPE(None, c_double)
_AT_POINT: Any = ctypes.CFUNCTYPE(None, c_double, c_int)
#: The functions that C calls in Python.
HOOKS: dict[str, Any] = {
    "output": ctypes.CFUNCTYPE(None, c_double, ctypes.c_char_p),
    "joint_forces": _AT,
    "driven_joints": _AT,
    "derivative": _AT,
    "ext_forces": _AT_POINT,
    "link_3d_forces": _AT_POINT,
    "link_force": ctypes.CFUNCTYPE(c_double, c_double, c_double, c_double, c_int),
    "cons_hJ": _AT,
    "cons_jdqd": _AT,
}


class HooksInC(ctypes.Structure):
    _fields_ = list(HOOKS.items())


class PushInC(ctypes.Structure):
    """Push of ``runtime.h``."""

    _fields_ = [
        ("joint", c_int),
        ("at", c_double * 4),
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
        ("longest_step", c_double),
        ("rtol", c_double),
        ("atol", c_double),
        ("most_steps", c_int),
        ("calls_loop", c_int),
        ("y", _row),
        ("frame_time", _row),
        ("n_frames", c_int),
        ("n_passed", c_int),
        ("frame_y", _row),
    ]


class RunInC(ctypes.Structure):
    """The members of Run of ``runtime.h`` that Python knows."""

    _fields_ = [
        ("data", DataInC),
        ("hooks", HooksInC),
        ("pushes", ctypes.POINTER(PushInC)),
        ("last_joint", _integers),
        ("user_h", _row),
        ("user_jdqd", _row),
        ("user_J", _row),
        ("state_scale", _row),
        ("point", SensorInC),
        ("dirdyn", ctypes.c_void_p * 2),
        ("damping", c_double),
        ("is_time_frozen", c_int),
        ("can_turn", c_int),
        ("is_turned", c_int),
        ("shown_angles", c_double * 3),
        ("is_recording", c_int),
    ]


def vector(array: Any) -> Any:
    """Return an array for C, which does not keep it alive."""
    return array.ctypes.data_as(_row)


def table(array: Any) -> Any:
    """Return a table for C, which does not keep the array alive."""
    return (_row * len(array))(*map(vector, array))


def integers(values: Any) -> Any:
    """Return whole numbers for C."""
    return (c_int * len(values))(*map(int, values))


class Memory:
    """The arrays of an MbsData, as C has them in a struct."""

    def __init__(self, data: MbsData, struct: DataInC | None = None) -> None:
        self.struct = c = DataInC() if struct is None else struct
        self.at = ctypes.byref(c)
        self.kept: dict[str, Any] = {}
        """Arrays and tables that C works on, whatever user code puts in their places."""
        c.njoint, c.Nux, c.DonePart = data.njoint, data.Nux, 1
        for name in (*ROWS, *MORE_ROWS, "qd0"):
            self.kept[name] = getattr(data, name)
            setattr(c, name, vector(self.kept[name]))
        for name in (*TABLES, "SWr", "l3DWr"):
            array = getattr(data, name)
            self.kept[name] = array, table(array)
            setattr(c, name, self.kept[name][1])
        self.kept["xfidpt"] = integers(data.xfidpt)
        c.xfidpt = self.kept["xfidpt"]
        self.kept["dpt"] = data.dpt
        c.dpt = table(data.dpt)
        c.g = (c_double * 4)(*data.g)
        data.g = np.ctypeslib.as_array(c.g)  # user code may change it
        self.take_partition(data)

    def take_partition(self, data: MbsData) -> None:
        c = self.struct
        c.nqu, c.nqv = data.nqu, data.nqv
        self.kept["Lambda"] = data.Lambda
        c.Lambda = vector(data.Lambda)
        for name in ("qu", "qv"):
            self.kept[name] = integers(getattr(data, name))
            setattr(c, name, self.kept[name])
