"""Sensors: points whose motion Robotran computes, from the config and from the URDF.

Beyond the method.  An IMU, accelerometer or gyroscope in ``<gazebo>`` or ``<sensor>`` becomes an
anchor point with a ``sensor``, all of whose signals are computed; so does the frame of each link
that the config names.  Contact sensors need no point: the force is that of the link's contact
points.  Cameras and the like have no place in an .mbs.

The generated code has a helper for each, which knows the sensor's own axes: a point has none.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from math import isfinite

from lxml import etree

from urdf2mbs.conversion import Conversion, Segment
from urdf2mbs.diagnostics import ConfigError, nearest
from urdf2mbs.engine.hookspecs import Pass
from urdf2mbs.mbs.model import Point, Sensor
from urdf2mbs.simulation import PointSensor
from urdf2mbs.spatial import HERE, Pose, compose, from_rpy

#: Every signal that Robotran can compute for a sensor.
MEASURES = ("Pos", "Rot", "Vit", "Om", "Acc", "Omp", "Jac")

#: The URDF's types of sensor that are about motion, as the generated code calls them.
KINDS = {"imu": "imu", "accelerometer": "accelerometer", "gyroscope": "gyroscope"}


class Sensors(Pass):
    reads = ("robot", "bodies")
    writes = ("anchors",)

    links: list[str] = []
    """Patterns of links that get a sensor at their frame, called as they are."""
    from_urdf: bool = True
    """Whether the sensors of ``<gazebo>`` and ``<sensor>`` are taken."""
    only: list[str] = []
    """Patterns of those sensors of the URDF that are taken; none: all."""

    def run(self, conversion: Conversion) -> None:
        wanted = _from_urdf(conversion, self) if self.from_urdf else []
        links = list(conversion.robot.links)
        for pattern in self.links:
            named = [link for link in links if fnmatchcase(link, pattern)]
            if not named:
                raise ConfigError(
                    "sensors-links", f"sensors: no link is called '{pattern}'",
                    hint=nearest(pattern, links) or "'*' in a pattern stands for any text: '*_sole'",
                )  # fmt: skip
            wanted += [(link, "frame", link, HERE) for link in named]
        if not wanted and not conversion.simulation.sensors:
            return
        holders = {
            link: (segment, pose)
            for segment in conversion.segments.values()
            for link, pose in segment.parts.items()
        }
        known: set[str] = set()
        lost: list[str] = []
        for name, kind, link, pose in wanted:
            if name in known:
                continue  # the same sensor in <gazebo> and in <sensor>
            known.add(name)
            segment, at = holders.get(link, (None, HERE))
            if segment is None or segment.parent is None:
                # the C library overruns its memory for sensors on the base
                lost.append(f"{name} (link '{link}')")
                continue
            conversion.simulation.sensors.append(
                _put(conversion, segment, name, kind, link, compose(at, pose), plain=pose is HERE)
            )
        if lost:
            conversion.warn(
                "sensor-left-out",
                f"{len(lost)} sensors are on links that are no part of a moving body: "
                f"{', '.join(lost)}",
            )
        if conversion.simulation.sensors:
            conversion.report["sensors"] = [
                {"name": s.name, "kind": s.kind, "link": s.link, "point": s.point}
                for s in conversion.simulation.sensors
            ]


def _put(
    conversion: Conversion,
    segment: Segment,
    name: str,
    kind: str,
    link: str,
    at: Pose,
    *,
    plain: bool,
) -> PointSensor:
    """A sensor at the link's own anchor point where it has one, else at a new point."""
    robot = conversion.robot
    points = segment.body.points
    point = next(
        (p for p in points if plain and p.name == link and p.sensor is None and p.extforce is None),
        None,
    )
    if point is None:
        point = Point(f"{name}_at", at.xyz)
        points.append(point)
    # sensors share a name space with bodies and joints, and must not take their names
    taken = name in robot.links or name in robot.joints
    point.sensor = Sensor(f"{name}_sensor" if taken else name, MEASURES)
    return PointSensor(name, kind, link, point, at.rot)


def _from_urdf(conversion: Conversion, options: Sensors) -> list[tuple[str, str, str, Pose]]:
    """Each sensor's name, kind, link, and pose in the link's frame."""
    robot = conversion.robot
    sensors: list[tuple[str, str, str, Pose]] = []
    for extension in robot.extensions:
        for name, kind, element in extension.sensors(*KINDS):
            if options.only and not any(fnmatchcase(name, p) for p in options.only):
                continue
            parent = element.find("parent")
            link = extension.reference if parent is None else parent.get("link")
            if link not in robot.links:
                conversion.warn(
                    "sensor-left-out", f"sensor '{name}' is on '{link}', which is no link"
                )
                continue
            conversion.simulation.used.append(extension)
            sensors.append((name, KINDS[kind], link, _pose(element)))
    return sensors


def _pose(element: etree._Element) -> Pose:
    """``<pose>x y z roll pitch yaw</pose>`` (SDF) or ``<origin xyz rpy>`` (URDF), m and rad."""
    origin, pose = element.find("origin"), element.find("pose")
    text = ""
    if origin is not None:
        text = f"{origin.get('xyz') or '0 0 0'} {origin.get('rpy') or '0 0 0'}"
    elif pose is not None:
        text = pose.text or ""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return HERE
    if len(numbers) != 6 or not any(numbers) or not all(map(isfinite, numbers)):
        return HERE
    x, y, z, roll, pitch, yaw = numbers
    return Pose((x, y, z), from_rpy((roll, pitch, yaw)))
