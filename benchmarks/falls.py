"""How fast and how exact robots stand and fall, beside MuJoCo with steps of 2 ms.

    pip install -e '.[bench]'
    OPENBLAS_NUM_THREADS=1 python benchmarks/falls.py ROBOT...    # .urdf files

Both get the same file: its shapes of collision (hulls of meshes), no limits of efforts, no friction
in joints, and the start position that ``init`` proposes, held by motors.  A robot that floats
stands for 2 s by the gains of ``init``.  It is dropped on its back from 0.3 m higher, for 1 s, with
gains that MuJoCo bears (100 N m/rad, 5 N m s/rad), and once more without motors.  A robot on a
fixed base falls for 2 s without motors.  Links do not touch each other.

Times are seconds of motion in one second of computing, of the steps alone, the best of several.
Errors are the largest of a joint's position (rad, m) in the first 0.5 s: ours beside steps with an
error of 1e-9, MuJoCo's beside its own steps of 20 us.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import mujoco
import numpy as np
from lxml import etree
from scipy.spatial import ConvexHull

from urdf2mbs.config.load import config_of
from urdf2mbs.config.model import Project
from urdf2mbs.engine.pipeline import Pipeline
from urdf2mbs.urdf.packages import Packages
from urdf2mbs_meshes.files import MeshFiles
from urdf2mbs_meshes.reader import read_mesh
from urdf2mbs_project.facts import find_robot_facts
from urdf2mbs_simulate.project import write_project
from urdf2mbs_simulate.runtime import MbsData, MbsDirdyn

RATE = 50
#: Seconds, how much higher the robot begins (m), if it lies on its back, and its gains (N m/rad,
#: N m s/rad); None: those of ``init``.
CASES: dict[str, tuple[float, float, bool, tuple[float, float] | None]] = {
    "stands": (2.0, 0.0, False, None),
    "falls": (1.0, 0.3, True, (100.0, 5.0)),
    "falls limp": (1.0, 0.3, True, (0.0, 0.0)),
}
ARM = {"falls limp": (2.0, 0.0, False, (0.0, 0.0))}


def plain(source: Path, folder: Path) -> Path:
    """The URDF with what both programs are to have; meshes are OBJ files beside it."""
    root = etree.parse(str(source), etree.XMLParser(remove_comments=True)).getroot()
    for name in ("visual", "gazebo", "transmission", "mujoco", "dynamics", "mimic"):
        for element in list(root.iter(name)):
            element.getparent().remove(element)
    for limit in root.iter("limit"):
        limit.set("effort", "0")
    files = MeshFiles(Packages({}, source))
    for collision in list(root.iter("collision")):
        mesh = collision.find("geometry/mesh")
        if mesh is None:
            continue
        path = files.find(mesh.get("filename"))
        if path is None:
            collision.getparent().remove(collision)
            continue
        made = folder / f"{len(list(folder.glob('*.obj')))}.obj"
        corners = np.concatenate([part.points for part in read_mesh(path).parts])
        triangles = ConvexHull(corners).simplices + 1
        made.write_text(
            "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners.tolist())
            + "".join(f"f {a} {b} {c}\n" for a, b, c in triangles.tolist())
        )
        mesh.set("filename", str(made))
    file = folder / source.name
    etree.ElementTree(root).write(str(file))
    return file


class Ours:
    def __init__(self, file: Path, folder: Path) -> None:
        passes: dict[str, Any] = {}
        for _ in range(2):  # what lets a robot stand is found from its model
            config, lines = config_of(
                {"source": str(file)}, pipeline="compact", passes=passes,
                output=Project(str(folder / "ours"), "c"),
            )  # fmt: skip
            conversion = Pipeline(config, lines, installed_plugins=False).run()
            passes = find_robot_facts(conversion).passes
        self.floats = conversion.base.floating
        self.model = write_project(conversion, force=True)
        data = MbsData(self.model)
        self.height = float(data.q[3]) if self.floats else 0.0
        self.friction = data.user_model["contact"]["friction"] if self.floats else 1.0
        self.gains = {
            name: (stiffness, data.user_model["hold_damping"][name], data.q[data.joint_id[name]])
            for name, stiffness in data.user_model.get("hold_stiffness", {}).items()
        }

    def move(self, case: Any, time: float, **more: float) -> tuple[Any, float]:
        """Positions at each frame, and the processor's seconds."""
        _, higher, back, gains = case
        data = MbsData(self.model)
        for name in self.gains if gains else ():
            data.user_model["hold_stiffness"][name], data.user_model["hold_damping"][name] = gains
        data.q[3] += higher
        data.q[4] += np.pi * back
        dirdyn = MbsDirdyn(data)
        dirdyn.set_options(tf=time, framerate=RATE, save2file=0, language="c", **more)
        begin = process_time()
        results = dirdyn.run()
        seconds = process_time() - begin
        return results.q[:, 7 if self.floats else 1 :], seconds


class Theirs:
    def __init__(self, file: Path, ours: Ours) -> None:
        root = etree.parse(str(file)).getroot()
        words = '<compiler strippath="false" fusestatic="true" balanceinertia="true"/>'
        root.append(etree.fromstring(f"<mujoco>{words}</mujoco>"))
        spec = mujoco.MjSpec.from_string(etree.tostring(root).decode())
        for mesh in spec.meshes:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        if ours.floats:
            spec.worldbody.first_body().add_freejoint()
        for geom in spec.geoms:
            geom.contype, geom.conaffinity, geom.friction[0] = 1, 0, ours.friction
        plane = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 0.1])
        plane.contype, plane.conaffinity, plane.friction[0] = 0, int(ours.floats), ours.friction
        self.model, self.ours = spec.compile(), ours
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST

    def move(self, case: Any, time: float, height: float, step: float) -> tuple[Any, float]:
        _, higher, back, gains = case
        model, data = self.model, mujoco.MjData(self.model)
        model.opt.timestep = step
        floats = self.ours.floats
        for name, (*own, start) in self.ours.gains.items():
            joint = model.joint(name)
            model.jnt_stiffness[joint.id], model.dof_damping[joint.dofadr] = gains or own
            data.qpos[joint.qposadr] = model.qpos_spring[joint.qposadr] = start
        if floats:
            data.qpos[:7] = [0, 0, height + higher, *((0, 1, 0, 0) if back else (1, 0, 0, 0))]
        rows, seconds = [], 0.0
        for _ in range(round(time * RATE)):
            begin = process_time()
            mujoco.mj_step(model, data, nstep=round(1 / RATE / step))
            seconds += process_time() - begin
            rows.append(data.qpos[7 * floats :].copy())
        return np.array(rows), seconds


def compare(source: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="falls-") as name:
        folder = Path(name)
        file = plain(source, folder)
        ours = Ours(file, folder)
        theirs = Theirs(file, ours)
        for title, case in (CASES if ours.floats else ARM).items():
            time = case[0]
            ours.move(case, 1e-3)
            loads = min(ours.move(case, 1e-3)[1] for _ in range(5))
            mine = min(ours.move(case, time)[1] for _ in range(5)) - loads
            other = min(theirs.move(case, time, ours.height, 0.002)[1] for _ in range(5))
            exact = ours.move(case, 0.5, rtoler=1e-9, atoler=1e-10)[0]
            error = np.abs(ours.move(case, 0.5)[0] - exact).max()
            fine = theirs.move(case, 0.5, ours.height, 2e-5)[0]
            off = np.abs(theirs.move(case, 0.5, ours.height, 0.002)[0] - fine).max()
            print(
                f"| {source.stem} {title} | {time / mine:.0f} | {time / other:.0f} | "
                f"{mine / other:.2f} | {error:.0e} | {off:.0e} |",
                flush=True,
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="+", type=Path, metavar="ROBOT")
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes a log file
    print("| | ours | MuJoCo | our CPU / its | our error | its error |\n|---|---|---|---|---|---|")
    for source in parser.parse_args().robots:
        compare(source)


if __name__ == "__main__":
    main()
