"""Posture: set the position that a simulation starts from.

Beyond the method, whose models start at zero.  In a project no joint starts beyond its limits: its
soft stop would throw the joint back.  Such a joint starts at the nearest limit.  A leader also
stays within the limits of its followers, if it can keep all of them.

The pass ``hold-gains`` computes the gains of ``hold``.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, nan, pi
from typing import Annotated, NamedTuple

import msgspec
from lxml import etree
from msgspec import Meta

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    MbsJoint,
    Pass,
    Placed,
    Step,
    choose,
    files,
    fits,
    nearest,
    rounded,
    safe_parser,
    some,
)
from urdf2mbs_project.ranges import Coordinate
from urdf2mbs_project.simulation import Coupling, Held, Simulation

#: The frequency (Hz) and the damping ratio of the held joints, unless the config has others.
DEFAULT_FREQUENCY, DEFAULT_DAMPING_RATIO = 10.0, 0.3
#: A joint may start this far beyond its limits (rad or m): numbers in a file are rounded.
ROUNDING = 1e-9
#: The start positions of more joints than this are too long for a message.
MAX_SHOWN = 10


class Gains(msgspec.Struct, forbid_unknown_fields=True):
    """The gains of a controller that holds joints."""

    frequency: Annotated[float, Meta(gt=0, le=1e3)] | None = None
    """At which what the joint carries would swing (Hz): ``stiffness = I (2 pi frequency)^2``."""
    damping_ratio: Annotated[float, Meta(ge=0, le=1e3)] | None = None
    """1: it does not swing; ``damping = 2 damping_ratio (I stiffness)^(1/2)``."""
    stiffness: Annotated[float, Meta(ge=0, le=1e12)] | None = None
    """N m/rad or N/m, instead of ``frequency``."""
    damping: Annotated[float, Meta(ge=0, le=1e12)] | None = None
    """N m s/rad or N s/m, instead of ``damping_ratio``."""


class HoldOptions(Gains, forbid_unknown_fields=True):
    """A controller that holds the start position."""

    joints: list[str] = []
    """Patterns of the joints that are held; none: all that move freely, without the base's."""
    gains: dict[str, Gains] = {}
    """Pattern of joints: other gains for these; a later pattern overrules."""


class Posture(Pass):
    """Set the start position, and choose the joints that a controller holds."""

    reads = ("robot", "bodies", "joints", "couplings")
    writes = ("posture",)

    joints: dict[str, Coordinate] = {}
    """Pattern of joints: initial position (rad or m); a later pattern overrules."""
    srdf: str | None = None
    """An SRDF file, relative to the config."""
    state: str | None = None
    """The group state of the SRDF file; ``joints`` overrule it."""
    hold: HoldOptions | None = None
    """A PD controller that holds the start position: ``{frequency: 10, damping_ratio: 0.3}``."""
    from_urdf: bool = True
    """Start from the ``initial_value`` of positions in ``<ros2_control>``; the other options
    overrule them."""
    inside: bool = True
    """In a project, start each joint within its limits."""

    def run(self, conversion: Conversion) -> None:
        """Set the positions: of the URDF, then of the SRDF, then of the config."""
        positions = self._find_positions(conversion)
        _update_followers(conversion)
        moves_inside = self.inside and conversion.settings.project is not None
        _keep_limits(conversion, positions, moves_inside=moves_inside)
        if self.hold is not None:
            conversion.state(Simulation).hold = _choose_held_joints(conversion, self.hold)
        if positions:
            conversion.report["posture"] = positions

    def _find_positions(self, conversion: Conversion) -> dict[str, float]:
        """Set the joints to the positions that are stated, and return these (rad or m)."""
        urdf_positions = _read_urdf_positions(conversion) if self.from_urdf else {}
        if not (urdf_positions or self.joints or self.srdf or self.state):
            return {}
        joints = _find_settable_joints(conversion)
        positions = {
            name: position for name, position in urdf_positions.items() if name in joints.settable
        }
        if positions:
            pairs = (f"{name} at {position:g}" for name, position in positions.items())
            message = f"joints start where <ros2_control> says: {some(pairs, MAX_SHOWN)}"
            conversion.note("posture-urdf", message)
        if self.srdf or self.state:
            positions |= _read_group_state(conversion, self, joints.settable)
        for pattern, position in self.joints.items():
            _check_pattern(conversion, pattern, joints)
            names = choose([pattern], joints.settable, "posture-joint", "posture: no joint")
            positions |= dict.fromkeys(names, position)
        for joint in conversion.robot.joints.values():
            # A follower without a coupling starts by its rule, too.
            rule = joint.mimic
            if rule is not None and rule.joint in positions and joint.name in joints.settable:
                position = rule.multiplier * positions[rule.joint] + rule.offset
                joints.settable[joint.name].q = position
        for name, position in positions.items():
            joints.settable[name].q = position
        return positions


class _Joints(NamedTuple):
    """The joints of the .mbs that a position may be stated for.

    The name is that of the URDF's joint; if this has several coordinates, of the .mbs joint.
    """

    settable: dict[str, MbsJoint]
    followers: set[str]
    """The names of those whose position follows from another joint."""


def _list_couplings(conversion: Conversion) -> list[Coupling]:
    """List the couplings of all followers, by a constraint or by user code."""
    simulation = conversion.state(Simulation)
    return [*simulation.couplings, *simulation.driven]


def _update_followers(conversion: Conversion) -> None:
    """Set the start positions of all followers by those of their leaders."""
    for coupling in _list_couplings(conversion):
        coupling.update_follower()


def _find_settable_joints(conversion: Conversion) -> _Joints:
    """Find the joints that may be given a position, and those that follow others."""
    coupled = {id(coupling.follower) for coupling in _list_couplings(conversion)}
    joints = _Joints({}, set())
    for step in conversion.steps():
        for joint in step.coordinates:
            name = step.joint.name if len(step.coordinates) == 1 else joint.name
            if id(joint) in coupled or joint.nature == "driven":
                joints.followers.add(name)
            else:
                joints.settable[name] = joint
    return joints


# --- where positions are stated ---


def _read_urdf_positions(conversion: Conversion) -> dict[str, float]:
    """Return the positions (rad or m) that ``<ros2_control>`` states, by joint."""
    positions: dict[str, float] = {}
    for extension in conversion.robot.extensions:
        if extension.starts:
            positions |= extension.starts
            conversion.state(Placed).elements.append(extension)
    return positions


def _check_pattern(conversion: Conversion, pattern: str, joints: _Joints) -> None:
    """Raise ConfigError if a pattern fits only joints that cannot be given a position."""
    if any(fits(name, [pattern]) for name in joints.settable):
        return
    if any(fits(name, [pattern]) for name in joints.followers):
        reason, hint = "follows another joint", "give the position of that one"
    elif pattern in conversion.frozen:
        reason, hint = f"is not in the .mbs: {conversion.frozen[pattern]}", None
    elif pattern in conversion.robot.joints:
        reason, hint = "has no position of its own", nearest(pattern, joints.settable)
    else:
        return
    raise ConfigError("posture-joint", f"posture: joint '{pattern}' {reason}", hint=hint)


def _read_group_state(
    conversion: Conversion, options: Posture, settable: Mapping[str, MbsJoint]
) -> dict[str, float]:
    """Read the positions (rad or m) in a ``<group_state>`` of an SRDF file.

    States of one name in several groups add up.
    """
    positions: dict[str, float] = {}
    unused: list[str] = []
    for state in _find_group_states(conversion, options):
        for element in state.iter("joint"):
            name, text = str(element.get("name")), str(element.get("value"))
            try:
                position = float(text)
            except ValueError:  # such as the several numbers of a joint with several coordinates
                position = nan
            if isfinite(position) and name in settable:
                positions[name] = position
            elif not isfinite(position) or name not in conversion.robot.joints:
                unused.append(name)
    if unused:
        message = (
            f"group state '{options.state}' is not used for {', '.join(unused)}: not a joint with "
            "one position"
        )
        conversion.warn("posture-state", message)
    return positions


def _find_group_states(conversion: Conversion, options: Posture) -> list[etree._Element]:
    """Find the elements ``<group_state>`` that the options name.

    Raises:
        ConfigError: The file cannot be read, or has no such state.
    """
    if options.srdf is None or options.state is None:
        message = "posture: 'srdf' and 'state' go together"
        hint = "'srdf' names a file, 'state' a state in it"
        raise ConfigError("posture-srdf", message, hint=hint)
    file = conversion.settings.folder / options.srdf
    try:
        root = etree.fromstring(files.read_bytes(file), safe_parser())
    except OSError as error:
        message = f"posture: cannot read '{file}': {error.strerror}"
        raise ConfigError("posture-srdf", message) from None
    except etree.XMLSyntaxError as error:
        message = f"posture: '{file}' is not XML: {error.msg}"
        raise ConfigError("posture-srdf", message, file=str(file), line=error.lineno) from None
    states = list(root.iter("group_state"))
    chosen = [state for state in states if state.get("name") == options.state]
    if not chosen:
        names = [str(state.get("name")) for state in states]
        hint = nearest(options.state, names) or f"there are: {', '.join(names) or 'none'}"
        message = f"posture: '{file}' has no group state '{options.state}'"
        raise ConfigError("posture-srdf", message, hint=hint)
    return chosen


# --- limits ---


class Limits(NamedTuple):
    """The limits of a joint (rad or m)."""

    lower: float
    upper: float

    def contain(self, position: float) -> bool:
        """Return True if a position is within the limits, or beyond by rounding."""
        return self.lower - ROUNDING <= position <= self.upper + ROUNDING


def get_limits(step: Step) -> Limits:
    """Return the limits of the .mbs joint; limits that leave no range are ignored."""
    limit = step.joint.limit
    lower = -inf if limit is None or limit.lower is None else limit.lower
    upper = inf if limit is None or limit.upper is None else limit.upper
    return Limits(lower, upper) if lower < upper else Limits(-inf, inf)


def _compute_middle(step: Step) -> float:
    """Return the middle of the limits of a URDF joint (rad or m), in few digits."""
    lower, upper = get_limits(step)
    middle = (lower + upper) / 2
    short = rounded(middle, 3)
    return short if abs(short - middle) < (upper - lower) / 4 else middle


def _keep_limits(
    conversion: Conversion, positions: Mapping[str, float], *, moves_inside: bool
) -> None:
    """Warn of joints that start beyond their limits, and move them to the nearest limit.

    Args:
        conversion: The robot, with its joints at their start positions.
        positions: The positions (rad or m) that are stated.
        moves_inside: False to warn only.
    """
    steps = {
        joint.name: step
        for step, joint in conversion.single_coordinates()
        if step.joint.type != "continuous"
    }
    stated = {name: step.coordinates[0].q or 0.0 for name, step in steps.items()}
    beyond = {
        name: position
        for name, position in stated.items()
        if not get_limits(steps[name]).contain(position)
    }
    if not beyond:
        return
    if moves_inside:
        _move_inside(conversion, steps)
    texts = [
        _describe_start(steps[name], position, is_stated=steps[name].joint.name in positions)
        for name, position in beyond.items()
    ]
    middle = {
        steps[name].joint.name: _compute_middle(steps[name])
        for name in beyond
        if isfinite(sum(get_limits(steps[name]))) and steps[name].joint.mimic is None
    }
    problem = "joints start beyond their limits"
    if moves_inside:
        problem = "joints would start beyond their limits, and start within"
    conversion.warn(
        "posture-limit",
        f"{problem}: {some(texts)}",
        joint=steps[next(iter(beyond))].joint.name,
        hint=_propose_middle(middle),
    )
    conversion.report["posture-limit"] = {"middle": middle}


def _describe_start(step: Step, stated: float, *, is_stated: bool) -> str:
    """Describe where a joint starts, and why not elsewhere.

    Args:
        step: The joint, at its start position.
        stated: The position (rad or m) that is beyond its limits.
        is_stated: True if the user has stated it.
    """
    lower, upper = get_limits(step)
    unit = "m" if step.joint.type == "prismatic" else "rad"
    start = step.coordinates[0].q or 0.0
    reason = f"not in [{lower:g}, {upper:g}] {unit}"
    if start != stated:
        reason = f"{stated + 0.0:g} is {reason}"
    if is_stated and unit == "rad" and abs(stated) > 2 * pi:
        reason += "; positions are in rad"
    return f"{step.joint.name} at {start + 0.0:g} ({reason})"


def _propose_middle(middle: Mapping[str, float]) -> str:
    """Return a hint to start joints in the middle of their limits (rad or m)."""
    if not middle:
        return "'passes: {posture: {joints: {NAME: VALUE}}}' sets a start position"
    if len(middle) > MAX_SHOWN:
        return "'urdf2mbs init' writes a config that starts them in the middle of their limits"
    pairs = (
        f"{msgspec.json.encode(name).decode()}: {position!r}" for name, position in middle.items()
    )
    return f"'passes: {{posture: {{joints: {{{', '.join(pairs)}}}}}}}' starts them in the middle"


def _move_inside(conversion: Conversion, steps: Mapping[str, Step]) -> None:
    """Move joints to the nearest limit, and leaders within the limits of their followers.

    Args:
        conversion: The robot.
        steps: The joints with limits, by the names of the .mbs.
    """
    couplings_of_leader: dict[str, list[Coupling]] = {}
    for coupling in _list_couplings(conversion):
        couplings_of_leader.setdefault(coupling.leader.name, []).append(coupling)
    followers = {coupling.follower.name for coupling in _list_couplings(conversion)}
    for name, step in steps.items():
        if name in followers:
            continue
        lower, upper = get_limits(step)
        for coupling in couplings_of_leader.get(name, ()):
            follower = steps.get(coupling.follower.name)
            if follower is not None and coupling.multiplier:
                # m q + b within the limits of the follower
                ends = [
                    (limit - coupling.offset) / coupling.multiplier
                    for limit in get_limits(follower)
                ]
                if max(lower, min(ends)) <= min(upper, max(ends)):
                    lower, upper = max(lower, min(ends)), min(upper, max(ends))
        joint = step.coordinates[0]
        position = joint.q or 0.0
        if not Limits(lower, upper).contain(position):
            joint.q = min(max(position, lower), upper)
    _update_followers(conversion)


# --- the controller that holds the start position ---


def _choose_held_joints(conversion: Conversion, options: HoldOptions) -> list[Held]:
    """Choose the joints that a controller holds, and what the config says of their gains.

    Raises:
        ConfigError: No joint is held, or a pattern of gains fits none.
    """
    joints = {
        step.joint.name: joint
        for step, joint in conversion.single_coordinates()
        if joint.nature == "independent" and fits(step.joint.name, options.joints or ["*"])
    }
    if not joints:
        raise ConfigError("posture-hold", "posture: no joint to hold fits 'hold.joints'")
    message = "posture: 'hold.gains': no joint that is held"
    gains_of_joint: dict[str, Gains] = dict.fromkeys(joints, options)
    for pattern, gains in options.gains.items():
        names = choose([pattern], joints, "posture-hold", message)
        gains_of_joint |= dict.fromkeys(names, gains)
    held_joints = []
    for name, joint in joints.items():
        gains = gains_of_joint[name]
        frequency = gains.frequency or options.frequency or DEFAULT_FREQUENCY
        ratios = (gains.damping_ratio, options.damping_ratio, DEFAULT_DAMPING_RATIO)
        ratio = next(ratio for ratio in ratios if ratio is not None)
        held_joints.append(Held(joint, gains.stiffness, gains.damping, frequency, ratio))
    return held_joints
