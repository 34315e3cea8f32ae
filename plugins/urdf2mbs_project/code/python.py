"""The generated module of a project in Python: tables of names, and code that uses them."""

from __future__ import annotations

from typing import Any

from urdf2mbs.mbs.model import Mbs
from urdf2mbs.messages.diagnostics import quoted
from urdf2mbs_project.code import FOLDER, dependent, fill, force_of, plotted
from urdf2mbs_project.simulation import (
    CONTACT_STATES,
    JOINT_STATES,
    Coupling,
    Simulation,
    state_numbers,
)


def robot_module(mbs: Mbs, simulation: Simulation) -> bytes:
    """The text of ``NAME_robot.py``; all names in the model must be final."""
    return (
        fill(FOLDER / "python_robot.py.in", mbs.name)
        .replace("@TABLES@\n", _tables(mbs, simulation))
        .encode()
    )


def _tables(mbs: Mbs, simulation: Simulation) -> str:
    def couplings(kind: list[Coupling]) -> list[Any]:
        return [(c.follower.name, c.leader.name, c.multiplier, c.offset) for c in kind]

    sensors = {
        s.name: (s.point.sensor.name, s.rotation)
        for s in simulation.sensors if s.point.sensor is not None
    }  # fmt: skip
    torques = {
        f.name: (tuple(joint.name for joint in f.joints), f.rotation)
        for f in simulation.force_torques
    }
    step = (
        "# A step (s) that a Runge-Kutta integrator can take with these numbers. What bounds it:\n"
    )
    parts = [
        "# Constraints: follower, leader, multiplier, offset.\n",
        _assign("COUPLINGS", couplings(simulation.couplings)),
        "N_CONSTRAINTS = len(COUPLINGS)\n\n",
        "# Joints that are driven by another: the same columns.\n",
        _assign("DRIVEN", couplings(simulation.driven)),
        "\n# Joints that follow from the constraints.\n",
        _assign("DEPENDENT", dependent(mbs)),
        "\n# External forces of the ground, each with the links of its body, and what of them may\n"
        "# touch, in the body (m): points; spheres, with a radius; points of rims, with a\n"
        "# radius, the axis, and the turn from the lowest point (rad).\n",
        _contacts(simulation),
        f"UP = np.array({simulation.up!r})\n",
        f"ACROSS = np.array({tuple(tuple(x + 0.0 for x in way) for way in simulation.across)!r})\n",
        "\n# Friction: where its states are in ux, three for each body that may touch.\n",
        _assign("FRICTION_STATES", state_numbers(mbs, JOINT_STATES)),
        f"CONTACT_STATE = {min(state_numbers(mbs, CONTACT_STATES).values(), default=0)}\n",
        "\n# Other external forces, each with the user model that says how large it is.\n",
        _assign("WRENCHES", {force_of(w.point): w.model.name for w in simulation.wrenches}),
        "\n# Springs and dampers between two points.\n",
        _assign("SPRINGS", [link.name for link in simulation.springs]),
        "\n# Sensors: Robotran's name, and the sensor's axes in the body, row by row.\n",
        _assign("SENSORS", sensors),
        "\n# Force-torque sensors: the joints whose Qc they read, the link's axes in them.\n",
        _assign("FORCE_TORQUE", torques),
        _laws(simulation),
        f"\n{step}# {quoted(simulation.shortened_by)}.\nTIME_STEP = {simulation.time_step!r}\n",
        "\n# What workR/main.py plots.\n",
        _assign("PLOTTED", plotted(mbs)),
    ]
    return "".join(parts)


def _contacts(simulation: Simulation) -> str:
    """The forces of the ground, a spot on each line."""
    lines = ["CONTACTS = {\n"]
    for contact in simulation.contacts:
        links = _literal(tuple(contact.links))
        lines.append(f"    {_literal(force_of(contact.point))}: ({links}, [\n")
        for at, radius, axis, turn in contact.spots:
            rim = (*axis, turn) if any(axis) else ()
            lines.append(f"        {_literal((*at, radius, *rim) if radius else at)},\n")
        lines.append("    ]),\n")
    return "".join([*lines, "}\n"])


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


def _assign(name: str, value: list[Any] | dict[str, Any]) -> str:
    """A list or a dict, an element on each line."""
    if isinstance(value, dict):
        (first, last), rows = "{}", [_entry(*item) for item in value.items()]
    else:
        (first, last), rows = "[]", [_literal(item) for item in value]
    inside = "".join(f"    {row},\n" for row in rows)
    return f"{name} = {first}\n{inside}{last}\n" if rows else f"{name} = {first}{last}\n"


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
