"""NAME_tables.h: the spots of bodies, the axes of sensors, and the names of joints."""

from __future__ import annotations

from math import cos, sin

from urdf2mbs.plugin import IDENTITY, Mbs
from urdf2mbs_project.code import list_dependent_joints
from urdf2mbs_project.code.c_text import escape_comment, format_array, format_numbers
from urdf2mbs_project.simulation import (
    Simulation,
    Spot,
    find_first_contact_state,
    get_force_name,
)


def generate_tables(mbs: Mbs, simulation: Simulation) -> str:
    """Return the text of NAME_tables.h."""
    joints = (f'"{name}"' for name in ("ground", *mbs.numbers()))
    return "".join(
        [
            f"/* The tables of {mbs.name}_robot.c; {mbs.name}_laws.h has their types.\n"
            " *\n * urdf2mbs writes this file anew at each conversion: do not edit it. */\n\n",
            _format_directions(simulation),
            _format_contacts(mbs, simulation),
            _format_sensor_axes(simulation),
            "/* The names of the joints by Robotran's number; those that follow from the "
            "constraints. */\n",
            format_array("char *const", "joint_names", joints),
            f'static const char dependent_joints[] = "{" ".join(list_dependent_joints(mbs))}";\n',
        ]
    )


def _format_directions(simulation: Simulation) -> str:
    """Return the directions up and along the ground."""
    across = ", ".join(f"{{{format_numbers(axis)}}}" for axis in simulation.horizontal_axes)
    return (
        "/* The direction against gravity, and two directions in the ground, in the axes of the "
        "base. */\n"
        f"static const double up[3] = {{{format_numbers(simulation.up)}}};\n"
        f"static const double across[2][3] = {{{across}}};\n\n"
    )


def _format_contacts(mbs: Mbs, simulation: Simulation) -> str:
    """Return the spots of each contact, and its struct Contact."""
    texts = []
    first_state = find_first_contact_state(mbs)
    for k, contact in enumerate(simulation.contacts):
        name = get_force_name(contact.point)
        state = first_state + 3 * k
        fields = f"{len(contact.spots)}, {state}, {contact.bounding_radius!r}"
        texts += [
            f"/* {escape_comment(', '.join(contact.links))} */\n",
            format_array("Spot", f"{name}_spots", map(_format_spot, contact.spots)),
            f"static const Contact {name} = {{{name}_spots, {fields}}};\n\n",
        ]
    return "".join(texts)


def _format_spot(spot: Spot) -> str:
    """Return a struct Spot."""
    axis = f", .axis = {{{format_numbers(spot.axis)}}}" if any(spot.axis) else ""
    rim = ""
    if spot.radius:
        down, aside = spot.radius * cos(spot.rim_angle), spot.radius * sin(spot.rim_angle)
        rim = f", .rim = {{{format_numbers((down, aside))}}}"
    return f"{{.centre = {{{format_numbers(spot.centre)}}}{axis}{rim}}}"


def _format_sensor_axes(simulation: Simulation) -> str:
    """Return the axes of each sensor in its body, and those of a body."""
    lines = [
        "/* The axes of sensors in their bodies, row by row; those of a body without a sensor. */\n"
    ]
    for sensor in simulation.sensors:
        if sensor.point.sensor is not None:
            array = f"{sensor.point.sensor.name}_axes[9]"
            lines.append(f"static const double {array} = {{{format_numbers(sensor.rotation)}}};\n")
    lines.append(f"static const double body_axes[9] = {{{format_numbers(IDENTITY)}}};\n\n")
    return "".join(lines)
