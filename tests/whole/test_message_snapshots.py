"""What the passes make of a few robots that ask for all of them, and what they say, to be read.

A change is on purpose, or it is a fault.  If it is on purpose, write the texts anew and read the
difference:  python tests/whole/test_message_snapshots.py
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

import msgspec
import pytest

from support.codes import TABLES
from support.rich_robot import PASSES, RICH, joint, limit, link
from urdf2mbs import Result, convert
from urdf2mbs.mbs.model import Body, Mbs
from urdf2mbs_project.mass import MassModel
from urdf2mbs_project.passes.time_step import linearise_forces
from urdf2mbs_project.simulation import Simulation
from urdf2mbs_project.stability import compute_reduction

TEXTS = Path(__file__).with_name("snapshots")
BALL = '<geometry><sphere radius="0.1"/></geometry>'
LIMIT = limit(-1, 1)
SOLID = (
    '<inertial><origin xyz="0 0.1 0.2"/><mass value="1"/><inertia ixx="{}" ixy="0" ixz="0" '
    'iyy="1" iyz="0" izz="1"/></inertial>'
)

#: A robot with what cannot be as it is.
ODD = (
    '<robot name="odd"><material name="wood"><texture filename="wood.png"/></material>'
    + link("root", 2.0, f'<visual>{BALL}<material name="wood"/></visual>')
    + "".join(
        f'<link name="of_{name}">{content}</link>' + joint(name, parent, axis, more, kind)
        for name, parent, axis, more, kind, content in (
            ("flat", "root", "0 0 1", limit(1, -1), "revolute", SOLID.format(3)),
            (
                "light",
                "root",
                "0 1 0",
                LIMIT,
                "revolute",
                SOLID.format(1).replace('"1"', '"-1"', 1),
            ),
            (
                "shell",
                "root",
                "1 0 0",
                limit(-0.5, 0.5),
                "revolute",
                '<collision><geometry><mesh filename="gone.stl"/></geometry></collision>'
                f"<visual>{BALL}</visual>",
            ),
            (
                "lid",
                "of_shell",
                "1 1 0",
                limit(0.25, 0.5),
                "prismatic",
                f'<collision>{BALL}</collision><visual><geometry><mesh filename="gone.stl" '
                'scale="1 1 -2"/></geometry></visual>',
            ),
            ("flag", "of_lid", "0 0 1", LIMIT + '<dynamics damping="1"/>', "revolute", ""),
            (
                "wing",
                "of_flat",
                "0 0 1",
                LIMIT + '<mimic joint="lid" multiplier="-9"/>',
                "revolute",
                SOLID.format(1) + "<sensor/>",
            ),
            ("plate", "root", "0 0 2", "", "planar", SOLID.format(1)),
            ("stuck", "root", "0 1 0", "", "fixed", SOLID.format(1)),
            (
                "far",
                "of_stuck",
                "0.0001 0 1",
                limit(2, 9) + '<dynamics friction="2"/>',
                "revolute",
                SOLID.format(1),
            ),
        )
    )
    + '<gazebo reference="of_far"><sensor name="eye" type="imu"/><mu1>0.3</mu1></gazebo>'
    + '<gazebo reference="of_wing"><sensor name="eye" type="imu"/></gazebo>'
    + '<gazebo reference="of_flag"><sensor name="lost" type="imu"/></gazebo>'
    + '<gazebo><joint name="of_far" type="revolute"><parent>of_far</parent><child>of_wing</child>'
    "<pose>0 0 1 0 0 0</pose><axis><xyz>1 2 3</xyz></axis></joint>"
    '<joint name="screw" type="screw"><parent>of_far</parent>'
    "<child>of_wing</child></joint></gazebo>"
    + '<transmission><joint name="far"/><actuator name="m"><motorInertia>0.01</motorInertia>'
    "</actuator></transmission></robot>"
)
#: A robot that falls apart without its meshes, of which the URDF says little.
BARE = (
    '<robot name="bare"><link name="world"/>'
    + joint("up", "world", "0 0 1", limit(-1, 1), "prismatic", rpy="0 0 0")
    + f'<link name="of_up"><visual>{BALL}</visual></link>'
    + joint("turn", "of_up", "1 0 0", limit(-1, 1), rpy="0 0 0")
    + link("of_turn")
    + joint("hang", "of_up", "0 1 0", '<mimic joint="turn"/>', "continuous")
    + link("of_hang")
    + joint("lead", "of_up", "0 1 0", "", "continuous")
    + '<link name="of_lead"/>'
    + joint("flag", "of_up", "0 1 0", '<mimic joint="lead"/>', "continuous")
    + '<link name="of_flag"/>'
    + joint("light", "of_up", "0 1 0", "", "continuous")
    + '<link name="of_light"/>'
    + link("of_sway")
    + joint("sway", "of_up", "0 1 0", '<mimic joint="light" multiplier="2"/>', "continuous")
    + "</robot>"
)
#: Point masses, which nothing resists to turn.
POINT = '<inertial><mass value="2"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
POINTS = (
    '<robot name="points">'
    + "".join(f'<link name="{name}">{POINT}</inertial></link>' for name in ("a", "of_b", "of_c"))
    + joint("b", "a", "0 0 1", limit(-1, 1) + '<dynamics friction="1" damping="2"/>')
    + joint("c", "of_b", "1 0 0", '<dynamics friction="3"/>', "continuous", at="0 0 1")
    + "</robot>"
)
#: Links without mass beside fixed joints whose forces are measured.
MEASURED = (
    '<robot name="measured">'
    + link("a")
    + joint("mount", "a", "0 0 1", kind="fixed", at="0.1 0 0")
    + '<link name="of_mount"/>'
    + joint("turn", "of_mount", "0 0 1", limit(-1, 1), at="0 0 0")
    + link("of_turn")
    + joint("bend", "of_turn", "0 1 0", limit(-1, 1))
    + '<link name="of_bend"/>'
    + joint("plate", "of_bend", "0 0 1", kind="fixed", at="0 0 0", rpy="0 0 0")
    + link("of_plate")
    + "</robot>"
)


def tree(*joints: tuple[str, str, str, str]) -> str:
    """Links l0, l1 ... behind joints of this parent, axis, kind and rpy."""
    return (
        '<robot name="tree">'
        + link("l0", 2.0)
        + "".join(
            joint(f"j{n}", parent, axis, limit(-1, 1), kind, "0.1 0.3 -0.2", rpy).replace(
                f"of_j{n}", f"l{n}"
            )
            + link(f"l{n}")
            for n, (parent, axis, kind, rpy) in enumerate(joints, start=1)
        )
        + "</robot>"
    )


#: A tree whose joints turn about axes in all directions.
TREE = tree(
    ("l0", "1 2 3", "revolute", "0 0 0"),
    ("l1", "1e-12 1 0", "revolute", "0.3 0 0"),
    ("l1", "0 0 -1", "prismatic", "0.1 0.2 0.3"),
    ("l2", "1 1 0", "revolute", "0 0 0"),
    ("l2", "0 0 1", "floating", "0.4 0 0"),
    ("l5", "-1 2 0", "revolute", "0 0.5 0"),
    ("l5", "-1 2 0", "continuous", "0 0.5 0.7"),
    ("l0", "0 -2 1", "planar", "0 0 1"),
    ("l8", "1 0 0", "revolute", "1.5707963 0 0"),
    ("l8", "0 1 1", "fixed", "1 1 1"),
    ("l10", "0 1 1", "revolute", "0 0 -1.5707963267948966"),
    ("l11", "0 -1 1", "revolute", "0 0 0"),
    ("l12", "1 1 1", "revolute", "1 2 3"),
)
#: Meshes that are well, mirrored, coloured, lost, broken, not ours, and with a face too many.
FACES = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\n"
FILES = {
    "one.obj": FACES,
    "odd.obj": f"{FACES}f 1 2 4\n",
    "worn.obj": f"{FACES}f 1 2 4\n",
    "bad.obj": "v 0 0 0\n",
    "own.obj": FACES,
    "p/animationR/vrml/own.wrl": "mine",
    "p/animationR/vrml/one_mirror_y.wrl": "mine",
}
MESHES = (
    '<robot name="meshes">'
    + "".join(
        link(
            f"of_m{n}",
            1.0,
            '<visual><geometry><mesh filename="{}" scale="{}"/></geometry>'
            '<material name="c{}"><color rgba="{}"/></material></visual>'.format(*mesh),
        )
        + (joint(f"m{n}", f"of_m{n - 1}", "0 0 1", kind="fixed") if n else "")
        for n, mesh in enumerate(
            (
                ("one.obj", "1 2 3", 0, "1 0 0 1"),
                ("one.obj", "1 -2 3", 1, "1 0 0 1"),
                ("one.obj", "-1 -2 1", 2, "1 0 0 1"),
                ("one.obj", "1 1 1", 3, "0 1 0 1"),
                ("one.obj", "1 1 1", 4, "0 1 0 0.25"),
                ("gone.stl", "1 1 1", 5, "1 1 1 1"),
                ("odd.obj", "1 1 1", 6, "1 1 1 1"),
                ("gone.stl", "1 1 1", 7, "1 1 1 1"),
                ("worn.obj", "1 1 1", 8, "1 1 1 1"),
                ("bad.obj", "1 1 1", 9, "1 1 1 1"),
                ("own.obj", "1 1 1", 10, "1 1 1 1"),
                ("lost.obj", "1 1 1", 11, "1 1 1 1"),
                ("odd.obj", "1 1 1", 12, "1 1 1 1"),
                ("gone.stl", "1 1 1", 13, "1 1 1 1"),
            )
        )
    )
    + "</robot>"
)
FAST = {
    **PASSES,
    "posture": {
        "joints": {"leg": 0.9, "swing": -0.3},
        "hold": {
            "frequency": 900.0,
            "damping_ratio": 2.0,
            "gains": {"arm": {"stiffness": 9e9, "damping": 7e4}},
        },
    },
    "contacts": {"links": ["of_ankle"], "stiffness": 9e8, "speed": 1e-5},
    "joint-parameters": {"stop_frequency": 800.0},
}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "tree-compact": (TREE, {"pipeline": "compact"}),
    "tree-rounded": (
        TREE,
        {"pipeline": "compact", "passes": {"align-frames": {"tolerance": 1e-6}}},
    ),
    "tree": (TREE, {"pipeline": "faithful"}),
    "fast": (RICH, {"pipeline": "compact", "base": "floating", "passes": FAST, "project": "p"}),
    "weightless": (
        RICH,
        {
            "pipeline": "compact",
            "base": "floating",
            "project": "p",
            "gravity": [0, 0, 0],
            "passes": {
                "contacts": {"links": ["of_ankle"]},
                "posture": {"hold": {}},
                "forces": {
                    "wrenches": {"pull": {"link": "of_arm", "force": [1, 0, 0]}},
                    "springs": {
                        "coil": {
                            "ends": [{"link": "of_arm"}, {"link": "trunk"}],
                            "stiffness": 3,
                            "length": 0.5,
                        }
                    },
                },
            },
        },
    ),
    "rich": (RICH, {"pipeline": "compact", "base": "floating", "passes": PASSES, "project": "p"}),
    "rich-file": (RICH, {"pipeline": "faithful", "base": "floating"}),
    "odd": (
        ODD,
        {
            "project": "p",
            "pipeline": "compact",
            "base": "fixed",
            "passes": {
                "estimate-inertia": {"density": 500, "repair": True},
                "snap": {"angle": 0.001},
                "posture": {"joints": {"far": 90}, "hold": {"frequency": 60}},
                "contacts": {"links": ["of_far", "of_lid"], "points": {"of_far": [[0, 0, -0.4]]}},
                "rotors": {"armature": {"flat": 0.2}},
            },
        },
    ),
    "odd-file": (ODD, {"pipeline": "faithful"}),
    "bare": (BARE, {"project": "p", "passes": {"estimate-inertia": {"total_mass": 3}}}),
    "bare-file": (BARE, {"pipeline": "compact", "output": "2 bare.mbs"}),
    "measured": (
        MEASURED,
        {"pipeline": "compact", "project": "p", "passes": {"force-torque": {"joints": ["*"]}}},
    ),
    "points": (POINTS, {"base": "floating"}),
    "meshes": (MESHES, {"project": "p", "files": FILES, "base": "floating"}),
}


def number(value: float) -> float:
    """A number without its rounding; a half goes up, wherever rounding puts it."""
    return 0.0 if abs(value) < 1e-9 else float(f"{value * (1 + 1e-9):.4g}")


def plain(value: Any) -> Any:
    """A value in few words: numbers without rounding, and what has a name by its name."""
    if isinstance(value, float):
        return number(value)
    if isinstance(value, dict):
        return {str(plain(key)): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple, set)):
        return [plain(inner) for inner in value]
    if isinstance(value, msgspec.Struct):
        name = getattr(value, "name", None)
        return name if name else plain(msgspec.structs.asdict(value))
    return value if isinstance(value, (str, int, bool, type(None))) else str(value)


#: What other lines have, too.
TWICE = ("joint-parameters", "project", "layout", "certificate")
#: The room or plugin that says each code.
ROOMS = {code: room for room, table in TABLES.items() for code in table}


def lines(result: Result) -> Iterator[str]:
    """The lines of a snapshot: messages by the room that says them, then numbers by their kind."""
    rooms = [ROOMS[found.code] for found in result.diagnostics]
    for room in sorted({*rooms}):
        yield f"## messages of {room}"
        for found in result.diagnostics:
            if ROOMS[found.code] == room:
                where = found.link or found.joint or ""
                yield f"{found.level}[{found.code}] {where}: {found.message}"
                yield from [f"    {found.hint}"] if found.hint else ()
    yield "## facts of the report"
    for name, fact in sorted(result.conversion.report.items()):
        if name not in TWICE and fact:
            yield f"{name}: {json.dumps(plain(fact))}"
    if result.report.left_out:
        yield f"left out: {json.dumps(plain(result.report.left_out))}"
    yield "## the model"
    yield from parts(result.mbs)
    if result.conversion.settings.project is not None:
        yield "## slopes of the forces"
        mass = MassModel(result.mbs)
        models = {
            model.name: {of.name: float(of.values[0]) for of in model.parameters}
            for model in result.mbs.user_models
        }
        reduction = compute_reduction(mass, result.conversion.state(Simulation))
        simulation = result.conversion.state(Simulation)
        for force in linearise_forces(simulation, mass, reduction, models):
            row = abs(force.jacobian_row).sum()
            numbers = [*map(number, (force.stiffness, force.damping, row))]
            yield f"slope {force.kind} {force.name}: {numbers}"


def parts(mbs: Mbs) -> Iterator[str]:
    for name, owner in mbs.base_and_bodies():
        joints = (
            f"{of.type} {of.name} {of.nature[:3]} {plain(of.q)}{' actuated' * of.actuated}"
            for of in getattr(owner, "joints", ())
        )
        points = (
            " ".join([of.name, str(plain(of.coordinates)), *(s.name for s in signals)])
            for of in owner.points
            for signals in [[s for s in (of.sensor, of.extforce) if s]]
        )
        shapes = (f"{of.kind} {of.name} {of.color} {of.url or ''}" for of in owner.shapes)
        if isinstance(owner, Body):
            yield f"{name} {plain([owner.mass, owner.com, owner.inertia])}: {', '.join(joints)}"
        for kind in (points, shapes):
            listed = "; ".join(kind)
            yield from [f"    {listed}"] if listed else ()
    if mbs.view is not None:
        views = (mbs.view, *mbs.view.viewpoints, *mbs.view.lights)
        yield f"view: {json.dumps([plain(msgspec.structs.astuple(view)) for view in views])}"
    for connection in (*mbs.cuts, *mbs.links):
        ends = f"{connection.endpoint1} {connection.endpoint2}"
        yield f"{connection.kind} {connection.name}: {ends} {plain(connection.length)}"
    for constraint in mbs.user_constraints:
        yield f"constraint {constraint.name}: {constraint.joints}"
    for model in mbs.user_models:
        values = (
            f"{of.name} {' '.join(str(number(float(value))) for value in of.values)}"
            for of in model.parameters
        )
        yield f"model {model.name}: {', '.join(values)}"


def told(name: str, folder: Path) -> str:
    """All lines of a case, without the folder."""
    text, settings = CASES[name]
    source = folder / "r.urdf"
    source.write_text(text)
    settings = dict(settings)
    for name, content in settings.pop("files", {}).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)
    if settings.pop("project", None):
        settings["output"] = {"project": folder / "p"}
    elif "output" in settings:
        settings["output"] = folder / settings["output"]
    result = convert(source, **settings)
    return "\n".join(lines(result)).replace(str(folder), "DIR") + "\n"


@pytest.mark.parametrize("name", CASES)
def test_what_is_made_and_said_is_as_it_was_read(name: str, tmp_path: Path) -> None:
    assert told(name, tmp_path) == (TEXTS / f"{name}.txt").read_text()


if __name__ == "__main__":
    for case in CASES:
        with TemporaryDirectory() as place:
            (TEXTS / f"{case}.txt").write_text(told(case, Path(place)))
