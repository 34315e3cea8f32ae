"""Formulas of textbook robots: their length and time beside sympy's mechanics and Drake's.

    python benchmarks/formulas.py [ROBOT ...]

For each robot of ``tests/plugins/equations/textbook.py``: the signs (symbols, numbers, + and -) of
all elements of M on and above the diagonal, in the book, in ours, in ``sympy.physics.mechanics``
(Kane's method, then ``simplify``), and in Drake (``CalcMassMatrix`` with symbols for positions and
masses), and the seconds of a processor.  Needs sympy; Drake is left out where ``pydrake`` is not
installed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import sympy
from sympy.physics import mechanics

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from plugins.equations.test_symbolic import convert, count_signs, write_python
from support.textbook import TEXTBOOKS
from urdf2mbs_equations.symbolic import make_symbolic_equations

MOMENTS = ("ixx", "iyy", "izz")


def read_vector(element: ElementTree.Element, tag: str, name: str) -> list[float]:
    """Return three numbers of an attribute."""
    return [float(number) for number in element.find(tag).get(name).split()]


def make_vector(numbers: Iterable[float], frame: Any, letter: str) -> Any:
    """Return a vector with a symbol for each component that is not zero."""
    vector = mechanics.Vector(0)
    for axis, unit, number in zip("xyz", frame, numbers, strict=True):
        if number:
            vector += sympy.sign(number) * sympy.Symbol(f"{letter}{axis}") * unit
    return vector


def make_kane_matrix(urdf: str) -> list[Any]:
    """Return the elements of M of a robot by Kane's method, with symbols for its data."""
    robot = ElementTree.fromstring(urdf)
    ground, origin = mechanics.ReferenceFrame("N"), mechanics.Point("O")
    origin.set_vel(ground, 0)
    links, places = (
        {link.get("name"): link for link in robot.iter("link")},
        {"base": (ground, origin)},
    )
    joints, bodies, loads, q, u = robot.findall("joint"), [], [], [], []
    while joints:
        joint = next(each for each in joints if each.find("parent").get("link") in places)
        joints.remove(joint)
        k = len(q) + 1
        q.append(mechanics.dynamicsymbols(f"q{k}"))
        u.append(mechanics.dynamicsymbols(f"u{k}"))
        frame, start = places[joint.find("parent").get("link")]
        point = start.locatenew(
            f"J{k}", make_vector(read_vector(joint, "origin", "xyz"), frame, f"l_{k - 1}")
        )
        point.v2pt_theory(start, ground, frame)
        if any(read_vector(joint, "origin", "rpy")):  # all of these robots: a quarter turn about x
            frame = frame.orientnew(f"F{k}", "Axis", [sympy.pi / 2, frame.x])
        numbers = map(sympy.nsimplify, read_vector(joint, "axis", "xyz"))
        axis = sum((n * unit for n, unit in zip(numbers, frame, strict=True)), mechanics.Vector(0))
        if joint.get("type") == "prismatic":
            moved = point.locatenew(f"P{k}", q[-1] * axis)
            sweep = frame.ang_vel_in(ground).cross(q[-1] * axis)
            moved.set_vel(ground, point.vel(ground) + u[-1] * axis + sweep)
            point = moved
        else:
            parent, frame = frame, frame.orientnew(f"B{k}", "Axis", [q[-1], axis])
            frame.set_ang_vel(parent, u[-1] * axis)
        child = joint.find("child").get("link")
        places[child] = frame, point
        inertial = links[child].find("inertial")
        if inertial is not None:
            offset = make_vector(read_vector(inertial, "origin", "xyz"), frame, f"l_c{k}")
            centre = point.locatenew(f"C{k}", offset)
            centre.set_vel(ground, point.vel(ground) + frame.ang_vel_in(ground).cross(offset))
            moments = inertial.find("inertia")
            symbols = [float(moments.get(m)) and sympy.Symbol(f"I_{k}{m}") for m in MOMENTS]
            mass, inertia = sympy.Symbol(f"m_{k}"), mechanics.inertia(frame, *symbols)
            bodies.append(mechanics.RigidBody(f"b{k}", centre, frame, mass, (inertia, centre)))
            loads.append((centre, -mass * sympy.Symbol("g") * ground.z))
    rates = [speed - coordinate.diff() for speed, coordinate in zip(u, q, strict=True)]
    kane = mechanics.KanesMethod(ground, q_ind=q, u_ind=u, kd_eqs=rates)
    kane.kanes_equations(bodies, loads)
    names = {each: sympy.Symbol(f"q_{k}") for k, each in enumerate(q, start=1)}
    matrix = kane.mass_matrix.xreplace(names)
    return [matrix[i, j] for i in range(len(q)) for j in range(i, len(q)) if matrix[i, j] != 0]


def count_expression(expression: Any) -> int:
    """Count the signs of an expression of sympy; ``cos(q_1 + q_2)`` is one, as in books."""
    short = {
        function: sympy.Symbol(f"c{k}")
        for k, function in enumerate(expression.atoms(sympy.sin, sympy.cos))
        if all(term.is_Symbol for term in sympy.Add.make_args(function.args[0]))
    }
    return count_signs(str(expression.xreplace(short)))


def count_drake(urdf: str) -> int:
    """Return the signs of M of Drake, with symbols for positions and masses."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import BodyIndex
    from pydrake.symbolic import Expression, Variable

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(urdf.replace('"continuous"', '"revolute"'), "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    symbolic = plant.ToSymbolic()
    context, n = symbolic.CreateDefaultContext(), symbolic.num_positions()
    symbolic.SetPositions(context, [Variable(f"q_{k}") for k in range(1, n + 1)])
    for k in range(2, symbolic.num_bodies()):
        symbolic.get_body(BodyIndex(k)).SetMass(context, Expression(Variable(f"m_{k}")))
    matrix = symbolic.CalcMassMatrix(context)
    return sum(count_signs(matrix[i, j].to_string()) for i in range(n) for j in range(i, n))


def main(names: list[str]) -> None:
    """Print a line for each robot."""
    has_drake = find_spec("pydrake") is not None
    print(f"{'robot':20} book  ours      s  sympy      s  simplified      s  drake      s")
    for name in names or TEXTBOOKS:
        book = TEXTBOOKS[name]
        model = convert(book.urdf)
        make_symbolic_equations(convert(TEXTBOOKS["pendulum"].urdf))  # imports what it needs
        times = [time.process_time()]
        equations = make_symbolic_equations(model)
        times.append(time.process_time())
        raw = make_kane_matrix(book.urdf)
        times.append(time.process_time())
        simplified = [sympy.simplify(element) for element in raw]
        times.append(time.process_time())
        drake = count_drake(book.urdf) if has_drake else 0
        times.append(time.process_time())
        elements = [formula for formula in equations.mass_matrix.values() if formula.terms]
        counts = [
            sum(count_signs(write_python(formula)) for formula in elements),
            sum(map(count_expression, raw)),
            sum(map(count_expression, simplified)),
            drake,
        ]
        seconds = [after - before for before, after in pairwise(times)]
        columns = "".join(f"{n:7} {s:6.3f}" for n, s in zip(counts, seconds, strict=True))
        print(f"{name:20} {sum(map(count_signs, book.mass_matrix.values())):4}{columns}")


if __name__ == "__main__":
    main(sys.argv[1:])
