"""The force laws that plugins put into the code of a project."""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import urdf2mbs
from support.laws import convert
from support.project_robots import BOX
from urdf2mbs import simulate
from urdf2mbs.engine.output import write
from urdf2mbs_simulate.compiler import compiler


def test_the_generated_python_calls_the_laws(tmp_path: Path) -> None:
    conversion = convert(tmp_path)
    module = tmp_path / "moved_robot.py"
    module.write_bytes(conversion.files[tmp_path / "moved/userfctR/moved_robot.py"])
    code = runpy.run_path(str(module))
    joints = conversion.mbs.numbers()
    data = SimpleNamespace(
        joint_id=joints,
        extforce_id={"breeze": 1},
        link_id={},
        user_model={},
        q=np.full(len(joints) + 1, 2.0),
        qd=np.zeros(len(joints) + 1),
        Qq=np.zeros(len(joints) + 1),
    )
    code["joint_forces"](data)
    assert data.Qq[joints["shoulder"]] == -24.0
    assert np.count_nonzero(data.Qq) == 1
    force = code["external_force"]([0, 1.0, 2.0, 5.0], None, [0, 7.0, 8.0, 9.0], data, 0.5, 1)
    assert force == (-7.0, 0.0, 5.0, 0.0, 0.0, 0.5)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_the_laws_move_the_robot_the_same_way_in_c(tmp_path: Path) -> None:
    write(convert(tmp_path))
    results = {
        language: simulate(tmp_path / "moved", time=0.1, language=language, rtol=1e-10, atol=1e-12)
        for language in ("c", "python")
    }
    np.testing.assert_allclose(results["c"].q, results["python"].q, rtol=0, atol=1e-8)
    forces = [result.external["breeze"] for result in results.values()]
    np.testing.assert_allclose(*forces, rtol=0, atol=1e-6)
    assert forces[0][-1, 5] == pytest.approx(0.1)  # its torque about z is the time
    assert np.abs(forces[0][:, 2]).max() > 0.01


AT_CONTACT = '''
from urdf2mbs.plugin import Pass, hookimpl
from urdf2mbs_project import simulation

class Lift(Pass):
    """4 N at a point that touches the ground."""
    reads = ("forces",)
    writes = ("forces",)

    def run(self, conversion):
        made = conversion.state(simulation.Simulation)
        made.laws.append(simulation.Law("lift", """
def lift(P, V, mbs_data, tsim, ixF):
    return (0.0, 0.0, 4.0, 0.0, 0.0, 0.0)
""", """
static void lift(const double P[4], const double V[4], const MbsData *mbs_data, double tsim,
    int ixF, double force[7])
{
    force[3] = 4.0;
}
""", points=[contact.point for contact in made.contacts]))

@hookimpl
def urdf2mbs_passes():
    return [Lift]
'''


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_a_law_at_a_contact_is_added_to_the_ground(tmp_path: Path) -> None:
    (tmp_path / "laws.py").write_text(AT_CONTACT)
    (tmp_path / "box.urdf").write_text(BOX)
    made = urdf2mbs.convert(
        tmp_path / "box.urdf",
        output={"project": tmp_path / "moved", "language": "both"},
        base="floating",
        plugins=[tmp_path / "laws.py"],
        after={"contacts": "lift"},
        passes={"contacts": {"links": ["*"]}},
    )
    write(made.conversion)
    for language in ("c", "python"):
        results = simulate(tmp_path / "moved", time=2.0, language=language)
        (force,) = results.external.values()
        assert force[-1, 2] == pytest.approx(2.0 * 9.81, rel=1e-4), language
        sunk = results.q[-1, results.data.joint_id["floating_base_T3"]] - 0.05
        stiffness = results.data.user_model["contact"]["stiffness"]
        assert -4.0 * stiffness * sunk == pytest.approx(2.0 * 9.81 - 4.0, rel=1e-4), language
