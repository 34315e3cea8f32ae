"""What stands around the bodies: sensors, external forces, loops, stops and user models.

All is read from the written .mbs; what a point is for is known by the passes.
"""

from __future__ import annotations

from math import dist, isfinite
from typing import Any, TypeAlias

from urdf2mbs.plugin import ZERO, Connection, Mbs, Summary, Use, Vec, add, rotate
from urdf2mbs.plugin import compute_placement as place
from urdf2mbs_report.table import Cell, Row, plain, titled

End: TypeAlias = "tuple[str | None, str | None]"
"""The names of a body, None for the base, and of one of its points, None for its origin."""


def _at(model: Mbs, end: End) -> Vec:
    """Where an end is in its body's frame (m)."""
    point = model.points().get(end)
    return ZERO if point is None else point.coordinates


def _stops(model: Mbs) -> dict[str, tuple[float | None, float | None]]:
    """Return the limits (rad or m) of joints, from the user models ``q_min`` and ``q_max``."""
    values = {"q_min": dict[str, float | None](), "q_max": dict[str, float | None]()}
    for name, joint, text in _limits(model):
        values[name][joint] = _number(text)
    low, high = values["q_min"], values["q_max"]
    return {name: (low.get(name), high.get(name)) for name in model.numbers() if name in low | high}


def _limits(model: Mbs) -> list[tuple[str, str, str]]:
    """Return the name of the user model, the joint, and the value of each limit of a joint."""
    return [
        (user_model.name, parameter.name, parameter.values[0])
        for user_model in model.user_models
        if user_model.name in ("q_min", "q_max")
        for parameter in user_model.parameters
        if parameter.values
    ]


def _number(text: str) -> float | None:
    """Return a finite number; None for other texts."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if isfinite(number) else None


def find_unread_limits(model: Mbs) -> list[str]:
    """Return a sentence for each limit of a joint that is no number, and so is not drawn."""
    numbers = model.numbers()
    return [
        f"joint '{joint}': {name} is '{text}'; expected a number, and no stop is drawn"
        for name, joint, text in _limits(model)
        if joint in numbers and _number(text) is None and text.strip().lower().lstrip("+-") != "inf"
    ]


def marks(said: Summary, model: Mbs) -> dict[str, Any]:
    """What the 3D model shows beside shapes."""
    dots = []
    for (body, _), point in model.points().items():
        if point.sensor is not None:
            use = said.uses.get(point.sensor.name)
            dots.append((body, point.coordinates, "sensors", use and use.rotation))
        if point.extforce is not None:
            use = said.uses.get(point.extforce.name)
            kind = "contacts" if use is not None and use.what == "contact" else "forces"
            spots = use.spots if use is not None and use.spots else (point.coordinates,)
            dots += [(body, spot, kind, None) for spot in spots]
    return {
        "points": dots,
        "lines": [
            (one.kind, *((end[0], _at(model, end)) for end in (one.endpoint1, one.endpoint2)))
            for one in (*model.cuts, *model.links)
            if not one.is_draft
        ],
        "stops": list(_stops(model).items()),
    }


def tables(said: Summary, model: Mbs) -> str:
    """Tables of points, loops, stops and user models; those of what there is."""
    parts = [
        _point_table(said, model),
        *(
            titled(title, head, [({"data-link": row[1]}, row) for row in rows])
            for title, head, rows in said.tables
        ),
        _connection_table(model),
        _user_model_tables(model),
    ]
    return "".join(parts) or '<p class="note">None.</p>'


def _point_table(said: Summary, model: Mbs) -> str:
    rows: list[Row] = []
    for (body, _), point in model.points().items():
        for one, kind in ((point.sensor, "sensor"), (point.extforce, "external force")):
            if one is None:
                continue
            cells: list[Cell] = [
                one.name, kind, ", ".join(one.measures), body or "base", point.name,
                point.coordinates,
            ]  # fmt: skip
            use = said.uses.get(one.name, Use(""))
            cells += (use.what, use.link) if said.uses else ()
            rows.append(({"data-body": body or ""}, cells))
    head = ("name", "kind", "measures", "body", "point", "at [m]")
    known = ("what it is", "URDF link") if said.uses else ()
    return titled("Sensors, contacts and external forces", (*head, *known), rows, right=(5,))


def _connection_table(model: Mbs) -> str:
    placed = place(model).bodies

    def where(end: End) -> Vec:
        pose = placed[end[0]]
        return add(pose.xyz, rotate(pose.rot, _at(model, end)))

    def words(end: End) -> str:
        return "/".join((end[0] or "base", *([end[1]] if end[1] else [])))

    def row(one: Connection) -> Row:
        ends = one.endpoint1, one.endpoint2
        apart = "not chosen yet" if one.is_draft else dist(*map(where, ends))
        about = {"data-body": one.endpoint2[0] or ""}
        return about, (one.name, one.kind, *map(words, ends), one.length, apart)

    rows = [row(one) for one in (*model.cuts, *model.links)]
    head = ("name", "kind", "from", "to", "length [m]", "apart at the start [m]")
    return titled("Loops and springs", head, rows, right=(4, 5))


def _user_model_tables(model: Mbs) -> str:
    """One table with a row for each joint and a column for each model whose parameters are
    joints; one of all other parameters."""
    numbers = model.numbers()
    kinds: dict[str, dict[str, str]] = {}
    others: list[Row] = []
    for one in model.user_models:
        values = {p.name: ", ".join(map(_short, p.values)) for p in one.parameters}
        if values and values.keys() <= numbers.keys():
            kinds[one.name] = values
        else:
            others += [plain(one.name, name, value) for name, value in values.items()]
    rows: list[Row] = [
        ({"data-joint": name}, (name, *(values.get(name) for values in kinds.values())))
        for name in numbers
        if any(name in values for values in kinds.values())
    ]
    head = ("joint", *kinds)
    return titled("User models: one value a joint", head, rows, right=range(1, len(head))) + titled(
        "Other user models", ("user model", "parameter", "value"), others, right=(2,)
    )


def _short(value: str) -> str:
    """Six digits of a number; another text as it is."""
    try:
        return f"{float(value) + 0.0:.6g}"
    except ValueError:
        return value
