"""The generated C: compiled with all warnings as errors, and equal to the Python to rounding."""

from __future__ import annotations

import shutil
import subprocess
from ctypes import CDLL, POINTER, Structure, c_double, c_int, c_void_p, cast, pointer
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import SHARED
from passes.test_mimic import CHAIN
from project.standin import MbsData, from1, make, user_functions, without_meshes

from urdf2mbs.testing import TINY

ROOT = Path(__file__).resolve().parents[2]
HEADERS = ROOT / "urdf2mbs" / "runtime" / "mbsysc"
GRIPPER = SHARED / "robots/robotiq_2f_140/expanded/robotiq_arg2f_140_model.urdf"

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not there")

Doubles = POINTER(c_double)


class Data(Structure):
    """MbsData as tests/project/mbsysc declares it."""

    _fields_ = [
        ("njoint", c_int), ("process", c_int), ("flag_stop", c_int),
        *((name, Doubles) for name in ("q", "qd", "qdd", "q0", "Qq", "Qc", "ux", "uxd")),
        ("dpt", Doubles * 4), ("xfidpt", POINTER(c_int)),
        ("SWr", POINTER(Doubles)), ("l3DWr", POINTER(Doubles)),
        ("g", c_double * 4), ("user_model", c_void_p),
    ]  # fmt: skip


class Parameter(Structure):
    _fields_ = [("n_value", c_int), ("value_list", Doubles)]


class Model(Structure):
    _fields_ = [("n_parameter", c_int), ("parameter_list", POINTER(POINTER(Parameter)))]


class Models(Structure):
    _fields_ = [("n_user_model", c_int), ("user_model_list", POINTER(POINTER(Model)))]


class File(Structure):
    _fields_ = [("user_models", POINTER(Models))]


class Sensor(Structure):
    _fields_ = [
        ("P", c_double * 4), ("R", c_double * 4 * 4), ("V", c_double * 4), ("OM", c_double * 4),
        ("A", c_double * 4), ("OMP", c_double * 4), ("J", Doubles * 7),
    ]  # fmt: skip


def doubles(array: Any) -> Any:
    return np.asarray(array).ctypes.data_as(Doubles)


def rows(array: Any) -> Any:
    flat = np.asarray(array)
    return (Doubles * len(flat))(*(doubles(flat[k]) for k in range(len(flat))))


def build(project: Path) -> CDLL:
    """Compile everything in userfctR, with the two exceptions that docs/first-simulation.md
    names; and main.c, which is not linked."""
    flags = ["-O1", "-Wall", "-Werror", "-Wno-comment", "-Wno-unused-variable"]
    include = [f"-I{HEADERS}", f"-I{project / 'userfctR'}"]
    library = project / "user.so"
    sources = [str(file) for file in sorted((project / "userfctR").glob("*.c"))]
    command = ["gcc", *flags, *include, "-shared", "-fPIC", "-o", str(library), *sources, "-lm"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    folders = ['-DPROJECT_FOLDER=""', '-DBUILD_FOLDER=""']
    main = str(project / "workR" / "src" / "main.c")
    command = ["gcc", *flags, *include, *folders, "-c", "-o", str(project / "main.o"), main]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return CDLL(str(library))


class InC:
    """The user functions in C, on the memory of the stand-in."""

    def __init__(self, project: Path, data: MbsData) -> None:
        self.library = library = build(project)
        self.data = data
        self.keep: list[Any] = []
        c = self.c = Data(njoint=data.njoint)
        self.Qq, self.uxd = np.zeros(data.njoint + 1), np.zeros(data.Nux + 1)
        self.SWr = np.zeros(data.SWr.shape)
        for name in ("q", "qd", "qdd", "q0", "Qc", "ux"):
            setattr(c, name, doubles(getattr(data, name)))
        c.Qq, c.uxd = doubles(self.Qq), doubles(self.uxd)
        c.dpt = (Doubles * 4)(*(doubles(np.asarray(data.dpt)[k]) for k in range(4)))
        points = np.asarray(data.xfidpt).astype(np.int32)
        c.xfidpt = points.ctypes.data_as(POINTER(c_int))
        listed = rows(self.SWr)
        c.SWr = cast(listed, POINTER(Doubles))
        c.g = (c_double * 4)(*np.asarray(data.g))
        self.keep += [points, listed]
        library.mbs_new_user_model.restype = c_void_p
        c.user_model = library.mbs_new_user_model()
        models = []
        for model in data.mbs.user_models:
            parameters = []
            for p in model.parameters:
                value = (c_double * 1)(float(p.values[0]))
                parameters.append(pointer(Parameter(1, cast(value, Doubles))))
                self.keep.append(value)
            array = (POINTER(Parameter) * len(parameters))(*parameters)
            models.append(pointer(Model(len(parameters), array)))
            self.keep += [array, parameters]
        array = (POINTER(Model) * len(models))(*models)
        file = File(pointer(Models(len(models), array)))
        library.mbs_load_user_model_xml(pointer(file), c_void_p(c.user_model))
        library.user_LinkForces.restype = c_double

    def joint_forces(self) -> Any:
        self.Qq[:] = 3.0
        self.library.user_JointForces.restype = c_void_p
        assert self.library.user_JointForces(pointer(self.c), c_double(0.0))
        return self.Qq[1:]

    def external(self, number: int, P: Any, V: Any, t: float) -> Any:
        none, turn = np.zeros(4), np.zeros((4, 4))
        self.library.user_ExtForces.restype = Doubles
        row = self.library.user_ExtForces(
            doubles(P), doubles(turn), doubles(V), doubles(none), doubles(none), doubles(none),
            pointer(self.c), c_double(t), number,
        )  # fmt: skip
        return np.array([row[k] for k in range(1, 10)])

    def constraints(self, count: int) -> tuple[Any, Any, Any]:
        h, jac = np.zeros(count + 1), np.zeros((count + 1, self.data.njoint + 1))
        jdqd = np.full(count + 1, 5.0)
        self.library.user_cons_hJ(doubles(h), rows(jac), pointer(self.c), c_double(0.0))
        self.library.user_cons_jdqd(doubles(jdqd), pointer(self.c), c_double(0.0))
        return h[1:], jac[1:, 1:], jdqd[1:]


def states(data: MbsData, count: int) -> Any:
    random = np.random.default_rng(8)
    for _ in range(count):
        for name in ("q", "qd", "qdd"):
            np.asarray(getattr(data, name))[1:] = random.normal(size=data.njoint)
        data.ux[1:] = 1e-3 * random.normal(size=data.Nux)
        yield random


def compare(project: Path, kind: str) -> None:
    """Everything that the functions of the two languages give, at random states."""
    data = MbsData(next((project / "dataR").glob("*.mbs")))
    with user_functions(project) as user:
        robot = user["user_dirdyn"].robot
        count = robot.N_CONSTRAINTS
        native = InC(project, data)
        seen = 0.0
        for random in states(data, 20):
            user["user_JointForces"].user_JointForces(data, 0.0)
            found = native.joint_forces()
            seen += np.abs(found).sum()
            assert np.allclose(found, np.asarray(data.Qq)[1:], rtol=1e-14, atol=1e-14)
            if count:
                h, jac, jdqd = from1(count), from1(count, data.njoint), from1(count)
                user["user_cons_hJ"].user_cons_hJ(h, jac, data, 0.0)
                user["user_cons_jdqd"].user_cons_jdqd(jdqd, data)
                ours = native.constraints(count)
                assert np.allclose(ours[0], np.asarray(h)[1:], rtol=0, atol=1e-14)
                assert np.array_equal(ours[1], np.asarray(jac)[1:, 1:])
                assert np.array_equal(ours[2], np.zeros(count))
            for number in range(1, len(data.forces) + 1):
                P, V, R, none = from1(3), from1(3), from1(3, 3), from1(3)
                P[1:], V[1:] = 0.01 * random.normal(size=3), 0.1 * random.normal(size=3)
                t = random.uniform(0, 1)
                row = user["user_ExtForces"].user_ExtForces(
                    P, R, V, none, none, none, data, t, number
                )
                ours = native.external(number, P, V, t)
                assert np.allclose(ours, np.asarray(row)[1:], rtol=1e-13, atol=1e-13)
            assert np.allclose(native.uxd, data.uxd, rtol=1e-13, atol=1e-13)
            for number in data.link_id.values():
                z, zd = random.normal(size=2)
                wanted = user["user_LinkForces"].user_LinkForces(z, zd, data, 0.0, number)
                given = (c_double(z), c_double(zd), pointer(native.c), c_double(0.0), number)
                assert native.library.user_LinkForces(*given) == pytest.approx(wanted, rel=1e-14)
            if robot.DRIVEN:
                before = [np.array(x) for x in (data.q, data.qd, data.qdd)]
                user["user_DrivenJoints"].user_DrivenJoints(data, 0.0)
                python = [np.array(x) for x in (data.q, data.qd, data.qdd)]
                for mine, old in zip((data.q, data.qd, data.qdd), before, strict=True):
                    np.asarray(mine)[:] = old
                native.library.user_DrivenJoints(pointer(native.c), c_double(0.0))
                for mine, wanted in zip((data.q, data.qd, data.qdd), python, strict=True):
                    assert np.allclose(np.asarray(mine), wanted, rtol=1e-15, atol=0)
        assert seen > 0.0 or kind == "driven"


def test_the_biped_with_all_there_is(tmp_path: Path) -> None:
    passes = {
        "posture": {"joints": {"*_knee": 0.6}, "hold": {"stiffness": 200, "damping": 4}},
        "contacts": {"links": ["*_foot"]},
        "sensors": {"links": ["imu"]},
        "forces": {
            "wrenches": {"push": {"link": "chest", "force": [1, 2, 3], "torque": [4, 5, 6],
                                  "start": 0.2, "stop": 0.7}},
            "springs": {"band": {"ends": [{"link": "pelvis"}, {"link": "head"}], "stiffness": 50,
                                 "damping": 2}},
        },
    }  # fmt: skip
    source = ROOT / "configs" / "biped.urdf.xacro"
    project = make(tmp_path, source, passes=passes, language="both")
    compare(project, "biped")
    # an IMU, in C and in Python
    data = MbsData(project / "dataR" / "robot.mbs")
    native = InC(project, data)
    random = np.random.default_rng(4)
    sensor = Sensor()
    computed = from1(3, 3)
    computed[1:, 1:] = random.normal(size=(3, 3))
    A, OM = random.normal(size=(2, 3))
    for i in (1, 2, 3):
        sensor.A[i], sensor.OM[i] = A[i - 1], OM[i - 1]
        for j in (1, 2, 3):
            sensor.R[i][j] = computed[i, j]
    force, turn = np.zeros(4), np.zeros(4)
    native.library.robot_imu(
        pointer(sensor), data.sensor_id["imu_sensor"], pointer(native.c), doubles(force),
        doubles(turn),
    )  # fmt: skip
    # the imu of the biped is mounted turned by 180 degrees about z
    R = np.asarray(computed)[1:, 1:]
    flip = np.diag([-1.0, -1.0, 1.0])
    assert np.allclose(force[1:], flip @ R @ (A + np.array([0, 0, 9.81])), rtol=0, atol=1e-13)
    assert np.allclose(turn[1:], flip @ R @ OM, rtol=0, atol=1e-13)


@pytest.mark.parametrize("nature", ["dependent", "driven"])
def test_mimic_chains(tmp_path: Path, nature: str) -> None:
    text = CHAIN.replace('<axis xyz="0 1 0"/></joint></robot>', (
        '<axis xyz="0 1 0"/><dynamics damping="0.5" friction="0.2"/></joint></robot>'
    ))  # fmt: skip
    passes = {"mimic": {"joints": {"*": nature}}}
    compare(make(tmp_path, text, passes=passes, language=["python", "c"]), nature)


@pytest.mark.parametrize("text", [CHAIN, TINY])
def test_the_code_is_the_same_for_all_robots_and_clean(tmp_path: Path, text: str) -> None:
    """The file of the package compiles as it stands, for a project that is called NAME."""
    project = make(tmp_path, text, name="NAME", language="c")
    code = files("urdf2mbs.project").joinpath("NAME_robot.c").read_bytes()
    assert code.strip() in (project / "userfctR" / "NAME_robot.c").read_bytes()
    flags = ["-std=c99", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror"]
    include = [f"-I{HEADERS}", f"-I{project / 'userfctR'}"]
    command = ["gcc", *flags, *include, "-c", "-o", str(tmp_path / "code.o")]
    source = str(project / "userfctR" / "NAME_robot.c")
    done = subprocess.run([*command, source], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_names_that_c_cannot_have(tmp_path: Path) -> None:
    """Joints and links called like words of C, like each other, and like a point's macro."""
    text = CHAIN.replace('"one"', '"double"').replace('"two"', '"a/b"').replace('"b"', '"a b"')
    text = text.replace('"three"', '"a_c"').replace('"d"', '"stop"').replace('"four"', '"NONE"')
    compare(make(tmp_path, text, name="while", language="both"), "driven")


@pytest.mark.skipif(not GRIPPER.is_file(), reason="the real robots are not beside the checkout")
def test_a_gripper(tmp_path: Path) -> None:
    pipeline = without_meshes("faithful")
    compare(make(tmp_path, GRIPPER, language="both", pipeline=pipeline), "gripper")


#: Stands for MBsysC: a run of three steps.
RUNTIME = """
#include <stdlib.h>
#include "mbs_data.h"
#include "mbs_dirdyn.h"
#include "mbs_part.h"
#include "mbs_set.h"
#include "mbs_load_xml.h"
void user_dirdyn_loop(MbsData *mbs_data, MbsDirdyn *mbs_dd);
MbsData* mbs_load(const char *file, const char *build)
{
    MbsData *data = calloc(1, sizeof(MbsData));
    data->njoint = 5;
    data->q = calloc(6, sizeof(double));
    data->qd = calloc(6, sizeof(double));
    return data;
}
void mbs_delete_data(MbsData *mbs_data) { }
void mbs_set_nb_userc(MbsData *mbs_data, int count) { }
MbsPart* mbs_new_part(MbsData *mbs_data)
{
    MbsPart *part = calloc(1, sizeof(MbsPart));
    part->options = calloc(1, sizeof(MbsPartOptions));
    return part;
}
int mbs_run_part(MbsPart *part, MbsData *mbs_data) { return mbs_data->DonePart = DONE; }
void mbs_delete_part(MbsPart *part) { }
MbsDirdyn* mbs_new_dirdyn(MbsData *mbs_data)
{
    MbsDirdyn *dirdyn = calloc(1, sizeof(MbsDirdyn));
    dirdyn->options = calloc(1, sizeof(MbsDirdynOptions));
    return dirdyn;
}
int mbs_run_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data)
{
    int k;
    for (k = 0; k < 3; k++) {
        mbs_data->tsim = 0.5 * k;
        mbs_data->qd[5] = -70.0;
        mbs_data->q[2] = k == 2 ? LAST : 0.0;
        user_dirdyn_loop(mbs_data, dirdyn);
    }
    return 0;
}
void mbs_delete_dirdyn(MbsDirdyn *dirdyn, MbsData *mbs_data) { }
"""


@pytest.mark.parametrize(
    ("done", "last", "code", "says"),
    [
        (1, "0.0", 0, ""),
        (0, "0.0", 1, "there is no partition, so the loops would be open: two three cannot"),
        (1, "0.0 / zero", 1, "at 1 s the position or speed of joint one is not a number"),
    ],
)
def test_main_stops_where_robotran_cannot_go_on(
    tmp_path: Path, done: int, last: str, code: int, says: str
) -> None:
    project = make(tmp_path, CHAIN, language="c", base="fixed")
    (tmp_path / "runtime.c").write_text(f"static volatile double zero = 0.0;\n{RUNTIME}")
    sources = [*(project / "userfctR").glob("*.c"), project / "workR" / "src" / "main.c"]
    command = [
        "gcc", "-w", f"-I{HEADERS}", f"-I{project / 'userfctR'}", f"-DDONE={done}",
        f"-DLAST=({last} + zero)", '-DPROJECT_FOLDER=""', '-DBUILD_FOLDER=""',
        "-o", str(tmp_path / "exe"), str(tmp_path / "runtime.c"), *map(str, sources), "-lm",
    ]  # fmt: skip
    subprocess.run(command, check=True)
    ran = subprocess.run([tmp_path / "exe"], check=False, capture_output=True, text=True)
    assert ran.returncode == code
    assert says in ran.stderr
    assert ("done: see resultsR" in ran.stdout) == (code == 0)
    assert ran.stderr.count("error:") <= 2
    if last != "0.0":
        assert "joint four was the fastest, at 70 rad/s" in ran.stderr
