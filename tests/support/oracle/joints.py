"""Forces in joints: damping, friction, springs, stops, and the controller that holds the start.

Each term is called by itself, and then all together.  Damping, friction, springs, limits and
effort are the URDF's; the numbers that urdf2mbs chooses (stiffness of stops, gains) are those of
the .mbs.
"""

from fnmatch import fnmatchcase
from math import inf
from typing import Any, NamedTuple

import numpy as np

from support.oracle.case import Case

#: By term, the user model and the number there that switches the term on.
SWITCHES = {
    "damping": ("joint_forces", "damping"),
    "friction": ("joint_forces", "friction"),
    "stops": ("joint_forces", "stops"),
    "springs": ("joint_forces", "springs"),
    "hold": ("hold", "on"),
}
#: By the URDF's number, the term that needs it, if the term is called otherwise.
TERMS = {"q_min": "stops", "q_max": "stops", "spring_stiffness": "springs"}
#: The user model with the index in ux of each bristle.
STATE_NUMBERS = "friction_state"
#: Where the time of all bristles is.
TIME = ("joint_forces", "friction_time")
#: Near the start (0), or beyond the upper or lower limit, and how fast.
STATES = ((0, 0.5), (0, 30.0), (1, 0.5), (1, -3.0), (-1, 0.5), (-1, -3.0))


def prove(case: Case) -> None:
    model, asked = case.data.user_model, case.asked.get("joint-parameters")
    numbers = {number: case.stated.numbers[name] for name, number in case.single.items()}
    switches = [(term, *switch) for term, switch in SWITCHES.items() if case.get(*switch)]
    kinds = (
        {kind for joint_numbers in numbers.values() for kind in joint_numbers} if asked else set()
    )
    wanted = {TERMS.get(kind, kind) for kind in kinds} & SWITCHES.keys()
    for term in sorted(wanted - {term for term, _, _ in switches}):
        if term != "stops" or asked.stops:
            case.differ(term, "the URDF states it, and the code leaves it out")
    _prove_held(case)
    for side, speed_factor in STATES:
        q, qd = state(case, side, speed_factor)
        for _, group, name in switches:
            model[group][name] = 0.0
        total = np.zeros(len(q))
        case.compare_joints("its forces", total, case.joint_forces(q, qd))
        for term, group, name in switches:
            model[group][name] = 1.0
            expected = np.zeros(len(q))
            for joint, number in case.data.joint_id.items():
                joint_numbers = numbers.get(number, {})
                expected[number] = _force(case, term, joint, joint_numbers, q[number], qd[number])
            case.compare_joints(term, expected, case.joint_forces(q, qd))
            if term == "friction":
                _prove_bristles(case, numbers, qd)
            model[group][name] = 0.0
            total = total + expected
        for _, group, name in switches:
            model[group][name] = 1.0
        case.compare_joints("all its forces", total, case.joint_forces(q, qd))


def state(case: Case, side: int, speed_factor: float) -> tuple[Any, Any]:
    """Draw q and qd: near the start, or beyond one of the limits, on the way in or out.

    Speeds are relative to those of friction and stops.
    """
    q, qd, _ = case.near_start(1e-4)
    numbers = {number: case.stated.numbers[name] for name, number in case.single.items()}
    for name, number in case.data.joint_id.items():
        rate = case.random.uniform(0.3, 1.0) * speed_factor
        limit = numbers.get(number, {}).get("q_max" if side > 0 else "q_min")
        bristle = _bristle(case, name, numbers.get(number, {}))
        case.data.ux[bristle.state] = case.random.uniform(-2.0, 2.0) * bristle.longest
        qd[number] = rate * (bristle.longest / bristle.time or 0.01)
        if side and limit is not None:
            q[number] = limit + side * case.random.uniform(0.1, 0.5)
            qd[number] = side * rate * (case.get("joint_forces", "stop_speed") or 1.0)
    return q, qd


def _force(case: Case, term: str, name: str, numbers: Any, q: float, qd: float) -> Any:
    """Return the force of a term in a joint at a position and a speed."""
    if term == "damping":
        return -numbers.get("damping", 0.0) * qd
    if term == "springs":
        return numbers.get("spring_stiffness", 0.0) * (numbers.get("spring_reference", 0.0) - q)
    if term == "friction":
        bristle = _bristle(case, name, numbers)
        bent = case.data.ux[bristle.state] + bristle.time * qd
        return -bristle.stiffness * np.clip(bent, -bristle.longest, bristle.longest)
    if term == "stops":
        side = 1.0 if q > numbers.get("q_max", inf) else -1.0
        depth = max(numbers.get("q_min", -inf) - q, q - numbers.get("q_max", inf), 0.0)
        harder = 1.0 + side * qd / (case.get("joint_forces", "stop_speed") or 1.0)
        return -side * max(case.get("stop_stiffness", name) * depth * harder, 0.0)
    offset = case.data.q0[case.data.joint_id[name]] - q
    force = case.get("hold_stiffness", name) * offset - case.get("hold_damping", name) * qd
    effort = numbers.get("effort", 0.0) or inf
    return max(-effort, min(effort, force))


class Bristle(NamedTuple):
    """The spring by which a joint has friction."""

    longest: float
    """The deflection at which it slips (rad or m)."""
    stiffness: float
    time: float
    """s."""
    state: int
    """The index of its deflection in ux."""


def _bristle(case: Case, name: str, numbers: Any) -> Bristle:
    """Return the bristle of a joint; without friction it has the time 1 s and no stiffness."""
    stiffness, time = (case.get(*key) for key in (("friction_stiffness", name), TIME))
    longest = numbers.get("friction", 0.0) / stiffness if stiffness else 0.0
    return Bristle(longest, stiffness, time or 1.0, int(case.get(STATE_NUMBERS, name)))


def _prove_bristles(case: Case, numbers: Any, qd: Any) -> None:
    """Compare the rates of bristles: they bend with their joints, and slip back in time."""
    expected, value = np.zeros((2, len(qd)))
    for name, number in case.data.joint_id.items():
        bristle = _bristle(case, name, numbers.get(number, {}))
        if bristle.stiffness:
            bent = case.data.ux[bristle.state]
            clipped = np.clip(bent, -bristle.longest, bristle.longest)
            expected[number] = qd[number] - (bent - clipped) / bristle.time
            value[number] = case.data.uxd[bristle.state]
    case.compare_joints("the rate of its bristle", expected, value)


def _prove_held(case: Case) -> None:
    """Compare the held joints with those that the config names."""
    asked = case.asked.get("posture") and case.asked["posture"].hold
    for name, number in case.single.items() if asked else ():
        coordinate = case.conversion.names.coordinates[name][0]
        held = coordinate in case.data.user_model.get("hold_stiffness", {})
        wanted = any(fnmatchcase(name, pattern) for pattern in asked.joints or ["*"])
        follows = case.natures[number] != "independent" and name in case.stated.mimics
        if held != (wanted and not follows and case.natures[number] != "driven"):
            case.differ(f"joint '{name}'", "is held" if held else "is not held")
