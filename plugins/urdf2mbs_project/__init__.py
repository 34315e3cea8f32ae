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


def _states(field: str) -> Callable[[Conversion, bool], bool]:
    """True of a robot for which elements of other programs state such things."""
    return lambda conversion, given: (
        given or any(getattr(extension, field) for extension in conversion.robot.extensions)
    )


def _follows(conversion: Conversion, given: bool) -> bool:
    """True if a joint follows another."""
    return given or any(joint.mimic for joint in conversion.robot.joints.values())


def _starts(conversion: Conversion, given: bool) -> bool:
    """True if zero may be no start position: it is beyond limits, or others are stated."""
    return in_project(conversion, _states("starts")(conversion, given)) or any(
        not (joint.limit.lower or 0.0) <= 0.0 <= (joint.limit.upper or 0.0)
        for joint in conversion.robot.joints.values()
        if joint.limit is not None
    )


def _senses(conversion: Conversion, given: bool) -> bool:
    """True if there may be sensors."""
    measured = any(step.measured for step in conversion.steps())
    return measured or _states("sensors")(conversion, given)


def _holds(conversion: Conversion, given: bool) -> bool:
    """True if a controller may hold joints."""
    return given or "posture" in conversion.settings.config.passes


@hookimpl
def urdf2mbs_passes() -> list[PassEntry]:
    passes: list[tuple[str, tuple[str, ...], Any]] = [
        ("force-torque", ("prune-massless",), _states("sensors")),
        ("mimic", ("decompose-joints",), _follows),
        ("actuators", ("decompose-joints", "mimic"), _states("motors")),
        ("posture", ("collect-anchors",), _starts),
        ("joint-laws", ("joint-parameters",), in_project),
        ("loops", ("joint-parameters", "joint-laws"), _states("joints")),
        ("contacts", ("joint-parameters", "loops"), None),
        ("sensors", ("joint-parameters", "contacts"), _senses),
        ("forces", ("joint-parameters", "sensors"), None),
        ("hold-gains", ("joint-parameters", "forces"), _holds),
        ("friction-states", ("joint-parameters", "forces", "hold-gains"), in_project),
        ("time-step", ("joint-parameters", "forces", "friction-states"), in_project),
        ("find-singular", ("emit", "merge"), always),
        ("project", ("check", "equations"), in_project),
    ]
    package = "urdf2mbs_project"
    return [
        PassEntry(name, package, after, *([] if work is None else [work]))
        for name, after, work in passes
    ]


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    does = "write a config for a robot, to start from"
    return [Command("init", does, "urdf2mbs_project.commands.init")]


@hookimpl
def urdf2mbs_folders() -> list[str]:
    return ["animationR/vrml", "dataR", "resultsR", "symbolicR", "userfctR", "workR"]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    return {"simulation": "urdf2mbs_project.simulation"}


@hookimpl
def urdf2mbs_extension(
    elements: list[tuple[Any, urdf.Extension]], reading: Reading, robot: urdf.Robot
) -> None:
    from urdf2mbs_project.gazebo import Extensions

    extensions = Extensions(reading, robot)
    for element, extension in elements:
        extensions.read(element, extension)


@hookimpl
def urdf2mbs_summary(conversion: Conversion) -> Summary | None:
    # without a state of ours there is nothing to say, and nothing to import
    if not any(kind.__module__.startswith("urdf2mbs_project") for kind in conversion.states):
        return None
    from urdf2mbs_project.summary import summarise

    return summarise(conversion)


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_project.codes import CODES

    return CODES
