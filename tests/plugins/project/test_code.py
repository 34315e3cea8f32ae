"""The code of a project does what the URDF and the options of the passes say."""

import re
from pathlib import Path
from typing import Any

import pytest

from support.project_code import code_of, prove_code
from support.rich_robot import PASSES, convert
from urdf2mbs.conversion import Conversion
from urdf2mbs.passes.check import prove
from urdf2mbs_simulate.compiler import compiler

ROBOT, USER = "userfctR/rich_robot.py", "userfctR/user_"
ONE = "\n        <type>scalar</type>\n        <value>1.0</value>"
#: What is planted in the generated files, and what the message names.
PLANTED = {
    "a rule's offset": (ROBOT, "* q[joint[leader]] - b", "* q[joint[leader]] + b", "its rule"),
    "a rule's derivative": (ROBOT, "joint[leader]] = -m", "joint[leader]] = m", "derivatives"),
    "a rule's acceleration": (ROBOT, "jdqd[k] = 0.0", "jdqd[k] = 1.0", "its rule, its acc"),
    "a row of a rule": (ROBOT, '("right", "left", -1.5', '("slide", "left", -1.5', "rule"),
    "where a joint is driven": (ROBOT, "q[joint[leader]] + b", "q[joint[leader]]", "its q, where"),
    "how fast it is driven": (ROBOT, "= m * qd[joint", "= qd[joint", "its qd, where it is driven"),
    "how it accelerates": (ROBOT, "m * qdd[joint", "-m * qdd[joint", "its qdd, where"),
    "the sign of damping": (ROBOT, "-= coefficient", "+= coefficient", "damping"),
    "damping of the next joint": (
        ROBOT,
        "coefficient * qd[joint[name]]",
        "coefficient * qd[joint[name] - 1]",
        "damping",
    ),
    "a spring of a joint at zero": (ROBOT, " - rest[name])", ")", "springs"),
    "slow friction": (ROBOT, "-= stiffness * bent", "-= 0.5 * stiffness * bent", "friction"),
    "a bristle that slips late": (
        ROBOT,
        "- (bent - max(-longest, min(longest, bent))) / time",
        "",
        "rate of its bristle",
    ),
    "a bristle of the next joint": (
        ROBOT,
        "bristle(mbs_data, state, qd",
        "bristle(mbs_data, state + 1, qd",
        "friction",
    ),
    "the other limit": (ROBOT, "lower.get(name, -inf) -", "upper.get(name, -inf) -", "stops"),
    "a stop that pulls": (ROBOT, "max(0.0, stiffness * depth", "(stiffness * depth", "stops"),
    "a stop that is harder on the way out": (
        ROBOT,
        "-qd[k], stiffness",
        "qd[k], stiffness",
        "stops",
    ),
    "a hold at zero": (ROBOT, "(mbs_data.q0[k] - q[k])", "(-q[k])", "hold"),
    "a motor that can do more": (
        ROBOT,
        "max(-effort, min(effort, force))",
        "min(effort, force)",
        "hold",
    ),
    "effort": (ROBOT, "if effort > 0.0 else force", "if effort > 9.0 else force", "hold"),
    "a wrench that does not end": (
        ROBOT,
        '<= tsim < wrench["stop"]',
        "<= tsim",
        "force 'wind' at 1.5 s",
    ),
    "a wrench's parts": (ROBOT, '("Fx", "Fy", "Fz",', '("Fx", "Fz", "Fy",', "force 'wind'"),
    "a ground above": (ROBOT, '- law["ground"]', '- law["ground"] - 0.01', "contact"),
    "a ground that pulls": (ROBOT, "pushed = normal > 0.0", "pushed = normal != 0.0", "contact"),
    "no friction": (ROBOT, 'law["friction"] * length', "0.0 * length", "contact"),
    "friction forwards": (ROBOT, "(UP - pull @", "(UP + pull @", "contact"),
    "a bristle in the air": (ROBOT, "= -state / time", "= 0.0", "bristles of 'of_"),
    "bristles that do not turn": (ROBOT, "+ state[2] * turned", "+ 0.0 * turned", "contact"),
    "bristles that slip late": (
        ROBOT,
        "- (bent - shorten(bent, longest)) / time",
        "",
        "bristles of",
    ),
    "a centre elsewhere": (ROBOT, "shift - turn * centre", "shift", "bristles of"),
    "a turn about another place": (
        ROBOT,
        "offset = turned - centre",
        "offset = turned",
        "bristles",
    ),
    "one spot that resists a turn": (
        ROBOT,
        "share = min(max(",
        "share = 1.0; (max(",
        "bristles of",
    ),
    "up": (ROBOT, "UP = np.array((", "UP = np.array((0.1 + ", "contact"),
    "the radius of a wheel": (ROBOT, "down * lowest", "2.0 * down * lowest", "of_roller"),
    "the axis of a wheel": (ROBOT, "(axis @ UP)[:, None] * axis -", "0.0 * axis -", "of_roller"),
    "the spin of a body": (
        ROBOT,
        "np.cross(OMxF[1:4], arms)",
        "np.cross(arms, OMxF[1:4])",
        "contact",
    ),
    "the torque on a body": (ROBOT, "np.cross(arms, forces)", "np.cross(forces, arms)", "contact"),
    "what is far does not touch": (
        ROBOT,
        "height >= contact.bound",
        "height >= 0.7 * contact.bound",
        "contact",
    ),
    "a spring's length": (ROBOT, 'Z - model["link_length"][name]', "Z", "spring 'rope'"),
    "a spring's damping": (ROBOT, '+ model["link_damping"]', '- model["link_damping"]', "spring"),
    "a sensor's axes": (
        ROBOT,
        "r[i] * x + r[i + 3] * y",
        "r[i] * x - r[i + 3] * y",
        "sensor 'imu'",
    ),
    "gravity in a sensor": (
        ROBOT,
        "computed.A[1] - g[1]",
        "computed.A[1] + g[1]",
        "sensor 'imu', what",
    ),
    "spin of a sensor": (ROBOT, "computed.OM)", "computed.OMP)", "sensor 'imu', what it reads"),
    "a torque sensor": (ROBOT, "torque = [r[i] * a", "torque = [-r[i] * a", "sensor 'hand', what"),
    "forces that add up": (f"{USER}JointForces.py", "mbs_data.Qq[1:] = 0.0", "pass", "its forces"),
    "the point of a force": (
        f"{USER}ExtForces.py",
        "SWr[7:10] = ",
        "SWr[7:10] = -1.0 * ",
        "force 'wind'",
    ),
    "a push for a pull": (f"{USER}LinkForces.py", "return robot", "return -robot", "spring 'rope'"),
    "nothing is driven": (
        f"{USER}DrivenJoints.py",
        "robot.driven_joints(mbs_data)",
        "pass",
        "driven",
    ),
    "a rule of its own": (
        f"{USER}cons_hJ.py",
        "robot.constraints(h, Jac, mbs_data)",
        "robot.constraints(h, Jac, mbs_data); h[1] += 0.5",
        "its rule",
    ),
    "code that fails": (
        ROBOT,
        "def get_indices(mbs_data):",
        "def get_indices(mbs_data, more):",
        "cannot run",
    ),
    "mass in the equations": (
        "symbolicR/mbs_dirdyna_rich.py",
        "    c[1] = ",
        "    c[1] = 1.0 + ",
        "accelerations",
    ),
    "loops": (
        "symbolicR/mbs_cons_jdqd_rich.py",
        "Jdqd[1] = ",
        "Jdqd[1] = 1.0 + ",
        "loops, their acc",
    ),
    "how far a loop is open": (
        "symbolicR/mbs_cons_hJ_rich.py",
        "- lrod[1] * ",
        "- 1.1 * lrod[1] * ",
        "how far they",
    ),
    "the speed of a loop": (
        "symbolicR/mbs_cons_hJ_rich.py",
        "Jac[1, 39] = ",
        "Jac[1, 39] = 1.1 * ",
        "their speed",
    ),
    "friction of the ground": (
        "dataR/rich.mbs",
        "<value>0.7</value>",
        "<value>0.6</value>",
        "contact law",
    ),
    "no damping": (
        "dataR/rich.mbs",
        f"damping</name>{ONE}",
        f"damping</name>{ONE[:-11]}0.0</value>",
        "damping: the URDF states it",
    ),
    "springs": ("symbolicR/mbs_link_rich.py", "Z[1] =", "Z[1] = 0.5 * ", "inverse dynamics"),
    "a sensor's motion": (
        "symbolicR/mbs_sensor_rich.py",
        "sens.A[1] = ",
        "sens.A[1] = 1.0 + ",
        "its A",
    ),
}
IN_C = {
    "the sign of damping": (
        "Qq[leg_id] -= user_model->damping",
        "Qq[leg_id] += user_model->damping",
        "its force in C",
    ),
    "the rest of a spring": ("- user_model->spring_reference.swing", "", "its force in C"),
    "a stop that pulls": ("fmax(0.0, stiffness * depth", "(stiffness * depth", "its force in C"),
    "the lowest point": (" + spot->rim[1] * tangent[i]", "", "in C"),
    "a ground that pulls": ("n <= 0.0", "0", "in C"),
    "a bristle's rate": ("rate[i] -= (bent[i] - clipped[i]) / time", "", "bristles in C"),
    "one spot that resists a turn": ("rates[2] *= 1.0 - share", "rates[2] = 0.0", "bristles in C"),
    "a turn about another place": (
        "sums.mixed -= centre[i]",
        "sums.mixed += centre[i]",
        "bristles",
    ),
    "a wrench's parts": ("user_model->wind.Fy", "user_model->wind.Fx", "force 'wind' in C"),
    "a rule": ("+ 1.5 * q[left_id]", "- 1.5 * q[left_id]", "in C"),
    "gravity in a sensor": ("A[2] - g[2]", "A[2] + g[2]", "'imu' in C"),
}
Made = tuple[Conversion, dict[str, bytes]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Make the project in memory, before its code is compared."""
    passes = {**PASSES, "equations": {"language": "both"}}
    folder = tmp_path_factory.mktemp("rich")
    output = {"project": str(folder / "rich"), "language": "both"}
    conversion = convert(folder, passes, stop_after="project", output=output)
    return conversion, code_of(conversion, ".py", ".c", ".h")


def find_differences(made: Made, *, in_c: bool = False, **changed: bytes) -> list[str]:
    """Return the differences, the largest first; equations are run only if they are changed."""
    equations = in_c or not changed or any("symbolicR" in name for name in changed)
    files = {name: made[1][name] for name in made[1] if equations or "symbolicR" not in name}
    return prove_code(made[0], files | changed, in_c=in_c)


def planted(made: Made, file: str, before: str, after: str) -> dict[str, bytes]:
    text = made[1][file].decode()
    assert before in text
    return {file: text.replace(before, after).encode()}


def test_the_code_as_it_is_does_what_the_urdf_says(made: Made) -> None:
    assert find_differences(made) == []


@pytest.mark.parametrize("fault", PLANTED)
def test_a_fault_in_the_code_is_found(made: Made, fault: str) -> None:
    *place, named = PLANTED[fault]
    messages = find_differences(made, **planted(made, *place))
    assert any(named in message for message in messages), messages[:3]


def test_a_force_elsewhere_or_without_a_law_is_found(made: Made) -> None:
    file = "dataR/rich.mbs"
    first, second = (f'"of_{name}_contact_force"' for name in ("ankle", "swing"))
    parts = re.split(f"({first}|{second})", made[1][file].decode())
    swapped = "".join({first: second, second: first}.get(part, part) for part in parts)
    messages = find_differences(made, **{file: swapped.encode()})
    assert any("shape touches" in message for message in messages), messages[:5]
    user = planted(made, f"{USER}ExtForces.py", "SWr[7:10] =", "SWr[1] = 1.0\n    SWr[7:10] =")
    stray, count = re.subn(
        r"(?s)(<pointname>rope_1</pointname>.*?</graphics>)",
        r'\1<extforce name="stray" Pos="true"/>',
        made[1][file].decode(),
    )
    assert count == 1
    messages = find_differences(made, **{file: stray.encode()}, **user)
    assert any("'stray', which has no law: is" in message for message in messages), messages[:5]


@pytest.mark.parametrize(
    ("point", "named"),
    [
        ("wind_at", "force 'wind': is"),
        ("rope_1", "end of spring 'rope'"),
        ("tie_2", "end of cut"),
        ("of_swing_contact", "contact 'of_swing_contact_force': "),
        ("of_right_at", "'of_right'"),
    ],
)
def test_a_point_elsewhere_is_found(made: Made, point: str, named: str) -> None:
    file, place = "dataR/rich.mbs", rf"(>{point}</pointname>\s*<coordinates>\s*<x>)(.*)(?=</x>)"
    text, count = re.subn(place, lambda m: f"{m[1]}{float(m[2]) + 1e-3}", made[1][file].decode())
    assert count == 1
    messages = find_differences(made, **{file: text.encode()})
    assert any(named in message for message in messages), messages[:5]


@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("fault", IN_C)
def test_a_fault_in_c_is_found(made: Made, fault: str) -> None:
    before, after, named = IN_C[fault]
    (file,) = (f for f in ("robot.c", "laws.h") if before in made[1][f"userfctR/rich_{f}"].decode())
    messages = find_differences(
        made, in_c=True, **planted(made, f"userfctR/rich_{file}", before, after)
    )
    assert any(named in message for message in messages), messages[:3]


@pytest.mark.parametrize(
    "place",
    [
        ("urdf2mbs_project.passes.mimic.follow", "'slide': its rule"),
        ("urdf2mbs_project.passes.contacts.dot", "the lowest contact at start"),
        ("urdf2mbs_project.passes.forces.dist", "spring 'rope'"),
    ],
)
def test_a_fault_of_a_pass_is_found(
    place: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, _, name = place[0].rpartition(".")
    original = getattr(__import__(module, fromlist=[name]), name)

    def wrong(*words: Any) -> Any:
        given = original(*words)
        return (*given[:2], given[2] + 0.1) if isinstance(given, tuple) else given + 0.1

    monkeypatch.setattr(place[0], wrong)
    conversion = convert(tmp_path)
    messages = prove_code(conversion, code_of(conversion, ".py"))
    assert any(place[1] in message for message in messages)


def test_the_verdict_of_a_project_leaves_out_what_its_passes_made(tmp_path: Path) -> None:
    """The generated user functions compute it; a file alone does not say who made it."""
    conversion = convert(tmp_path)
    assert conversion.checked.proof.not_compared == {}
    assert "force 'wind'" in prove(conversion, conversion.mbs).not_compared
