"""Forces that the user's functions give: external ones, links between two points, 3D links.

Each is put on its body at the centre of mass, in the body's axes, as ``frc`` and ``trq``.
"""

from __future__ import annotations

from collections.abc import Collection

from urdf2mbs.equations.graph import Expr
from urdf2mbs.equations.kinematics import Motion, into, motion
from urdf2mbs.equations.routine import Call, Routine
from urdf2mbs.equations.tree import NONE, Tree, Vector
from urdf2mbs.mbs.model import Connection

XYZ = (1, 2, 3)


class _Load:
    """What all forces together put on each body."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.force: dict[int, Vector] = {}
        self.torque: dict[int, Vector] = {}

    def put(self, number: int, force: Vector, at: Vector, torque: Vector = NONE) -> None:
        """A force at a point and a torque, all in the frame of the body."""
        tree = self.tree
        lever = tree.minus(at, tree.centre(tree.frames[number]))
        torque = tree.plus(torque, tree.cross(lever, force))
        self.force[number] = tree.plus(self.force.get(number, NONE), force)
        self.torque[number] = tree.plus(self.torque.get(number, NONE), torque)

    def store(self, routine: Routine) -> None:
        for name, loads in (("frc", self.force), ("trq", self.torque)):
            for number, vector in sorted(loads.items()):
                for k, value in zip(XYZ, vector, strict=True):
                    if value:
                        place = f"{name}[{k}][{number}]"
                        there = self.tree.graph.input(place)
                        routine.store(place, self.tree.graph.add(there, value))


def vector_of(tree: Tree, name: str, first: int = 1) -> Vector:
    """Three elements of what a user function has returned."""
    x, y, z = (tree.graph.input(f"{name}[{k}]") for k in range(first, first + 3))
    return x, y, z


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
            result = _asked(routine, "ExtForces", number, at, point.extforce.measures)
            force = into(tree, at.axes, vector_of(tree, result))
            torque = into(tree, at.axes, vector_of(tree, result, 4))
            load.put(last, force, vector_of(tree, result, 7), torque)
    load.store(routine)
    return routine


def _asked(
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


def ends(tree: Tree, connection: Connection) -> tuple[tuple[int, Vector], tuple[int, Vector]]:
    """The number of the last joint and the point in its frame, of both ends."""
    (body1, point1), (body2, point2) = connection.endpoint1, connection.endpoint2
    return (
        (tree.last[body1], tree.point(body1, point1)),
        (tree.last[body2], tree.point(body2, point2)),
    )


def common(tree: Tree, one: int, other: int) -> int:
    """The frame from which the ways to both of two frames part."""
    inwards = {0}
    while one:
        inwards.add(one)
        one = tree.frames[one].parent
    while other not in inwards:
        other = tree.frames[other].parent
    return other


def links(tree: Tree) -> Routine:
    """Forces along the line between two points; positive ones pull these together."""
    graph = tree.graph
    routine = Routine(graph)
    load = _Load(tree)
    found = [link for link in tree.mbs.links if link.kind == "link"]
    for number, link in enumerate(found, start=1):
        (last1, at1), (last2, at2) = ends(tree, link)
        start = common(tree, last1, last2)
        one = motion(tree, last1, at1, start=start, accelerations=False)
        two = motion(tree, last2, at2, start=start, accelerations=False)
        between = tree.minus(two.position, one.position)
        length = graph.sqrt(tree.dot(between, between))
        line = _divided(tree, between, length)
        rate = tree.dot(tree.minus(two.velocity, one.velocity), line)
        routine.store(f"Z[{number}]", length)
        routine.store(f"Zd[{number}]", rate)
        call = ("s", "tsim", str(number))
        routine.steps.append(
            Call("user_LinkForces", (f"Z[{number}]", f"Zd[{number}]", *call), f"force{number}")
        )
        force = graph.input(f"force{number}")
        routine.store(f"Flink[{number}]", force)
        pull = tree.times(force, line)
        if last1:
            load.put(last1, into(tree, one.axes, pull), at1)
        if last2:
            x, y, z = into(tree, two.axes, pull)
            load.put(last2, (-x, -y, -z), at2)
    load.store(routine)
    return routine


def _divided(tree: Tree, v: Vector, by: Expr) -> Vector:
    inverse = tree.graph.div(1, by)
    return tree.times(inverse, v)


def links3d(tree: Tree) -> Routine:
    """Force and torque between two points, by the second's motion seen from the first body.

    Both act at the second point, on the first body as returned and on the second reversed;
    all is in the axes of the first body.
    """
    routine = Routine(tree.graph)
    load = _Load(tree)
    found = [link for link in tree.mbs.links if link.kind == "link3D"]
    for number, link in enumerate(found, start=1):
        (last1, at1), (last2, at2) = ends(tree, link)
        relative = _relative(tree, (last1, at1), (last2, at2))
        every = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp")
        result = _asked(routine, "Link3DForces", number, relative, every)
        force, torque = vector_of(tree, result), vector_of(tree, result, 4)
        if last1:
            load.put(last1, force, tree.plus(at1, relative.position), torque)
        if last2:
            fx, fy, fz = into(tree, relative.axes, force)
            mx, my, mz = into(tree, relative.axes, torque)
            load.put(last2, (-fx, -fy, -fz), at2, (-mx, -my, -mz))
    load.store(routine)
    return routine


def _relative(tree: Tree, one: tuple[int, Vector], two: tuple[int, Vector]) -> Motion:
    """The motion of the second point in the axes of the first body, as seen from there."""
    start = common(tree, one[0], two[0])
    a = motion(tree, *one, start=start)
    b = motion(tree, *two, start=start)
    p = tree.minus(b.position, a.position)
    across = tree.cross(a.spin, p)
    v = tree.minus(tree.minus(b.velocity, a.velocity), across)
    w = tree.minus(b.spin, a.spin)
    rate = tree.minus(b.spin_rate, a.spin_rate)
    rate = tree.minus(rate, tree.cross(a.spin, w))
    # b = a + w' x p + w x (w x p) + 2 w x v + what is seen
    seen = tree.minus(b.acceleration, a.acceleration)
    seen = tree.minus(seen, tree.cross(a.spin_rate, p))
    seen = tree.minus(seen, tree.cross(a.spin, across))
    seen = tree.minus(seen, tree.times(tree.graph.constant(2.0), tree.cross(a.spin, v)))
    x, y, z = (into(tree, a.axes, axis) for axis in b.axes)
    return Motion(
        (x, y, z), into(tree, a.axes, p), into(tree, a.axes, v), into(tree, a.axes, w),
        into(tree, a.axes, seen), into(tree, a.axes, rate),
    )  # fmt: skip
