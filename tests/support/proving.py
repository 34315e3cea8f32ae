"""Short robots in URDF, and the proof that a conversion of one is the same robot."""

from typing import Any

from lxml import etree

from support.compare import beside_its_urdf, lost_shapes, structure_faults
from support.oracle.urdf import Urdf
from urdf2mbs import Result
from urdf2mbs.mbs.model import Mbs
from urdf2mbs.testing import convert_text

#: What of a robot's mass is found in the wrong place, relative; all that is found is rounding.
TOLERANCE = 1e-12
FORCES = ("matrix", "gravity", "dynamics")


def prove(
    text: str | bytes, *, tolerance: float = TOLERANCE, moved: float = 0.0, **settings: Any
) -> Result:
    """Convert by ``compact`` and compare with pinocchio on the URDF, at zero and at a random
    position: the pose of every link, each rigid group's mass, centre and inertia, mass matrix,
    gravity forces, inverse dynamics, shapes.

    ``moved`` is how far (rad) axes may be moved to where they belong.
    """
    data = text.encode() if isinstance(text, str) else text
    settings.setdefault("pipeline", "compact")
    result = convert_text(data.decode(), **settings)
    assert_same(result, data, settings.get("base", "auto"), tolerance, moved)
    return result


def assert_same(
    result: Result, text: bytes, base: str, tolerance: float, moved: float = 0.0
) -> dict[str, float]:
    """The largest error of each kind."""
    # the ground has no inertia in an .mbs
    root = etree.fromstring(text)
    for element in root.findall("link"):
        if result.frames[element.get("name", "")].body is None:
            for inertial in element.findall("inertial"):
                element.remove(inertial)
    text = etree.tostring(root)
    comparison, errors = beside_its_urdf(result, Urdf.parse(text), text, base)
    # a moved axis costs poses about as much, and the forces of light joints far more
    cost = {kind: 1e4 if kind in FORCES else 10.0 for kind in errors}
    wrong = {k: off for k, off in errors.items() if not off <= tolerance + cost[k] * moved}
    assert not wrong
    assert structure_faults(comparison, faithful=False) == []
    assert lost_shapes(comparison) == []
    return errors


def chains(result: Result) -> dict[str, list[str]]:
    """Each body's joints: the type, in lower case if it is driven."""
    return {
        body.name: [
            joint.type.lower() if joint.nature == "driven" else joint.type for joint in body.joints
        ]
        for body in result.mbs.bodies
    }


def driven(result: Result) -> int:
    return sum(joint.nature == "driven" for body in result.mbs.bodies for joint in body.joints)


def models(mbs: Mbs) -> dict[str, dict[str, float]]:
    """The numbers of the user models."""
    return {
        model.name: {of.name: float(of.values[0]) for of in model.parameters}
        for model in mbs.user_models
    }


def codes(result: Result) -> set[str]:
    return {said.code for said in result.diagnostics}
