"""Sensors: points whose motion Robotran computes, from the config and from the URDF.

Beyond the method.  A contact sensor needs no point: its force is the sum over the link's contact
points.  Cameras and the like have no place in an .mbs.  The generated code has a helper for each
sensor, which knows the sensor's axes, since a point has none.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import dist

from urdf2mbs.plugin import (
    HERE,
    Conversion,
    Pass,
    Placed,
    Point,
    Pose,
    Segment,
    choose,
    compose,
    counted,
    free_name,
    mbs,
)
from urdf2mbs.plugin import UrdfSensor as Sensor
from urdf2mbs_project.gazebo import MOTION
from urdf2mbs_project.simulation import MEASURES, ForceTorque, PointSensor, Simulation

#: Two places are the same if their numbers (m, 1) are no further apart: files round their digits.
CLOSE = 1e-6


class Sensors(Pass):
    reads = ("robot", "bodies", "joints")
    writes = ("anchors",)

    links: list[str] = []
    """Patterns of links that get a sensor at their frame. The sensor has the link's name."""
    from_urdf: bool = True
    """Use the sensors of ``<gazebo>`` and ``<sensor>``."""
    only: list[str] = []
    """Patterns of the URDF's sensors that are used; none: all."""

    def run(self, conversion: Conversion) -> None:
        simulation = conversion.state(Simulation)
        simulation.force_torques = [*_force_torques(conversion)]
        wanted = self._of_urdf(conversion) if self.from_urdf else []
        links = choose(self.links, conversion.robot.links, "sensors-links", "sensors: no link")
        wanted += [Sensor(link, "frame", link) for link in links]
        if not wanted and not simulation.sensors:
            return
        parts = conversion.parts()
        lost: list[str] = []
        for name, sensor in _name_apart(conversion, wanted).items():
            segment, at = parts.get(sensor.on, (None, HERE))
            if segment is None or segment.parent is None:
                # the C library overruns its memory for sensors on the base
                lost.append(f"{name} (link '{sensor.on}')")
                continue
            simulation.sensors.append(_put(conversion, segment, name, sensor, at))
        if lost:
            conversion.warn(
                "sensor-left-out",
                f"{counted(len(lost), 'sensor')} left out, on links that are no part of a moving "
                f"body: {', '.join(lost)}",
            )
        if simulation.sensors:
            conversion.report["sensors"] = [
                {"name": s.name, "kind": s.kind, "link": s.link, "point": s.point}
                for s in simulation.sensors
            ]

    def _of_urdf(self, conversion: Conversion) -> list[Sensor]:
        """The sensors of motion that are wanted."""
        extensions = conversion.robot.extensions
        sensors = [s for element in extensions for s in element.sensors if s.type in MOTION]
        names = [sensor.name for sensor in sensors]
        only = names
        if self.only:
            only = choose(self.only, names, "sensors-only", "sensors: no sensor of the URDF")
        wanted = [sensor for sensor in sensors if sensor.name in only]
        for element in extensions:
            if any(sensor in wanted for sensor in element.sensors):
                conversion.state(Placed).elements.append(element)
        return wanted


def _force_torques(conversion: Conversion) -> Iterator[ForceTorque]:
    """The force-torque sensors, which ``decompose-joints`` has made of fixed joints."""
    for segment in conversion.segments.values():
        for step in segment.steps:
            if step.measured is not None:
                link = step.joint.child
                at = segment.parts.get(link) or step.frames[link]
                yield ForceTorque(step.measured, link, step.joints[-6:], at.rot)


def _name_apart(conversion: Conversion, sensors: list[Sensor]) -> dict[str, Sensor]:
    """The sensors by name, no two of one name.

    A sensor may be in ``<gazebo>`` and in ``<sensor>``, and may have its place in one of them only.
    """
    named: dict[str, Sensor] = {}
    names: dict[tuple[str, str, bool], list[str]] = {}
    taken = {sensor.name for sensor in sensors}
    for sensor in sensors:
        twins = names.setdefault((sensor.name, sensor.on, sensor.type in MOTION), [])
        for name in twins:
            one, two = sensor.pose, named[name].pose
            if HERE in (one, two) or dist((*one.xyz, *one.rot), (*two.xyz, *two.rot)) <= CLOSE:
                if sensor.pose != HERE:
                    named[name] = sensor
                break
        else:
            name = sensor.name
            if name in named:
                name = free_name(f"{sensor.on}_{name}", taken)
                taken.add(name)
                conversion.warn(
                    "sensor-renamed",
                    f"several sensors are called '{sensor.name}': that of link '{sensor.on}' is "
                    f"called '{name}' here",
                    line=sensor.line,
                )
            twins.append(name)
            named[name] = sensor
    return named


def _put(
    conversion: Conversion, segment: Segment, name: str, sensor: Sensor, at: Pose
) -> PointSensor:
    """A sensor at the link's own anchor point where it has one, else at a new point."""
    robot, link, points = conversion.robot, sensor.on, segment.body.points
    at = compose(at, sensor.pose)
    point = next(
        (p for p in points if p.name == link and p.sensor is None and p.extforce is None), None
    )
    if point is None or sensor.pose != HERE:
        point = Point(f"{name}_at", at.xyz)
        points.append(point)
    # sensors share a name space with bodies and joints, and must not take their names
    taken = name in robot.links or name in robot.joints
    point.sensor = mbs.Sensor(f"{name}_sensor" if taken else name, (*MEASURES, "Jac"))
    return PointSensor(name, sensor.type, link, point, at.rot)
