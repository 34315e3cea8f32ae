"""The project's trigonometry against numpy and pinocchio."""

from math import pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from support.examples import reproducible
from urdf2mbs import spatial
from urdf2mbs.spatial import IDENTITY, ZERO, Pose, direction, lump, unit

pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed")

many = settings(reproducible, max_examples=200)

#: What the exact result may be off by: a few roundings of numbers up to 1.
EXACT = 1e-15
RIGHT = pi / 2

angles = st.one_of(
    st.sampled_from(
        (0.0, RIGHT, -RIGHT, pi, -pi, 1.5708, 1.57079632679, 3.14159, 1e-12, -1e-300, 100.0)
    ),
    st.floats(-2 * pi, 2 * pi),
)
triples = st.tuples(angles, angles, angles)
numbers = st.floats(-10, 10)
vectors = st.tuples(numbers, numbers, numbers)
poses = st.builds(Pose, vectors, triples.map(spatial.from_rpy))
tensors = st.tuples(*[numbers] * 6)


def square(rot):
    return np.array(rot).reshape(3, 3)


def full(tensor):
    xx, xy, xz, yy, yz, zz = tensor
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def homogeneous(pose):
    out = np.eye(4)
    out[:3, :3] = square(pose.rot)
    out[:3, 3] = pose.xyz
    return out


def near(a, b, tolerance):
    np.testing.assert_allclose(np.array(a, dtype=float), b, rtol=0, atol=tolerance)


@many
@given(triples)
@example(ZERO)
def test_from_rpy_is_pinocchio_s(rpy):
    near(square(spatial.from_rpy(rpy)), pin.rpy.rpyToMatrix(*rpy), EXACT)


def test_no_turn_is_exactly_the_identity():
    assert spatial.from_rpy(ZERO) == IDENTITY
    assert spatial.from_rpy((-0.0, 0.0, -0.0)) == IDENTITY
    assert spatial.rpy_turns((0.0, -0.0, 0.0)) == ()
    assert spatial.from_turns(()) == IDENTITY


@many
@given(st.sampled_from((1, 2, 3)), angles)
def test_from_turn_turns_about_its_axis(k, angle):
    wanted = pin.AngleAxis(angle, np.eye(3)[k - 1]).toRotationMatrix()
    near(square(spatial.from_turn((k, angle))), wanted, EXACT)


@many
@given(triples)
def test_turns_about_current_axes_are_the_rpy(rpy):
    turns = spatial.rpy_turns(rpy)

    assert turns == tuple((k, a) for k, a in zip((3, 2, 1), rpy[::-1], strict=True) if a)
    near(spatial.from_turns(turns), spatial.from_rpy(rpy), EXACT)


@many
@given(triples)
@example((RIGHT, 0.0, 0.0))
@example((0.0, RIGHT, 0.0))
@example((0.3, -RIGHT, 1.1))
@example((RIGHT, RIGHT, RIGHT))
@example((1.5708, 1.5708, 1.5708))
@example((1.57079632679, -1.57079632679, 0.0))
@example((0.1, RIGHT - 1e-8, 0.2))
@example((0.1, RIGHT - 1e-15, 0.2))
def test_xyz_angles_give_the_same_rotation_everywhere(rpy):
    rot = spatial.from_rpy(rpy)

    angles = spatial.to_xyz_angles(rot)

    x, y, z = (
        pin.AngleAxis(angle, axis).toRotationMatrix()
        for angle, axis in zip(angles, np.eye(3), strict=True)
    )
    near(x @ y @ z, square(rot), EXACT)
    assert -RIGHT <= angles[1] <= RIGHT


@many
@given(triples, triples)
def test_products(a, b):
    a, b = spatial.from_rpy(a), spatial.from_rpy(b)
    near(square(spatial.multiply(a, b)), square(a) @ square(b), EXACT)
    assert (square(spatial.transpose(a)) == square(a).T).all()


@many
@given(triples, vectors, vectors)
def test_vectors(rpy, u, v):
    rot = spatial.from_rpy(rpy)
    near(spatial.rotate(rot, v), square(rot) @ v, 1e-13)
    assert spatial.add(u, v) == tuple(np.add(u, v))


@many
@given(poses, poses)
def test_poses(a, b):
    near(homogeneous(spatial.compose(a, b)), homogeneous(a) @ homogeneous(b), 1e-13)
    near(homogeneous(spatial.inverse(a)), np.linalg.inv(homogeneous(a)), 1e-13)


@many
@given(triples, tensors)
def test_rotate_inertia(rpy, tensor):
    rot = spatial.from_rpy(rpy)
    wanted = square(rot) @ full(tensor) @ square(rot).T
    near(full(spatial.rotate_inertia(rot, tensor)), wanted, 1e-13)


def test_an_inertia_that_is_not_turned_keeps_every_digit():
    tensor = (0.1, 0.2, 0.30000000000000004, 0.4, 0.5, 0.6)
    assert spatial.rotate_inertia(IDENTITY, tensor) == tensor


def about_the_origin(mass, centre, tensor):
    """Check the 6x6 inertia: the parallel-axis theorem is pinocchio's."""
    inertia = pin.Inertia(mass, np.array(centre), np.zeros((3, 3))).matrix()
    inertia[3:, 3:] += full(tensor)
    return inertia


@many
@given(st.lists(st.tuples(st.floats(0.01, 100), vectors, tensors), min_size=1, max_size=4))
def test_lumped_parts_have_the_inertia_of_all(parts):
    wanted = sum(about_the_origin(*part) for part in parts)
    near(about_the_origin(*lump(parts)), wanted, 1e-9)


def test_parts_without_mass_lump_where_they_are_given() -> None:
    """They have no centre; their inertias add up."""
    one, two = (1.0, 0.1, 0.2, 2.0, 0.3, 3.0), (0.5, 0.0, -0.2, 0.5, 0.0, 0.5)
    found = lump([(0.0, (1.0, 2.0, 3.0), one), (0.0, (4.0, 5.0, 6.0), two)])
    assert found == (0.0, (0.0, 0.0, 0.0), tuple(a + b for a, b in zip(one, two, strict=True)))


@pytest.mark.parametrize("length", [5e-324, 1e-310, 1e-160, 1.0, 1e160, 1.7e308])
def test_an_axis_of_any_length(length: float) -> None:
    assert unit((length, 0.0, -length)) == pytest.approx((0.5**0.5, 0.0, -(0.5**0.5)), rel=1e-15)
    assert direction((0.0, length, 0.0)) == (0.0, 1.0, 0.0)


def test_a_direction_is_a_unit_vector_after_what_is_small_is_taken_off() -> None:
    x, y, z = direction((1.0, 1.0, 0.9e-9))
    assert z == 0.0
    assert abs(x * x + y * y - 1.0) <= 2.3e-16
    assert direction((1.0, 0.0, 5e-10)) == (1.0, 0.0, 0.0)
    assert direction((1.0, 0.0, 2e-9))[2] == pytest.approx(2e-9)


def test_no_turn_is_made_for_nothing() -> None:
    assert spatial.fewest_turns(IDENTITY) == ()
    for k in (1, 2, 3):
        assert spatial.fewest_turns(spatial.from_turn((k, 0.5))) == ((k, 0.5),)


@pytest.mark.parametrize("off", [1e-10, 1e-8, 1e-5])
def test_three_turns_next_to_a_pitch_of_90_degrees(off: float) -> None:
    """Yaw alone is ill determined there; roll must make up for what yaw was taken to be."""
    rot = spatial.from_rpy((0.3, pi / 2 - off, 0.7))
    turns = spatial.fewest_turns(rot)
    assert len(turns) == 3
    np.testing.assert_allclose(spatial.from_turns(turns), rot, atol=1e-15)
