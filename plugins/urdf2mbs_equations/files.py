"""The files of ``symbolicR``: which there are, what each says of itself, and what it holds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from urdf2mbs.plugin import SENSOR_MEASURES, ConversionError, Diagnostic, Mbs, quoted
from urdf2mbs.plugin import MbsSensor as Sensor
from urdf2mbs_equations.accelerations import Massless, accelerations
from urdf2mbs_equations.c import CWriter
from urdf2mbs_equations.constraints import constant_gaps, constraints
from urdf2mbs_equations.derivatives import derivatives
from urdf2mbs_equations.dynamics import joint_forces, mass_matrix
from urdf2mbs_equations.energy import centre_of_mass, first_moment, kinetic
from urdf2mbs_equations.equations_fit import fingerprint
from urdf2mbs_equations.graph import Expr, Scalar
from urdf2mbs_equations.kinematics import Motion, motion
from urdf2mbs_equations.loads import extforces, links, links3d
from urdf2mbs_equations.matlab import MatlabWriter
from urdf2mbs_equations.mirror import find_mirrored
from urdf2mbs_equations.python import PythonWriter
from urdf2mbs_equations.regressor import regressor
from urdf2mbs_equations.routine import Absent, Cases, Count, Loops, Made, Refused, Routine
from urdf2mbs_equations.tree import Tree, is_fixed
from urdf2mbs_equations.writer import Writer

#: What is generated, by Robotran's names.
FUNCTIONS = (
    "dirdyna", "invdyna", "accelred", "invdynared", "cons_hJ", "cons_jdqd", "link", "link3D",
    "extforces", "sensor", "gensensor",
)  # fmt: skip
#: What Robotran has not, and is generated where it is asked for: what its file says of itself.
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
OWN = {**ENERGY, **DERIVATIVES}
WRITERS: dict[str, type[Writer]] = {"python": PythonWriter, "matlab": MatlabWriter}


@dataclass
class Equations:
    """The files of one model by name, and what was counted."""

    files: dict[str, bytes] = field(default_factory=dict)
    counts: dict[str, Count] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    """Functions that are not generated, and why."""
    fixed: list[tuple[int, str, float]] = field(default_factory=list)
    """Joints that never move: number, name, and the position (rad, m) taken for constant."""
    warnings: list[Diagnostic] = field(default_factory=list)


#: The first words of every file.
MARK = "Written by urdf2mbs from"
#: What to do about a cut that can never close.
NEVER_CLOSES = (
    "Robotran leaves this equation out and says nothing: let the ends of the cut be at one place"
)


def generate(
    mbs: Mbs,
    data: bytes,
    file: str,
    *,
    language: str = "python",
    fold: bool = False,
    pairs: bool = True,
    energy: bool = False,
    functions: Iterable[str] = FUNCTIONS,
    derivatives: bool = False,
) -> Equations:
    """Generate the equations of a model.

    ``data`` is the .mbs file and ``file`` its name, for the headers.  ``fold`` writes all
    constants as numbers; else masses, centres of mass, inertias and points are read from the
    data.  ``pairs`` lets C compute mirrored limbs together, which takes gcc or clang.  ``energy``
    also writes the functions ``energy``, ``momentum`` and ``com``.  ``functions`` are those that
    are wanted.  ``derivatives`` adds the derivatives of invdyna and its regressor.

    Raises ConversionError where the model's name is no identifier: it is part of the names.
    """
    if not mbs.name.isidentifier() or not mbs.name.isascii():
        raise ConversionError(
            "mbsname-no-identifier",
            f"the name of the model is '{mbs.name}', and the equations' files are called after it",
            file=file,
            hint="give it a name of letters, digits and '_' in <mbsname>",
        )
    out = Equations(
        fixed=[
            (number, joint.name, joint.q or 0.0)
            for number, joint in enumerate(mbs.joints().values(), start=1)
            if is_fixed(joint)
        ],
        warnings=[
            Diagnostic("warning", "loop-never-closes", message, file=file, hint=NEVER_CLOSES)
            for _, message in constant_gaps(mbs)
        ],
    )
    maker = Maker(mbs, fold=fold)
    writer = CWriter(mbs, pairs=pairs) if language == "c" else WRITERS[language](mbs)
    mark = f"{MARK} {quoted(Path(file).name)}. Do not edit: generate again."
    parts = "tree, numbers" if fold else "tree, fixed"
    head = [mark, f"Fits ({parts}): sha256 {fingerprint(data, parts)}"]
    more = (*(ENERGY if energy else ()), *(DERIVATIVES if derivatives else ()))
    for name in (*functions, *more):
        if name not in writer.lacks:
            made = _refuse_draft(mbs, name) or getattr(maker, name.lower())()
            _write(name, made, writer, head, out, fold=fold)
        elif name == "link3D" and writer.facts()["LINKS3D"]:
            out.left_out[name] = "how Robotran has it in this language is not known"
    return out


def _write(
    name: str, made: Made, writer: Writer, head: list[str], out: Equations, *, fold: bool
) -> None:
    """Add the file of one function; ``head`` are the first lines of all files."""
    if isinstance(made, Refused):
        out.left_out[name] = made.why
    writer.count = Count()
    text = writer.function(name, made)
    out.counts[name] = writer.count
    head = [
        *head,
        f"{name} of {writer.mbs.name}, {len(writer.mbs.numbers())} joints",
        *([OWN[name]] if name in OWN else []),
        *_remarks(made, writer.count, out.fixed, fold=fold),
    ]
    lines = "".join(f"{writer.comment} {line}".rstrip() + "\n" for line in head)
    out.files[f"mbs_{name}_{writer.mbs.name}.{writer.suffix}"] = (lines + "\n" + text).encode()


def _refuse_draft(mbs: Mbs, function: str) -> Refused | None:
    """The reason if a function needs a cut or a link that is a draft."""
    needs_cuts = function in ("cons_hJ", "cons_jdqd", "accelred", "invdynared")
    needed = mbs.cuts if needs_cuts else [link for link in mbs.links if link.kind == function]
    for connection in needed:
        if connection.is_draft:
            name = quoted(connection.name)
            why = f"{connection.kind} '{name}' is a draft: an end of it is on no body or no point"
            return Refused(why)
    return None


def _remarks(
    made: Made, count: Count, fixed: list[tuple[int, str, float]], *, fold: bool
) -> list[str]:
    """What the head of a file says of its function."""
    if isinstance(made, Refused):
        return [f"Not generated: {made.why}."]
    if isinstance(made, Absent):
        return [f"The model has no {made.what}: this is not to be called."]
    if isinstance(made, Loops):
        lines = ["Loops are closed by Newton's method; M, c and phi are other functions'."]
        if made.user:
            lines.append(
                "The user's constraints are asked of user_cons_hJ and user_cons_jdqd; "
                "user_cons_J_accelred is not called."
            )
        return lines
    lines = [
        f"{count.operations} operations: {count.products} products, {count.sums} sums, "
        f"{count.functions} functions, {count.divisions} divisions, {count.signs} signs"
    ]
    if count.paired:
        lines.append(f"{count.paired} of them are done two at a time, for two mirrored limbs.")
    if fold:
        lines.append("All constants are numbers: a change of the data has no effect.")
    else:
        lines.append(
            "What is zero in the .mbs, or a rounding of it, stays zero; other masses, centres, "
            "inertias and points are read from the data."
        )
    if fixed:
        lines.append("These joints never move, and their positions are numbers:")
        lines += [f"  {number} {quoted(joint)} at {q!r}" for number, joint, q in fixed]
    return lines


MASSLESS = Refused("no body has a mass")


class Maker:
    """The functions of one model, or why there is none."""

    def __init__(self, mbs: Mbs, *, fold: bool) -> None:
        self.mbs = mbs
        self.tree = partial(Tree, mbs, fold=fold)
        points = [point for body in mbs.bodies for point in body.points]
        self.has_points = any(point.sensor or point.extforce for point in points)

    def _mirrored(self) -> tuple[Tree, dict[int, int]]:
        """The tree with the axes of second limbs named as those of the first, and the twins."""
        twin, labels = find_mirrored(self.tree())
        return self.tree(labels=labels), twin

    def dirdyna(self) -> Routine:
        tree, twin = self._mirrored()
        c = joint_forces(tree, ())
        table = {("M", i, k): value for (i, k), value in mass_matrix(tree).items()}
        routine = _tables(tree, table, twin, symmetric=True)
        _store_forces(routine, "c", c, twin)
        return routine

    def invdyna(self) -> Routine:
        tree, twin = self._mirrored()
        routine = Routine(tree.graph)
        _store_forces(routine, "phi", joint_forces(tree, range(len(tree.frames))), twin)
        return routine

    def derivatives(self) -> Routine:
        tree, twin = self._mirrored()
        read = {
            (f"D{by}", row, column): value
            for (by, row, column), value in derivatives(tree).items()
            if isinstance(getattr(tree.frames[column], by), Expr)
        }
        return _tables(tree, read, twin)

    def regressor(self) -> Routine:
        tree = self.tree()
        return _tables(tree, {("Y", *key): value for key, value in regressor(tree).items()}, {})

    def accelred(self) -> Routine | Loops | Refused:
        tree = self.tree()
        dependent = any(f.joint.nature == "dependent" for f in tree.frames[1:])
        if self.mbs.cuts or dependent:
            return self.invdynared()
        try:
            qdd = accelerations(tree)
        except Massless as error:
            joint = quoted(str(error))
            return Refused(f"no matter moves with joint '{joint}', so nothing resists its forces")
        routine = Routine(tree.graph)
        for k, value in qdd.items():
            routine.store(f"s.qdd[{k}]", value)
        return routine

    def invdynared(self) -> Loops | Refused:
        tree = self.tree()
        numbers: dict[str, list[int]] = {"dependent": [], "independent": [], "driven": []}
        for frame in tree.frames[1:]:
            numbers[frame.joint.nature].append(frame.number)
        cuts, dependent = len(constraints(tree)), len(numbers["dependent"])
        if dependent < cuts:
            return Refused(
                f"the cuts make {cuts} equations, and {dependent} joints are dependent: "
                "it takes one joint for each equation"
            )
        return Loops(**numbers, cuts=cuts, user=dependent - cuts)

    def cons_hj(self) -> Routine | Absent:
        tree = self.tree()
        routine = Routine(tree.graph)
        for number, constraint in enumerate(constraints(tree), start=1):
            routine.store(f"h[{number}]", constraint.value)
            for k, value in constraint.jacobian.items():
                if value:
                    routine.store(f"Jac[{number}][{k}]", value)
        return routine if self.mbs.cuts else Absent("cuts")

    def cons_jdqd(self) -> Routine | Absent:
        tree = self.tree()
        jdqd = [constraint.jdqd for constraint in constraints(tree)]
        return Routine(tree.graph).fill("Jdqd", jdqd) if self.mbs.cuts else Absent("cuts")

    def link(self) -> Routine | Absent:
        return links(self.tree())

    def link3d(self) -> Routine | Absent:
        return links3d(self.tree())

    def extforces(self) -> Routine | Absent:
        return extforces(self.tree()) if self.has_points else Absent("external forces or sensors")

    def sensor(self) -> Cases | Absent:
        if not self.has_points:
            return Absent("sensors or external forces")
        routines: dict[int, Routine] = {}
        for body in self.mbs.bodies:
            for point in body.points:
                if point.sensor is not None:
                    tree = self.tree()
                    at = motion(tree, tree.last[body.name], tree.point(body.name, point.name))
                    routines[len(routines) + 1] = _sensor(tree, at, point.sensor)
        return routines

    def energy(self) -> Routine:
        tree = self.tree()
        potential = -(tree.gravity() @ first_moment(tree)[1])
        return Routine(tree.graph).fill("E", (kinetic(tree)[0], potential))

    def momentum(self) -> Routine | Refused:
        tree = self.tree()
        _, linear, angular = kinetic(tree)
        centre = centre_of_mass(tree)
        if centre is None:
            return MASSLESS
        return Routine(tree.graph).fill("P", linear).fill("L", angular - centre.cross(linear))

    def com(self) -> Routine | Refused:
        tree = self.tree()
        centre = centre_of_mass(tree)
        return MASSLESS if centre is None else Routine(tree.graph).fill("P", centre)

    def gensensor(self) -> Cases:
        every = Sensor("", tuple(sorted(SENSOR_MEASURES)))
        tree = self.tree()
        numbers = range(1, len(tree.frames))
        return {k: _sensor(tree, motion(tree, k), every) for k in numbers}


def _store_forces(routine: Routine, name: str, values: list[Scalar], twin: dict[int, int]) -> None:
    for k in range(len(values) - 1, 0, -1):
        routine.store(f"{name}[{k}]", values[k])
    for k, j in twin.items():
        if k < j:
            routine.mirror(values[k], values[j])


def _tables(
    tree: Tree,
    values: dict[tuple[str, int, int], Scalar],
    twin: dict[int, int],
    *,
    symmetric: bool = False,
) -> Routine:
    """A routine that stores elements of tables by name, row and column, twins next to each
    other."""
    routine = Routine(tree.graph)
    twins = {(name, i, k): (name, twin.get(i, i), twin.get(k, k)) for name, i, k in values}
    for key in dict.fromkeys(key for pair in twins.items() for key in pair if key in values):
        name, i, k = key
        more = [f"{name}[{k}][{i}]"] if symmetric and i != k else []
        routine.store(f"{name}[{i}][{k}]", values[key], *more)
        if twins[key] in values and (k, i) < twins[key][:0:-1]:
            routine.mirror(values[key], values[twins[key]])
    return routine


def _sensor(tree: Tree, at: Motion, sensor: Sensor) -> Routine:
    routine = Routine(tree.graph)
    for name, place, value in at.measured(sensor.measures):
        routine.store(f"sens.{name}{place}", value)
    if "Jac" in sensor.measures:
        for first, columns in ((1, at.linear), (4, at.angular)):
            for joint, column in columns.items():
                for row, value in enumerate(column, start=first):
                    if value:
                        routine.store(f"sens.J[{row}][{joint}]", value)
    return routine
