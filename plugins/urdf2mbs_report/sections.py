"""The sections of the page about a robot: joints, bodies, names, omitted values, the proof."""

from __future__ import annotations

import json
from math import degrees
from pathlib import Path
from typing import Any

import msgspec

from urdf2mbs.plugin import (
    HERE,
    Conversion,
    Diagnostic,
    Mbs,
    Rot,
    fewest_turns,
    left_out,
    report,
    verdict,
)
from urdf2mbs_report.tables import Cell, PageTable, Row, format_cell

#: The messages about what the URDF has and the .mbs has no place for.
LEFT_OUT_CODES = ("collision", "extension", "texture", "rotors-left-out", "loop-left-out")
#: Number of letters of a changed value that are shown.
MAX_VALUE_LENGTH = 80


def make_joint_table(model: Mbs, conversion: Conversion | None) -> PageTable:
    """Make the table of joints; with a conversion, also of what the URDF says of each."""
    urdf_cells = {} if conversion is None else _describe_urdf_joints(conversion, model)
    coordinate_numbers = model.numbers()
    rows = []
    for body in model.bodies:
        for joint in body.joints:
            cells: list[Cell] = [
                f"q{coordinate_numbers[joint.name]}",
                joint.name,
                joint.type,
                joint.nature,
                joint.q or 0.0,
                body.name,
                *urdf_cells.get(joint.name, ()),
            ]
            rows.append(Row(cells, {"class": joint.nature, "data-joint": joint.name}))
    columns = ["number", "joint", "type", "nature", "initial q [rad, m]", "body"]
    if conversion is not None:
        columns += ["URDF joint", "limits [rad, m]", "velocity", "effort", "follows"]
    return PageTable(columns, rows, numeric_columns=(0, 4, 7, 8, 9))


def _describe_urdf_joints(conversion: Conversion, model: Mbs) -> dict[str, list[Cell]]:
    """Return what the URDF says of each .mbs joint: its joint, limits, velocity, effort, leader.

    A limit is shown only for a URDF joint that became a single coordinate.
    """
    origins = {
        mbs_name: urdf_name
        for urdf_name, mbs_names in conversion.names.joints.items()
        for mbs_name in mbs_names
    }
    single_coordinates = {
        mbs_names[0]: urdf_name
        for urdf_name, mbs_names in conversion.names.coordinates.items()
        if len(mbs_names) == 1
    }
    cells_by_joint: dict[str, list[Cell]] = {}
    for mbs_name in model.numbers():
        joint = conversion.robot.joints.get(single_coordinates.get(mbs_name, ""))
        limit = joint.limit if joint else None
        mimic = joint.mimic if joint else None
        is_limited = limit and joint and joint.type != "continuous"
        cells_by_joint[mbs_name] = [
            origins.get(mbs_name),
            (limit.lower, limit.upper) if limit and is_limited else None,
            limit.velocity if limit else None,
            limit.effort if limit else None,
            str(mimic) if mimic else None,
        ]
    return cells_by_joint


def make_body_table(model: Mbs, conversion: Conversion | None) -> PageTable:
    """Make the table of bodies; with a conversion, also of the URDF links of each."""
    links_by_body: dict[str | None, list[str]] = {}
    for link_name, frame in conversion.frames.items() if conversion else ():
        if frame.joint is None:
            links_by_body.setdefault(frame.body, []).append(link_name)
    columns = [
        "body",
        "parent",
        "at point",
        "mass [kg]",
        "centre of mass [m]",
        "joints",
        "shapes",
        "inertia xx, xy, xz, yy, yz, zz [kg m²]",
    ]
    if conversion is not None:
        columns.insert(1, "URDF links")
    n_names = columns.index("mass [kg]")
    rows = []
    for body in model.bodies:
        cells: list[Cell] = [
            body.name,
            body.parent or "base",
            body.point or "origin",
            body.mass,
            body.com,
            len(body.joints),
            len(body.shapes),
            body.inertia,
        ]
        if conversion is not None:
            cells.insert(1, ", ".join(links_by_body.get(body.name, ())))
        rows.append(Row(cells, {"data-body": body.name}))
    total_mass = sum(body.mass or 0.0 for body in model.bodies)
    n_others = len(columns) - n_names - 1
    footer: list[Cell] = ["total", *[""] * (n_names - 1), total_mass, *[""] * n_others]
    return PageTable(columns, rows, numeric_columns=range(n_names, len(columns)), footer=footer)


# --- names ---


def make_name_tables(conversion: Conversion) -> list[PageTable]:
    """Make the tables of what became of each link and joint of the URDF."""
    joint_columns = ("URDF joint", "type", ".mbs joints, in the order in which they act")
    return [
        PageTable(
            ("URDF link", "in the .mbs", "shifted by [m]", "and turned by"),
            [_make_link_row(conversion, link_name) for link_name in conversion.robot.links],
            numeric_columns=(2,),
            title="Links",
        ),
        PageTable(
            joint_columns,
            [
                _make_joint_name_row(conversion, joint_name)
                for joint_name in conversion.robot.joints
            ],
            title="Joints",
        ),
    ]


def _make_link_row(conversion: Conversion, link_name: str) -> Row:
    """Make a row of a link: its body or joint in the .mbs, and its origin there."""
    frame = conversion.frames.get(link_name)
    mbs_element, frame_shift, frame_turns = "-", None, ""
    if frame is not None:
        mbs_element = "base" if frame.body is None else f"body {frame.body}"
        mbs_element = mbs_element if frame.joint is None else f"after joint {frame.joint}"
        frame_shift = None if frame.pose == HERE else frame.pose.xyz
        frame_turns = _format_turns(frame.pose.rot)
    return Row((link_name, mbs_element, frame_shift, frame_turns), {"data-link": link_name})


def _format_turns(rotation: Rot) -> str:
    """Return a rotation as turns about current axes, in Robotran's words: ``R3 90°, R1 -45°``."""
    return ", ".join(
        f"R{axis} {format_cell(degrees(angle))}°" for axis, angle in fewest_turns(rotation)
    )


def _make_joint_name_row(conversion: Conversion, joint_name: str) -> Row:
    """Make a row of a URDF joint: its type, and what became of it."""
    joint = conversion.robot.joints[joint_name]
    outcome = ", ".join(conversion.names.joints.get(joint_name, ()))
    outcome = outcome or f"none: '{joint.child}' is rigid with the body that carries it"
    if joint_name in conversion.frozen:
        outcome = f"left out, held at 0: {conversion.frozen[joint_name]}"
    return Row((joint_name, joint.type, outcome), {"data-urdf-joint": joint_name})


# --- omitted values ---


class LeftOut(msgspec.Struct):
    """What the URDF says, and the .mbs has no place for."""

    messages: list[str]
    table: PageTable
    """Every number of the URDF's joints that neither a user model nor a constraint holds."""


def list_left_out(conversion: Conversion) -> LeftOut:
    """List what the messages name, and the numbers of joints without a place in the .mbs."""
    messages = [
        diagnostic.message
        for diagnostic in conversion.diagnostics
        if diagnostic.code in LEFT_OUT_CODES
    ]
    rows = []
    for joint_name, parts in left_out(conversion).items():
        for part_name, values in parts.items():
            values_text = ", ".join(
                _format_left_out_value(value_name, value) for value_name, value in values.items()
            )
            rows.append(Row((joint_name, part_name.replace("_", " "), values_text)))
    columns = ("URDF joint", "part", "values [as in the URDF: rad, m, N m, N, s]")
    return LeftOut(messages, PageTable(columns, rows))


def _format_left_out_value(value_name: str, value: Any) -> str:
    """Return a value with its name; the name of a joint has no quotes."""
    if value is None:
        return f"{value_name} none"
    return f"{value_name} {value if value_name == 'joint' else repr(value)}"


# --- proof and messages ---


class ProofSection(msgspec.Struct):
    """The quantities that the proof compared, and their differences."""

    verdict: str
    is_checked: bool
    is_same: bool = False
    rejected_name: str = ""
    """The name of the file as which a wrong .mbs was written."""
    positions: int = 0
    groups: int = 0
    tables: list[PageTable] = []


def describe_proof(conversion: Conversion) -> ProofSection:
    """Describe the proof of a conversion."""
    proof = conversion.checked.proof
    if proof is None:
        return ProofSection(verdict(conversion), is_checked=False)
    rejected_file = conversion.checked.rejected
    deviations = [
        Row((quantity, f"{deviation:.2e}")) for quantity, deviation in proof.largest.items()
    ]
    differences = [
        Row((difference.kind, f"{difference.size:.2e}", difference.message))
        for difference in proof.differences
    ]
    changes = [
        Row(
            (
                robot_change.by,
                change.kind,
                change.name,
                _format_changed_value(change.before),
                _format_changed_value(change.after),
            )
        )
        for robot_change in conversion.checked.changed
        for change in robot_change.changes
    ]
    tables = [
        PageTable(("what", "relative size", "where"), differences, (1,), "Differences"),
        PageTable(("what", "why"), _make_pair_rows(proof.but_for), (), "The same, but for"),
        PageTable(("what", "why"), _make_pair_rows(proof.not_compared), (), "Not compared"),
        PageTable(
            ("pass", "what", "link or joint", "in the URDF", "now"),
            changes,
            title="Changed on purpose",
        ),
    ]
    return ProofSection(
        verdict(conversion),
        is_checked=True,
        is_same=proof.same,
        rejected_name=rejected_file.name if rejected_file else "",
        positions=proof.positions,
        groups=proof.groups,
        tables=[
            PageTable(("compared", "largest relative deviation"), deviations, (1,)),
            *(table for table in tables if table.rows),
        ],
    )


def _make_pair_rows(pairs: dict[str, str]) -> list[Row]:
    """Make a row of each key and value."""
    return [Row(pair) for pair in pairs.items()]


def _format_changed_value(value: Any) -> str:
    """Return a changed value as JSON, cut if it is long."""
    text = "" if value is None else json.dumps(msgspec.to_builtins(value))
    return text if len(text) <= MAX_VALUE_LENGTH else f"{text[: MAX_VALUE_LENGTH - 3]}..."


class Verdict(msgspec.Struct):
    """The verdict of the proof, and its CSS class."""

    text: str
    kind: str
    """``same``, ``other`` or ``unknown``."""


class Message(msgspec.Struct):
    """A message of the conversion."""

    diagnostic: Diagnostic
    place: str
    """File and line, if they are known."""
    attributes: dict[str, str]
    """As those of a ``Row``."""


def list_messages(conversion: Conversion) -> list[Message]:
    """List all messages, warnings first."""
    messages = []
    for diagnostic in sorted(
        conversion.diagnostics, key=lambda diagnostic: diagnostic.level != "warning"
    ):
        attributes = {}
        if diagnostic.joint is not None:
            attributes = {"data-urdf-joint": diagnostic.joint}
        elif diagnostic.link is not None:
            attributes = {"data-link": diagnostic.link}
        location = ""
        if diagnostic.file and diagnostic.line:
            location = f"{Path(diagnostic.file).name}:{diagnostic.line}"
        messages.append(Message(diagnostic, location, attributes))
    return messages


class RobotSections(msgspec.Struct):
    """The sections of the page of a conversion; ``templates/robot.html`` shows them."""

    verdict: Verdict
    no_dynamics: str
    """Why no forces can move the robot; empty if they can."""
    name_tables: list[PageTable]
    left_out: LeftOut
    proof: ProofSection
    messages: list[Message]


def describe_robot(conversion: Conversion) -> RobotSections:
    """Describe a conversion for its page."""
    conversion_report = report(conversion)
    verdict_kind = "unknown"
    if conversion_report.proof is not None:
        verdict_kind = "same" if conversion_report.proof.same else "other"
    return RobotSections(
        verdict=Verdict(conversion_report.verdict, verdict_kind),
        no_dynamics=conversion_report.no_dynamics,
        name_tables=make_name_tables(conversion),
        left_out=list_left_out(conversion),
        proof=describe_proof(conversion),
        messages=list_messages(conversion),
    )
