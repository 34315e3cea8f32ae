"""Forces at points (wrenches, and laws of plugins), and springs between two points."""

from __future__ import annotations

from typing import Any

import numpy as np

from urdf2mbs.laws.case import Case


def prove(case: Case) -> None:
    options = case.asked.get("forces")
    known = {c.point.extforce.name for c in case.simulation.contacts if c.point.extforce}
    for name, wrench in options.wrenches.items() if options else ():
        known.add(own := name if name in case.points else f"{name}_force")
        if own not in case.points:
            case.differ(f"force '{name}'", "it is not in the .mbs", kind="forces")
            continue
        body, point = case.points[own]
        what = f"force '{name}': where it acts"
        case.is_there(what, body, point.coordinates, wrench.link, wrench.at)
        for time in (wrench.start - 1.0, wrench.start, wrench.stop):
            acts = wrench.start <= time < wrench.stop
            should = np.array([*wrench.force, *wrench.torque]) * acts
            given = case.code.external(own, np.zeros(3), np.zeros(3), time)
            case.compare(f"force '{name}' at {time:g} s", should, given[:6], 0.0, "N, N m")
            case.compare(what, point.coordinates, given[6:], case.size, "m")
    _prove_laws(case, known)
    for name, spring in options.springs.items() if options else ():
        _prove_spring(case, name, spring)
    asked = len(options.springs) if options else 0
    for link in case.mbs.links[asked:]:
        case.unproven[f"link '{link.name}' ({link.kind})"] = "of a plugin, or added by hand"


def _prove_laws(case: Case, known: set[str]) -> None:
    """The laws of plugins at points; where no law is, there is no force."""
    laws = {p.extforce.name: law for law in case.simulation.laws for p in law.points if p.extforce}
    wrenches = {w.point.extforce.name for w in case.simulation.wrenches if w.point.extforce}
    for name, (_, point) in case.points.items():
        if point.extforce is None or point.extforce.name != name or name in known:
            continue
        at, speed = case.random.uniform(-1.0, 1.0, (2, 3))
        given = case.code.external(name, at, speed, 1.0)[:6]
        law = laws.get(name)
        if law is not None and law.should is not None:
            case.compare(f"force '{name}'", law.should(at, speed, 1.0), given, 0.0, "N, N m")
        elif law is not None or name in wrenches:
            case.unproven[f"force '{name}'"] = "of a plugin, which does not say what it should be"
        else:
            case.compare(f"force '{name}', which has no law", np.zeros(6), given, 0.0, "N, N m")


def _prove_spring(case: Case, name: str, spring: Any) -> None:
    own = name if name in {link.name for link in case.mbs.links} else f"{name}_spring"
    link = next((link for link in case.mbs.links if link.name == own), None)
    if link is None:
        case.differ(f"spring '{name}'", "it is not in the .mbs", kind="forces")
        return
    points = case.mbs.points()
    for end, meant in zip((link.endpoint1, link.endpoint2), spring.ends, strict=True):
        at = points[end].coordinates
        case.is_there(f"spring '{name}': where it ends", end[0], at, meant.link, meant.at)
    case.go(0)
    one, two = (case.on_link(end.link, end.at).at for end in spring.ends)
    rest = float(np.linalg.norm(two - one)) if spring.length is None else spring.length
    for length, rate in case.random.uniform(0.1, 2.0, (2, 2)):
        should = spring.stiffness * (length - rest) + spring.damping * rate
        scale = spring.stiffness * length
        given = case.code.spring(own, length, rate)
        case.compare(f"spring '{name}': its force", should, given, scale, "N")
