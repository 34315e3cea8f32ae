"""Forces in joints: damping, friction, soft stops, and the controller that holds the start.

Each term is called by itself, and then all together.  Damping, friction, limits and effort are
the URDF's.  The numbers that urdf2mbs chooses follow from the inertia that the joint feels or
carries.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from math import inf, pi
from typing import Any

import numpy as np

from urdf2mbs.laws.case import Case
from urdf2mbs.proof.parameters import stated

#: By term, the user model and the number there that switches the term on.
SWITCHES = {
    "damping": ("joint_forces", "damping"), "friction": ("joint_forces", "friction"),
    "stops": ("joint_forces", "stops"), "hold": ("hold", "on"),
}  # fmt: skip
#: The slope of friction at rest is at most this times the inertia (1/s).
SLOPE = 300.0
#: The frequency (Hz) and damping ratio of what is held.
HELD = (10.0, 0.3)
#: How friction rises with the speed, in parts of the speed at which it is nearly full.  Far above
#: this speed it is 1, and at rest 0, whatever the law.
RISE = np.tanh


def prove(case: Case) -> None:
    numbers = {case.numbers[own]: stated(case.robot.joints[name]) for name, own in _single(case)}
    _prove_choices(case)
    switches = {term: switch for term, switch in SWITCHES.items() if case.code.get(*switch)}
    for term in ("damping", "friction"):
        lost = [number for number, own in numbers.items() if term in own]
        if lost and term not in switches and "joint-parameters" in case.asked:
            case.differ(term, "the URDF states it, and it is switched off")
    for switch in switches.values():
        case.code.set(*switch, 0.0)
    for factor in (1.0, 40.0):
        _prove_terms(case, numbers, switches, factor)
    for switch in switches.values():
        case.code.set(*switch, 1.0)


def _single(case: Case) -> list[tuple[str, str]]:
    return list(case.single.items()) if "joint-parameters" in case.asked else []


def _prove_terms(
    case: Case, numbers: dict[int, dict[str, float]], switches: dict[str, Any], factor: float
) -> None:
    """Compare each term, and their sum, at a random state; ``factor``: how fast."""
    code = case.code
    q, qd, _ = case.state()
    for number, own in numbers.items():  # on both sides of each limit
        if "q_min" in own or "q_max" in own:
            low, high = own.get("q_min", -inf), own.get("q_max", inf)
            low, high = max(low, min(high, 0.0) - pi), min(high, max(low, 0.0) + pi)
            q[number] = case.random.uniform(low - 0.5 * (high - low), high + 0.5 * (high - low))
    qd *= factor
    alone = code.joint_forces(q, qd)
    plugins = _laws(case, q, qd, alone)
    total = np.array(alone)
    for term, switch in switches.items():
        code.set(*switch, 1.0)
        should = np.zeros(len(q))
        for name, number in case.numbers.items():
            should[number] = _force(case, term, name, numbers.get(number, {}), q, qd)
        case.compare_joints(term, should, code.joint_forces(q, qd) - alone)
        code.set(*switch, 0.0)
        total += should
    for switch in switches.values():
        code.set(*switch, 1.0)
    case.compare_joints("all its forces", total, code.joint_forces(q, qd))
    for switch in switches.values():
        code.set(*switch, 0.0)
    case.compare_joints("its forces", plugins, alone)


def _force(case: Case, term: str, name: str, own: dict[str, float], q: Any, qd: Any) -> float:
    """What a term gives a joint."""
    at, rate, get = q[case.numbers[name]], qd[case.numbers[name]], case.code.get
    if term == "damping":
        return -own.get("damping", 0.0) * rate
    if term == "friction" and "friction" in own:
        return float(-own["friction"] * RISE(rate / (get("friction_speed", name) or inf)))
    if term == "stops" and own.keys() & {"q_min", "q_max"}:
        side = 1.0 if at > own.get("q_max", inf) else -1.0
        depth = max(own.get("q_min", -inf) - at, at - own.get("q_max", inf), 0.0)
        harder = 1.0 + side * rate / (get("joint_forces", "stop_speed") or inf)
        return -side * max((get("stop_stiffness", name) or 0.0) * depth * harder, 0.0)
    if term == "hold" and get("hold_stiffness", name) is not None:
        stiffness, damping = get("hold_stiffness", name) or 0.0, get("hold_damping", name) or 0.0
        push = stiffness * (case.code.start[case.numbers[name]] - at) - damping * rate
        most = own.get("effort", 0.0) or inf
        return max(-most, min(most, push)) if most > 0.0 else push
    return 0.0


def _laws(case: Case, q: Any, qd: Any, alone: Any) -> Any:
    """What the laws of plugins should give, as their plugins say; else what they give."""
    should = np.zeros(len(q))
    for law in case.simulation.laws:
        if law.should is None:
            case.unproven[f"law '{law.name}'"] = "of a plugin, which does not say what it should be"
        for joint in law.joints:
            number = case.numbers[joint.name]
            given = alone[number] if law.should is None else law.should(q[number], qd[number])
            should[number] = given if law.should is None else should[number] + given
    return should


def _prove_choices(case: Case) -> None:
    """Compare the numbers that were chosen with the inertias that they follow from."""
    get, (carried, felt) = case.code.get, case.inertias
    options = case.asked.get("joint-parameters")
    for name, own in _single(case):
        number, inertia = stated(case.robot.joints[name]), felt[case.numbers[own]]
        if "friction" in number:
            speed = options.friction_speed
            fine = speed if inertia <= 0.0 else max(speed, number["friction"] / (SLOPE * inertia))
            case.choice(f"joint '{name}': friction_speed", get("friction_speed", own), fine, -1)
        if number.keys() & {"q_min", "q_max"} and options.stops:
            stiffness = inertia * (2 * pi * options.stop_frequency) ** 2
            case.choice(f"joint '{name}': stop_stiffness", get("stop_stiffness", own), stiffness, 1)
    asked = case.asked.get("posture") and case.asked["posture"].hold
    standing = {contact.link for contact in case.simulation.contacts}
    for name, own in case.single.items() if asked else ():
        held = case.natures[case.numbers[own]] == "independent" and any(
            fnmatchcase(name, pattern) for pattern in asked.joints or ["*"]
        )
        stiffness, damping = get("hold_stiffness", own), get("hold_damping", own)
        if held != (stiffness is not None) or held != (damping is not None):
            case.differ(f"joint '{name}'", f"is {'not ' * held}held", kind="forces")
        if not held or stiffness is None or damping is None:
            continue
        gains = [asked, *(g for p, g in asked.gains.items() if fnmatchcase(name, p))]
        last = gains[-1]
        frequency = last.frequency or asked.frequency or HELD[0]
        ratios = [gain.damping_ratio for gain in (last, asked) if gain.damping_ratio is not None]
        ratio = [*ratios, HELD[1]][0]
        if last.stiffness is not None:
            case.choice(f"joint '{name}': hold_stiffness", stiffness, last.stiffness, 1)
        elif not standing:
            inertia = carried[case.numbers[own]]
            should = inertia * (2 * pi * frequency) ** 2
            case.choice(f"joint '{name}': hold_stiffness", stiffness, should, 1)
        if last.damping is not None:
            case.choice(f"joint '{name}': hold_damping", damping, last.damping, 1)
        elif stiffness and last.stiffness is None:
            # of the inertia that its stiffness says it carries
            should = 2 * ratio * stiffness / (2 * pi * frequency)
            most = 3000.0 * felt[case.numbers[own]]
            slack = 1.1 * min(should, most) + 1e-300
            if not damping <= slack or (damping < 0.9 * min(should, most)):
                case.choice(f"joint '{name}': hold_damping", damping, min(should, most), 1)

