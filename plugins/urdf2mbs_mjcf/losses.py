"""Name what an MJCF has and a URDF cannot say: each kind once, with the number and some names."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from urdf2mbs.plugin import Diagnostic, some
from urdf2mbs_mjcf.fields import LOST, LOST_OPTIONS, PLUGINS

if TYPE_CHECKING:
    from urdf2mbs_mjcf.model import Compiled

#: The codes of fields that are lost, by the beginning of the field.
_CODES = {
    "geom_fluid": "mjcf-fluid",
    "opt.": "mjcf-fluid",
    "key_": "mjcf-start",
    "nflex": "mjcf-soft-body",
    "npair": "mjcf-contact",
    "nplugin": "mjcf-plugin",
}
#: Counts of elements that are lost as a whole.
_COUNTS = {
    "nflex": "flexible bodies (flex)",
    "npair": "pairs of contact",
    "nplugin": "plugins of MuJoCo",
}
_NOTES = ("mjcf-soft", "mjcf-frame")
#: The sensors that become sensors of the .mbs, on a site.
MOTION_SENSORS = ("accelerometer", "gyro")
#: Sensors of what each project has by itself.
_MEASURED = ("jointpos", "jointvel", "clock")
#: What a flag may disable, of what the .mbs has.
_FLAGS = (
    "constraint",
    "equality",
    "frictionloss",
    "limit",
    "contact",
    "spring",
    "damper",
    "passive",
    "actuation",
)


class Losses:
    """What was left out so far: the names of the elements, by code and kind."""

    def __init__(self) -> None:
        self._names: dict[tuple[str, str], list[str]] = {}

    def add(self, code: str, kind: str, name: str) -> None:
        """Add an element of a kind, such as ``"tendons"``."""
        self._names.setdefault((code, kind), []).append(name)

    def list_messages(self, source: Path) -> list[Diagnostic]:
        """Return one message of each kind."""
        messages = []
        for (code, kind), names in self._names.items():
            level: Literal["note", "warning"] = "note" if code in _NOTES else "warning"
            known = [name for name in names if name]
            count = f" ({len(names)})" if len(names) > 1 else ""
            text = f"{kind}{count}" + (f": {some(known, 4)}" if known else "")
            messages.append(Diagnostic(level, code, text, file=str(source)))
        return messages


def add_losses(losses: Losses, model: Compiled) -> None:
    """Add what no element of a URDF is made of."""
    for field, names in model.lost.items():
        kinds = {**LOST, **PLUGINS, **_COUNTS}
        kind = kinds.get(field) or LOST_OPTIONS.get(field.removeprefix("opt."))
        codes = (code for beginning, code in _CODES.items() if field.startswith(beginning))
        code = next(codes, "mjcf-law")
        for name in names if kind else ():  # a skin is the look of a robot
            losses.add(code, str(kind), name)
    for body in model.bodies:
        if body.mocapid >= 0:
            losses.add("mjcf-mocap", "bodies that a user moves (mocap) stand still", body.name)
    for actuator in model.actuators:
        if actuator.dyntype != "none":
            kind = "actuators with a state, such as muscles"
            losses.add("mjcf-actuator", kind, actuator.name)
    for flag in model.disabled:
        if flag in _FLAGS:
            losses.add("mjcf-flag", "flags switch off what the .mbs has", flag)
    _add_sensors(losses, model)
    _add_soft(losses, model)


def _add_sensors(losses: Losses, model: Compiled) -> None:
    """Add the sensors that are not of motion on a site."""
    for sensor in model.sensors:
        is_read = sensor.type in MOTION_SENSORS and sensor.objtype == "site"
        if not is_read and sensor.type not in _MEASURED:
            kind = "sensors that are no accelerometer and no gyro on a site"
            losses.add("mjcf-sensor", kind, sensor.name or sensor.type)


def _add_soft(losses: Losses, model: Compiled) -> None:
    """Add what is soft in MuJoCo, and stiff in a project or exact in the .mbs."""
    names = {
        "limits": [joint.name for joint in model.joints if joint.limited],
        "friction": [str(number) for number, dof in enumerate(model.dofs) if dof.frictionloss],
        "equalities": [equality.name for equality in model.equalities],
    }
    soft = [f"{kind} ({len(found)})" for kind, found in names.items() if found]
    if soft:
        losses.add("mjcf-soft", f"soft in MuJoCo, and stiff here: {', '.join(soft)}", "")
