"""The content of each function of ``symbolicR`` for one model, by Robotran's names."""

from __future__ import annotations

from functools import partial

from urdf2mbs.plugin import SENSOR_MEASURES, Mbs, quoted
from urdf2mbs.plugin import MbsSensor as Sensor
from urdf2mbs_equations.accelerations import MasslessJointError, compute_accelerations
from urdf2mbs_equations.constraints import list_constraints
from urdf2mbs_equations.derivatives import compute_derivatives
from urdf2mbs_equations.dynamics import compute_joint_forces, compute_mass_matrix
from urdf2mbs_equations.energy import (
    compute_centre_of_mass,
    compute_first_moment,
    compute_kinetic_state,
)
from urdf2mbs_equations.graph import Expr, Scalar
from urdf2mbs_equations.kinematics import AnchorPoint, Motion, compute_motion
from urdf2mbs_equations.loads import make_external_forces, make_links, make_links_3d
from urdf2mbs_equations.pairs import find_mirrored
from urdf2mbs_equations.regressor import compute_regressor
from urdf2mbs_equations.routine import Absent, Cases, Content, Loops, Refused, Routine
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import ZERO_VECTOR

MASSLESS = Refused("no body has a mass")


class ContentMaker:
    """Makes the content of the functions of one model; ``make_X`` is the function X."""

    def __init__(self, mbs: Mbs, *, fold: bool) -> None:
        self.mbs = mbs
        self.make_tree = partial(Tree, mbs, fold=fold)
        points = [point for body in mbs.bodies for point in body.points]
        self.has_points = any(point.sensor or point.extforce for point in points)

    def make(self, name: str) -> Content:
        """Return the content of a function, or the reason why there is none."""
        refused = _refuse_draft(self.mbs, name)
        if refused is not None:
            return refused
        content: Content = getattr(self, f"make_{name.lower()}")()
        return content

    def _make_mirrored_tree(self) -> tuple[Tree, dict[int, int]]:
        """Return a tree whose mirrored limbs have the same axes, and the twin of each joint."""
        mirrored = find_mirrored(self.make_tree())
        return self.make_tree(axes_in_file=mirrored.axes_in_file), mirrored.twin

    def make_dirdyna(self) -> Routine:
        """Make M and c of the equations of motion ``M qdd + c = Qq``."""
        tree, twin = self._make_mirrored_tree()
        c = compute_joint_forces(tree, ())
        elements = {("M", i, k): value for (i, k), value in compute_mass_matrix(tree).items()}
        routine = _store_matrices(tree, elements, twin, symmetric=True)
        _store_forces(routine, "c", c, twin)
        return routine

    def make_invdyna(self) -> Routine:
        """Make the joint forces that q, qd and qdd require."""
        tree, twin = self._make_mirrored_tree()
        routine = Routine(tree.graph)
        forces = compute_joint_forces(tree, range(len(tree.frames)))
        _store_forces(routine, "phi", forces, twin)
        return routine

    def make_derivatives(self) -> Routine:
        """Make the derivatives of invdyna by q, qd and qdd; what is not a symbol has none."""
        tree, twin = self._make_mirrored_tree()
        elements = {
            (f"D{variable}", row, column): value
            for (variable, row, column), value in compute_derivatives(tree).items()
            if isinstance(getattr(tree.frames[column], variable), Expr)
        }
        return _store_matrices(tree, elements, twin)

    def make_regressor(self) -> Routine:
        """Make the regressor of invdyna by the inertial parameters."""
        tree = self.make_tree()
        elements = {("Y", *key): value for key, value in compute_regressor(tree).items()}
        return _store_matrices(tree, elements, {})

    def make_accelred(self) -> Routine | Loops | Refused:
        """Make the accelerations: as equations for a tree, else by the template for loops."""
        tree = self.make_tree()
        has_dependent = any(frame.joint.nature == "dependent" for frame in tree.frames[1:])
        if self.mbs.cuts or has_dependent:
            return self.make_invdynared()
        try:
            qdd = compute_accelerations(tree)
        except MasslessJointError as error:
            joint = quoted(str(error))
            return Refused(f"no matter moves with joint '{joint}', so nothing resists its forces")
        routine = Routine(tree.graph)
        for k, value in qdd.items():
            routine.store(f"s.qdd[{k}]", value)
        return routine

    def make_invdynared(self) -> Loops | Refused:
        """Make the partition and the numbers of constraints, for the template for loops."""
        tree = self.make_tree()
        numbers: dict[str, list[int]] = {"dependent": [], "independent": [], "driven": []}
        for frame in tree.frames[1:]:
            numbers[frame.joint.nature].append(frame.number)
        n_cut_rows, n_dependent = len(list_constraints(tree)), len(numbers["dependent"])
        if n_dependent < n_cut_rows:
            return Refused(
                f"the cuts make {n_cut_rows} equations, and {n_dependent} joints are dependent: "
                "it takes one joint for each equation"
            )
        return Loops(**numbers, n_cut_rows=n_cut_rows, n_user_rows=n_dependent - n_cut_rows)

    def make_cons_hj(self) -> Routine | Absent:
        """Make the constraints of all cuts, and their Jacobian."""
        if not self.mbs.cuts:
            return Absent("cuts")
        tree = self.make_tree()
        routine = Routine(tree.graph)
        for row, constraint in enumerate(list_constraints(tree), start=1):
            routine.store(f"h[{row}]", constraint.value)
            for k, value in constraint.jacobian.items():
                if value:
                    routine.store(f"Jac[{row}][{k}]", value)
        return routine

    def make_cons_jdqd(self) -> Routine | Absent:
        """Make the second derivatives of the constraints for qdd = 0."""
        if not self.mbs.cuts:
            return Absent("cuts")
        tree = self.make_tree()
        jdqd = [constraint.jdqd for constraint in list_constraints(tree)]
        return Routine(tree.graph).fill("Jdqd", jdqd)

    def make_link(self) -> Routine | Absent:
        """Make the forces of all links."""
        return make_links(self.make_tree())

    def make_link3d(self) -> Routine | Absent:
        """Make the forces of all 3D links."""
        return make_links_3d(self.make_tree())

    def make_extforces(self) -> Routine | Absent:
        """Make all external forces."""
        if not self.has_points:
            return Absent("external forces or sensors")
        return make_external_forces(self.make_tree())

    def make_sensor(self) -> Cases | Absent:
        """Make the motion of each sensor."""
        if not self.has_points:
            return Absent("sensors or external forces")
        routines: dict[int, Routine] = {}
        for body in self.mbs.bodies:
            for point in body.points:
                if point.sensor is not None:
                    tree = self.make_tree()
                    position = tree.get_point(body.name, point.name)
                    anchor = AnchorPoint(tree.last_joint[body.name], position)
                    motion = compute_motion(tree, anchor)
                    routines[len(routines) + 1] = _store_sensor(tree, motion, point.sensor)
        return routines

    def make_gensensor(self) -> Cases:
        """Make the motion of the frame of each joint."""
        sensor = Sensor("", tuple(sorted(SENSOR_MEASURES)))
        tree = self.make_tree()
        return {
            k: _store_sensor(tree, compute_motion(tree, AnchorPoint(k, ZERO_VECTOR)), sensor)
            for k in range(1, len(tree.frames))
        }

    def make_energy(self) -> Routine:
        """Make the kinetic energy, and the potential energy of gravity."""
        tree = self.make_tree()
        gravity = tree.get_gravity()
        _, first_moment = compute_first_moment(tree)
        potential_energy = -(gravity @ first_moment)
        kinetic_energy = compute_kinetic_state(tree).energy
        return Routine(tree.graph).fill("E", (kinetic_energy, potential_energy))

    def make_momentum(self) -> Routine | Refused:
        """Make the linear momentum, and the angular momentum about the centre of mass."""
        tree = self.make_tree()
        state, centre = compute_kinetic_state(tree), compute_centre_of_mass(tree)
        if centre is None:
            return MASSLESS
        angular = state.angular_momentum - centre.cross(state.linear_momentum)
        return Routine(tree.graph).fill("P", state.linear_momentum).fill("L", angular)

    def make_com(self) -> Routine | Refused:
        """Make the centre of mass of the model."""
        tree = self.make_tree()
        centre = compute_centre_of_mass(tree)
        return MASSLESS if centre is None else Routine(tree.graph).fill("P", centre)


def _store_forces(routine: Routine, array: str, values: list[Scalar], twin: dict[int, int]) -> None:
    """Store the forces of all joints in an array."""
    for k in range(len(values) - 1, 0, -1):
        routine.store(f"{array}[{k}]", values[k])
    for k, counterpart in twin.items():
        if k < counterpart:
            routine.mark_mirrored(values[k], values[counterpart])


def _store_matrices(
    tree: Tree,
    elements: dict[tuple[str, int, int], Scalar],
    twin: dict[int, int],
    *,
    symmetric: bool = False,
) -> Routine:
    """Return a routine that stores elements of matrices.

    Args:
        tree: The model.
        elements: By array, row and column.
        twin: The mirrored joints: their elements follow each other.
        symmetric: Store each element also at the transposed place.
    """
    routine = Routine(tree.graph)
    twins = {(name, i, k): (name, twin.get(i, i), twin.get(k, k)) for name, i, k in elements}
    sorted_keys = dict.fromkeys(key for pair in twins.items() for key in pair if key in elements)
    for key in sorted_keys:
        name, i, k = key
        transposed = [f"{name}[{k}][{i}]"] if symmetric and i != k else []
        routine.store(f"{name}[{i}][{k}]", elements[key], *transposed)
        _, twin_i, twin_k = twins[key]
        if twins[key] in elements and (k, i) < (twin_k, twin_i):
            routine.mark_mirrored(elements[key], elements[twins[key]])
    return routine


def _store_sensor(tree: Tree, motion: Motion, sensor: Sensor) -> Routine:
    """Return a routine that stores the signals of a sensor."""
    routine = Routine(tree.graph)
    for array, indices, value in motion.list_signals(sensor.measures):
        routine.store(f"sens.{array}{indices}", value)
    if "Jac" in sensor.measures:
        for first_row, jacobian in ((1, motion.linear), (4, motion.angular)):
            for joint, column in jacobian.items():
                for row, value in enumerate(column, start=first_row):
                    if value:
                        routine.store(f"sens.J[{row}][{joint}]", value)
    return routine


def _refuse_draft(mbs: Mbs, function: str) -> Refused | None:
    """Return the reason if a function needs a cut or a link that is a draft."""
    needs_cuts = function in ("cons_hJ", "cons_jdqd", "accelred", "invdynared")
    needed = mbs.cuts if needs_cuts else [link for link in mbs.links if link.kind == function]
    for connection in needed:
        if connection.is_draft:
            name = quoted(connection.name)
            return Refused(
                f"{connection.kind} '{name}' is a draft: an end of it is on no body or no point"
            )
    return None
