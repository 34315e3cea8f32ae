"""Posture: the position that a simulation starts from.

Beyond the method, whose models start at zero.  Joints get their initial value from the config
or from a group state of an SRDF file; joints that follow others follow.  Where a joint starts
outside its limits, that is said.  With ``hold``, the generated joint forces hold this position
by a PD controller.

Positions and limits are the URDF's: a joint that align-frames made count the other way round
starts at minus what is given.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from math import inf, isfinite, pi

import msgspec
from lxml import etree

from urdf2mbs import files
from urdf2mbs.conversion import Conversion
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Joint
from urdf2mbs.simulation import Hold


class HoldOptions(msgspec.Struct, forbid_unknown_fields=True):
    stiffness: float
    """N m/rad or N/m."""
    damping: float
    """N m s/rad or N s/m."""
    joints: list[str] = []
    """Patterns of the joints that are held; none: all that move freely, without the base's."""

    def __post_init__(self) -> None:
        for value in (self.stiffness, self.damping):
            if not 0.0 <= value < inf:
                raise ValueError(f"{value} holds nothing: give a finite number, not below 0")


class Posture(Pass):
    reads = ("robot", "joints", "couplings")
    writes = ("posture",)

    joints: dict[str, float] = {}
    """Pattern of joints: initial position (rad or m); a later pattern overrules."""
    srdf: str | None = None
    """An SRDF file, relative to the config."""
    state: str | None = None
    """The group state of the SRDF file; ``joints`` overrule it."""
    hold: HoldOptions | None = None
    """A PD controller that holds the start position: ``{stiffness: 200, damping: 4}``."""

    def run(self, conversion: Conversion) -> None:
        asked = self.joints or self.srdf or self.state
        settable, followers = _joints(conversion) if asked else ({}, set())
        given = _group_state(conversion, self, settable) if self.srdf or self.state else {}
        for pattern, value in self.joints.items():
            if not isfinite(value):
                raise ConfigError("posture-value", f"posture: '{pattern}' is {value}")
            names = [name for name in settable if fnmatchcase(name, pattern)]
            if not names:
                raise _unknown(conversion, pattern, settable, followers)
            given |= dict.fromkeys(names, value)
        for name, value in given.items():
            settable[name].q = -value if name in conversion.names.flipped else value
        for coupling in (*conversion.simulation.couplings, *conversion.simulation.driven):
            coupling.follower.q = coupling.multiplier * (coupling.leader.q or 0.0) + coupling.offset
        _tell_limits(conversion, given)
        if self.hold is not None:
            conversion.simulation.hold = _hold(conversion, self.hold)
        if given:
            conversion.report["posture"] = given


#: What a joint may be beyond its limits (rad or m): the rounding of numbers in a file.
ROUNDING = 1e-9


def _joints(conversion: Conversion) -> tuple[dict[str, Joint], set[str]]:
    """The .mbs joints that may be given a position, by the URDF joint's name (by their own where
    it has several coordinates), and the names of those that follow others."""
    simulation = conversion.simulation
    bound = {id(c.follower) for c in (*simulation.couplings, *simulation.driven)}
    settable: dict[str, Joint] = {}
    followers: set[str] = set()
    for segment in conversion.segments.values():
        for step in segment.steps:
            one = len(step.coordinates) == 1
            for joint in step.coordinates:
                name = step.joint.name if one else joint.name
                if id(joint) in bound:
                    followers.add(name)
                else:
                    settable[name] = joint
    return settable, followers


def _unknown(
    conversion: Conversion, pattern: str, settable: dict[str, Joint], followers: set[str]
) -> ConfigError:
    if any(fnmatchcase(name, pattern) for name in followers):
        why, hint = "follows another joint", "give the position of that one"
    elif pattern in conversion.frozen:
        why, hint = f"is not in the .mbs: {conversion.frozen[pattern]}", None
    elif pattern in conversion.robot.joints:
        why, hint = "has no position of its own", nearest(pattern, settable)
    else:
        return ConfigError(
            "posture-joint", f"posture: no joint is called '{pattern}'",
            hint=nearest(pattern, settable) or "'*' in a pattern stands for any text: '*_knee'",
        )  # fmt: skip
    return ConfigError("posture-joint", f"posture: joint '{pattern}' {why}", hint=hint)


def _group_state(
    conversion: Conversion, options: Posture, settable: dict[str, Joint]
) -> dict[str, float]:
    """The positions in a ``<group_state>``; states of one name in several groups add up."""
    if options.srdf is None or options.state is None:
        raise ConfigError(
            "posture-srdf", "posture: 'srdf' and 'state' go together",
            hint="'srdf' names the file, 'state' a group state in it",
        )  # fmt: skip
    file = conversion.settings.folder / options.srdf
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(files.read(file), parser)
    except OSError as error:
        raise ConfigError(
            "posture-srdf", f"posture: cannot read '{file}': {error.strerror}"
        ) from None
    except etree.XMLSyntaxError as error:
        raise ConfigError(
            "posture-srdf", f"posture: '{file}' is not XML: {error.msg}",
            file=str(file), line=error.lineno,
        ) from None  # fmt: skip
    states = list(root.iter("group_state"))
    chosen = [state for state in states if state.get("name") == options.state]
    if not chosen:
        known = [str(state.get("name")) for state in states]
        raise ConfigError(
            "posture-srdf", f"posture: '{file}' has no group state '{options.state}'",
            hint=nearest(options.state, known) or f"there are: {', '.join(known) or 'none'}",
        )  # fmt: skip
    given: dict[str, float] = {}
    left_out: list[str] = []
    for element in (joint for state in chosen for joint in state.iter("joint")):
        name, text = str(element.get("name")), str(element.get("value"))
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not isfinite(value):
            # a joint with several coordinates has several numbers there
            left_out.append(name)
        elif name in settable:
            given[name] = value
        elif name not in conversion.robot.joints:
            left_out.append(name)
    if left_out:
        conversion.warn(
            "posture-state",
            f"group state '{options.state}' is not used for {', '.join(left_out)}: not a joint "
            "with one position",
        )
    return given


def _tell_limits(conversion: Conversion, given: dict[str, float]) -> None:
    beyond: list[str] = []
    for segment in conversion.segments.values():
        for step in segment.steps:
            limit = step.joint.limit
            if limit is None or len(step.coordinates) != 1 or step.joint.type == "continuous":
                continue
            low = -inf if limit.lower is None else limit.lower
            high = inf if limit.upper is None else limit.upper
            q = step.coordinates[0].q or 0.0
            q = -q if step.flipped else q
            if low < high and not low - ROUNDING <= q <= high + ROUNDING:
                unit = "m" if step.joint.type == "prismatic" else "rad"
                told = f"{step.joint.name} at {q:g} of [{low:g}, {high:g}] {unit}"
                if step.joint.name in given and unit == "rad" and abs(q) > 2 * pi:
                    told += " (positions are in rad)"
                beyond.append(told)
    if beyond:
        conversion.warn(
            "posture-limit",
            f"joints that start beyond their limits: {'; '.join(beyond)}",
            hint="give a start position: 'passes: {posture: {joints: {NAME: VALUE}}}'",
        )


def _hold(conversion: Conversion, options: HoldOptions) -> Hold:
    held = [
        step.coordinates[0]
        for segment in conversion.segments.values()
        for step in segment.steps
        if len(step.coordinates) == 1
        and step.coordinates[0].nature == "independent"
        and any(fnmatchcase(step.joint.name, pattern) for pattern in options.joints or ["*"])
    ]
    if not held:
        raise ConfigError("posture-hold", "posture: no joint to hold fits 'hold.joints'")
    return Hold(held, options.stiffness, options.damping)
