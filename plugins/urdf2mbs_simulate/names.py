"""What MBsysPy has beside its classes: outputs, and products of arrays that count from 1."""

from __future__ import annotations

import runpy
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from urdf2mbs.plugin import ConversionError
from urdf2mbs_simulate.data import MbsData

#: What stands for the modules of MBsysPy.
MODULES = {
    "MBsysPy": "urdf2mbs_simulate.runtime", "MBsysPy.mbs_utilities": __name__,
    "MBsysPy.mbsyspy.mbs_sensor": "urdf2mbs_simulate.runtime",
    "MBsysPy.mbsyspy.utilities.algebra": __name__,
}  # fmt: skip
#: Modules and headers that are Robotran's, and not of MBsysPy itself, by how their names begin.
ADD_ONS = {
    "mbs_tgc": "tyres on the ground", "tgc_": "tyres on the ground", "mbs_rw": "wheels on rails",
    "mbs_car_tireGround": "tyres on the ground", "tireGroundCar": "tyres on the ground",
}  # fmt: skip


class _Present(threading.local):
    """The models whose user code runs in a thread: the functions below write to the last one."""

    def __init__(self) -> None:
        self.models: list[MbsData] = []


present = _Present()


def set_output(value: float, name: str) -> None:
    """Keep a number of the present time for the results."""
    present.models[-1].set_output(value, name)


def define_output_vector(name: str, size: int) -> None:
    """Outputs need no announcement here."""


def set_output_vector(values: Any, name: str) -> None:
    """Keep several numbers of the present time for the results."""
    present.models[-1].set_output_vector(values, name)


def matrix_vector_product(matrix: Any, vector: Any) -> Any:
    """The product of a matrix (n+1, m+1) and a vector (m+1), whose index 0 is not used."""
    return np.concatenate([[0.0], np.asarray(matrix)[1:, 1:] @ np.asarray(vector)[1:]])


def matrix_product(one: Any, other: Any) -> Any:
    """The product of two matrices whose index 0 is not used."""
    found = np.zeros((len(one), np.shape(other)[1]))
    found[1:, 1:] = np.asarray(one)[1:, 1:] @ np.asarray(other)[1:, 1:]
    return found


def transpose(matrix: Any) -> Any:
    """The transpose of a matrix."""
    return np.asarray(matrix).T


def vector_cross_product(one: Any, other: Any) -> Any:
    """The product (4) of two vectors (4), whose index 0 is not used."""
    return np.concatenate([[0.0], np.cross(np.asarray(one)[1:4], np.asarray(other)[1:4])])


matrix_matrix_product, cross_product = matrix_product, vector_cross_product


def describe_add_on(name: str) -> str | None:
    """Describe a module or a header of an add-on of Robotran's; None of others."""
    for start, what in ADD_ONS.items():
        if name.startswith(start):
            return f"it is of an add-on of Robotran's, for {what}, which is not here"
    return None


def run_script(script: str) -> None:
    """Run a project's own main.py, with this runtime in MBsysPy's place.

    An error of ours ends the program with its words.
    """
    file = Path(script).absolute()
    sys.modules.update({name: import_module(at) for name, at in MODULES.items()})
    sys.path[:0] = [str(file.parent), str(file.parent.parent / "userfctR")]
    sys.argv = [script, *sys.argv[2:]]
    try:
        runpy.run_path(str(file), run_name="__main__")
    except ConversionError as error:
        sys.exit(str(error))
    except ImportError as error:
        if what := describe_add_on(error.name or ""):
            sys.exit(f"{script}: {error}\n  {what}")
        raise
