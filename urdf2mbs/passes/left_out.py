"""Left out: name the parts of the URDF that have no place in an .mbs.

The pass also names mimic joints that are free, or locked by their limits, and says if the model is
too large for Robotran's generator of equations.
"""

from __future__ import annotations

from collections import Counter

from urdf2mbs.conversion import Conversion
from urdf2mbs.hookspecs import Pass
from urdf2mbs.messages.diagnostics import some
from urdf2mbs.states import Placed
from urdf2mbs.urdf.mimic import find_locked_joints

#: Most accounts of Robotran's generator of equations allow so many.
JOINTS, CUTS, SENSORS = 80, 30, 30


class LeftOut(Pass):
    reads = ("robot", "bodies", "joints", "anchors", "forces", "names")

    def run(self, conversion: Conversion) -> None:
        # a fixed joint has no motion that could be damped or limited
        there = {step.joint.name for one in conversion.segments.values() for step in one.steps}
        joints = [j for j in conversion.robot.joints.values() if j.moves and j.name in there]
        kept = conversion.state(Placed).joints
        _warn_of_free_followers(conversion)
        _warn_of_locked_joints(conversion)
        _note_size(conversion)
        lossy = [
            joint
            for joint in joints
            if (of := joint.dynamics) and (of.damping or of.friction or of.spring_stiffness)
        ]
        for code, what, found in (
            ("joint-dynamics", "damping, friction and springs", lossy),
            ("limit", "limits", [j for j in joints if j.limit]),
            ("safety-controller", "safety controllers", [j for j in joints if j.safety_controller]),
            ("calibration", "calibrations", [j for j in joints if j.calibration]),
        ):
            names = [joint.name for joint in found if joint.name not in kept.get(code, ())]
            message = f"{what} are left out, as an .mbs joint has none: {some(names)}"
            if names and found is lossy:
                conversion.warn("joint-dynamics-lost", message)
            elif names:
                conversion.note(code, message)
        used = set(map(id, conversion.state(Placed).elements))
        left = [one.tag for one in conversion.robot.extensions if id(one) not in used]
        if tags := Counter(left):
            listed = ", ".join(f"{count} <{tag}>" for tag, count in tags.items())
            conversion.note("extension", f"elements of other programs are left out: {listed}")


def _note_size(conversion: Conversion) -> None:
    """Say if the model is larger than Robotran's generator, a web service, allows most users."""
    mbs = conversion.mbs
    sensors = [point for body in mbs.bodies for point in body.points if point.sensor is not None]
    over = [
        f"{len(things)} {what} ({most})"
        for things, what, most in (
            (mbs.joints(), "joints", JOINTS), (mbs.cuts, "cuts", CUTS),
            (sensors, "sensors", SENSORS),
        )
        if len(things) > most
    ]  # fmt: skip
    if over:
        conversion.note(
            "generator-limits",
            "more than most accounts of Robotran's generator of equations allow: "
            f"{', '.join(over)}; the pass 'equations' writes them without a limit",
        )


def _warn_of_free_followers(conversion: Conversion) -> None:
    """Name the joints that are followers in the URDF, but independent in the .mbs."""
    if not any(joint.mimic for joint in conversion.robot.joints.values()):
        return
    own = conversion.mbs.joints()
    free = {name for name, joint in own.items() if joint.nature == "independent"}
    joints = conversion.robot.joints
    rules = [
        f"{name} = {mimic}"
        for name, names in conversion.names.coordinates.items()
        if (mimic := joints[name].mimic) is not None and free.issuperset(names)
    ]
    if rules:
        in_project = conversion.settings.project is not None
        conversion.warn(
            "mimic",
            f"joints that follow others in the URDF are independent in the .mbs: {some(rules)}",
            hint=None if in_project else "a project couples them: 'output: {project: DIR}'",
        )


def _warn_of_locked_joints(conversion: Conversion) -> None:
    """Name the joints that cannot move within the limits of those that follow them."""
    for locked in find_locked_joints(conversion.robot):
        message = locked.describe(conversion.robot)
        conversion.warn("mimic-locked", message, joint=locked.follower.name)
