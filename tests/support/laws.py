"""A plugin that adds joint laws, and a robot converted with it."""

from pathlib import Path
from typing import Any

import urdf2mbs
from urdf2mbs.testing import TINY

PLUGIN = '''
from urdf2mbs.plugin import Pass, hookimpl, mbs
from urdf2mbs_project import simulation

class Laws(Pass):
    """A torque in a joint, and a force at a point."""
    reads = ("joints", "bodies")
    writes = ("anchors", "forces")
    name_of_point: str = "wind"

    def run(self, conversion):
        (shoulder,) = [j for step, j in conversion.single_coordinates()
                       if step.joint.name == "shoulder"]
        _, point = conversion.add_point("here", "hand", (0.1, 0.0, 0.0), "laws-link", "laws: at")
        point.extforce = mbs.Sensor("breeze", ("Pos", "Vit"))
        conversion.state(simulation.Simulation).laws += [
            simulation.Law("rubber", """
def rubber(mbs_data, joint):
    return -3.0 * mbs_data.q[joint] ** 3
""", """
static double rubber(const MbsData *mbs_data, int joint)
{
    return -3.0 * mbs_data->q[joint] * mbs_data->q[joint] * mbs_data->q[joint];
}
""", joints=[shoulder]),
            simulation.Law(self.name_of_point, """
def wind(P, V, mbs_data, tsim, ixF):
    return (-V[1], 0.0, P[3], 0.0, 0.0, tsim)
""", """
static void wind(const double P[4], const double V[4], const MbsData *mbs_data, double tsim,
    int ixF, double force[7])
{
    force[1] = -V[1];
    force[3] = P[3];
    force[6] = tsim;
}
""", points=[point]),
        ]

@hookimpl
def urdf2mbs_passes():
    return [Laws]
'''


def convert(tmp_path: Path, **options: Any) -> Any:
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "laws.py").write_text(PLUGIN)
    return urdf2mbs.convert(
        tmp_path / "tiny.urdf",
        output={"project": tmp_path / "moved", "language": "both"},
        plugins=[tmp_path / "laws.py"],
        after={"joint-parameters": "laws"},
        passes={"laws": options},
    ).conversion
