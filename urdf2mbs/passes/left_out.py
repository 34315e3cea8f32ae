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
from urdf2mbs.urdf.model import Joint

#: The largest model for most accounts of Robotran's generator of equations.
MAX_JOINTS, MAX_CUTS, MAX_SENSORS = 80, 30, 30


class LeftOut(Pass):
    """Name the parts of the URDF that have no place in an .mbs."""

    reads = ("robot", "bodies", "joints", "anchors", "forces", "names")

    def run(self, conversion: Conversion) -> None:
        """Report what the model lacks, and what it may be too large for."""
        _warn_of_free_followers(conversion)
        _warn_of_locked_joints(conversion)
        _note_size(conversion)
        _note_properties(conversion)
        _note_extensions(conversion)


def _warn_of_free_followers(conversion: Conversion) -> None:
    """Warn of joints that are followers in the URDF, but independent in the .mbs."""
    joints = conversion.robot.joints
    if not any(joint.mimic for joint in joints.values()):
        return
    mbs_joints = conversion.mbs.joints()
    free = {name for name, joint in mbs_joints.items() if joint.nature == "independent"}
    rules = [
        f"{name} = {mimic}"
        for name, mbs_names in conversion.names.coordinates.items()
        if (mimic := joints[name].mimic) is not None and free.issuperset(mbs_names)
    ]
    if rules:
        in_project = conversion.settings.project is not None
        conversion.warn(
            "mimic",
            f"joints that follow others in the URDF are independent in the .mbs: {some(rules)}",
            hint=None if in_project else "a project couples them: 'output: {project: DIR}'",
        )


def _warn_of_locked_joints(conversion: Conversion) -> None:
    """Warn of joints that cannot move within the limits of those that follow them."""
    for locked in find_locked_joints(conversion.robot):
        message = locked.describe(conversion.robot)
        conversion.warn("mimic-locked", message, joint=locked.follower.name)


def _note_size(conversion: Conversion) -> None:
    """Note if the model is larger than Robotran's generator, a web service, allows most users."""
    mbs = conversion.mbs
    sensors = [point for body in mbs.bodies for point in body.points if point.sensor is not None]
    sizes = (
        (len(mbs.joints()), "joints", MAX_JOINTS),
        (len(mbs.cuts), "cuts", MAX_CUTS),
        (len(sensors), "sensors", MAX_SENSORS),
    )
    exceeded = [f"{size} {noun} ({limit})" for size, noun, limit in sizes if size > limit]
    if exceeded:
        conversion.note(
            "generator-limits",
            "more than most accounts of Robotran's generator of equations allow: "
            f"{', '.join(exceeded)}; the pass 'equations' writes them without a limit",
        )


def _note_properties(conversion: Conversion) -> None:
    """Name the properties of joints that are not in the .mbs.

    A fixed joint has none, as it has no motion that could be damped or limited.
    """
    joints_in_mbs = {step.joint.name for step in conversion.steps()}
    joints = [
        joint
        for joint in conversion.robot.joints.values()
        if joint.moves and joint.name in joints_in_mbs
    ]
    damped = [joint for joint in joints if _has_dynamics(joint)]
    limited = [joint for joint in joints if joint.limit]
    guarded = [joint for joint in joints if joint.safety_controller]
    calibrated = [joint for joint in joints if joint.calibration]
    placed = conversion.state(Placed).joints
    for code, noun, candidates in (
        ("joint-dynamics", "damping, friction and springs", damped),
        ("limit", "limits", limited),
        ("safety-controller", "safety controllers", guarded),
        ("calibration", "calibrations", calibrated),
    ):
        names = [joint.name for joint in candidates if joint.name not in placed.get(code, ())]
        message = f"{noun} are left out, as an .mbs joint has none: {some(names)}"
        if names and code == "joint-dynamics":
            conversion.warn("joint-dynamics-lost", message)  # it changes the motion
        elif names:
            conversion.note(code, message)


def _has_dynamics(joint: Joint) -> bool:
    """Return True if a joint has damping, friction or a spring."""
    dynamics = joint.dynamics
    if dynamics is None:
        return False
    return bool(dynamics.damping or dynamics.friction or dynamics.spring_stiffness)


def _note_extensions(conversion: Conversion) -> None:
    """Count the elements of other programs from which no pass has taken anything."""
    used = set(map(id, conversion.state(Placed).elements))
    tags = Counter(
        extension.tag for extension in conversion.robot.extensions if id(extension) not in used
    )
    if tags:
        listed = ", ".join(f"{count} <{tag}>" for tag, count in tags.items())
        conversion.note("extension", f"elements of other programs are left out: {listed}")
