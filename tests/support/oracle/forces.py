"""Forces at points (wrenches), and springs between two points."""

from typing import Any

import numpy as np

from support.oracle.case import Case


def prove(case: Case) -> None:
    options, points = case.asked.get("forces"), case.points
    names = {c.point.extforce.name for c in case.simulation.contacts if c.point.extforce}
    for name, wrench in options.wrenches.items() if options else ():
        names.add(force_name := name if name in points else f"{name}_force")
        place = points[force_name][0], points[force_name][1].name
        case.compare_place(f"force '{name}'", place, wrench.link, wrench.at)
        for time in (wrench.start - 1.0, wrench.start, wrench.stop):
            acts = float(wrench.start <= time < wrench.stop)
            force = acts * np.array([*wrench.force, *wrench.torque])
            expected = [*force, *points[force_name][1].coordinates]
            actual = case.external(force_name, np.zeros(3), np.zeros(3), time)
            case.compare(f"force '{name}' at {time:g} s", expected, actual, "N, N m, m")
    for name in [name for name in case.data.extforce_id if name not in names]:
        position, speed = case.random.uniform(-1.0, 1.0, (2, 3))
        actual = case.external(name, position, speed, 1.0)[:6]
        case.compare(f"force '{name}', which has no law", np.zeros(6), actual, "N, N m")
    for name, spring in options.springs.items() if options else ():
        _prove_spring(case, name, spring)


def _prove_spring(case: Case, name: str, spring: Any) -> None:
    link_name = name if name in case.data.link_id else f"{name}_spring"
    link = next(link for link in case.mbs.links if link.name == link_name)
    for end, meant in zip((link.endpoint1, link.endpoint2), spring.ends, strict=True):
        case.compare_place(f"an end of spring '{name}'", end, meant.link, meant.at)
    case.go(0)
    first, second = (case.on_link(end.link, end.at).P for end in spring.ends)
    rest = float(np.linalg.norm(second - first)) if spring.length is None else spring.length
    for length, rate in case.random.uniform(0.1, 2.0, (2, 2)):
        expected = spring.stiffness * (length - rest) + spring.damping * rate
        actual = case.data.user_LinkForces(
            length, rate, case.data, 0.0, case.data.link_id[link_name]
        )
        case.compare(f"spring '{name}'", expected, actual, "N", spring.stiffness * length)
