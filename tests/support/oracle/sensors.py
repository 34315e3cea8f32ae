"""Sensors: where they are, and what they read in their own axes.

At rest the specific force points up: it is the acceleration without gravity.  A force-torque
sensor reads what the side of the base does to its link, at the link's origin and in its axes.
"""

import sys
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from support.oracle.case import TOLERANCE, ZERO, Case
from support.oracle.multibody import Array

#: Where a sensor is that a link has by its name (4x4).
ORIGIN = np.eye(4)
#: m, m/s^2: the elements that state one sensor round its digits.
CLOSE = 1e-4


def prove(case: Case) -> None:
    options = case.asked.get("sensors")
    poses: dict[tuple[str, str], list[Array]] = {}
    for link in case.stated.links if options else ():
        if any(fnmatchcase(link, pattern) for pattern in options.links):
            poses[link, link] = [ORIGIN]
    for sensor in case.stated.sensors if options and options.from_urdf else ():
        if any(fnmatchcase(sensor.name, pattern) for pattern in options.only or ["*"]):
            poses.setdefault((sensor.link, sensor.name), []).append(sensor.pose)
    made = set()
    for other_sensor in case.simulation.sensors:
        # of several sensors of one name, all but the first have their link's name, too
        names = other_sensor.name, other_sensor.name.removeprefix(f"{other_sensor.link}_")
        keys = [(other_sensor.link, name) for name in names if (other_sensor.link, name) in poses]
        _prove_sensor(case, other_sensor, poses[keys[0]])
        made.add(keys[0])
    for _, name in sorted(poses.keys() - made):
        case.differ(f"sensor '{name}'", "is not there")
    for torque in case.simulation.force_torques:
        _prove_force_torque(case, torque)


def _prove_sensor(case: Case, sensor: Any, poses: list[Array]) -> None:
    """Compare a sensor with one of the poses that the URDF gives it: the nearest."""
    label, data = f"sensor '{sensor.name}'", case.data
    signal = str(sensor.point.sensor and sensor.point.sensor.name)
    q, qd, qdd = case.go(1)
    place = case.in_mbs(signal, qdd)
    poses = [pose for pose in poses if pose is not ORIGIN] or poses
    candidates = [(case.on_link(sensor.link, pose[:3, 3], qdd), pose[:3, :3]) for pose in poses]
    meant, turn = min(
        candidates, key=lambda candidate: float(np.abs(candidate[0].P - place.P).max())
    )
    axes = turn.T @ meant.R
    scale = CLOSE / TOLERANCE
    case.compare(f"{label}, its place", meant.P, place.P, "m", scale * case.size)
    expected = [*(axes @ (meant.A - case.gravity)), *(axes @ meant.OM)]
    actual = np.concatenate(case.imu(sensor.name, place))
    case.compare(f"{label}, what it reads", expected, actual, "m/s^2, rad/s", scale)
    if case.has_equations:
        data.q[:], data.qd[:], data.qdd[:] = q, qd, qdd
        computed = sys.modules[f"{data.mbs_name}_robot"].sensor(data, sensor.name)
        for name, value in place._asdict().items():
            measured = getattr(computed, name)[1:]
            if name == "J":  # what is held has derivatives there, too
                value, measured = value[:, case.moving], measured[:, case.moving]
            measured = measured[:, 1:] if name == "R" else measured
            case.compare(f"{label}, its {name}", value, measured, "", 1.0)


def _prove_force_torque(case: Case, torque: Any) -> None:
    """Compare the forces along and about six axes, seen from the link."""
    data, label = case.data, f"sensor '{torque.name}'"
    data.Qc[:] = case.random.uniform(-1.0, 1.0, len(data.Qc))
    case.go(1)
    link, expected = case.on_link(torque.link), np.zeros(6)
    for joint in torque.joints:
        joint_place = case.theirs.place(case.evaluator.joints[joint.name].node, ZERO)
        along = link.R @ joint_place.R[int(joint.type[1]) - 1]
        part = slice(0, 3) if joint.type[0] == "T" else slice(3, 6)
        expected[part] += data.Qc[data.joint_id[joint.name]] * along
        case.compare(f"{label}, its place", link.P, joint_place.P, "m", case.size)
    actual = sys.modules[f"{data.mbs_name}_robot"].force_torque(data, torque.name)
    case.compare(f"{label}, what it reads", expected, actual, "N, N m", 1.0)
