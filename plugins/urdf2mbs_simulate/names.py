"""Functions of MBsysPy beside its classes: outputs, and products of arrays that count from 1."""

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

#: The modules of this runtime that replace those of MBsysPy.
MODULES = {
    "MBsysPy": "urdf2mbs_simulate.runtime",
    "MBsysPy.mbs_utilities": __name__,
    "MBsysPy.mbsyspy.mbs_sensor": "urdf2mbs_simulate.runtime",
    "MBsysPy.mbsyspy.utilities.algebra": __name__,
}
#: Add-ons of Robotran, which MBsysPy lacks, too: how the names of their modules and headers begin.
ADD_ONS = {
    "mbs_tgc": "tyres on the ground",
    "tgc_": "tyres on the ground",
    "mbs_rw": "wheels on rails",
    "mbs_car_tireGround": "tyres on the ground",
    "tireGroundCar": "tyres on the ground",
}


class _ActiveModels(threading.local):
    """The models whose user code runs in this thread, the innermost last.

    MBsysPy's ``set_output`` has no argument that names its model: it is the last of these.
    """

    def __init__(self) -> None:
        self.models: list[MbsData] = []


active = _ActiveModels()


def set_output(value: float, name: str) -> None:
    """Record a number of the present time for the results."""
    active.models[-1].set_output(value, name)


def define_output_vector(name: str, size: int) -> None:
    """Do nothing: outputs need no announcement here."""


def set_output_vector(values: Any, name: str) -> None:
    """Record several numbers of the present time for the results."""
    active.models[-1].set_output_vector(values, name)


def matrix_vector_product(matrix: Any, vector: Any) -> Any:
    """Return the product (n+1) of a matrix (n+1, m+1) and a vector (m+1); index 0 is not used."""
    return np.concatenate([[0.0], np.asarray(matrix)[1:, 1:] @ np.asarray(vector)[1:]])


def matrix_product(left: Any, right: Any) -> Any:
    """Return the product of two matrices whose index 0 is not used."""
    product = np.zeros((len(left), np.shape(right)[1]))
    product[1:, 1:] = np.asarray(left)[1:, 1:] @ np.asarray(right)[1:, 1:]
    return product


def transpose(matrix: Any) -> Any:
    """Return the transpose of a matrix."""
    return np.asarray(matrix).T


def vector_cross_product(left: Any, right: Any) -> Any:
    """Return the cross product (4) of two vectors (4), whose index 0 is not used."""
    return np.concatenate([[0.0], np.cross(np.asarray(left)[1:4], np.asarray(right)[1:4])])


matrix_matrix_product, cross_product = matrix_product, vector_cross_product


def describe_add_on(name: str) -> str | None:
    """Describe the add-on of Robotran that a module or header belongs to.

    Args:
        name: The name of the module or header.

    Returns:
        A clause for an error message; None if the file belongs to no add-on.
    """
    for prefix, subject in ADD_ONS.items():
        if name.startswith(prefix):
            return f"it belongs to an add-on of Robotran, for {subject}, which is not available"
    return None


def run_script(script: str) -> None:
    """Run a project's own main.py, with this runtime in place of MBsysPy.

    Args:
        script: The path of the script.

    Raises:
        SystemExit: The simulation failed; its message is that of the error.
    """
    file = Path(script).absolute()
    sys.modules.update({name: import_module(module) for name, module in MODULES.items()})
    sys.path[:0] = [str(file.parent), str(file.parent.parent / "userfctR")]
    sys.argv = [script, *sys.argv[2:]]
    try:
        runpy.run_path(str(file), run_name="__main__")
    except ConversionError as error:
        sys.exit(str(error))
    except ImportError as error:
        if add_on := describe_add_on(error.name or ""):
            sys.exit(f"{script}: {error}\n  {add_on}")
        raise
