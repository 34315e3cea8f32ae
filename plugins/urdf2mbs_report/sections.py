"""The tables of the page: joints, bodies, names, what is left out, the proof, messages."""

from __future__ import annotations

import json
from html import escape
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import HERE, Conversion, Mbs, left_out, verdict
from urdf2mbs_report.table import Cell, Html, Row, plain, table, titled

#: Messages about what the URDF has and the .mbs has no place for.
LEFT_OUT = ("collision", "extension", "texture", "rotors-left-out", "loop-left-out")


def joints(model: Mbs, conversion: Conversion | None) -> str:
    """The joints; with a conversion, also what the URDF says of each."""
    urdf = {} if conversion is None else _urdf_joints(conversion, model)
    numbers = model.numbers()
    rows: list[Row] = [
        (
            {"class": joint.nature, "data-joint": joint.name},
            (
                f"q{numbers[joint.name]}", joint.name, joint.type, joint.nature, joint.q,
                body.name, *urdf.get(joint.name, ()),
            ),
        )
        for body in model.bodies
        for joint in body.joints
    ]  # fmt: skip
    head = ["number", "joint", "type", "nature", "initial q [rad, m]", "body"]
    if conversion is not None:
        head += ["URDF joint", "limits [rad, m]", "velocity", "effort", "follows"]
    return table(head, rows, right=(0, 4, 7, 8, 9))


def _urdf_joints(conversion: Conversion, model: Mbs) -> dict[str, list[Cell]]:
    """What the URDF says of each .mbs joint: its joint, limits, velocity, effort, leader."""
    origin = {name: urdf for urdf, names in conversion.names.joints.items() for name in names}
    alone = {
        names[0]: urdf for urdf, names in conversion.names.coordinates.items() if len(names) == 1
    }
    cells: dict[str, list[Cell]] = {}
    for name in model.numbers():
        urdf = conversion.robot.joints.get(alone.get(name, ""))
        limit = urdf.limit if urdf else None
        mimic = urdf.mimic if urdf else None
        cells[name] = [
            origin.get(name),
            (limit.lower, limit.upper) if limit and urdf and urdf.type != "continuous" else None,
            limit.velocity if limit else None,
            limit.effort if limit else None,
            str(mimic) if mimic else None,
        ]
    return cells


def bodies(model: Mbs, conversion: Conversion | None) -> str:
    """The bodies; with a conversion, also the URDF links of each."""
    links: dict[str | None, list[str]] = {}
    for link, at in conversion.frames.items() if conversion else ():
        if at.joint is None:
            links.setdefault(at.body, []).append(link)
    head = [
        "body", "parent", "at point", "mass [kg]", "centre of mass [m]",
        "inertia xx, xy, xz, yy, yz, zz [kg m²]", "joints", "shapes",
    ]  # fmt: skip
    if conversion is not None:
        head.append("URDF links")
    rows: list[Row] = [
        (
            {"data-body": body.name},
            (
                body.name, body.parent or "base", body.point or "origin", body.mass, body.com,
                body.inertia, len(body.joints), len(body.shapes),
                *([", ".join(links.get(body.name, ()))] if conversion else ()),
            ),
        )
        for body in model.bodies
    ]  # fmt: skip
    total = sum(body.mass or 0.0 for body in model.bodies)
    foot = ["total", "", "", total, *[""] * (len(head) - 4)]
    return table(head, rows, right=(3, 4, 5, 6, 7), foot=foot)


def names(conversion: Conversion) -> str:
    """What became of each link and joint of the URDF."""
    links: list[Row] = []
    for link in conversion.robot.links:
        at, where, shifted = conversion.frames.get(link), "-", None
        if at is not None:
            where = "base" if at.body is None else f"body {at.body}"
            where = where if at.joint is None else f"after joint {at.joint}"
            shifted = None if at.pose == HERE else at.pose.xyz
        links.append(({"data-link": link}, (link, where, shifted)))
    joints: list[Row] = []
    for name, joint in conversion.robot.joints.items():
        became = ", ".join(conversion.names.joints.get(name, ()))
        became = became or f"none: '{joint.child}' is rigid with the body that carries it"
        if name in conversion.frozen:
            became = f"left out, held at 0: {conversion.frozen[name]}"
        joints.append(({"data-urdf-joint": name}, (name, joint.type, became)))
    return (
        "<h3>Links</h3>"
        + table(("URDF link", "in the .mbs", "shifted by [m]"), links, right=(2,))
        + "<h3>Joints</h3>"
        + table(("URDF joint", "type", ".mbs joints, in the order in which they act"), joints)
    )


def lost(conversion: Conversion) -> str:
    """What the messages name, and every number of the URDF's joints that has found no place."""
    said = [escape(one.message) for one in conversion.diagnostics if one.code in LEFT_OUT]
    named = f"<ul>{''.join(f'<li>{text}</li>' for text in said)}</ul>" if said else ""
    rows = []
    for name, parts in left_out(conversion).items():
        for part, values in parts.items():
            listed = ", ".join(
                f"{key} {'none' if value is None else value if key == 'joint' else repr(value)}"
                for key, value in values.items()
            )
            rows.append(plain(name, part.replace("_", " "), listed))
    if not rows:
        return named or '<p class="note">Nothing.</p>'
    columns = ("URDF joint", "part", "values [as in the URDF: rad, m, N m, N, s]")
    return named + table(columns, rows)


def proof(conversion: Conversion) -> str:
    """What was compared, and what differs."""
    found = conversion.checked.proof
    if found is None:
        return (
            f'<p class="note">{verdict(conversion)}: the pass <code>check</code> is not in the '
            "pipeline. Add it after <code>emit</code>. The comparison in the 3D model is made "
            "at the position shown only.</p>"
        )
    same = (
        "The .mbs was read back and compared with the URDF by a second route: it is "
        f"{escape(verdict(conversion))}."
        if found.same
        else "<b>The .mbs is not the same robot as the URDF.</b> It was written as "
        f"{escape(conversion.checked.rejected.name if conversion.checked.rejected else '')}."
    )
    changed = [
        plain(one.by, change.kind, change.name, _short(change.before), _short(change.after))
        for one in conversion.checked.changed
        for change in one.changes
    ]
    return (
        f"<p>{same}</p><dl><dt>Positions compared</dt><dd>{found.positions}, zero included</dd>"
        f"<dt>Rigid groups</dt><dd>{found.groups}: each must move as its counterpart, and have "
        "its mass, centre and inertia</dd></dl>"
        + table(
            ("compared", "largest relative deviation"),
            [plain(kind, f"{size:.2e}") for kind, size in found.largest.items()], right=(1,),
        )
        + titled(
            "Differences", ("what", "relative size", "where"),
            [plain(d.kind, f"{d.size:.2e}", d.message) for d in found.differences], right=(1,),
        )
        + titled("The same, but for", ("what", "why"), _pairs(found.but_for))
        + titled("Not compared", ("what", "why"), _pairs(found.not_compared))
        + titled(
            "Changed on purpose", ("pass", "what", "link or joint", "in the URDF", "now"), changed
        )
    )  # fmt: skip


def _pairs(given: dict[str, str]) -> list[Row]:
    return [plain(*pair) for pair in given.items()]


def _short(value: Any) -> str:
    """A changed value as text."""
    text = "" if value is None else json.dumps(msgspec.to_builtins(value))
    return text if len(text) <= 80 else f"{text[:77]}..."


def messages(conversion: Conversion) -> str:
    """All messages, warnings first."""
    if not conversion.diagnostics:
        return '<p class="note">None.</p>'
    rows: list[Row] = []
    for said in sorted(conversion.diagnostics, key=lambda d: d.level != "warning"):
        about = {"data-urdf-joint": said.joint} if said.joint is not None else {}
        if said.joint is None and said.link is not None:
            about = {"data-link": said.link}
        hint = f'<br><span class="note">{escape(said.hint)}</span>' if said.hint else ""
        where = f"{Path(said.file).name}:{said.line}" if said.file and said.line else ""
        level = Html(f'<span class="level {said.level}">{said.level}</span>')
        rows.append((about, (level, said.code, Html(escape(said.message) + hint), where)))
    return table(("level", "code", "what", "where"), rows)
