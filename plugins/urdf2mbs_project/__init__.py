"""A Robotran project: user models, contacts, sensors, loops, mimic; its code in Python and C."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from urdf2mbs.plugin import Command, PassEntry, always, hookimpl, in_project

if TYPE_CHECKING:
    from urdf2mbs.plugin import Conversion, Reading, Summary, urdf

#: The plugins that this plugin needs: contacts read meshes; a project carries a test whether its
#: equations fit the model, and ``loops`` names the rows that the equations leave out; ``init``
#: proposes the preset ``compact``.
NEEDS = ("meshes", "equations", "compact")


def _has_extension(field: str) -> Callable[[Conversion, bool], bool]:
    """Return a condition: an element of another program has data in a field, or given options."""
    return lambda conversion, given: (
        given or any(getattr(extension, field) for extension in conversion.robot.extensions)
    )


def _has_followers(conversion: Conversion, given: bool) -> bool:
    """Return True if a joint follows another, or options are given."""
    return given or any(joint.mimic for joint in conversion.robot.joints.values())


def _may_start_elsewhere(conversion: Conversion, given: bool) -> bool:
    """Return True if joints may not start at zero: it is beyond limits, or others are stated."""
    has_starts = _has_extension("starts")(conversion, given)
    return in_project(conversion, has_starts) or any(
        not (joint.limit.lower or 0.0) <= 0.0 <= (joint.limit.upper or 0.0)
        for joint in conversion.robot.joints.values()
        if joint.limit is not None
    )


def _may_have_sensors(conversion: Conversion, given: bool) -> bool:
    """Return True if there may be sensors, or options are given."""
    has_force_torque = any(step.measured for step in conversion.steps())
    return has_force_torque or _has_extension("sensors")(conversion, given)


def _may_hold_joints(conversion: Conversion, given: bool) -> bool:
    """Return True if a controller may hold joints."""
    return given or "posture" in conversion.settings.config.passes


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    """Return the passes, what each comes after, and when it has work."""
    passes: list[tuple[str, tuple[str, ...], Any]] = [
        ("force-torque", ("prune-massless",), _has_extension("sensors")),
        ("mimic", ("decompose-joints",), _has_followers),
        ("actuators", ("decompose-joints", "mimic"), _has_extension("motors")),
        ("posture", ("collect-anchors",), _may_start_elsewhere),
        ("joint-laws", ("joint-parameters",), in_project),
        ("loops", ("joint-parameters", "joint-laws"), _has_extension("joints")),
        ("contacts", ("joint-parameters", "loops"), None),
        ("sensors", ("joint-parameters", "contacts"), _may_have_sensors),
        ("forces", ("joint-parameters", "sensors"), None),
        ("hold-gains", ("joint-parameters", "forces"), _may_hold_joints),
        ("friction-states", ("joint-parameters", "forces", "hold-gains"), in_project),
        ("time-step", ("joint-parameters", "forces", "friction-states"), in_project),
        ("find-singular", ("emit", "merge"), always),
        ("project", ("check", "equations"), in_project),
    ]
    package = "urdf2mbs_project"
    return [
        PassEntry(name, package, after, *([] if has_work is None else [has_work]))
        for name, after, has_work in passes
    ]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    """Return the commands."""
    description = "write a config for a robot, to start from"
    return [Command("init", description, "urdf2mbs_project.commands.init")]


@hookimpl
def urdf2mbs_folders() -> list[str]:
    """Return the folders of a Robotran project."""
    return ["animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR"]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    """Return the modules that plugins may import."""
    return {"simulation": "urdf2mbs_project.simulation"}


@hookimpl
def urdf2mbs_extension(
    elements: list[tuple[Any, urdf.Extension]], reading: Reading, robot: urdf.Robot
) -> None:
    """Read the elements of other programs."""
    from urdf2mbs_project.gazebo import ExtensionReader

    reader = ExtensionReader(reading, robot)
    for element, extension in elements:
        reader.read(element, extension)


@hookimpl
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    """Return the uses of sensors and forces; None if no pass of this plugin has run."""
    # This check imports nothing of the plugin.
    if not any(kind.__module__.startswith("urdf2mbs_project") for kind in conversion.states):
        return None
    from urdf2mbs_project.summary import summarise

    return summarise(conversion)


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    """Return the meanings of message codes."""
    from urdf2mbs_project.codes import CODES

    return CODES
