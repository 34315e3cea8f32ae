"""Sensors, external forces, loops, limits and user models: marks of the 3D model, and tables.

All is read from the written .mbs.  Only the use of a point comes from the passes that made it.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import dist, isfinite
from typing import Any, NamedTuple, TypeAlias

from urdf2mbs.plugin import (
    ZERO,
    Mbs,
    Point,
    Summary,
    Use,
    Vec,
    add,
    compute_placement,
    rotate,
)
from urdf2mbs_report.tables import Cell, PageTable, Row, format_cell

Endpoint: TypeAlias = "tuple[str | None, str | None]"
"""The names of a body, None for the base, and of one of its points, None for its origin."""

Limits: TypeAlias = "tuple[float | None, float | None]"
"""The lower and the upper limit of a joint (rad or m); None if there is none."""

#: The user models that hold the limits of joints.
LIMIT_MODELS = ("q_min", "q_max")


class LimitParameter(NamedTuple):
    """A limit of a joint, as the text in its user model."""

    user_model: str
    joint: str
    text: str


# --- limits ---


def find_unreadable_limits(model: Mbs) -> list[str]:
    """Return a sentence for each limit of a joint that is not a number, and so is not drawn."""
    joint_numbers = model.numbers()
    return [
        f"joint '{joint_name}': {user_model} is '{limit_text}'; expected a number, "
        "and no stop is drawn"
        for user_model, joint_name, limit_text in _list_limit_parameters(model)
        if joint_name in joint_numbers
        and _parse_finite(limit_text) is None
        and limit_text.strip().lower().lstrip("+-") != "inf"
    ]


def _find_limits(model: Mbs) -> dict[str, Limits]:
    """Return the limits of the joints that have some, in the order of the joints."""
    limits: dict[str, dict[str, float | None]] = {model_name: {} for model_name in LIMIT_MODELS}
    for user_model, joint_name, limit_text in _list_limit_parameters(model):
        limits[user_model][joint_name] = _parse_finite(limit_text)
    lower_limits, upper_limits = limits["q_min"], limits["q_max"]
    return {
        joint_name: (lower_limits.get(joint_name), upper_limits.get(joint_name))
        for joint_name in model.numbers()
        if joint_name in lower_limits or joint_name in upper_limits
    }


def _list_limit_parameters(model: Mbs) -> list[LimitParameter]:
    """Return the parameters of the user models that hold limits."""
    return [
        LimitParameter(user_model.name, parameter.name, parameter.values[0])
        for user_model in model.user_models
        if user_model.name in LIMIT_MODELS
        for parameter in user_model.parameters
        if parameter.values
    ]


def _parse_finite(number_text: str) -> float | None:
    """Return a finite number; None for other texts."""
    try:
        number = float(number_text)
    except ValueError:
        return None
    return number if isfinite(number) else None


# --- marks ---


def list_marks(summary: Summary, model: Mbs) -> dict[str, Any]:
    """List the marks that the 3D model shows beside shapes, for the script of the page.

    Returns:
        ``points``: (body, point in the body's frame (m), kind, rotation or None);
        ``lines``: (kind, (body, point), (body, point)); ``stops``: (joint, limits);
        ``ground``: the height of the ground (m).
    """
    point_marks: list[tuple[Any, ...]] = []
    points = model.points()
    for (body, _), point in points.items():
        if point.sensor is not None:
            use = summary.uses.get(point.sensor.name)
            point_marks.append((body, point.coordinates, "sensors", use and use.rotation))
        point_marks += [
            (body, position, force_kind, None)
            for position, force_kind in _list_forces(summary, point)
        ]
    line_marks = [
        (
            connection.kind,
            (connection.endpoint1[0], _get_position(points, connection.endpoint1)),
            (connection.endpoint2[0], _get_position(points, connection.endpoint2)),
        )
        for connection in (*model.cuts, *model.links)
        if not connection.is_draft
    ]
    return {
        "points": point_marks,
        "lines": line_marks,
        "stops": list(_find_limits(model).items()),
        "ground": _find_ground(model),
    }


def list_cuts(model: Mbs) -> list[dict[str, Any]]:
    """List the cuts that close loops, for the script of the page; lengths are in m."""
    points = model.points()
    return [
        {
            "kind": cut.kind,
            "name": cut.name,
            "first": (cut.endpoint1[0], _get_position(points, cut.endpoint1)),
            "second": (cut.endpoint2[0], _get_position(points, cut.endpoint2)),
            "length": cut.length or 0.0,
        }
        for cut in model.cuts
        if not cut.is_draft
    ]


def _find_ground(model: Mbs) -> float:
    """Return the height of the ground (m) of the contacts; 0 without contacts."""
    for user_model in model.user_models:
        for parameter in user_model.parameters:
            if (user_model.name, parameter.name) == ("contact", "ground") and parameter.values:
                return _parse_finite(parameter.values[0]) or 0.0
    return 0.0


def _list_forces(summary: Summary, point: Point) -> list[tuple[Vec, str]]:
    """Return where the external force of a point acts (m, in the body's frame), and its kind."""
    if point.extforce is None:
        return []
    use = summary.uses.get(point.extforce.name)
    force_kind = "contacts" if use is not None and use.what == "contact" else "forces"
    positions = use.spots if use is not None and use.spots else (point.coordinates,)
    return [(position, force_kind) for position in positions]


def _get_position(points: Mapping[Endpoint, Point], endpoint: Endpoint) -> Vec:
    """Return the position of an endpoint in its body's frame (m)."""
    point = points.get(endpoint)
    return ZERO if point is None else point.coordinates


# --- tables ---


def make_connection_tables(summary: Summary, model: Mbs) -> list[PageTable]:
    """Make the tables of points, loops and user models; those that have rows."""
    tables = [_make_point_table(summary, model)]
    for title, columns, rows in summary.tables:
        linked_rows = [Row(row, {"data-link": row[1]}) for row in rows]
        tables.append(PageTable(columns, linked_rows, title=title))
    tables.append(_make_loop_table(model))
    tables += _make_user_model_tables(model)
    return [table for table in tables if table.rows]


def _make_point_table(summary: Summary, model: Mbs) -> PageTable:
    """Make the table of sensors and external forces; with their uses if passes made some."""
    rows = []
    for (body, _), point in model.points().items():
        for element, element_kind in ((point.sensor, "sensor"), (point.extforce, "external force")):
            if element is None:
                continue
            cells: list[Cell] = [
                element.name,
                element_kind,
                ", ".join(element.measures),
                body or "base",
                point.name,
                point.coordinates,
            ]
            if summary.uses:
                use = summary.uses.get(element.name, Use(""))
                cells += [use.what, use.link]
            rows.append(Row(cells, {"data-body": body or ""}))
    columns = ["name", "kind", "measures", "body", "point", "at [m]"]
    if summary.uses:
        columns += ["what it is", "URDF link"]
    return PageTable(columns, rows, (5,), "Sensors, contacts and external forces")


def _make_loop_table(model: Mbs) -> PageTable:
    """Make the table of cuts and links, with the distance of their ends at the start."""
    placed_bodies, points = compute_placement(model).bodies, model.points()

    def compute_position(endpoint: Endpoint) -> Vec:
        body_pose = placed_bodies[endpoint[0]]
        return add(body_pose.xyz, rotate(body_pose.rot, _get_position(points, endpoint)))

    rows = []
    for connection in (*model.cuts, *model.links):
        endpoints = connection.endpoint1, connection.endpoint2
        distance = (
            "not chosen yet" if connection.is_draft else dist(*map(compute_position, endpoints))
        )
        cells = (
            connection.name,
            connection.kind,
            *map(_format_endpoint, endpoints),
            connection.length,
            distance,
        )
        rows.append(Row(cells, {"data-body": connection.endpoint2[0] or ""}))
    columns = ("name", "kind", "from", "to", "length [m]", "apart at the start [m]")
    return PageTable(columns, rows, (4, 5), "Loops and springs")


def _format_endpoint(endpoint: Endpoint) -> str:
    """Return the body of an endpoint, with its point if it has one."""
    body, point = endpoint
    return "/".join((body or "base", *([point] if point else [])))


def _make_user_model_tables(model: Mbs) -> list[PageTable]:
    """Make the tables of user models.

    The first has a row for each joint, and a column for each user model whose parameters are
    joints; the second has all other parameters.
    """
    joint_numbers = model.numbers()
    values_by_model: dict[str, dict[str, str]] = {}
    other_rows: list[Row] = []
    for user_model in model.user_models:
        parameter_values = {
            parameter.name: ", ".join(map(_shorten_number, parameter.values))
            for parameter in user_model.parameters
        }
        if parameter_values and parameter_values.keys() <= joint_numbers.keys():
            values_by_model[user_model.name] = parameter_values
        else:
            other_rows += [
                Row((user_model.name, parameter_name, parameter_value))
                for parameter_name, parameter_value in parameter_values.items()
            ]
    joint_rows = [
        Row(
            (
                joint_name,
                *(
                    parameter_values.get(joint_name)
                    for parameter_values in values_by_model.values()
                ),
            ),
            {"data-joint": joint_name},
        )
        for joint_name in joint_numbers
        if any(joint_name in parameter_values for parameter_values in values_by_model.values())
    ]
    columns = ("joint", *values_by_model)
    return [
        PageTable(columns, joint_rows, range(1, len(columns)), "User models: one value a joint"),
        PageTable(("user model", "parameter", "value"), other_rows, (2,), "Other user models"),
    ]


def _shorten_number(number_text: str) -> str:
    """Return a number as in other cells; another text as it is."""
    try:
        return format_cell(float(number_text))
    except ValueError:
        return number_text
