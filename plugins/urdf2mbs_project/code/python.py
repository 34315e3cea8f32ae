"""The generated module of a project in Python: tables of names, and code that uses them."""

from __future__ import annotations

from typing import Any

from urdf2mbs.plugin import Mbs, quoted
from urdf2mbs_project.code import FOLDER, dependent, fill, plotted
from urdf2mbs_project.simulation import (
    JOINT_STATES,
    Coupling,
    Simulation,
    contact_state,
    force_of,
    state_numbers,
)


def robot_module(mbs: Mbs, simulation: Simulation) -> bytes:
    """The text of ``NAME_robot.py``; all names in the model must be final."""

    def rows(couplings: list[Coupling]) -> list[Any]:
        return [(c.follower.name, c.leader.name, c.multiplier, c.offset) for c in couplings]

    tables: dict[str, Any] = {
        "COUPLINGS": rows(simulation.couplings),
        "DRIVEN": rows(simulation.driven),
        "DEPENDENT": dependent(mbs),
        "UP": simulation.up,
        "ACROSS": simulation.across,
        "FRICTION_STATES": state_numbers(mbs, JOINT_STATES),
        "CONTACT_STATE": contact_state(mbs),
        "WRENCHES": {force_of(w.point): w.model.name for w in simulation.wrenches},
        "SPRINGS": [link.name for link in simulation.springs],
        "SENSORS": {
            name: (s.point.sensor.name, s.rotation)
            for s in simulation.sensors
            if s.point.sensor is not None
            for name in (s.name, s.point.sensor.name)
        },
        "FORCE_TORQUE": {
            f.name: (tuple(joint.name for joint in f.joints), f.rotation)
            for f in simulation.force_torques
        },
        "TIME_STEP": simulation.time_step,
        "PLOTTED": plotted(mbs),
    }
    text = fill(FOLDER / "python_robot.py.in", mbs.name)
    for name, value in tables.items():
        text = text.replace(f"@{name}@", _table(value))
    text = text.replace("@CONTACTS@", _contacts(simulation))
    text = text.replace("@SHORTENED_BY@", quoted(simulation.shortened_by))
    return text.replace("@LAWS@\n", _laws(simulation)).encode()


def _contacts(simulation: Simulation) -> str:
    """The forces of the ground, a spot on each line."""
    lines = ["{\n"]
    for contact in simulation.contacts:
        links = _literal(tuple(contact.links))
        lines.append(f"    {_literal(force_of(contact.point))}: ({links}, [\n")
        for at, radius, axis, turn in contact.spots:
            rim = (*axis, turn) if any(axis) else ()
            lines.append(f"        {_literal((*at, radius, *rim) if radius else at)},\n")
        lines.append("    ]),\n")
    return "".join([*lines, "}"])


def _laws(simulation: Simulation) -> str:
    """The laws of plugins, and what each acts on."""
    laws = simulation.laws
    joints = ((joint.name, law.name) for law in laws for joint in law.joints)
    points = ((force_of(point), law.name) for law in laws for point in law.points)
    return "".join(
        [
            *(f"\n\n{law.python.strip()}\n" for law in laws),
            "\n" * (2 if laws else 1),
            "# Laws of plugins: of joints, and of external forces.\n",
            f"JOINT_LAWS = [{', '.join(f'({_literal(name)}, {law})' for name, law in joints)}]\n",
            f"POINT_LAWS = [{', '.join(f'({_literal(name)}, {law})' for name, law in points)}]\n",
        ]
    )


def _table(value: Any) -> str:
    """A list or a dict with an element on each line; another value as it is."""
    if not isinstance(value, list | dict) or not value:
        return _literal(value)
    if isinstance(value, dict):
        (first, last), rows = "{}", [_entry(*item) for item in value.items()]
    else:
        (first, last), rows = "[]", [_literal(item) for item in value]
    return "".join([f"{first}\n", *(f"    {row},\n" for row in rows), last])


def _entry(key: str, value: Any) -> str:
    entry = f"{_literal(key)}: {_literal(value)}"
    if len(entry) <= 95 or not isinstance(value, tuple):
        return entry
    parts = "".join(f"        {_literal(part)},\n" for part in value)
    return f"{_literal(key)}: (\n{parts}    )"


def _literal(value: Any) -> str:
    """A Python literal, strings in double quotes."""
    if isinstance(value, str):
        return '"' + quoted(value).replace('"', '\\"') + '"'
    if isinstance(value, tuple):
        return f"({', '.join(map(_literal, value))}{',' if len(value) == 1 else ''})"
    return repr(value + 0.0) if isinstance(value, float) else repr(value)
