"""Forces that the user's functions give: external ones, links between two points, 3D links.

Each is put on its body at the centre of mass, in the body's axes, as ``frc`` and ``trq``.
"""

from __future__ import annotations

from collections.abc import Collection

from urdf2mbs_equations.graph import Expr, root
from urdf2mbs_equations.kinematics import Motion, common, ends, motion, relative
from urdf2mbs_equations.routine import Absent, Call, Routine
from urdf2mbs_equations.tree import Tree
from urdf2mbs_equations.vectors import NONE, Vector

XYZ = (1, 2, 3)


class _Load:
    """The sum of all forces on each body, at its centre of mass, in its frame (N, Nm)."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.force: dict[int, Vector] = {}
        self.torque: dict[int, Vector] = {}

    def put(self, number: int, force: Vector, at: Vector, torque: Vector = NONE) -> None:
        """A force (N) at a point (m) and a torque (Nm), all in the frame behind the joint of this
        number, which is a body's last."""
        lever = at - self.tree.centre(self.tree.frames[number])
        self.force[number] = self.force.get(number, NONE) + force
        self.torque[number] = self.torque.get(number, NONE) + (torque + lever.cross(force))

    def store(self, routine: Routine) -> None:
        for name, loads in (("frc", self.force), ("trq", self.torque)):
            for number, vector in sorted(loads.items()):
                for k, value in zip(XYZ, vector, strict=True):
                    if value:
                        place = f"{name}[{k}][{number}]"
                        routine.store(place, self.tree.graph.input(place) + value)


def _vector(tree: Tree, name: str, first: int = 1) -> Vector:
    """Three elements of what a user function has returned."""
    return Vector(tree.graph.input(f"{name}[{k}]") for k in range(first, first + 3))


def extforces(tree: Tree) -> Routine:
    """All external forces."""
    routine = Routine(tree.graph)
    load = _Load(tree)
    number = 0
    for body in tree.mbs.bodies:
        for point in body.points:
            if point.extforce is None:
                continue
            number += 1
            last = tree.last[body.name]
            at = motion(tree, last, tree.point(body.name, point.name))
            result = _ask(routine, "ExtForces", number, at, point.extforce.measures)
            force, torque = (at.axes @ _vector(tree, result, first) for first in (1, 4))
            load.put(last, force, _vector(tree, result, 7), torque)
    load.store(routine)
    return routine


def _ask(
    routine: Routine, function: str, number: int, at: Motion, measures: Collection[str]
) -> str:
    """Tell a user function of a point's motion (what is not measured is zero); gives the name of
    what it returns."""
    for name, place, value in at.measured(measures):
        if value:
            routine.store(f"{name}xF{number}{place}", value)
    given = [f"{name}xF{number}" for name in ("P", "R", "V", "OM", "A", "OMP")]
    result = f"SWr{number}"
    call = Call(f"user_{function}", (*given, "s", "tsim", str(number)), result)
    routine.steps.append(call)
    return result


def links(tree: Tree) -> Routine | Absent:
    """Forces along the line between two points; positive ones pull these together."""
    every_link = [link for link in tree.mbs.links if link.kind == "link"]
    if not every_link:
        return Absent("links")
    routine = Routine(tree.graph)
    load = _Load(tree)
    for number, link in enumerate(every_link, start=1):
        end1, end2 = ends(tree, link)
        start = common(tree, end1[0], end2[0])
        a = motion(tree, *end1, start=start, accelerations=False)
        b = motion(tree, *end2, start=start, accelerations=False)
        between = b.position - a.position
        if any(between):
            length = root(between @ between)
            line = 1 / length * between
            rate = (b.velocity - a.velocity) @ line
        else:  # both ends are in one place: there is no line
            length, line, rate = 0, NONE, 0
        routine.store(f"Z[{number}]", length)
        routine.store(f"Zd[{number}]", rate)
        arguments = (f"Z[{number}]", f"Zd[{number}]", "s", "tsim", str(number))
        routine.steps.append(Call("user_LinkForces", arguments, f"force{number}"))
        force: Expr = tree.graph.input(f"force{number}")
        routine.store(f"Flink[{number}]", force)
        pull = force * line
        if end1[0]:
            load.put(end1[0], a.axes @ pull, end1[1])
        if end2[0]:
            load.put(end2[0], -(b.axes @ pull), end2[1])
    load.store(routine)
    return routine


def links3d(tree: Tree) -> Routine | Absent:
    """Force and torque between two points, by the second's motion seen from the first body.

    Both act at the second point, on the first body as returned and on the second reversed;
    all is in the axes of the first body.
    """
    every_link = [link for link in tree.mbs.links if link.kind == "link3D"]
    if not every_link:
        return Absent("3D links")
    routine = Routine(tree.graph)
    load = _Load(tree)
    for number, link in enumerate(every_link, start=1):
        (last1, at1), (last2, at2) = ends(tree, link)
        seen = relative(tree, (last1, at1), (last2, at2))
        every = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
        result = _ask(routine, "Link3DForces", number, seen, every)
        force, torque = _vector(tree, result), _vector(tree, result, 4)
        if last1:
            load.put(last1, force, at1 + seen.position, torque)
        if last2:
            load.put(last2, -(seen.axes @ force), at2, -(seen.axes @ torque))
    load.store(routine)
    return routine
