"""The names of MBsysPy, as ``urdf2mbs.runtime`` offers them to user code."""

from urdf2mbs_simulate import names as mbs_utilities
from urdf2mbs_simulate.data import MbsSensor
from urdf2mbs_simulate.dirdyn import MbsDirdyn, MbsPart
from urdf2mbs_simulate.equilibrium import MbsEquil
from urdf2mbs_simulate.modal import MbsModal
from urdf2mbs_simulate.names import (
    define_output_vector,
    matrix_product,
    matrix_vector_product,
    set_output,
    set_output_vector,
    transpose,
    vector_cross_product,
)
from urdf2mbs_simulate.python_code import MbsData
from urdf2mbs_simulate.results import Results
from urdf2mbs_simulate.trajectory import MbsInvdyn, MbsSolvekin

__all__ = [
    "MbsData",
    "MbsDirdyn",
    "MbsEquil",
    "MbsInvdyn",
    "MbsModal",
    "MbsPart",
    "MbsSensor",
    "MbsSolvekin",
    "Results",
    "define_output_vector",
    "matrix_product",
    "matrix_vector_product",
    "mbs_utilities",
    "set_output",
    "set_output_vector",
    "transpose",
    "vector_cross_product",
]
