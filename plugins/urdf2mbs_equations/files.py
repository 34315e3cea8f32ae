"""The files of ``symbolicR``: their names and their heads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from urdf2mbs.plugin import ConversionError, Diagnostic, Mbs, quoted
from urdf2mbs_equations.c import CWriter
from urdf2mbs_equations.constraints import find_constant_gaps
from urdf2mbs_equations.contents import ContentMaker
from urdf2mbs_equations.equations_fit import fingerprint
from urdf2mbs_equations.followers import Follower
from urdf2mbs_equations.latex import write_document
from urdf2mbs_equations.latex_recursion import write_recursion
from urdf2mbs_equations.matlab import MatlabWriter
from urdf2mbs_equations.matlab_data import write_data, write_example
from urdf2mbs_equations.options import EquationOptions
from urdf2mbs_equations.plain_text import list_formulas, list_symbols
from urdf2mbs_equations.python import PythonWriter
from urdf2mbs_equations.routine import (
    Absent,
    Content,
    Loops,
    OperationCount,
    Refused,
)
from urdf2mbs_equations.symbolic import NoFormulasError, make_symbolic_equations
from urdf2mbs_equations.tree import is_fixed
from urdf2mbs_equations.writer import Writer

#: The functions of Robotran.
FUNCTIONS = (
    "dirdyna",
    "invdyna",
    "accelred",
    "invdynared",
    "cons_hJ",
    "cons_jdqd",
    "link",
    "link3D",
    "extforces",
    "sensor",
    "gensensor",
)
#: Functions that Robotran does not have, by option: the sentence about each in its file.
ENERGY = {
    "energy": "E[1] is the kinetic energy, E[2] that of gravity, 0 at the base's origin (J).",
    "momentum": "P is the linear momentum (kg m/s), L the angular one about the centre of mass "
    "(kg m^2/s), in the base's axes.",
    "com": "P is the centre of mass (m), in the base's axes.",
}
DERIVATIVES = {
    "derivatives": "Dq[i][k], Dqd[i][k] and Dqdd[i][k] are the derivatives of phi[i] of invdyna by "
    "q[k], qd[k] and qdd[k].",
    "regressor": "The sum of Y[i][k] times parameter k is phi[i] of invdyna, without frc and trq. "
    "Each body has ten, in the order of the .mbs: mass, first moments x, y, z (kg m), inertia xx, "
    "xy, xz, yy, yz, zz about its origin (kg m^2).",
}
ADDITIONAL_FUNCTIONS = {**ENERGY, **DERIVATIVES}

#: The first words of every file.
MARK = "Written by urdf2mbs from"
#: The remedy for a cut that can never close.
NEVER_CLOSES = (
    "Robotran leaves this equation out and says nothing: let the ends of the cut be at one place"
)


class FixedJoint(NamedTuple):
    """A joint that never moves, and its position, which is a number in the equations."""

    number: int
    name: str
    q: float
    """rad or m."""


@dataclass
class Equations:
    """The files of one model."""

    files: dict[str, bytes] = field(default_factory=dict)
    """By name."""
    counts: dict[str, OperationCount] = field(default_factory=dict)
    """By function, the number of its operations."""
    left_out: dict[str, str] = field(default_factory=dict)
    """By function, the reason why it is not generated."""
    formulas: dict[str, str] = field(default_factory=dict)
    """Of M, c and g in LaTeX: each element in plain text."""
    symbols: dict[str, str] = field(default_factory=dict)
    """What each symbol of the formulas is, with its number and unit."""
    fixed: list[FixedJoint] = field(default_factory=list)
    followers: list[str] = field(default_factory=list)
    """The joints that are known to follow others."""
    warnings: list[Diagnostic] = field(default_factory=list)


def generate(
    mbs: Mbs,
    data: bytes,
    file: str,
    options: EquationOptions,
    functions: Iterable[str] = FUNCTIONS,
    *,
    followers: Sequence[Follower] = (),
) -> Equations:
    """Generate the equations of a model in one language.

    Args:
        mbs: The model.
        data: The .mbs file, for the checksum in the heads.
        file: The name of the .mbs file, for heads and messages.
        options: The options; the language is ``python``, ``c`` or ``matlab``.
        functions: The functions of Robotran to generate.
        followers: Joints that follow others.  Formulas are those of the joints that lead; C and
            MATLAB get what reduces M, c and other results to these.

    Raises:
        ConversionError: The name of the model is not an identifier, which Robotran needs.
    """
    if not mbs.name.isidentifier() or not mbs.name.isascii():
        raise ConversionError(
            "mbsname-no-identifier",
            f"the name of the model is '{mbs.name}'; expected an identifier, since the functions "
            "of the equations are named after it",
            file=file,
            hint="give it a name of letters, digits and '_' in <mbsname>",
        )
    equations = Equations(
        fixed=[
            FixedJoint(number, joint.name, joint.q or 0.0)
            for number, joint in enumerate(mbs.joints().values(), start=1)
            if is_fixed(joint)
        ],
        warnings=[
            Diagnostic("warning", "loop-never-closes", message, file=file, hint=NEVER_CLOSES)
            for _, message in find_constant_gaps(mbs)
        ],
    )
    names = [*functions]
    names += ENERGY if options.energy else ()
    names += DERIVATIVES if options.derivatives else ()
    if options.language == "latex":
        _write_latex(mbs, data, file, equations, followers)
        return equations
    file_writer = _FileWriter(mbs, data, file, options, equations)
    for name in names:
        file_writer.write(name)
    if options.language == "matlab":
        file_writer.write_matlab_data(data, followers)
    if isinstance(file_writer.writer, CWriter) and followers:
        file_writer.write_followers(file_writer.writer, followers)
    return equations


def _write_latex(
    mbs: Mbs, data: bytes, file: str, equations: Equations, followers: Sequence[Follower]
) -> None:
    """Write formulas of M, c and g; of larger robots, the recursion that computes them."""
    try:
        symbolic = make_symbolic_equations(mbs, followers)
        text = write_document(symbolic)
        equations.formulas, equations.symbols = list_formulas(symbolic), list_symbols(symbolic)
    except NoFormulasError as error:
        equations.left_out["formulas"] = f"{error}; the file has the recursion of Newton and Euler"
        text = write_recursion(mbs, followers)
    checksum = f"Fits (tree, numbers): sha256 {fingerprint(data, 'tree, numbers')}"
    head = f"% {MARK} {quoted(Path(file).name)}. Do not edit: generate again.\n% {checksum}\n\n"
    equations.files[f"{mbs.name}_equations.tex"] = f"{head}{text}".encode()


def _make_writer(mbs: Mbs, options: EquationOptions) -> Writer:
    if options.language == "c":
        return CWriter(mbs, pairs=options.pairs)
    return {"python": PythonWriter, "matlab": MatlabWriter}[options.language or ""](mbs)


class _FileWriter:
    """Writes the files of one model, in one language, to an ``Equations``."""

    def __init__(
        self, mbs: Mbs, data: bytes, file: str, options: EquationOptions, equations: Equations
    ) -> None:
        self.mbs, self.options, self.equations = mbs, options, equations
        self.writer = _make_writer(mbs, options)
        self.maker = ContentMaker(mbs, fold=options.fold)
        parts = "tree, numbers" if options.fold else "tree, fixed"
        self.head = [
            f"{MARK} {quoted(Path(file).name)}. Do not edit: generate again.",
            f"Fits ({parts}): sha256 {fingerprint(data, parts)}",
        ]
        """The first lines of all files."""

    def write(self, name: str) -> None:
        """Write the file of one function."""
        writer, equations = self.writer, self.equations
        if name in writer.missing_functions:
            if name == "link3D" and writer.find_features()["LINKS3D"]:
                equations.left_out[name] = "how Robotran has it in this language is not known"
            return
        content = self.maker.make(name)
        if isinstance(content, Refused):
            equations.left_out[name] = content.reason
        writer.count = OperationCount()
        text = writer.write_function(name, content)
        equations.counts[name] = writer.count
        head = [
            *self.head,
            f"{name} of {self.mbs.name}, {len(self.mbs.numbers())} joints",
            *([ADDITIONAL_FUNCTIONS[name]] if name in ADDITIONAL_FUNCTIONS else []),
            *self._describe(content),
        ]
        lines = "".join(f"{writer.comment} {line}".rstrip() + "\n" for line in head)
        file = f"mbs_{name}_{self.mbs.name}.{writer.suffix}"
        equations.files[file] = f"{lines}\n{text}".encode()

    def write_followers(self, writer: CWriter, followers: Sequence[Follower]) -> None:
        """Write what moves followers, and reduces M, c and other results to their leaders."""
        head = (
            *self.head,
            f"followers of {self.mbs.name}, {len(self.mbs.numbers())} joints",
            "They follow others by <mimic>. q = T q + offset, where columns of followers are zero:",
            "  mbs_followers(s);         q, qd and qdd of followers",
            "  mbs_dirdyna(M, c, s, t);",
            "  mbs_reduce_matrix(M);     M = T' M T",
            "  mbs_reduce_vector(c);     c = T' c",
        )
        lines = "".join(f"// {line}\n" for line in head)
        file = f"mbs_followers_{self.mbs.name}.c"
        self.equations.files[file] = f"{lines}\n{writer.write_followers(followers)}".encode()

    def write_matlab_data(self, data: bytes, followers: Sequence[Follower]) -> None:
        """Write the data of the .mbs, which must fit its numbers, and an example."""
        checksum = f"Fits (tree, numbers): sha256 {fingerprint(data, 'tree, numbers')}"
        name, (mark, fits) = self.mbs.name, self.head
        for file, lines, text in (
            (f"{name}_data.m", (mark, checksum), write_data(self.mbs, followers)),
            (f"{name}_example.m", (mark, fits), write_example(self.mbs, followers)),
        ):
            head = "".join(f"% {line}\n" for line in lines)
            self.equations.files[file] = f"{head}\n{text}".encode()

    def _describe(self, content: Content) -> list[str]:
        """Return what the head of a file says about its function."""
        if isinstance(content, Refused):
            return [f"Not generated: {content.reason}."]
        if isinstance(content, Absent):
            return [f"The model has no {content.feature}: this is not to be called."]
        if isinstance(content, Loops):
            return _describe_loops(content)
        return [
            *_describe_count(self.writer.count),
            _describe_constants(fold=self.options.fold),
            *_describe_fixed_joints(self.equations.fixed),
        ]


def _describe_loops(loops: Loops) -> list[str]:
    lines = ["Loops are closed by Newton's method; M, c and phi are other functions'."]
    if loops.n_user_rows:
        lines.append(
            "The user's constraints are asked of user_cons_hJ and user_cons_jdqd; "
            "user_cons_J_accelred is not called."
        )
    return lines


def _describe_count(count: OperationCount) -> list[str]:
    lines = [
        f"{count.operations} operations: {count.products} products, {count.sums} sums, "
        f"{count.functions} functions, {count.divisions} divisions, {count.signs} signs"
    ]
    if count.paired:
        lines.append(f"{count.paired} of them are done two at a time, for two mirrored limbs.")
    return lines


def _describe_constants(*, fold: bool) -> str:
    if fold:
        return "All constants are numbers: a change of the data has no effect."
    return (
        "What is zero in the .mbs, or a rounding of it, stays zero; other masses, centres, "
        "inertias and points are read from the data."
    )


def _describe_fixed_joints(fixed: list[FixedJoint]) -> list[str]:
    if not fixed:
        return []
    return [
        "These joints never move, and their positions are numbers:",
        *(f"  {joint.number} {quoted(joint.name)} at {joint.q!r}" for joint in fixed),
    ]
