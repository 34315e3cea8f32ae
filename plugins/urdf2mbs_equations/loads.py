"""Forces of user functions: external forces, links between two points, and 3D links.

Each is added to its body at the centre of mass, in body axes, as Robotran's ``frc`` and ``trq``.
"""

from __future__ import annotations

from collections.abc import Collection

from urdf2mbs.plugin import Connection
from urdf2mbs_equations.graph import Expr, square_root
from urdf2mbs_equations.kinematics import (
    AnchorPoint,
    Motion,
    compute_motion,
    compute_relative_motion,
    find_common_ancestor,
    find_ends,
)
from urdf2mbs_equations.routine import Absent, Call, Routine
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import ZERO_VECTOR, Vector

#: Robotran's indices of a vector.
XYZ = (1, 2, 3)
#: All signals of a motion, as an .mbs names them.
ALL_SIGNALS = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")


class _BodyLoads:
    """The sum of all forces on each body, at its centre of mass, in its frame (N, Nm)."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.forces: dict[int, Vector] = {}
        self.torques: dict[int, Vector] = {}

    def add(self, point: AnchorPoint, force: Vector, torque: Vector = ZERO_VECTOR) -> None:
        """Add a force (N) at a point, and a torque (Nm), both in body axes."""
        body = point.joint
        lever = point.position - self.tree.get_centre(self.tree.frames[body])
        self.forces[body] = self.forces.get(body, ZERO_VECTOR) + force
        moment = torque + lever.cross(force)
        self.torques[body] = self.torques.get(body, ZERO_VECTOR) + moment

    def store(self, routine: Routine) -> None:
        """Add the sums to ``frc`` and ``trq``."""
        for array, loads in (("frc", self.forces), ("trq", self.torques)):
            for body, vector in sorted(loads.items()):
                for k, value in zip(XYZ, vector, strict=True):
                    if value:
                        element = f"{array}[{k}][{body}]"
                        routine.store(element, self.tree.graph.make_input(element) + value)


def _make_vector(tree: Tree, array: str, first: int = 1) -> Vector:
    """Return three elements of an array that a user function has returned."""
    return Vector(tree.graph.make_input(f"{array}[{k}]") for k in range(first, first + 3))


def make_external_forces(tree: Tree) -> Routine:
    """Return the routine ``extforces``.

    A user function returns SWr: force and torque in base axes, and the point where they act, in
    body axes.
    """
    routine = Routine(tree.graph)
    loads = _BodyLoads(tree)
    number = 0
    for body in tree.mbs.bodies:
        for point in body.points:
            if point.extforce is None:
                continue
            number += 1
            last_joint = tree.last_joint[body.name]
            anchor = AnchorPoint(last_joint, tree.get_point(body.name, point.name))
            motion = compute_motion(tree, anchor)
            result = _call_user_function(
                routine, "ExtForces", number, motion, point.extforce.measures
            )
            force, torque = (motion.axes @ _make_vector(tree, result, k) for k in (1, 4))
            loads.add(AnchorPoint(last_joint, _make_vector(tree, result, 7)), force, torque)
    loads.store(routine)
    return routine


def _call_user_function(
    routine: Routine, function: str, number: int, motion: Motion, measures: Collection[str]
) -> str:
    """Call a user function with the motion of a point; signals that are not measured are zero.

    Returns:
        The name of the array that the function returns.
    """
    for array, indices, value in motion.list_signals(measures):
        if value:
            routine.store(f"{array}xF{number}{indices}", value)
    arrays = [f"{name}xF{number}" for name in ("P", "R", "V", "OM", "A", "OMP")]
    result = f"SWr{number}"
    call = Call(f"user_{function}", (*arrays, "s", "tsim", str(number)), result)
    routine.steps.append(call)
    return result


def make_links(tree: Tree) -> Routine | Absent:
    """Return the routine ``link``: forces along the lines between two points.

    With d from the first point to the second, v its derivative and F the force that the user
    function returns::

        Z = |d|      Zd = v . d / Z      force on the first body: F d / Z, on the second: -F d / Z
    """
    links = [link for link in tree.mbs.links if link.kind == "link"]
    if not links:
        return Absent("links")
    routine = Routine(tree.graph)
    loads = _BodyLoads(tree)
    for number, link in enumerate(links, start=1):
        _add_link(tree, link, number, routine, loads)
    loads.store(routine)
    return routine


def _add_link(
    tree: Tree, link: Connection, number: int, routine: Routine, loads: _BodyLoads
) -> None:
    end1, end2 = find_ends(tree, link)
    start = find_common_ancestor(tree, end1.joint, end2.joint)
    first = compute_motion(tree, end1, start=start, accelerations=False)
    second = compute_motion(tree, end2, start=start, accelerations=False)
    d = second.position - first.position
    if any(d):
        length = square_root(d @ d)
        direction = 1 / length * d
        rate = (second.velocity - first.velocity) @ direction
    else:  # both ends always coincide: the link has no direction
        length, direction, rate = 0, ZERO_VECTOR, 0
    routine.store(f"Z[{number}]", length)
    routine.store(f"Zd[{number}]", rate)
    arguments = (f"Z[{number}]", f"Zd[{number}]", "s", "tsim", str(number))
    routine.steps.append(Call("user_LinkForces", arguments, f"force{number}"))
    force: Expr = tree.graph.make_input(f"force{number}")
    routine.store(f"Flink[{number}]", force)
    pull = force * direction
    if end1.joint:
        loads.add(end1, first.axes @ pull)
    if end2.joint:
        loads.add(end2, -(second.axes @ pull))


def make_links_3d(tree: Tree) -> Routine | Absent:
    """Return the routine ``link3D``: force and torque between two points.

    They depend on the motion of the second point relative to the first body.  Both act at the
    second point, on the first body as returned and on the second body reversed.  All vectors are in
    axes of the first body.
    """
    links = [link for link in tree.mbs.links if link.kind == "link3D"]
    if not links:
        return Absent("3D links")
    routine = Routine(tree.graph)
    loads = _BodyLoads(tree)
    for number, link in enumerate(links, start=1):
        end1, end2 = find_ends(tree, link)
        motion = compute_relative_motion(tree, end1, end2)
        result = _call_user_function(routine, "Link3DForces", number, motion, ALL_SIGNALS)
        force, torque = _make_vector(tree, result), _make_vector(tree, result, 4)
        if end1.joint:
            point = AnchorPoint(end1.joint, end1.position + motion.position)
            loads.add(point, force, torque)
        if end2.joint:
            loads.add(end2, -(motion.axes @ force), -(motion.axes @ torque))
    loads.store(routine)
    return routine
