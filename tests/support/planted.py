"""Faults that are planted in an .mbs, for tests of the proof and of the certificate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from urdf2mbs.mbs.model import Connection, Joint, Mbs, Sensor, UserConstraint
from urdf2mbs.testing import TINY

Plant = Callable[[Mbs], None]
"""Changes a model."""

MIMIC = TINY.replace(
    '<axis xyz="0 1 1"/>', '<axis xyz="0 1 1"/><mimic joint="wrist_roll" multiplier="2"/>'
)
WORLD = TINY.replace(
    '<link name="body">',
    '<link name="world"/><joint name="stand" type="fixed"><parent link="world"/>'
    '<child link="body"/></joint><link name="body">',
)
ALL_JOINTS = ("shoulder", "wrist_roll", "wrist_pitch")


class NatureFault(NamedTuple):
    """A fault that concerns the nature of joints, a cut, or the base."""

    urdf: str
    base: str
    """Of the .mbs: ``auto``, ``fixed`` or ``floating``."""
    plant: Plant
    kind: str
    """The kind of a difference that is found."""


# --- elements of a model ---


def find_body(mbs: Mbs, name: str) -> Any:
    """Find a body; its mass and inertia may be None."""
    return next(body for body in mbs.bodies if body.name == name)


def find_joint(mbs: Mbs, name: str) -> Joint:
    """Find a joint."""
    return mbs.joints()[name]


# --- faults ---


def do_nothing(_: Mbs) -> None:
    """Leave a model as it is."""


def set_joint(name: str, **values: Any) -> Plant:
    """Give a joint other values."""

    def plant(mbs: Mbs) -> None:
        for key, value in values.items():
            setattr(find_joint(mbs, name), key, value)

    return plant


def set_body(name: str, **values: Any) -> Plant:
    """Give a body other values."""

    def plant(mbs: Mbs) -> None:
        for key, value in values.items():
            setattr(find_body(mbs, name), key, value)

    return plant


def set_parameter(model_name: str, joint: str, text: str) -> Plant:
    """Give a joint another number in a user model."""

    def plant(mbs: Mbs) -> None:
        (model,) = (model for model in mbs.user_models if model.name == model_name)
        (parameter,) = (parameter for parameter in model.parameters if parameter.name == joint)
        parameter.values = (text,)

    return plant


def set_driven_rotation(**values: Any) -> Plant:
    """Give the driven rotation before the shoulder other values."""

    def plant(mbs: Mbs) -> None:
        joints = find_body(mbs, "arm").joints
        (rotation,) = (joint for joint in joints if joint.nature == "driven" and joint.q)
        for key, value in values.items():
            setattr(rotation, key, value)

    return plant


def set_natures(nature: str, *names: str) -> Plant:
    """Give joints another nature."""

    def plant(mbs: Mbs) -> None:
        for name in names:
            find_joint(mbs, name).nature = nature

    return plant


def change_gravity(index: int, share: float) -> Plant:
    """Change a component of gravity by a share of g."""

    def plant(mbs: Mbs) -> None:
        gravity = list(mbs.base.gravity)
        gravity[index] += 9.81 * share
        mbs.base.gravity = (gravity[0], gravity[1], gravity[2])

    return plant


def change_tensor(index: int) -> Plant:
    """Change an element of the inertia of the first body by 1e-6."""

    def plant(mbs: Mbs) -> None:
        tensor = list(mbs.bodies[0].inertia or ())
        tensor[index] += 1e-6
        mbs.bodies[0].inertia = tuple(tensor)  # type: ignore[assignment]

    return plant


def negate_products(mbs: Mbs) -> None:
    """Negate the products of inertia of the arm."""
    xx, xy, xz, yy, yz, zz = find_body(mbs, "arm").inertia
    find_body(mbs, "arm").inertia = (xx, -xy, -xz, yy, -yz, zz)


def add_joint(nature: str) -> Plant:
    """Add a joint to the hand."""
    return lambda mbs: find_body(mbs, "hand").joints.append(Joint("more", "R1", nature))


def add_cut(kind: str, nature: str = "independent", *names: str) -> Plant:
    """Add a cut from the hand to the ground, and give joints another nature."""

    def plant(mbs: Mbs) -> None:
        set_natures(nature, *names)(mbs)
        length = 0.5 if kind == "rod" else None
        mbs.cuts.append(Connection(kind, "tie", ("hand", "tool"), (None, None), length))

    return plant


def constrain_follower(mbs: Mbs) -> None:
    """Make the follower of ``MIMIC`` dependent by a user constraint."""
    find_joint(mbs, "wrist_pitch").nature = "dependent"
    mbs.user_constraints.append(UserConstraint("follows", ("wrist_pitch", "wrist_roll")))


def add_force(mbs: Mbs) -> None:
    """Add an external force."""
    mbs.bodies[0].points[0].extforce = Sensor("push", ("Pos",))


#: What is planted in TINY, and the kinds of the differences.  A driven joint is at a position, so
#: that a fault after it is not taken for a wrong zero.
PLANTED: dict[str, tuple[Plant, set[str]]] = {
    **{
        f"gravity {index} off by {share}": (
            change_gravity(index, share),
            {"gravity"} if share > 1e-9 else set(),
        )
        for index in (0, 2)
        for share in (1e-12, 1e-8, 1e-3)
    },
    "dependent": (set_joint("shoulder", nature="dependent"), {"nature"}),
    "held": (set_joint("shoulder", nature="driven", q=0.4), {"nature"}),
    "held, and of another type": (set_joint("shoulder", nature="driven", type="T3"), {"nature"}),
    "starts elsewhere": (set_joint("shoulder", q=0.4), set()),
    "slides": (set_joint("shoulder", type="T3"), {"type"}),
    "no mass": (set_body("hand", mass=None), {"mass", "inertia"}),
    "a centre negated": (set_body("arm", com=(0.0, 0.0, -0.15)), {"centre"}),
    "products of inertia negated": (negate_products, {"inertia"}),
    "an anchor 1e-6 m off": (
        lambda mbs: setattr(find_body(mbs, "body").points[0], "coordinates", (0.100001, 0.0, 0.15)),
        {"frame"},
    ),
    "damping a hundredfold": (set_parameter("damping", "shoulder", "10.0"), {"parameter"}),
    "a limit moved": (set_parameter("q_max", "shoulder", "1.5015"), {"parameter"}),
    "no symbols": (set_joint("shoulder", symbols=()), {"symbols"}),
    "q alone in the symbols": (set_joint("shoulder", symbols=("q",)), {"symbols"}),
    "no q in the symbols of a driven joint": (set_driven_rotation(symbols=("qd",)), {"symbols"}),
    "a velocity of a driven joint": (set_driven_rotation(symbols=None, qd=1.0), {"symbols"}),
    "an acceleration of a driven joint": (set_driven_rotation(symbols=None, qdd=1.0), {"symbols"}),
    "a rotation of 1e-8 too much": (set_driven_rotation(q=0.5 + 1e-8), {"frame"}),
    "another rotation": (set_driven_rotation(q=-0.5), {"frame"}),
    "a joint too many": (add_joint("independent"), {"joint-extra"}),
    "a dependent joint too many": (add_joint("dependent"), {"joint-extra"}),
}
NATURE_FAULTS: dict[str, NatureFault] = {
    "a base that floats, of a robot fixed to the world": NatureFault(
        WORLD, "floating", do_nothing, "base"
    ),
    "a follower that is driven": NatureFault(
        MIMIC, "auto", set_natures("driven", "wrist_pitch"), "nature"
    ),
    "a follower that nothing moves": NatureFault(
        MIMIC, "auto", set_natures("dependent", "wrist_pitch"), "nature"
    ),
    "a cut that welds": NatureFault(
        TINY, "fixed", add_cut("solid", "dependent", *ALL_JOINTS), "cut"
    ),
    "a cut without a dependent joint": NatureFault(TINY, "fixed", add_cut("rod"), "cut"),
    "a cut with too many dependent joints": NatureFault(
        TINY, "fixed", add_cut("rod", "dependent", "shoulder", "wrist_roll"), "cut"
    ),
    "a dependent joint that no cut moves": NatureFault(
        TINY, "fixed", set_natures("dependent", "wrist_pitch"), "nature"
    ),
}
#: Set a number of TINY's model to any value.
NUMBERS: dict[str, Callable[[Mbs, float], None]] = {
    "gravity": lambda mbs, value: setattr(mbs.base, "gravity", (0.0, value, -9.81)),
    "mass": lambda mbs, value: setattr(mbs.bodies[1], "mass", value),
    "centre": lambda mbs, value: setattr(mbs.bodies[1], "com", (0.0, value, 0.15)),
    "inertia": lambda mbs, value: setattr(
        mbs.bodies[1], "inertia", (1.0, 0.0, value, 1.0, 0.0, 1.0)
    ),
    "anchor": lambda mbs, value: setattr(
        mbs.bodies[0].points[0], "coordinates", (0.1, value, 0.15)
    ),
    "angle": lambda mbs, value: setattr(mbs.bodies[1].joints[0], "q", value),
}
