"""Functions of the equations that Python calls, in C (``calls.c``): their buffers are made once."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np

from urdf2mbs_simulate.compiler import HERE, Source, compile_library, list_header_folders
from urdf2mbs_simulate.equations import find_equations
from urdf2mbs_simulate.joint_selection import JointSelection, make_singular_error
from urdf2mbs_simulate.memory import (
    CallInC,
    CouplingInC,
    JointRunInC,
    SharedData,
    as_c_integers,
    as_c_table,
    as_c_vector,
)
from urdf2mbs_simulate.python_code import MbsData

DOUBLE = np.dtype(float)
#: The number of the caller's joints, and that of the parameters of all bodies, in a shape.
JOINTS, PARAMETERS = -1, -2


class Signature(NamedTuple):
    """What a function of ``calls.c`` takes and returns."""

    equations: tuple[str, ...]
    """The functions of the equations that it calls."""
    shape: tuple[int, ...]
    """Of an output."""
    n_outputs: int = 1


_SQUARE = (JOINTS, JOINTS)
#: The functions by their names in Python; ``calls.c`` has them in capitals.
SIGNATURES = {
    "mass_matrix": Signature(("dirdyna",), _SQUARE),
    "bias": Signature(("invdyna",), (JOINTS,)),
    "inverse_dynamics": Signature(("invdyna",), (JOINTS,)),
    "inverse_derivatives": Signature(("derivatives",), _SQUARE, 3),
    "forward_dynamics": Signature(("dirdyna",), (JOINTS,)),
    "forward_derivatives": Signature(("dirdyna", "derivatives"), _SQUARE, 3),
    "regressor": Signature(("regressor",), (JOINTS, PARAMETERS)),
    "energy": Signature(("energy",), (2,)),
    "centre_of_mass": Signature(("com",), (3,)),
    "momentum": Signature(("momentum",), (6,)),
    "position": Signature(("gensensor",), (3,)),
    "jacobian": Signature(("gensensor",), (6, JOINTS)),
}


class EquationsInC:
    """The equations of a model in C; a function is compiled when it is first called."""

    def __init__(self, data: MbsData, selection: JointSelection) -> None:
        self.data, self.selection = data, selection
        self.shared_data = SharedData(data)
        self.functions: dict[Any, Function] = {}

    def evaluate(self, name: str, *state: Any) -> Any:
        """Return the output of a function of ``SIGNATURES`` for one state, or for many.

        Args:
            name: The function.
            *state: q, qd, and qdd or tau, each (joints) or (states, joints); those left out are 0.

        Returns:
            An array, or a tuple of several; of many states, the states come first.

        Raises:
            ValueError: An argument does not have a number for each joint.
            TypeError: They are not real numbers.
            LinAlgError: The mass matrix is singular.
        """
        function = self.functions.get(name)
        if function is None:
            function = self.functions[name] = Function(self, name)
        return function(*state)

    def evaluate_place(self, name: str, place: int, point: int, q: Any) -> Any:
        """Return the ``position`` or the ``jacobian`` of a point.

        Args:
            name: The function.
            place: The number of the last joint of the body.
            point: The number of the point; 0 is the origin of the body.
            q: As in ``evaluate``.
        """
        key = name, place, point
        function = self.functions.get(key)
        if function is None:
            function = self.functions[key] = Function(self, name)
            function.call.place, function.call.point = place, point
        return function(q)


class Function:
    """A function of the equations in C, with the memory of its arguments and results."""

    def __init__(self, equations: EquationsInC, name: str) -> None:
        """Compile a function.

        Raises:
            ConversionError: The equations cannot be made, or do not compile.
        """
        self.name, self.selection = name, equations.selection
        signature = SIGNATURES[name]
        self.entry = _load_function(equations.data, name, signature)
        n_joints, n_parameters = self.selection.n_joints, 10 * len(equations.data.body_id)
        sizes = {JOINTS: n_joints, PARAMETERS: n_parameters}
        self.shape = tuple(sizes.get(length, length) for length in signature.shape)
        self.joint_shape = (n_joints,)
        self.outputs = list(np.zeros((signature.n_outputs, *self.shape)))
        self.inputs = list(np.zeros((3, n_joints)))
        self.arrays: list[Any] = [equations.shared_data]
        """Kept alive while C works on them."""
        self.call = self._make_call(equations, n_parameters)
        _set_states(self.call, self.inputs, self.outputs, 1)
        self.address = ctypes.addressof(self.call)
        self.is_single, self.output = signature.n_outputs == 1, self.outputs[0]

    def _make_call(self, equations: EquationsInC, n_parameters: int) -> CallInC:
        """Return the struct of C, without inputs and outputs."""
        selection, data = self.selection, equations.data
        n_all, n = data.njoint, selection.n_joints
        couplings = [
            CouplingInC(follower.joint, leader, factor)
            for follower in selection.followers
            for leader, factor in follower.factors.items()
        ]
        width = max(n_all, n_parameters if self.name == "regressor" else 0) + 1
        tables, matrices = np.zeros((3, max(n_all + 1, 7), width)), np.zeros((3, n, n))
        rows = [as_c_table(table) for table in tables]
        coupling_array = (CouplingInC * len(couplings))(*couplings)
        runs = [JointRunInC(*run) for run in _list_runs(selection.numbers)]
        run_array = (JointRunInC * len(runs))(*runs)
        independent = as_c_integers(selection.independent)
        vectors = {
            "q0": selection.q0,
            "zeros": np.zeros(n_all + 1),
            "vector": np.zeros(n_all + 1),
            "bias": np.zeros(n),
            "factors": np.zeros(n * n),
            "columns": np.zeros(3 * n * n),
        }
        self.arrays += [tables, matrices, rows, coupling_array, run_array, independent, vectors]
        return CallInC(
            s=ctypes.pointer(equations.shared_data.struct),
            n_all=n_all,
            n=n,
            n_runs=len(runs),
            run=run_array,
            n_couplings=len(couplings),
            coupling=coupling_array,
            n_independent=len(independent),
            independent=independent,
            n_parameters=n_parameters,
            n_numbers=int(np.prod(self.shape)),
            table=tuple(map(_as_pointer, rows)),
            matrix=tuple(map(as_c_vector, matrices)),
            **{name: as_c_vector(vector) for name, vector in vectors.items()},
        )

    def __call__(self, *state: Any) -> Any:
        """Return the outputs for one state or many, see ``EquationsInC.evaluate``."""
        for memory, values in zip(self.inputs, state):  # noqa: B905  those left out stay zeros
            if (
                type(values) is not np.ndarray
                or values.shape != self.joint_shape
                or values.dtype is not DOUBLE
            ):
                return self._call_checked(state)
            memory[...] = values
        if self.entry(self.address):
            self._raise_singular(self.call)
        if self.is_single:
            return self.output.copy()
        return tuple(output.copy() for output in self.outputs)

    def _call_checked(self, state: Sequence[Any]) -> Any:
        """Return the outputs for arguments that are not what ``__call__`` expects."""
        states = self.selection.check_states(self.name, state)
        if states[0].ndim == 1:
            return self(*states)
        n_states = len(states[0])
        outputs = [np.empty((n_states, *self.shape)) for _ in self.outputs]
        call = CallInC.from_buffer_copy(self.call)
        _set_states(call, states, outputs, n_states)
        if self.entry(ctypes.addressof(call)):
            self._raise_singular(call)
        return outputs[0] if self.is_single else tuple(outputs)

    def _raise_singular(self, call: CallInC) -> NoReturn:
        raise make_singular_error(self.selection.names[call.singular])


def _set_states(call: CallInC, inputs: Any, outputs: Any, n_states: int) -> None:
    """Let a call read inputs (states, joints), and fill outputs (outputs, states, ...)."""
    call.n_states = n_states
    for k in range(len(call.input)):
        call.input[k] = as_c_vector(inputs[k]) if k < len(inputs) else None
    for k, values in enumerate(outputs):
        call.output[k] = as_c_vector(values)


def _list_runs(numbers: Any) -> list[tuple[int, int, int]]:
    """Return an index, the number there, and the length of each run of consecutive numbers."""
    breaks = np.flatnonzero(np.diff(numbers, prepend=-1) != 1).tolist()
    ends = [*breaks[1:], len(numbers)]
    return [
        (start, int(numbers[start]), end - start) for start, end in zip(breaks, ends, strict=False)
    ]


def _as_pointer(rows: Any) -> Any:
    return ctypes.cast(rows, ctypes.POINTER(ctypes.POINTER(ctypes.c_double)))


def _load_function(data: MbsData, name: str, signature: Signature) -> Any:
    """Return a function of ``calls.c``, compiled with the equations that it calls."""
    folders = list_header_folders(data.user_path, data.symbolic_path)
    files = find_equations(data, signature.equations, "c").values()
    sources = [Source(file, folders) for file in files]
    caller = Source(
        HERE / "calls.c",
        folders,
        ("-O3", "-fno-tree-loop-distribute-patterns", f"-D{name.upper()}"),
    )
    entry = compile_library([*sources, caller]).evaluate
    entry.argtypes = [ctypes.c_void_p]
    return entry
