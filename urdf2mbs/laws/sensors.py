"""Sensors: where they are, and what they read in their own axes.

At rest the specific force points up: it is the acceleration without gravity.  A force-torque
sensor reads what the side of the base does to its link, at the link's origin and in its axes.
"""

from __future__ import annotations

from fnmatch import fnmatchcase

import numpy as np

from urdf2mbs.laws.case import Case
from urdf2mbs.simulation import ForceTorque, PointSensor
from urdf2mbs.spatial import HERE, Pose
from urdf2mbs.urdf.gazebo import MOTION

#: m, 1: files round the digits of a place.
CLOSE = 1e-5


def prove(case: Case) -> None:
    options, sensors = case.asked.get("sensors"), case.simulation.sensors
    poses: dict[tuple[str, str], list[Pose]] = {}
    for extension in case.robot.extensions if options and options.from_urdf else ():
        for sensor in extension.sensors:
            chosen = not options.only or any(fnmatchcase(sensor.name, p) for p in options.only)
            if sensor.type in MOTION and chosen:
                poses.setdefault((sensor.on, sensor.name), []).append(sensor.pose)
    for link in case.robot.links if options else ():
        if any(fnmatchcase(link, pattern) for pattern in options.links):
            poses.setdefault((link, link), []).append(HERE)
    made = {(sensor.link, sensor.name) for sensor in sensors}
    lost = any(d.code == "sensor-left-out" for d in case.conversion.diagnostics)
    for link, name in poses.keys() - made - {(on, own.removeprefix(f"{on}_")) for on, own in made}:
        if not lost:
            case.differ(f"sensor '{name}' of link '{link}'", "it is not there", kind="anchors")
    for sensor in sensors:
        short = sensor.name.removeprefix(f"{sensor.link}_")
        own = poses.get((sensor.link, sensor.name)) or poses.get((sensor.link, short), [])
        if own:
            _prove_sensor(case, sensor, own)
        else:
            case.unproven[f"sensor '{sensor.name}'"] = "of a plugin"
    for torque in case.simulation.force_torques:
        _prove_force_torque(case, torque)


def _prove_sensor(case: Case, sensor: PointSensor, poses: list[Pose]) -> None:
    """One of the poses that the URDF gives it is its own; files may give several."""
    what, signal = f"sensor '{sensor.name}'", sensor.point.sensor
    if signal is None or signal.name not in case.points:
        case.differ(what, "it is not in the .mbs", kind="anchors")
        return
    body, point = case.points[signal.name]
    q, qd, qdd = case.go(1)
    place = case.in_mbs(body, point.coordinates, qdd)
    # whichever of its poses is nearest; the origin stands for a pose that is not given
    poses = [pose for pose in poses if pose != HERE] or poses
    known = [case.on_link(sensor.link, pose.xyz, qdd) for pose in poses]
    offs = [float(np.abs(at.at - place.at).max()) for at in known]
    nearest = int(np.argmin(offs))
    if offs[nearest] > CLOSE * case.size:
        case.compare(f"{what}: its place", known[nearest].at, place.at, case.size, "m", "anchors")
    meant = known[nearest]
    axes = meant.axes @ np.array(poses[nearest].rot).reshape(3, 3)
    pull = meant.acceleration - np.array(case.conversion.settings.config.gravity)
    should = np.concatenate([axes.T @ pull, axes.T @ meant.spin])
    given = case.code.imu(sensor.name, signal.name, place)
    if not case.near(should, given, CLOSE / 1e-8):
        case.compare(f"{what}: what it reads", should, given, 0.0, "m/s^2, rad/s")
    if case.code.has_equations:
        measured = case.code.measure(signal.name, q, qd, qdd)
        moving = list(case.moving.values())
        values = (*place[:1], *place[2:4], *place[5:], place.axes.T, place.jacobian[:, moving])
        for kind, value, number in zip(_MEASURED, values, measured, strict=True):
            own = number[:, moving] if value.shape[0] == 6 else number
            case.compare(f"{what}: {kind}", value, own, 1.0)


_MEASURED = (
    "its position", "its speed", "its acceleration", "its spin", "the rate of its spin",
    "its axes", "its derivatives",
)  # fmt: skip


def _prove_force_torque(case: Case, torque: ForceTorque) -> None:
    """The forces along and about six axes, seen from the link."""
    forces = case.random.uniform(-1.0, 1.0, case.ours.size)
    given = case.code.force_torque(torque.name, forces)
    case.go(1)
    link = case.on_link(torque.link, (0.0, 0.0, 0.0))
    should = np.zeros(6)
    for joint in torque.joints:
        group, frame = case.theirs.side.after[joint.name]
        here = case.theirs.place(group, frame, np.zeros(case.theirs.size))
        kind, axis = joint.type
        part = slice(0, 3) if kind == "T" else slice(3, 6)
        number = case.numbers[joint.name]
        should[part] += forces[number] * link.axes.T @ here.axes[:, int(axis) - 1]
        what = f"sensor '{torque.name}': its place"
        case.compare(what, link.at, here.at, case.size, "m", "anchors")
    if given is not None:
        case.compare(f"sensor '{torque.name}': what it reads", should, given, 1.0, "N, N m")
