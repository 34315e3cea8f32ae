"""Forces: external forces at points, and springs between points, from the config.

Beyond the method.  A wrench is an ``extforce`` at a point; the user model of its name has its
components, in the axes of the base, and when it starts and stops.  A spring is a ``link`` between
two points, with the force ``K (Z - Z0) + D dZ/dt`` along it; stiffness, damping and length are
parameters of user models, with the names of the springs.
"""

from __future__ import annotations

from math import dist

import msgspec

from urdf2mbs.plugin import (
    ZERO,
    ConfigError,
    Connection,
    Conversion,
    MbsSensor,
    Pass,
    Placement,
    UserModel,
    compute_placement,
    identifiers,
)
from urdf2mbs_project.places import compute_point_position
from urdf2mbs_project.ranges import End, Force, Gain, Length, Position, Time
from urdf2mbs_project.simulation import MEASURES, WRENCH_COMPONENTS, Simulation, Wrench

#: A time (s) that no simulation reaches.
NEVER = 1e9


class WrenchOptions(msgspec.Struct, forbid_unknown_fields=True):
    """An external force and torque on a link."""

    link: str
    """On which it acts."""
    at: Position = ZERO
    """In the link's frame (m)."""
    force: tuple[Force, Force, Force] = ZERO
    """N, in the axes of the base."""
    torque: tuple[Force, Force, Force] = ZERO
    """N m, in the axes of the base."""
    start: Time = 0.0
    """When it begins (s)."""
    stop: Time = NEVER
    """When it ends (s)."""


class SpringOptions(msgspec.Struct, forbid_unknown_fields=True):
    """A spring and damper between two links."""

    ends: tuple[End, End]
    """``[{link: a, at: [x, y, z]}, {link: b, at: [x, y, z]}]``"""
    stiffness: Gain
    """N/m."""
    damping: Gain = 0.0
    """N s/m."""
    length: Length | None = None
    """Where it is at rest (m); none: as long as it is at the start position."""


class Forces(Pass):
    """Add the wrenches and springs of the config."""

    reads = ("robot", "bodies", "joints", "posture")
    writes = ("anchors", "forces")

    wrenches: dict[str, WrenchOptions] = {}
    """Name: ``{link, at, force, torque, start, stop}``."""
    springs: dict[str, SpringOptions] = {}
    """Name: ``{ends: [{link, at}, {link, at}], stiffness, damping, length}``."""

    def run(self, conversion: Conversion) -> None:
        """Add the points, the forces between and at them, and their user models."""
        if not self.wrenches and not self.springs:
            return
        for name in (*self.wrenches, *self.springs):
            if identifiers([name]) != [name]:
                message = f"forces: '{name}' cannot be a name in Robotran"
                hint = "take letters, digits and '_', a letter first"
                raise ConfigError("forces-name", message, hint=hint)
        for name, wrench in self.wrenches.items():
            _add_wrench(conversion, name, wrench)
        self._add_springs(conversion)
        simulation = conversion.state(Simulation)
        conversion.report["forces"] = {
            "wrenches": [wrench.point for wrench in simulation.wrenches],
            "springs": simulation.springs,
        }

    def _add_springs(self, conversion: Conversion) -> None:
        """Add the springs, and the user models with their numbers."""
        placement = compute_placement(conversion.mbs)
        stiffness: dict[str, float] = {}
        damping: dict[str, float] = {}
        lengths: dict[str, float] = {}
        for name, spring in self.springs.items():
            link = _add_spring_link(conversion, name, spring)
            distance = _measure_length(conversion, placement, link)
            if distance == 0.0:
                message = (
                    f"forces: the ends of spring '{name}' coincide, so that its force has no "
                    "direction"
                )
                raise ConfigError("forces-spring", message)
            stiffness[link.name], damping[link.name] = spring.stiffness, spring.damping
            lengths[link.name] = distance if spring.length is None else spring.length
        if stiffness:
            conversion.mbs.user_models += [
                UserModel.of("link_stiffness", stiffness),
                UserModel.of("link_damping", damping),
                UserModel.of("link_length", lengths),
            ]


def _choose_name(conversion: Conversion, name: str, kind: str) -> str:
    """Return a name for a force or link, which must not be that of a body or a joint."""
    robot = conversion.robot
    return f"{name}_{kind}" if name in robot.links or name in robot.joints else name


def _add_wrench(conversion: Conversion, name: str, options: WrenchOptions) -> None:
    """Add a wrench, its point and its user model."""
    text = f"forces: '{name}' acts on"
    body, point = conversion.add_point(f"{name}_at", options.link, options.at, "forces-link", text)
    if body is None:
        message = f"{text} link '{options.link}', which never moves"
        raise ConfigError("forces-link", message)
    point.extforce = MbsSensor(_choose_name(conversion, name, "force"), MEASURES)
    components = zip(WRENCH_COMPONENTS, (*options.force, *options.torque), strict=True)
    numbers = {**dict(components), "start": options.start, "stop": options.stop}
    model = UserModel.of(name, numbers)
    conversion.mbs.user_models.append(model)
    conversion.state(Simulation).wrenches.append(Wrench(point, model))


def _add_spring_link(conversion: Conversion, name: str, options: SpringOptions) -> Connection:
    """Add a spring as a link of the .mbs, and the points where it ends."""
    text = f"forces: '{name}' acts on"
    ends = [
        conversion.add_point(f"{name}_{number}", end.link, end.at, "forces-link", text)
        for number, end in enumerate(options.ends, start=1)
    ]
    start, stop = ((body, point.name) for body, point in ends)
    link = Connection("link", _choose_name(conversion, name, "spring"), start, stop)
    conversion.mbs.links.append(link)
    conversion.state(Simulation).springs.append(link)
    return link


def _measure_length(conversion: Conversion, placement: Placement, link: Connection) -> float:
    """Return the length (m) of a link at the start position."""
    ends = [
        compute_point_position(placement, conversion.mbs, *endpoint)
        for endpoint in (link.endpoint1, link.endpoint2)
    ]
    return dist(*ends)
