"""Joints of rubber: a torque that grows with the third power of the angle."""

from urdf2mbs.plugin import Conversion, Pass, UserModel, choose, hookimpl
from urdf2mbs_project import simulation

PYTHON = """
def rubber(mbs_data, joint):
    return -mbs_data.user_model["rubber"]["stiffness"] * mbs_data.q[joint] ** 3
"""
C = """
static double rubber(const MbsData *mbs_data, int joint)
{
    const double q = mbs_data->q[joint];
    return -mbs_data->user_model->rubber.stiffness * q * q * q;
}
"""


class Rubber(Pass):
    """Joints of rubber: a torque that grows with the third power of the angle."""

    reads = ("joints",)
    writes = ("forces",)

    joints: list[str]
    """Patterns of URDF joints that move by one coordinate."""
    stiffness: float = 1.0
    """N m/rad^3."""

    def run(self, conversion: Conversion) -> None:
        joints = {step.joint.name: joint for step, joint in conversion.single_coordinates()}
        chosen = choose(self.joints, joints, "rubber-joints", "rubber: no joint")
        conversion.mbs.user_models.append(UserModel.of("rubber", {"stiffness": self.stiffness}))
        law = simulation.Law("rubber", PYTHON, C, joints=[joints[name] for name in chosen])
        conversion.state(simulation.Simulation).laws.append(law)


@hookimpl
def urdf2mbs_passes() -> list[type[Pass]]:
    return [Rubber]
