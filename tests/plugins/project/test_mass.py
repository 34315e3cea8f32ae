"""The mass matrix and the velocities of an .mbs, against Pinocchio's."""

import numpy as np
import pytest
from hypothesis import given

from support.mbs_models import few
from support.oracle.pin import to_pinocchio
from support.singular import mass_matrix, trees
from urdf2mbs.mbs.model import Body, Joint, Mbs
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.places import compute_point_position, find_floating_body, list_joints_to_base

pin = pytest.importorskip("pinocchio")


@few
@given(trees())
def test_mass_matrix_and_velocities_are_those_of_pinocchio(mbs: Mbs) -> None:
    for number, joint in enumerate(mbs.joints().values(), start=1):
        joint.nature, joint.q = "independent", 0.37 * number
    model, mass = to_pinocchio(mbs), MassModel(mbs)
    data = model.createData()
    q = np.array([placed.joint.q for placed in mass.placement.joints])
    np.testing.assert_allclose(mass.matrix, mass_matrix(model, q), rtol=0, atol=1e-11)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for body in mbs.bodies:
        frame = model.getFrameId(f"{body.name}/p")
        wanted = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED).reshape(6, -1)
        position = compute_point_position(mass.placement, mbs, body.name, "p")
        jacobian = np.vstack(
            [
                mass.compute_point_jacobian(body.name, position),
                mass.compute_rotation_jacobian(body.name),
            ]
        )
        np.testing.assert_allclose(jacobian, wanted, rtol=0, atol=1e-12)
        moving = mass.moves[:, mass.placement.last_joints[body.name]].nonzero()[0]
        assert list_joints_to_base(mass.placement, body.name) == sorted(moving, reverse=True)
    assert list_joints_to_base(mass.placement, None) == []
    assert not mass.compute_point_jacobian(None, (1.0, 2.0, 3.0)).any()
    assert not mass.compute_rotation_jacobian(None).any()
    assert (
        mass.compute_point_jacobian(None, (1.0, 2.0, 3.0)).shape
        == mass.compute_rotation_jacobian(None).shape
        == (3, len(q))
    )


def test_a_body_floats_by_three_free_shifts_on_the_base() -> None:
    def body(natures: str, parent: str | None = None) -> Body:
        joints = [
            Joint(f"j{number}", f"T{number}", "independent" if nature == "i" else "driven")
            for number, nature in enumerate(natures, start=1)
        ]
        return Body(f"b{natures}", parent, None, [*joints, Joint("r", "R1")])

    arm, floating_body = body("ii"), body("iii")
    assert find_floating_body(Mbs("m", bodies=[arm, floating_body])) is floating_body
    for bodies in ([arm], [body("iid")], [arm, body("iii", arm.name)]):
        assert find_floating_body(Mbs("m", bodies=bodies)) is None
