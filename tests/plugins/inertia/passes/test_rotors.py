"""Rotors: the inertia that joints feel behind their gears is Pinocchio's armature."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.build import SOLID, joint, link, robot
from urdf2mbs import convert, load_equations
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs.testing import convert_text

MOTOR = (
    '<transmission name="t"><joint name="{}"><mechanicalReduction>7</mechanicalReduction></joint>'
    "<actuator>{}</actuator></transmission>"
)
GEAR = "<mechanicalReduction>-50</mechanicalReduction><motorInertia>2e-4</motorInertia>"
ROBOT = robot(
    link("a", SOLID),
    link("b", SOLID),
    link("c", SOLID),
    link("d", SOLID),
    link("e", SOLID),
    joint("a", "b", "revolute", xyz="0 0 0.5", rpy="0.3 0.2 0.1", axis="1 2 3"),
    joint("b", "c", "prismatic", xyz="0 0.4 0", rpy="1.5707963267948966 0 0"),
    joint("c", "d", "revolute", xyz="0.3 0 0.1", axis="0 -1 0"),
    joint("a", "e", "revolute", xyz="0.3 0 0.1", axis="0 -1 1"),
    MOTOR.format("a_to_b", GEAR),
    MOTOR.format("b_to_c", "<motorInertia>0.01</motorInertia>"),
    MOTOR.format("c_to_d", "<motorInertia>many</motorInertia>"),
    MOTOR.format("a_to_e", "<mechanicalReduction>3</mechanicalReduction>"),
)
STATED = {"a_to_b": 0.5, "b_to_c": 0.49}
OWN = {"from_urdf": True, "armature": {"c_to_*": 0.2, "a_to_e": 1.5}}


def test_a_transmission_states_the_inertia() -> None:
    result = convert_text(ROBOT)
    found: dict[str, float] = {}
    for extension in result.robot.extensions:
        found |= extension.rotors
    assert found == pytest.approx(STATED)
    said = {diagnostic.code: diagnostic for diagnostic in result.diagnostics}
    assert "joint 'a_to_b' 0.5, joint 'b_to_c' 0.49 kg m^2" in said["rotors-left-out"].message
    assert said["number-left-out"].message.startswith("the inertia of a rotor is left out")
    with pytest.raises(ConfigError) as wrong:
        convert_text(ROBOT, passes={"rotors": {"armature": {"a_to_b": 1.0}}})
    assert wrong.value.code == "rotors-project"
    result = convert_text(ROBOT, passes={"rotors": {"from_urdf": True}})
    assert "rotors-left-out" in {diagnostic.code for diagnostic in result.diagnostics}


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_accelerations_are_those_of_pinocchios_armature(base: str, tmp_path: Path) -> None:
    pin = pytest.importorskip("pinocchio")
    (tmp_path / "r.urdf").write_text(ROBOT)
    options: dict[str, dict[str, Any]] = {"rotors": OWN}
    made = convert(
        tmp_path / "r.urdf",
        base=base,
        pipeline="compact",
        passes=options,
        output={"project": str(tmp_path / "p")},
    )
    assert made.report.proof is not None
    assert made.report.proof.same
    assert made.report.mass == pytest.approx(8.0 if base == "fixed" else 10.0)
    assert "4 links added, 4 joints added" in made.report.verdict
    armature = {**STATED, "c_to_d": 0.2, "a_to_e": 1.5}
    assert made.conversion.report["rotors"] == pytest.approx(armature)

    equations = load_equations(
        tmp_path / "r.urdf", base=base, pipeline="compact", passes=options, language="python"
    )
    root = pin.JointModelFreeFlyer() if base == "floating" else None
    model = pin.buildModelFromXML(ROBOT, root) if root else pin.buildModelFromXML(ROBOT)
    for name, inertia in armature.items():
        model.armature[model.joints[model.getJointId(name)].idx_v] = inertia
    rng = np.random.default_rng(2)
    names = list(equations.joints)
    moving = [model.names[i] for i in range(1, model.njoints) if model.names[i] in armature]
    for _ in range(5):
        q, qd, tau = rng.uniform(-1, 1, (3, len(moving)))
        own = np.zeros((3, len(names)))
        for k, name in enumerate(names):
            if name.removesuffix("_rotor_turn") in moving:
                at = moving.index(name.removesuffix("_rotor_turn"))
                own[:, k] = q[at], qd[at], tau[at]
                if name.endswith("_turn"):
                    own[2, k] = 0.0
        accelerations = equations.forward_dynamics(*own)
        found = [accelerations[names.index(name)] for name in moving]
        full = pin.neutral(model)
        full[-len(moving) :] = q
        v, force = np.zeros(model.nv), np.zeros(model.nv)
        v[-len(moving) :], force[-len(moving) :] = qd, tau
        wanted = pin.aba(model, model.createData(), full, v, force)[-len(moving) :]
        assert np.allclose(found, wanted, rtol=1e-9, atol=1e-9)
