"""Sensors: points whose motion Robotran computes, from the config and from the URDF.

Beyond the method.  A contact sensor needs no point: its force is the sum over the link's contact
points.  Cameras and the like cannot be written in an .mbs.  The generated code has a helper for
each sensor, which knows the sensor's axes: a point has none.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import dist

from urdf2mbs.plugin import (
    HERE,
    Conversion,
    MbsSensor,
    Pass,
    Placed,
    Point,
    Pose,
    Segment,
    UrdfSensor,
    choose,
    compose,
    counted,
    free_name,
)
from urdf2mbs_project.sdf import MOTION
from urdf2mbs_project.simulation import MEASURES, ForceTorque, PointSensor, Simulation

#: Two poses are the same if their numbers (m, 1) differ by no more: files round their digits.
POSE_TOLERANCE = 1e-6


class Sensors(Pass):
    """Add sensors at points."""

    reads = ("robot", "bodies", "joints")
    writes = ("anchors",)

    links: list[str] = []
    """Patterns of links that get a sensor at their frame. The sensor has the link's name."""
    from_urdf: bool = True
    """Use the sensors of ``<gazebo>`` and ``<sensor>``."""
    only: list[str] = []
    """Patterns of the URDF's sensors that are used; none: all."""

    def run(self, conversion: Conversion) -> None:
        """Add the sensors of the URDF, and those of links that the config names."""
        simulation = conversion.state(Simulation)
        simulation.force_torques = [*_list_force_torques(conversion)]
        sensors = self._choose_urdf_sensors(conversion) if self.from_urdf else []
        links = choose(self.links, conversion.robot.links, "sensors-links", "sensors: no link")
        sensors += [UrdfSensor(link, "frame", link) for link in links]
        if not sensors and not simulation.sensors:
            return
        parts = conversion.parts()
        left_out: list[str] = []
        for name, sensor in _choose_names(conversion, sensors).items():
            segment, link_pose = parts.get(sensor.on, (None, HERE))
            if segment is None or segment.parent is None:
                # Robotran's C library overruns its memory for sensors on the base.
                left_out.append(f"{name} (link '{sensor.on}')")
                continue
            pose = compose(link_pose, sensor.pose)
            simulation.sensors.append(_add_sensor(conversion, segment, name, sensor, pose))
        if left_out:
            message = (
                f"{counted(len(left_out), 'sensor')} left out, on links that are no part of a "
                f"moving body: {', '.join(left_out)}"
            )
            conversion.warn("sensor-left-out", message)
        if simulation.sensors:
            conversion.report["sensors"] = [
                {
                    "name": sensor.name,
                    "kind": sensor.kind,
                    "link": sensor.link,
                    "point": sensor.point,
                }
                for sensor in simulation.sensors
            ]

    def _choose_urdf_sensors(self, conversion: Conversion) -> list[UrdfSensor]:
        """Choose the sensors of motion of the URDF."""
        extensions = conversion.robot.extensions
        sensors = [
            sensor
            for extension in extensions
            for sensor in extension.sensors
            if sensor.type in MOTION
        ]
        names = [sensor.name for sensor in sensors]
        if self.only:
            message = "sensors: no sensor of the URDF"
            names = choose(self.only, names, "sensors-only", message)
        chosen = [sensor for sensor in sensors if sensor.name in names]
        for extension in extensions:
            if any(sensor in chosen for sensor in extension.sensors):
                conversion.state(Placed).elements.append(extension)
        return chosen


def _list_force_torques(conversion: Conversion) -> Iterator[ForceTorque]:
    """List the force-torque sensors that ``decompose-joints`` has made of fixed joints."""
    for segment in conversion.segments.values():
        for step in segment.steps:
            if step.measured is not None:
                link = step.joint.child
                pose = segment.parts.get(link) or step.frames[link]
                yield ForceTorque(step.measured, link, step.joints[-6:], pose.rot)


def _choose_names(conversion: Conversion, sensors: list[UrdfSensor]) -> dict[str, UrdfSensor]:
    """Return the sensors by unique names, each once.

    A sensor may be written in ``<gazebo>`` and in ``<sensor>``, and may have a pose in one of them
    only.  Sensors on one link with one name are the same if their poses are, or if one has none.
    """
    sensor_of_name: dict[str, UrdfSensor] = {}
    names: dict[tuple[str, str, bool], list[str]] = {}
    used_names = {sensor.name for sensor in sensors}
    for sensor in sensors:
        candidates = names.setdefault((sensor.name, sensor.on, sensor.type in MOTION), [])
        same = next(
            (name for name in candidates if _is_same_pose(sensor.pose, sensor_of_name[name].pose)),
            None,
        )
        if same is not None:
            if sensor.pose != HERE:
                sensor_of_name[same] = sensor
            continue
        name = sensor.name
        if name in sensor_of_name:
            name = free_name(f"{sensor.on}_{name}", used_names)
            used_names.add(name)
            message = (
                f"several sensors are called '{sensor.name}': that of link '{sensor.on}' is "
                f"called '{name}' here"
            )
            conversion.warn("sensor-renamed", message, line=sensor.line)
        candidates.append(name)
        sensor_of_name[name] = sensor
    return sensor_of_name


def _is_same_pose(first: Pose, second: Pose) -> bool:
    """Return True if two poses are the same, or if one of them is not stated."""
    if HERE in (first, second):
        return True
    return dist((*first.xyz, *first.rot), (*second.xyz, *second.rot)) <= POSE_TOLERANCE


def _add_sensor(
    conversion: Conversion, segment: Segment, name: str, sensor: UrdfSensor, pose: Pose
) -> PointSensor:
    """Add a sensor at the anchor point of its link if that is free, else at a new point.

    Args:
        conversion: The robot.
        segment: The segment whose body has the link.
        name: The name of the sensor.
        sensor: The sensor of the URDF, or of the config.
        pose: Its pose in the body.
    """
    robot, link, points = conversion.robot, sensor.on, segment.body.points
    free_points = [point for point in points if point.sensor is None and point.extforce is None]
    link_point = next((point for point in free_points if point.name == link), None)
    if link_point is None or sensor.pose != HERE:
        link_point = Point(f"{name}_at", pose.xyz)
        points.append(link_point)
    # Sensors share a name space with bodies and joints, and must not take their names.
    is_used = name in robot.links or name in robot.joints
    link_point.sensor = MbsSensor(f"{name}_sensor" if is_used else name, (*MEASURES, "Jac"))
    return PointSensor(name, sensor.type, link, link_point, pose.rot)
