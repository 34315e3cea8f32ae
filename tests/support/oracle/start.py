"""The start: positions that were asked for, limits, rules of followers, and feet on the ground."""

from fnmatch import fnmatchcase
from math import inf

from support.oracle import followers
from support.oracle import ground as ground_law
from support.oracle.case import Case


def prove(case: Case) -> None:
    q, options, ground = case.data.q0, case.asked.get("posture"), case.asked.get("contacts")
    tied = {**followers.rules(case, "dependent"), **followers.rules(case, "driven")}
    for number, (row, offset) in tied.items():
        name = list(case.data.joint_id)[number - 1]
        case.compare(f"joint '{name}': its start", offset, row @ q, "(its rule)", 1.0)
    leaders = {k for row, _ in tied.values() for k in row.nonzero()[0]}
    stated_starts = case.stated.starts if options.from_urdf else {}
    for name, number in case.single.items():
        if number in tied or case.natures[number] != "independent":
            continue  # a loop may move it
        limits = case.stated.numbers[name]
        low, high = limits.get("q_min", -inf), limits.get("q_max", inf)
        asked = [value for p, value in options.joints.items() if fnmatchcase(name, p)]
        should = (asked or [stated_starts.get(name, 0.0)])[-1]
        # a leader also keeps the limits of those that follow it
        wanted = q[number] if number in leaders else should
        wanted = min(max(wanted, low), high) if options.inside else wanted
        case.compare(f"joint '{name}': its start", wanted, q[number], "rad or m", 1.0)
    contacts = case.simulation.contacts
    if case.conversion.base.inserted is not None and ground and ground.stand and contacts:
        case.go(0)
        low = min(ground_law.lowest(case, c) for c in contacts)
        case.compare("the lowest contact at start", ground.ground, low, "m", case.size)
