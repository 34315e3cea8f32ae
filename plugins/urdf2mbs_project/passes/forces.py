"""Forces: external forces at points, and springs between points, from the config.

Beyond the method.  A wrench is an ``extforce`` at a point; a user model of its name says how large
it is, in the axes of the base, and from when to when it acts.  A spring is a ``link`` between two
points, with the force ``K (Z - Z0) + D dZ/dt`` along it; stiffness, damping and length are
parameters of user models, called as the springs are.
"""

from __future__ import annotations

from math import dist

import msgspec

from urdf2mbs.plugin import ZERO, ConfigError, Connection, Conversion, Pass, UserModel, identifiers
from urdf2mbs.plugin import MbsSensor as Sensor
from urdf2mbs.plugin import compute_placement as place
from urdf2mbs_project.places import point_at
from urdf2mbs_project.ranges import End, Force, Gain, Length, Place, Time
from urdf2mbs_project.simulation import MEASURES, WRENCH, Simulation, Wrench

#: A time (s) that no simulation reaches.
NEVER = 1e9


class WrenchOptions(msgspec.Struct, forbid_unknown_fields=True):
    link: str
    """On which it acts."""
    at: Place = ZERO
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
    ends: tuple[End, End]
    """``[{link: a, at: [x, y, z]}, {link: b, at: [x, y, z]}]``"""
    stiffness: Gain
    """N/m."""
    damping: Gain = 0.0
    """N s/m."""
    length: Length | None = None
    """Where it is at rest (m); none: as long as it is at the start position."""


class Forces(Pass):
    reads = ("robot", "bodies", "joints", "posture")
    writes = ("anchors", "forces")

    wrenches: dict[str, WrenchOptions] = {}
    """Name: ``{link, at, force, torque, start, stop}``."""
    springs: dict[str, SpringOptions] = {}
    """Name: ``{ends: [{link, at}, {link, at}], stiffness, damping, length}``."""

    def run(self, conversion: Conversion) -> None:
        if not self.wrenches and not self.springs:
            return
        mbs, simulation = conversion.mbs, conversion.state(Simulation)
        for name in (*self.wrenches, *self.springs):
            if identifiers([name]) != [name]:
                raise ConfigError(
                    "forces-name", f"forces: '{name}' cannot be a name in Robotran",
                    hint="take letters, digits and '_', a letter first",
                )  # fmt: skip
        # forces and links share a name space with bodies and joints, and must not take their names
        taken = conversion.robot.links.keys() | conversion.robot.joints.keys()
        for name, wrench in self.wrenches.items():
            acts = ("forces-link", f"forces: '{name}' acts on")
            body, point = conversion.add_point(f"{name}_at", wrench.link, wrench.at, *acts)
            if body is None:
                raise ConfigError(
                    "forces-link",
                    f"forces: '{name}' acts on link '{wrench.link}', which never moves",
                )
            point.extforce = Sensor(f"{name}_force" if name in taken else name, MEASURES)
            parts = dict(zip(WRENCH, (*wrench.force, *wrench.torque), strict=True))
            model = UserModel.of(name, {**parts, "start": wrench.start, "stop": wrench.stop})
            mbs.user_models.append(model)
            simulation.wrenches.append(Wrench(point, model))
        placement = place(mbs)
        stiffness: dict[str, float] = {}
        damping: dict[str, float] = {}
        lengths: dict[str, float] = {}
        for name, spring in self.springs.items():
            acts = ("forces-link", f"forces: '{name}' acts on")
            ends = [
                conversion.add_point(f"{name}_{number}", end.link, end.at, *acts)
                for number, end in enumerate(spring.ends, start=1)
            ]
            one, two = ((body, point.name) for body, point in ends)
            own = f"{name}_spring" if name in taken else name
            link = Connection("link", own, one, two)
            mbs.links.append(link)
            distance = dist(point_at(placement, mbs, *one), point_at(placement, mbs, *two))
            length = distance if spring.length is None else spring.length
            if distance == 0.0:
                raise ConfigError(
                    "forces-spring", f"forces: the ends of spring '{name}' coincide, so that its "
                    "force has no direction",
                )  # fmt: skip
            stiffness[own], damping[own], lengths[own] = spring.stiffness, spring.damping, length
            simulation.springs.append(link)
        if stiffness:
            models = {"stiffness": stiffness, "damping": damping, "length": lengths}
            mbs.user_models += [UserModel.of(f"link_{key}", of) for key, of in models.items()]
        conversion.report["forces"] = {
            "wrenches": [wrench.point for wrench in simulation.wrenches],
            "springs": simulation.springs,
        }
