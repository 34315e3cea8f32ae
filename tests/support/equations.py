"""Random trees of bodies, and their equations as Python or C."""

import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st

from support.examples import reproducible
from support.oracle.generated import CEquations, PythonEquations
from support.real_robots import REAL_ROBOTS
from urdf2mbs.mbs.model import Base, Body, Joint, Mbs, Point
from urdf2mbs.mbs.reader import read_mbs
from urdf2mbs_equations.files import FUNCTIONS, generate
from urdf2mbs_equations.options import EquationOptions

#: Numbers as files have them: zero, a quarter turn written short or long, anything.
angles = st.sampled_from([0.0, 1.5708, np.pi / 2, -np.pi / 2, np.pi, 1.57079632679, 0.3])


lengths = st.sampled_from([0.0, 0.0, 0.1, -0.25, 1e-9, 0.7])


vectors = st.tuples(lengths, lengths, lengths)


@st.composite
def trees(draw: st.DrawFn, most: int = 4) -> Mbs:
    """Draw a tree of bodies with one to three joints each, each body with two points."""
    mbs = Mbs("tree", base=Base(gravity=draw(st.sampled_from([(0, 0, -9.81), (1.0, 2.0, 3.0)]))))
    mbs.base.points = [Point("P", draw(vectors))]
    for i in range(draw(st.integers(2, most))):
        parent = draw(st.sampled_from([None, *(body.name for body in mbs.bodies)]))
        joints = []
        for j in range(draw(st.integers(1, 3))):
            kind = draw(st.sampled_from(["T1", "T2", "T3", "R1", "R2", "R3", "R1", "R2", "R3"]))
            joint = Joint(f"j{i}_{j}", kind)
            if draw(st.integers(0, 3)) == 0:
                joint.nature, joint.q = "driven", draw(angles)
                joint.symbols = draw(st.sampled_from([("q",), ("q", "qd", "qdd"), None]))
            joints.append(joint)
        body = Body(f"b{i}", parent, draw(st.sampled_from([None, "P"])), joints)
        if draw(st.integers(0, 4)):
            body.mass = draw(st.sampled_from([0.5, 2.0]))
            body.com = draw(vectors)
            body.inertia = draw(
                st.sampled_from([(0.1, 0.01, 0.02, 0.2, -0.03, 0.25), (0.1, 0, 0, 0.1, 0, 0.1)])
            )
        body.points = [Point("P", draw(vectors)), Point("Q", draw(vectors))]
        mbs.bodies.append(body)
    return mbs


def write_equations(
    mbs: Mbs, *, c: bool = False, functions: Iterable[str] = FUNCTIONS, **options: Any
) -> PythonEquations:
    settings = EquationOptions(language="c" if c else "python", **options)
    made = generate(mbs, b"<mbsDescR7/>", "tree.mbs", settings, functions)
    with tempfile.TemporaryDirectory() as folder:
        return (CEquations if c else PythonEquations)(made, mbs, Path(folder))


few = settings(reproducible, max_examples=10)


def convert_robot(name: str) -> tuple[Mbs, bytes]:
    """Convert a real robot by the preset compact."""
    for robot in REAL_ROBOTS:
        if robot.name == name:
            data = robot.convert(pipeline="compact").data
            return read_mbs(data, "robot.mbs", mechanics_only=True), data
    pytest.skip("the real robots are not here")
