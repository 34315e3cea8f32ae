"""Robots beside other readers of URDF: mass matrix and gravity forces, beside Pinocchio's.

    pip install . pin 'mujoco>=3' drake pybullet
    python benchmarks/beside.py ROBOT...          # .urdf files, or names of robot_descriptions
    python benchmarks/beside.py --minimal DIR     # the smallest robot that shows each difference

Each reader gets the same file, without geometry, and welds the root to the world.  Joints are
matched by name.  All joints move freely, also those that follow others (<mimic>).  A cell has the
largest deviation at five random positions, relative to Pinocchio's largest number.  A reader that
is not installed is left out.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import tempfile
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from lxml import etree

#: A reader gives the names of the joints, and M and g at positions by name.
Motion = tuple[list[str], Callable[[dict[str, float]], tuple[np.ndarray, np.ndarray]]]
GRAVITY = 9.81
#: The smallest robots: what differs, and the file.
LINK = '<link name="{}"><inertial><origin xyz="{}" rpy="{}"/><mass value="1"/><inertia {}/></inertial></link>'  # noqa: E501
INERTIA = 'ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"'
JOINT = '<joint name="{0}" type="revolute"><parent link="base"/><child link="{1}"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>{2}</joint>'  # noqa: E501
MINIMAL = {
    "rotated-inertial": LINK.format("arm", "0.1 0 0", "0.5 0.6 0.7", INERTIA)
    + JOINT.format("j", "arm", ""),
    "products-of-inertia": LINK.format(
        "arm", "0.1 0 0", "0 0 0", INERTIA.replace('xy="0"', 'xy="0.3"')
    )
    + JOINT.format("j", "arm", ""),
    "mimic": LINK.format("arm", "0.1 0 0", "0 0 0", INERTIA)
    + LINK.format("finger", "0.1 0 0", "0 0 0", INERTIA)
    + JOINT.format("j", "arm", "")
    + JOINT.format("k", "finger", '<mimic joint="j" multiplier="-1"/>'),
    "triangle": LINK.format("arm", "0.1 0 0", "0 0 0", INERTIA.replace('zz="2.5"', 'zz="4"'))
    + JOINT.format("j", "arm", ""),
    "fixed-frame": LINK.format("arm", "0.1 0 0", "0 0 0", INERTIA)
    + '<link name="tool"/><joint name="k" type="fixed"><parent link="arm"/><child link="tool"/>'
    + '<origin xyz="1 0 0"/></joint>'
    + JOINT.format("j", "arm", ""),
    "massless-tip": LINK.format("arm", "0.1 0 0", "0 0 0", INERTIA)
    + '<link name="tip"/>'
    + JOINT.format("j", "arm", "")
    + '<joint name="k" type="continuous"><parent link="arm"/><child link="tip"/></joint>',
}


def pinocchio(file: Path) -> Motion:
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    names = list(model.names)[1:]

    def motion(q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        values = pin.neutral(model)
        for name, joint in zip(names, model.joints[1:], strict=True):
            wide = joint.nq == 2  # a continuous joint has cosine and sine
            angle = q[name]
            values[joint.idx_q : joint.idx_q + joint.nq] = (
                [np.cos(angle), np.sin(angle)] if wide else angle
            )
        mass = pin.crba(model, data, values)
        mass = np.triu(mass) + np.triu(mass, 1).T
        return mass, pin.computeGeneralizedGravity(model, data, values).copy()

    return names, motion


def urdf2mbs(file: Path) -> Motion:
    from urdf2mbs import convert, load_equations

    model = file.with_suffix(".mbs")
    model.write_bytes(convert(file, base="fixed", pipeline="faithful").data)
    robot = load_equations(model)
    joints = etree.parse(file).iterfind("joint")
    moving = {joint.get("name") for joint in joints if joint.get("type") != "fixed"}
    names = [name for name in robot.joints if name in moving]
    places = [robot.joints.index(name) for name in names]
    start = np.array(robot.data.q0[1:])

    def motion(q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        values = start.copy()
        values[places] = [q[name] for name in names]
        rest = np.zeros_like(values)
        return robot.mass_matrix(values)[np.ix_(places, places)], robot.bias(values, rest)[places]

    return names, motion


def mujoco(file: Path) -> Motion:
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.gravity[:] = 0, 0, -GRAVITY
    data = mujoco.MjData(model)
    names = [model.joint(index).name for index in range(model.njnt)]

    def motion(q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        data.qpos[:] = [q[name] for name in names]
        data.qvel[:] = 0
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        return mass, data.qfrc_bias.copy()

    return names, motion


def drake(file: Path) -> Motion:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JointIndex

    plant = MultibodyPlant(time_step=0.0)
    (robot,) = Parser(plant).AddModels(str(file))
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    root = _root(file)
    if root != "world":  # Drake takes a link of this name for its own world
        plant.WeldFrames(plant.world_frame(), plant.GetBodyByName(root, robot).body_frame())
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints = [plant.get_joint(JointIndex(n)) for n in range(plant.num_joints())]
    joints = sorted((j for j in joints if j.num_velocities()), key=lambda j: j.velocity_start())

    def motion(q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        plant.SetPositions(context, [q[joint.name()] for joint in joints])
        mass = plant.CalcMassMatrixViaInverseDynamics(context)
        return mass, -plant.CalcGravityGeneralizedForces(context)

    return [joint.name() for joint in joints], motion


def pybullet(file: Path) -> Motion:
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation()
    pybullet.setGravity(0, 0, -GRAVITY)
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    with _silence():
        robot = pybullet.loadURDF(str(file), useFixedBase=True, flags=flags)
    described = [pybullet.getJointInfo(robot, n) for n in range(pybullet.getNumJoints(robot))]
    names = [joint[1].decode() for joint in described if joint[2] != pybullet.JOINT_FIXED]

    def motion(q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        values = [q[name] for name in names]
        rest = [0.0] * len(names)
        mass = np.array(pybullet.calculateMassMatrix(robot, values))
        return mass, np.array(pybullet.calculateInverseDynamics(robot, values, rest, rest))

    return names, motion


READERS = {"urdf2mbs": urdf2mbs, "mujoco": mujoco, "drake": drake, "pybullet": pybullet}


@contextlib.contextmanager
def _silence():  # type: ignore[no-untyped-def]  # what C++ prints goes past sys.stdout
    kept = [os.dup(1), os.dup(2)]
    with open(os.devnull, "wb") as nowhere:  # noqa: PTH123
        for number in (1, 2):
            os.dup2(nowhere.fileno(), number)
    try:
        yield
    finally:
        for number, stream in zip((1, 2), kept, strict=True):
            os.dup2(stream, number)


def _root(file: Path) -> str:
    robot = etree.parse(file).getroot()
    children = {child.get("link") for child in robot.iterfind("joint/child")}
    return next(
        link.get("name") for link in robot.iterfind("link") if link.get("name") not in children
    )


def compare(file: Path) -> dict[str, str]:
    """What each reader makes of a robot, beside Pinocchio's."""
    names, reference = pinocchio(file)
    random = np.random.default_rng(0)
    states = [dict(zip(names, random.uniform(-1, 1, len(names)), strict=True)) for _ in range(5)]
    cells = {"joints": str(len(names))}
    for reader, read in READERS.items():
        try:
            found, motion = read(file)
            cells[reader] = _deviation(names, reference, found, motion, states)
        except ModuleNotFoundError:
            continue
        except Exception as error:
            cells[reader] = f"refused: {str(error).strip().splitlines()[0][:70]}"
    return cells


def _deviation(
    names: list[str],
    reference: Callable[[dict[str, float]], tuple[np.ndarray, np.ndarray]],
    found: list[str],
    motion: Callable[[dict[str, float]], tuple[np.ndarray, np.ndarray]],
    states: list[dict[str, float]],
) -> str:
    same = [name for name in names if name in found]
    ours, theirs = ([all_.index(name) for name in same] for all_ in (names, found))
    worst = np.zeros(2)
    for state in states:
        for n, (right, read) in enumerate(zip(reference(state), motion(state), strict=True)):
            grid = (
                (np.ix_(ours, ours), np.ix_(theirs, theirs)) if right.ndim == 2 else (ours, theirs)
            )
            largest = abs(right).max(initial=0.0) or 1.0
            worst[n] = np.fmax(
                worst[n], abs(read[grid[1]] - right[grid[0]]).max(initial=0.0) / largest
            )
    missing = len(names) - len(same)
    text = "same" if (worst < 1e-9).all() else f"M {worst[0]:.1g}, g {worst[1]:.1g}"
    return text + (f"; {missing} joints lost" if missing else "")


def _without_geometry(source: Path, folder: Path) -> Path:
    root = etree.parse(source).getroot()
    for tag in ("visual", "collision", "gazebo", "transmission"):
        for element in list(root.iter(tag)):
            element.getparent().remove(element)
    file = folder / f"{source.stem}.urdf"
    file.write_bytes(etree.tostring(root))
    return file


def _file(robot: str) -> Path:
    if Path(robot).is_file():
        return Path(robot)
    from urdf2mbs_xacro.descriptions import locate

    return Path(locate(f"robot_descriptions:{robot}").path)


def _versions() -> str:
    found = []
    for package in ("pin", *READERS):
        with contextlib.suppress(PackageNotFoundError):
            found.append(f"{package} {version(package)}")
    return ", ".join(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", metavar="ROBOT")
    parser.add_argument("--minimal", type=Path, metavar="DIR")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        files = [_without_geometry(_file(robot), Path(scratch)) for robot in arguments.robots]
        if arguments.minimal:
            arguments.minimal.mkdir(parents=True, exist_ok=True)
            for name, text in MINIMAL.items():
                file = arguments.minimal / f"{name}.urdf"
                file.write_text(f'<robot name="{name}"><link name="base"/>{text}</robot>')
                files.append(file)
        print(f"{_versions()}\n")
        rows = {file.stem: compare(file) for file in files}
    columns = [
        reader for reader in ("joints", *READERS) if any(reader in row for row in rows.values())
    ]
    print("| robot |", " | ".join(columns), "|")
    print("|---|" + "---|" * len(columns))
    for name, row in rows.items():
        print(f"| {name} |", " | ".join(row.get(column, "") for column in columns), "|")


if __name__ == "__main__":
    main()
