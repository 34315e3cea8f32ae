"""Left out: what the URDF says and the .mbs has no place for is named.

So is what follows from that: a mimic joint that is free, a model that is too large for Robotran's
generator of equations.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.messages.diagnostics import counted, some
from urdf2mbs.urdf.model import Joint

#: What most accounts of Robotran's generator of equations allow.
JOINTS, CUTS, SENSORS = 80, 30, 30


class LeftOut(Pass):
    reads = ("robot", "names")

    def run(self, conversion: Conversion) -> None:
        # a fixed joint has no motion that could be damped or limited
        joints = [joint for joint in conversion.robot.joints.values() if joint.moves]
        kept = conversion.simulation.kept
        _tell_mimic(conversion)
        _tell_limits(conversion)
        lossy = [
            joint
            for joint in joints
            if joint.dynamics
            and (joint.dynamics.damping or joint.dynamics.friction)
            and joint.name not in kept.get("joint-dynamics", ())
        ]
        if lossy:
            conversion.warn(
                "joint-dynamics",
                f".mbs has no joint damping or friction; left out on {_some(lossy)}",
                hint="add them in user_JointForces",
            )
        for code, what, found in (
            ("limit", "limits", [j for j in joints if j.limit]),
            ("safety-controller", "safety controllers", [j for j in joints if j.safety_controller]),
            ("calibration", "calibration", [j for j in joints if j.calibration]),
        ):
            found = [joint for joint in found if joint.name not in kept.get(code, ())]
            if found:
                conversion.note(code, f".mbs has no joint {what}; left out on {_some(found)}")
        tags: dict[str, int] = {}
        used = set(map(id, conversion.simulation.used))
        for extension in conversion.robot.extensions:
            if id(extension) not in used:
                tags[extension.tag] = tags.get(extension.tag, 0) + 1
        if tags:
            listed = ", ".join(f"{count} <{tag}>" for tag, count in tags.items())
            conversion.note("extension", f".mbs has no place for {listed}; left out")


def _tell_limits(conversion: Conversion) -> None:
    """Robotran's generator is a web service that counts."""
    mbs = conversion.mbs
    counted = {
        "joints": (sum(len(body.joints) for body in mbs.bodies), JOINTS),
        "cuts": (len(mbs.cuts), CUTS),
        "sensors": (
            sum(point.sensor is not None for body in mbs.bodies for point in body.points),
            SENSORS,
        ),
    }
    over = [f"{count} {what} ({most})" for what, (count, most) in counted.items() if count > most]
    if over:
        conversion.note(
            "generator-limits",
            "more than most accounts of Robotran's generator of equations allow: "
            f"{', '.join(over)}; the pass 'equations' writes them without a limit",
        )


def _tell_mimic(conversion: Conversion) -> None:
    """Name the joints that follow others in the URDF, and are independent in the .mbs."""
    if not any(joint.mimic for joint in conversion.robot.joints.values()):
        return
    free = {
        joint.name
        for body in conversion.mbs.bodies
        for joint in body.joints
        if joint.nature == "independent"
    }
    joints = conversion.robot.with_flipped(conversion.names.flipped).joints
    rules = [
        f"{name} = {mimic.multiplier!r} * {mimic.joint} + {mimic.offset!r}"
        for name, names in conversion.names.coordinates.items()
        if (mimic := joints[name].mimic) is not None and free.issuperset(names)
    ]
    if rules:
        in_project = conversion.settings.project is not None
        conversion.warn(
            "mimic",
            "joints that follow others are independent in the .mbs"
            + ("" if in_project else ", which cannot couple them")
            + f": {', '.join(rules)}",
            hint=None if in_project else "a project can: 'output: {project: DIR}'",
        )


def _some(joints: list[Joint]) -> str:
    return f"{counted(len(joints), 'joint')}: {some(joint.name for joint in joints)}"
