"""Posture: the position that a simulation starts from.

Beyond the method, whose models start at zero.  In a project no joint starts beyond its limits: its
soft stop would throw the joint back.  Such a joint starts at the nearest limit.  A leader also
stays within the limits of its followers, if it can keep all of them.

The pass ``hold-gains`` computes the gains of ``hold``.
"""

from __future__ import annotations

from math import inf, isfinite, pi
from typing import Annotated

import msgspec
from lxml import etree
from msgspec import Meta

from urdf2mbs.plugin import (
    ConfigError,
    Conversion,
    Pass,
    Placed,
    Step,
    choose,
    files,
    fits,
    nearest,
    safe_parser,
    some,
)
from urdf2mbs.plugin import MbsJoint as Joint
from urdf2mbs_project.ranges import Coordinate
from urdf2mbs_project.simulation import Coupling, Held, Simulation


class Gains(msgspec.Struct, forbid_unknown_fields=True):
    frequency: Annotated[float, Meta(gt=0, le=1e3)] | None = None
    """At which what the joint carries would swing (Hz): ``stiffness = I (2 pi frequency)^2``."""
    damping_ratio: Annotated[float, Meta(ge=0, le=1e3)] | None = None
    """1: it does not swing; ``damping = 2 damping_ratio (I stiffness)^(1/2)``."""
    stiffness: Annotated[float, Meta(ge=0, le=1e12)] | None = None
    """N m/rad or N/m, instead of ``frequency``."""
    damping: Annotated[float, Meta(ge=0, le=1e12)] | None = None
    """N m s/rad or N s/m, instead of ``damping_ratio``."""


class HoldOptions(Gains, forbid_unknown_fields=True):
    joints: list[str] = []
    """Patterns of the joints that are held; none: all that move freely, without the base's."""
    gains: dict[str, Gains] = {}
    """Pattern of joints: other gains for these; a later pattern overrules."""


class Posture(Pass):
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
        starts = _starts(conversion) if self.from_urdf else {}
        asked = starts or self.joints or self.srdf or self.state
        settable, followers = _joints(conversion) if asked else ({}, set())
        given = {name: start for name, start in starts.items() if name in settable}
        if given:
            listed = some((f"{name} at {start:g}" for name, start in given.items()), SHOWN)
            what = f"joints start where <ros2_control> says: {listed}"
            conversion.note("posture-urdf", what)
        given |= _group_state(conversion, self, settable) if self.srdf or self.state else {}
        for pattern, value in self.joints.items():
            _refuse(conversion, pattern, settable, followers)
            names = choose([pattern], settable, "posture-joint", "posture: no joint")
            given |= dict.fromkeys(names, value)
        for joint in conversion.robot.joints.values():  # what nothing binds here starts by its rule
            rule = joint.mimic
            if rule is not None and rule.joint in given and joint.name in settable:
                settable[joint.name].q = rule.multiplier * given[rule.joint] + rule.offset
        for name, value in given.items():
            settable[name].q = value
        _follow(conversion)
        _keep_limits(
            conversion, given, move=self.inside and conversion.settings.project is not None
        )
        if self.hold is not None:
            conversion.state(Simulation).hold = _hold(conversion, self.hold)
        if given:
            conversion.report["posture"] = given


#: The frequency (Hz) and the damping ratio of what a joint carries, unless the config has others.
FREQUENCY, DAMPING_RATIO = 10.0, 0.3
#: A joint may be so far beyond its limits (rad or m): numbers in a file are rounded.
ROUNDING = 1e-9
#: The start positions of more joints are too long for a message.
SHOWN = 10


def _joints(conversion: Conversion) -> tuple[dict[str, Joint], set[str]]:
    """The .mbs joints that may be given a position, by name, and the names of the followers.

    The name is the URDF joint's; if this joint has several coordinates, the .mbs joint's.
    """
    simulation = conversion.state(Simulation)
    bound = {id(c.follower) for c in (*simulation.couplings, *simulation.driven)}
    settable: dict[str, Joint] = {}
    followers: set[str] = set()
    for step in conversion.steps():
        for joint in step.coordinates:
            name = step.joint.name if len(step.coordinates) == 1 else joint.name
            if id(joint) in bound or joint.nature == "driven":
                followers.add(name)
            else:
                settable[name] = joint
    return settable, followers


def _starts(conversion: Conversion) -> dict[str, float]:
    """The positions that ``<ros2_control>`` states, by joint."""
    starts: dict[str, float] = {}
    for extension in conversion.robot.extensions:
        if extension.starts:
            starts |= extension.starts
            conversion.state(Placed).elements.append(extension)
    return starts


def _refuse(
    conversion: Conversion, pattern: str, settable: dict[str, Joint], followers: set[str]
) -> None:
    """Raise ConfigError if the pattern fits only joints that cannot be given a position."""
    if any(fits(name, [pattern]) for name in settable):
        return
    if any(fits(name, [pattern]) for name in followers):
        why, hint = "follows another joint", "give the position of that one"
    elif pattern in conversion.frozen:
        why, hint = f"is not in the .mbs: {conversion.frozen[pattern]}", None
    elif pattern in conversion.robot.joints:
        why, hint = "has no position of its own", nearest(pattern, settable)
    else:
        return
    raise ConfigError("posture-joint", f"posture: joint '{pattern}' {why}", hint=hint)


def _group_state(
    conversion: Conversion, options: Posture, settable: dict[str, Joint]
) -> dict[str, float]:
    """The positions in a ``<group_state>``; states of one name in several groups add up."""
    if options.srdf is None or options.state is None:
        what, hint = "'srdf' and 'state' go together", "'srdf' names a file, 'state' a state in it"
        raise ConfigError("posture-srdf", f"posture: {what}", hint=hint)
    file = conversion.settings.folder / options.srdf
    try:
        root = etree.fromstring(files.read_bytes(file), safe_parser())
    except OSError as error:
        what = f"posture: cannot read '{file}': {error.strerror}"
        raise ConfigError("posture-srdf", what) from None
    except etree.XMLSyntaxError as error:
        what = f"posture: '{file}' is not XML: {error.msg}"
        raise ConfigError("posture-srdf", what, file=str(file), line=error.lineno) from None
    states = list(root.iter("group_state"))
    chosen = [state for state in states if state.get("name") == options.state]
    if not chosen:
        known = [str(state.get("name")) for state in states]
        hint = nearest(options.state, known) or f"there are: {', '.join(known) or 'none'}"
        what = f"posture: '{file}' has no group state '{options.state}'"
        raise ConfigError("posture-srdf", what, hint=hint)
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


def _follow(conversion: Conversion) -> None:
    for coupling in (*conversion.state(Simulation).couplings, *conversion.state(Simulation).driven):
        coupling.follow()


def _keep_limits(conversion: Conversion, given: dict[str, float], *, move: bool) -> None:
    """Say which joints start beyond their limits, and ``move`` them to the nearest limit."""
    steps = {
        joint.name: step
        for step, joint in conversion.single_coordinates()
        if step.joint.type != "continuous"
    }
    joints = {name: step.coordinates[0] for name, step in steps.items()}
    limits = {name: limits_of(step) for name, step in steps.items()}
    starts = {name: joint.q or 0.0 for name, joint in joints.items()}
    beyond = {name: q for name, q in starts.items() if not _within(q, limits[name])}
    if not beyond:
        return
    if move:
        _move_inside(conversion, joints, limits)
    texts = []
    for name, q in beyond.items():
        step, (low, high) = steps[name], limits[name]
        unit = "m" if step.joint.type == "prismatic" else "rad"
        start = joints[name].q or 0.0
        moved = f"{q + 0.0:g} is " if start != q else ""
        why = f"{moved}not in [{low:g}, {high:g}] {unit}"
        if step.joint.name in given and unit == "rad" and abs(q) > 2 * pi:
            why += "; positions are in rad"
        texts.append(f"{step.joint.name} at {start + 0.0:g} ({why})")
    middle = {
        steps[name].joint.name: _middle(steps[name])
        for name in beyond
        if isfinite(sum(limits[name])) and steps[name].joint.mimic is None
    }
    names = {name: msgspec.json.encode(name).decode() for name in middle}
    listed = ", ".join(f"{names[name]}: {q!r}" for name, q in middle.items())
    hint = f"'passes: {{posture: {{joints: {{{listed}}}}}}}' starts them in the middle"
    if not middle:
        hint = "'passes: {posture: {joints: {NAME: VALUE}}}' gives a start position"
    elif len(middle) > SHOWN:
        hint = "'urdf2mbs init' writes a config that starts them in the middle of their limits"
    said = "joints start beyond their limits"
    if move:
        said = "joints would start beyond their limits, and start within"
    conversion.warn(
        "posture-limit",
        f"{said}: {some(texts)}",
        joint=steps[next(iter(beyond))].joint.name,
        hint=hint,
    )
    conversion.report["posture-limit"] = {"middle": middle}


def _middle(step: Step) -> float:
    """The middle of the limits of a URDF joint (rad or m), in few digits."""
    low, high = limits_of(step)
    middle = (low + high) / 2
    short = float(f"{middle:.3g}")
    return short if abs(short - middle) < (high - low) / 4 else middle


def limits_of(step: Step) -> tuple[float, float]:
    """The limits of the .mbs joint (rad or m); limits that leave no room do not count."""
    limit = step.joint.limit
    low = -inf if limit is None or limit.lower is None else limit.lower
    high = inf if limit is None or limit.upper is None else limit.upper
    if not low < high:
        return -inf, inf
    return low, high


def _within(q: float, limits: tuple[float, float]) -> bool:
    return limits[0] - ROUNDING <= q <= limits[1] + ROUNDING


def _move_inside(
    conversion: Conversion, joints: dict[str, Joint], limits: dict[str, tuple[float, float]]
) -> None:
    followers: dict[str, list[Coupling]] = {}
    couplings = (*conversion.state(Simulation).couplings, *conversion.state(Simulation).driven)
    for coupling in couplings:
        followers.setdefault(coupling.leader.name, []).append(coupling)
    bound = {coupling.follower.name for coupling in couplings}
    for name, joint in joints.items():
        if name in bound:
            continue
        low, high = limits[name]
        for coupling in followers.get(name, ()):
            m, b = coupling.multiplier, coupling.offset
            if m:
                range_ = limits.get(coupling.follower.name, (-inf, inf))
                ends = sorted((end - b) / m for end in range_)
                if max(low, ends[0]) <= min(high, ends[1]):
                    low, high = max(low, ends[0]), min(high, ends[1])
        q = joint.q or 0.0
        if not _within(q, (low, high)):
            joint.q = min(max(q, low), high)
    _follow(conversion)


def _hold(conversion: Conversion, options: HoldOptions) -> list[Held]:
    joints = {
        step.joint.name: joint
        for step, joint in conversion.single_coordinates()
        if joint.nature == "independent" and fits(step.joint.name, options.joints or ["*"])
    }
    if not joints:
        raise ConfigError("posture-hold", "posture: no joint to hold fits 'hold.joints'")
    what = "posture: 'hold.gains': no joint that is held"
    patterns = {
        pattern: choose([pattern], joints, "posture-hold", what) for pattern in options.gains
    }
    held = []
    for name, joint in joints.items():
        chosen: Gains = options
        for pattern, names in patterns.items():
            if name in names:
                chosen = options.gains[pattern]
        frequency = chosen.frequency or options.frequency or FREQUENCY
        ratios = (chosen.damping_ratio, options.damping_ratio, DAMPING_RATIO)
        ratio = next(value for value in ratios if value is not None)
        held.append(Held(joint, chosen.stiffness, chosen.damping, frequency, ratio))
    return held
