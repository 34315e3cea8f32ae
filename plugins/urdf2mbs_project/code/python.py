"""The generated module of a project in Python: tables of names, and code that uses them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from urdf2mbs.plugin import Mbs, quoted
from urdf2mbs_project.code import (
    FOLDER,
    fill_template,
    list_dependent_joints,
    list_plotted_joints,
)
from urdf2mbs_project.simulation import (
    JOINT_STATES,
    Coupling,
    Simulation,
    find_first_contact_state,
    find_state_indices,
    get_force_name,
)

#: An entry of a table that is longer than this (characters) takes several lines.
MAX_ENTRY_LENGTH = 95


def generate_robot_module(mbs: Mbs, simulation: Simulation) -> bytes:
    """Return the text of ``NAME_robot.py``.

    Args:
        mbs: The model, with its final names.
        simulation: What its code is generated from.
    """
    text = fill_template(FOLDER / "python_robot.py.in", mbs.name)
    for name, value in _make_tables(mbs, simulation).items():
        text = text.replace(f"@{name}@", format_table(value))
    text = text.replace("@CONTACTS@", _format_contacts(simulation))
    text = text.replace("@SHORTENED_BY@", quoted(simulation.shortened_by))
    return text.replace("@LAWS@\n", _format_laws(simulation)).encode()


def _make_tables(mbs: Mbs, simulation: Simulation) -> dict[str, Any]:
    """Return the tables of the module by their names."""
    sensors = {}
    for sensor in simulation.sensors:
        if sensor.point.sensor is not None:
            for name in (sensor.name, sensor.point.sensor.name):
                sensors[name] = (sensor.point.sensor.name, sensor.rotation)
    return {
        "COUPLINGS": _list_rules(simulation.couplings),
        "DRIVEN": _list_rules(simulation.driven),
        "DEPENDENT": list_dependent_joints(mbs),
        "UP": simulation.up,
        "ACROSS": simulation.horizontal_axes,
        "FRICTION_STATES": find_state_indices(mbs, JOINT_STATES),
        "CONTACT_STATE": find_first_contact_state(mbs),
        "WRENCHES": {
            get_force_name(wrench.point): wrench.model.name for wrench in simulation.wrenches
        },
        "SPRINGS": [link.name for link in simulation.springs],
        "SENSORS": sensors,
        "FORCE_TORQUE": {
            sensor.name: (tuple(joint.name for joint in sensor.joints), sensor.rotation)
            for sensor in simulation.force_torques
        },
        "TIME_STEP": simulation.time_step,
        "PLOTTED": list_plotted_joints(mbs),
    }


def _list_rules(couplings: list[Coupling]) -> list[tuple[str, str, float, float]]:
    """List couplings as rows: follower, leader, multiplier, offset."""
    return [
        (coupling.follower.name, coupling.leader.name, coupling.multiplier, coupling.offset)
        for coupling in couplings
    ]


def _format_contacts(simulation: Simulation) -> str:
    """Return the table of the forces of the ground, a spot on each line."""
    lines = ["{\n"]
    for contact in simulation.contacts:
        name, links = get_force_name(contact.point), tuple(contact.links)
        lines.append(f"    {_format_literal(name)}: ({_format_literal(links)}, [\n")
        for spot in contact.spots:
            row: tuple[float, ...] = spot.centre
            if spot.radius:
                row = (*row, spot.radius)
            if spot.radius and any(spot.axis):
                row = (*row, *spot.axis, spot.rim_angle)
            lines.append(f"        {_format_literal(row)},\n")
        lines.append("    ]),\n")
    return "".join([*lines, "}"])


def _format_laws(simulation: Simulation) -> str:
    """Return the laws of plugins, and the tables of what each acts on."""
    laws = simulation.laws
    joints = (
        f"({_format_literal(joint.name)}, {law.name})" for law in laws for joint in law.joints
    )
    points = (
        f"({_format_literal(get_force_name(point))}, {law.name})"
        for law in laws
        for point in law.points
    )
    return "".join(
        [
            *(f"\n\n{law.python.strip()}\n" for law in laws),
            "\n" * (2 if laws else 1),
            "# Laws of plugins: of joints, and of external forces.\n",
            f"JOINT_LAWS = [{', '.join(joints)}]\n",
            f"POINT_LAWS = [{', '.join(points)}]\n",
        ]
    )


def format_table(value: Any) -> str:
    """Return a list or a dict with an element on each line; another value as a literal."""
    if not isinstance(value, list | dict) or not value:
        return _format_literal(value)
    if isinstance(value, Mapping):
        first, last = "{", "}"
        rows = [_format_entry(key, element) for key, element in value.items()]
    else:
        first, last = "[", "]"
        rows = [_format_literal(element) for element in value]
    return "".join([f"{first}\n", *(f"    {row},\n" for row in rows), last])


def _format_entry(key: str, value: Any) -> str:
    """Return an entry of a dict, over several lines if it is a long tuple."""
    entry = f"{_format_literal(key)}: {_format_literal(value)}"
    if len(entry) <= MAX_ENTRY_LENGTH or not isinstance(value, tuple):
        return entry
    elements = "".join(f"        {_format_literal(element)},\n" for element in value)
    return f"{_format_literal(key)}: (\n{elements}    )"


def _format_literal(value: Any) -> str:
    """Return a Python literal, strings in double quotes, without negative zeros."""
    if isinstance(value, str):
        return '"' + quoted(value).replace('"', '\\"') + '"'
    if isinstance(value, tuple):
        return f"({', '.join(map(_format_literal, value))}{',' if len(value) == 1 else ''})"
    return repr(value + 0.0) if isinstance(value, float) else repr(value)
