"""Proves a project's code: loads its files from memory, and calls them at random states.

Python gives what the URDF says (the other files of this folder); C gives what Python gives.
"""

import ctypes
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from support.oracle import equations, followers, forces, ground, joints, sensors, start
from support.oracle.case import Case
from urdf2mbs.conversion import Conversion
from urdf2mbs_project.simulation import CONTACT_STATES, Simulation, get_force_name
from urdf2mbs_simulate.c_code import CCode
from urdf2mbs_simulate.memory import SensorInC, as_c_vector
from urdf2mbs_simulate.python_code import PythonEquations, user_code
from urdf2mbs_simulate.runtime import MbsData

#: The folders of a project that hold code.
FOLDERS = ("userfctR", "symbolicR")


def code_of(conversion: Conversion, *endings: str) -> dict[str, bytes]:
    """Return the model and the code of a project, by their paths in it."""
    output, project = conversion.settings.output, conversion.settings.project
    assert project is not None
    return {
        path.relative_to(project).as_posix(): data
        for path, data in conversion.files_of("starter", "ours").items()
        if path == output or (path.parent.name in FOLDERS and path.suffix in endings)
    }


def prove(case: Case) -> None:
    """Compare all that the code of a project does; ``case`` gets what is found."""
    for law in (start, joints, followers, ground, forces, sensors, equations):
        law.prove(case)


def prove_code(
    conversion: Conversion, files: Mapping[str, bytes], *, in_c: bool = False
) -> list[str]:
    """Return the differences of a project's code from its robot, the largest first.

    ``files`` are by their path in the project.  ``in_c``: the C, too.
    """
    differences: dict[str, tuple[float, str]] = {}
    with tempfile.TemporaryDirectory(prefix="urdf2mbs-") as folder:
        for path, content in files.items():
            file = Path(folder, path)
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(content)
        data = MbsData(next(Path(folder).glob("dataR/*.mbs")))
        try:
            with user_code(data):
                case = Case(conversion, conversion.state(Simulation), data, PythonEquations(data))
                differences = case.found
                case.has_equations = in_c or any(data.symbolic_path.glob("mbs_accelred_*.py"))
                prove(case)
                if in_c:
                    _compare_c(case)
        except Exception as error:  # of code that may do anything
            if getattr(error, "code", "") != "equations-not-generated":
                differences["code"] = 1.0, f"the code of the project cannot run: {error!r}"
    return [
        message
        for _, message in sorted(differences.values(), key=lambda difference: -difference[0])
    ]


def _compare_c(case: Case) -> None:
    """Compare C with Python in the same states."""
    python, user = case.data, ctypes.c_double(0.0)
    data = MbsData(python._run.file)
    code = CCode(data)
    for side, speed_factor in joints.STATES:
        q, qd = joints.state(case, side, speed_factor)
        data.q[:], data.qd[:], data.Qq[:], data.ux[:] = q, qd, 1e3, python.ux
        python.uxd[:] = data.uxd[:] = 0.0
        code.library.user_JointForces(code.run_address, user)
        case.compare_joints("its force in C", case.joint_forces(q, qd), [0.0, *data.Qq[1:]])
        case.compare("the rates of bristles in C", python.uxd, data.uxd, "m/s or rad/s")
    times = {t for m in python.user_model.values() if "stop" in m for t in (m["start"], m["stop"])}
    # at full speed the ground seldom pushes
    for time, pace in [*((time, 1.0) for time in sorted({0.0, *times})), *[(0.0, 0.01)] * 3]:
        q, qd, qdd = case.near_start(0.02)
        qd *= pace
        for each in (python, data):
            each.q[:], each.qd[:], each.qdd[:], each.tsim = q, qd, qdd, time
        if case.code.compute_accelerations():
            continue
        if code.compute_accelerations():
            case.differ("accelerations in C", "the loops cannot be closed, as Python closes them")
            continue
        for name in ("q", "qd", "qdd"):
            values = getattr(python, name), getattr(data, name)
            size = max(1.0, np.abs(values[0]).max())
            case.compare_joints(f"its {name} in C", *values, size, followers.UNIT)
        case.compare("the rates of bristles in C", python.uxd, data.uxd, "m/s or rad/s")
        for name, number in python.extforce_id.items():
            actual = data.SWr[number][1:]
            case.compare(f"force '{name}' in C", python.SWr[number][1:], actual, "N, N m, m")
        for name, number in python.link_id.items():
            case.compare(f"spring '{name}' in C", python.Fl[number], data.Fl[number], "N")
    _compare_ground(case, code)
    q, qd, qdd = case.go(1)
    read = getattr(code.library, f"{python.mbs_name}_imu")
    for sensor in case.simulation.sensors:
        name = str(sensor.point.sensor and sensor.point.sensor.name)
        place, measured = case.in_mbs(name, qdd), SensorInC()
        for kind in ("P", "V", "A", "OM", "OMP"):
            getattr(measured, kind)[1:4] = getattr(place, kind)
        for k, axis in enumerate(place.R, start=1):
            measured.R[4 * k + 1 : 4 * k + 4] = axis
        actual = np.zeros((2, 4))
        read(
            ctypes.byref(measured),
            data.sensor_id[name],
            code.run_address,
            *map(as_c_vector, actual),
        )
        expected = np.concatenate(case.imu(sensor.name, place))
        case.compare(f"sensor '{sensor.name}' in C", expected, actual[:, 1:].ravel(), "", 1.0)


def _compare_ground(case: Case, code: CCode) -> None:
    python, data = case.data, code.data
    places = python.user_model.get(CONTACT_STATES, {}).values()
    for contact, states in zip(case.simulation.contacts, places, strict=True):
        force = get_force_name(contact.point)
        number = python.extforce_id[force]
        for touch in ground.touches(case, force, contact.spots):
            python.ux[states] = data.ux[states] = touch.bent
            expected = case.external(
                force, touch.position, touch.speed, axes=touch.axes, spin=touch.spin
            )
            motion = SensorInC()
            motion.P[1:4], motion.V[1:4], motion.OM[1:4] = touch.position, touch.speed, touch.spin
            for k, axis in enumerate(touch.axes, start=1):
                motion.R[4 * k + 1 : 4 * k + 4] = axis
            parts = (getattr(motion, name) for name in ("P", "R", "V", "OM", "A", "OMP"))
            code.library.user_ExtForces(*parts, code.run_address, ctypes.c_double(0.0), number)
            case.compare(f"force '{force}' in C", expected, data.SWr[number][1:], "N, N m, m")
            rates = python.uxd[states], data.uxd[states]
            case.compare("the rates of bristles in C", *rates, "m/s or rad/s")
