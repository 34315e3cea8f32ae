"""Notes on a partition, and errors of loops that cannot be closed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from urdf2mbs.plugin import some
from urdf2mbs_equations.constraints import list_constraints
from urdf2mbs_equations.tree import Tree
from urdf2mbs_simulate.data import MbsData
from urdf2mbs_simulate.equations import SimulationError
from urdf2mbs_simulate.model_code import Code

#: A joint is at its stop if it is nearer (rad, m): numerical derivatives count half of the stop.
AT_STOP = 1e-5


def note_stops(data: MbsData, *, touching: bool = False) -> None:
    """Note which joints start beyond their soft stops, which push them.

    Args:
        data: The model.
        touching: True to note joints at a stop, too: numerical derivatives count half of it.
    """
    models = data.user_model
    margin = AT_STOP if touching else -AT_STOP

    def is_beyond(joint: str, limit: str, sign: float) -> bool:
        position = data.q[data.joint_id[joint]]
        distance = sign * (position - models.get(limit, {}).get(joint, -sign * np.inf))
        return bool(distance < margin)

    joints = [
        joint
        for joint in models.get("stop_stiffness", {})
        for limit, sign in (("q_min", 1.0), ("q_max", -1.0))
        if is_beyond(joint, limit, sign)
    ]
    state = "at a stop, or beyond" if touching else "pushed by their stops from the start"
    note = f"{state}: {some(joints)}; 'passes: {{posture: {{joints: {{NAME: VALUE}}}}}}' starts "
    note += "elsewhere"
    if joints and note not in data._run.notes:
        data._run.notes.append(note)


def note_changes(data: MbsData, freed: Any, added: Any) -> None:
    """Note how the partition differs from the .mbs, and the lines that declare it there."""
    notes = data._run.notes
    if len(freed):
        note = f"dependent in the .mbs, but no constraint rules them: {format_joints(data, freed)}"
        if not any(data.user_path.glob("user_cons_hJ.*")):
            note += "; is user_cons_hJ of the project missing?"
        notes.append(note)
    if len(added):
        names = format_joints(data, added)
        notes.append(f"dependent here, since those of the .mbs do not suffice: {names}")
    for joints, nature in ((freed, "independent"), (added, "dependent")):
        if len(joints):
            notes.append(f"in the .mbs: <nature>{nature}</nature> in {format_joints(data, joints)}")


def format_joints(data: MbsData, joints: Iterable[int]) -> str:
    """Return the names of joints, in the order of the model."""
    names = list(data.joint_id)
    return ", ".join(names[number - 1] for number in sorted(joints))


def make_gap_error(code: Code) -> SimulationError:
    """Return an error that names the equation with the largest gap."""
    data = code.data
    h, jacobian = code.compute_constraints()
    row = int(np.abs(h).argmax())
    text = _describe_gap(code, row, h[row])
    is_fixed_row = np.abs(jacobian[row, 1:]).max(initial=0.0) == 0.0
    cause = "no joint moves it" if is_fixed_row else "no pose near the drawn one closes it"
    return SimulationError(
        "partition",
        f"a loop cannot be closed: {text}, and {cause}",
        file=str(data._run.file),
        hint="draw the model nearer to a closed pose (initialvalue), or check lengths and points",
    )


def _describe_gap(code: Code, row: int, h: float) -> str:
    """Describe how far an equation h = 0 is from closed."""
    data, name, gap = code.data, describe_row(code, row), abs(h)
    if row >= code.row_counts.cuts:
        return f"{name} is missed by {gap:.3g}"
    constraint = list_constraints(Tree(data._run.mbs))[row]
    if constraint.cut.kind == "rod":  # its h is half the difference of squares
        rods = [cut.name for cut in data._run.mbs.cuts if cut.kind == "rod"]
        length = data.lrod[1 + rods.index(constraint.cut.name)]
        gap = abs(np.sqrt(max(length**2 + 2.0 * h, 0.0)) - length)
    is_angle = constraint.direction.startswith("about")
    gap, unit = (gap, "rad") if is_angle else (1000 * gap, "mm")
    return f"{name} is {gap:.3g} {unit} from closed {constraint.direction}"


def describe_row(code: Code, row: int) -> str:
    """Return the cut or the user's equation that a row belongs to."""
    cuts = code.row_counts.cuts
    if row >= cuts:
        return f"equation {row - cuts + 1} of user_cons_hJ"
    cut = list_constraints(Tree(code.data._run.mbs))[row].cut
    return f"{cut.kind} '{cut.name}'"
