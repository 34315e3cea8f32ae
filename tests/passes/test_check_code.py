"""The code of a project does what the URDF says, or the project is rejected."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import pytest
from laws.rich import PASSES, convert, joint, limit, link

from urdf2mbs import verify
from urdf2mbs.cli import main
from urdf2mbs.conversion import Conversion
from urdf2mbs.disk.output import write
from urdf2mbs.passes.check_code import code_of
from urdf2mbs.runtime.c_code import compiler
from urdf2mbs.runtime.code import prove_code

ROBOT, USER = "userfctR/rich_robot.py", "userfctR/user_"
ONE = "\n        <type>scalar</type>\n        <value>1.0</value>"
#: What is planted in the generated files, and what the message names.
PLANTED = {
    "a rule's offset": (ROBOT, "m * q[leader] - b", "m * q[leader] + b", "'slide': its rule"),
    "a rule's derivative": (ROBOT, "Jac[k, leader] = -m", "Jac[k, leader] = m", "derivatives"),
    "a rule's acceleration": (ROBOT, "jdqd[k] = 0.0", "jdqd[k] = 1.0", "its rule, its acc"),
    "a row of a rule": (
        ROBOT, '("right", "left", -1.5', '("slide", "left", -1.5', "rule"),
    "where a joint is driven": (ROBOT, "m * q[leader] + b", "m * q[leader]", "its q, where"),
    "how fast it is driven": (ROBOT, "m * qd[leader]", "qd[leader]", "its qd, where it is driven"),
    "how it accelerates": (ROBOT, "m * qdd[leader]", "-m * qdd[leader]", "its qdd, where"),
    "the sign of damping": (ROBOT, "Qq[joint] -= damping", "Qq[joint] += damping", "damping"),
    "damping of the next joint": (
        ROBOT, "damping[name] * qd[joint]", "damping[name] * qd[joint - 1]", "damping"),
    "a spring of a joint at zero": (ROBOT, "(q[joint] - rest[name])", "q[joint]", "springs"),
    "slow friction": (ROBOT, "Qq[joint] -= k * pull", "Qq[joint] -= 0.5 * k * pull", "friction"),
    "a bristle that slips late": (ROBOT, "- (there - kept) / time", "", "rate of its bristle"),
    "a bristle of the next joint": (
        ROBOT, "bristle(mbs_data, state, (qd", "bristle(mbs_data, state + 1, (qd", "friction"),
    "the other limit": (ROBOT, '["q_min"][name] - q', '["q_max"][name] - q', "stops"),
    "a stop that pulls": (ROBOT, "max(0.0, stiffness * depth", "(stiffness * depth", "stops"),
    "a stop that is harder on the way out": (
        ROBOT, "-qd[joint], stiffness", "qd[joint], stiffness", "stops"),
    "a hold at zero": (ROBOT, "(mbs_data.q0[joint] - q[joint])", "(-q[joint])", "hold"),
    "a motor that can do more": (ROBOT, "max(-most, min(most, push))", "min(most, push)", "hold"),
    "effort": (ROBOT, "if most > 0.0 else push", "if most > 9.0 else push", "hold"),
    "a wrench that does not end": (
        ROBOT, '<= tsim < wrench["stop"]', "<= tsim", "force 'wind' at 1.5 s"),
    "a wrench's parts": (ROBOT, '("Fx", "Fy", "Fz",', '("Fx", "Fz", "Fy",', "force 'wind'"),
    "a ground above": (ROBOT, 'law["ground"] - sum', '-law["ground"] + sum', "contact"),
    "a ground that pulls": (ROBOT, "depth > 0.0 and normal > 0.0", "True", "contact"),
    "no friction": (ROBOT, 'law["friction"] * length', "0.0 * length", "contact"),
    "friction forwards": (ROBOT, "UP[i] - pull[0]", "UP[i] + pull[0]", "contact"),
    "a bristle in the air": (
        ROBOT, 'length if touches else 0.0  #', "length  #", "bristle of 'of_ankle"),
    "up": (ROBOT, "UP = (", "UP = (0.1 + ", "contact"),
    "the radius of a wheel": (ROBOT, "[-radius * part", "[-2 * radius * part", "of_roller"),
    "the axis of a wheel": (ROBOT, "UP[i] - along * axis[i]", "UP[i]", "of_roller_contact_1"),
    "the spin of a wheel": (ROBOT, "cross(OMxF[1:], arm)", "cross(arm, OMxF[1:])", "of_roller"),
    "the torque on a wheel": (ROBOT, "*cross(arm, force)", "0.0, 0.0, 0.0", "of_roller"),
    "a foot less": (ROBOT, '    "of_ankle_contact_2_force": "of_ankle",\n', "", "contact_2_force'"),
    "a spring's length": (ROBOT, 'Z - model["link_length"][name]', "Z", "spring 'rope'"),
    "a spring's damping": (ROBOT, '+ model["link_damping"]', '- model["link_damping"]', "spring"),
    "a sensor's axes": (
        ROBOT, "r[i] * x + r[i + 3] * y", "r[i] * x - r[i + 3] * y", "sensor 'imu'"),
    "gravity in a sensor": (ROBOT, "found.A[1] - g[1]", "found.A[1] + g[1]", "sensor 'imu', what"),
    "spin of a sensor": (ROBOT, "found.OM)", "found.OMP)", "sensor 'imu', what it reads"),
    "a torque sensor": (ROBOT, "torque = [r[i] * a", "torque = [-r[i] * a", "sensor 'hand', what"),
    "forces that add up": (f"{USER}JointForces.py", "mbs_data.Qq[1:] = 0.0", "pass", "its forces"),
    "the point of a force": (
        f"{USER}ExtForces.py", "SWr[7:10] = ", "SWr[7:10] = -1.0 * ", "contact"),
    "a push for a pull": (f"{USER}LinkForces.py", "return robot", "return -robot", "spring 'rope'"),
    "nothing is driven": (
        f"{USER}DrivenJoints.py", "robot.driven_joints(mbs_data)", "pass", "driven"),
    "a rule of its own": (f"{USER}cons_hJ.py", "robot.constraints(h, Jac, mbs_data)",
                          "robot.constraints(h, Jac, mbs_data); h[1] += 0.5", "its rule"),
    "code that fails": (
        ROBOT, "def look_up(mbs_data):", "def look_up(mbs_data, more):", "cannot run"),
    "mass in the equations": (
        "symbolicR/mbs_dirdyna_rich.py", "    c[1] = ", "    c[1] = 1.0 + ", "accelerations"),
    "loops": (
        "symbolicR/mbs_cons_jdqd_rich.py", "Jdqd[1] = ", "Jdqd[1] = 1.0 + ", "loops, their acc"),
    "how far a loop is open": (
        "symbolicR/mbs_cons_hJ_rich.py", "- lrod[1] * ", "- 1.1 * lrod[1] * ", "how far they"),
    "the speed of a loop": (
        "symbolicR/mbs_cons_hJ_rich.py", "Jac[1, 37] = ", "Jac[1, 37] = 1.1 * ", "their speed"),
    "friction of the ground": (
        "dataR/rich.mbs", "<value>0.7</value>", "<value>0.6</value>", "contact law"),
    "no damping": (
        "dataR/rich.mbs", f"damping</name>{ONE}", f"damping</name>{ONE[:-11]}0.0</value>",
        "damping: the URDF states it"),
    "springs": ("symbolicR/mbs_link_rich.py", "Z[1] =", "Z[1] = 0.5 * ", "inverse dynamics"),
    "a sensor's motion": (
        "symbolicR/mbs_sensor_rich.py", "sens.A[1] = ", "sens.A[1] = 1.0 + ", "its A"),
}  # fmt: skip
IN_C = {
    "the sign of damping": ("Qq[d->joint] -=", "Qq[d->joint] +=", "its force in C"),
    "the rest of a spring": ("- number(mbs_data, s->rest)", "", "its force in C"),
    "a stop that pulls": ("fmax(0.0, stiffness * depth", "(stiffness * depth", "its force in C"),
    "the lowest point": ("at[i] = P[i] + arm[i]", "at[i] = P[i]", "in C"),
    "a ground that pulls": ("depth > 0.0 && normal > 0.0", "1", "in C"),
    "a bristle's rate": ("- lost * bent[k] / time", "", "bristles in C"),
    "a wrench's parts": ("w->parts[i - 1]", "w->parts[0]", "force 'wind' in C"),
    "a rule": ("- c->multiplier * q[c->leader]", "+ c->multiplier * q[c->leader]", "in C"),
    "gravity in a sensor": ("A[2] - mbs_data->g[2]", "A[2] + mbs_data->g[2]", "'imu' in C"),
}
Made = tuple[Conversion, dict[str, bytes]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The project in memory, before its code is compared."""
    passes = {**PASSES, "equations": {"language": "both"}}
    folder = tmp_path_factory.mktemp("rich")
    output = {"project": str(folder / "rich"), "language": "both"}
    conversion = convert(folder, passes, stop_after="project", output=output)
    return conversion, code_of(conversion, ".py", ".c", ".h")


def found(made: Made, *, in_c: bool = False, **changed: bytes) -> list[str]:
    """What differs, the largest first; equations are run only where they are changed."""
    proof = copy.deepcopy(made[0].proof)
    assert proof is not None
    equations = in_c or not changed or any("symbolicR" in name for name in changed)
    files = {name: made[1][name] for name in made[1] if equations or "symbolicR" not in name}
    prove_code(made[0], proof, files | changed, in_c=in_c)
    assert proof.same == (not proof.differences)
    if proof.same:
        assert not proof.not_compared
        assert len(proof.by_code) == 12
    return [difference.message for difference in proof.differences]


def planted(made: Made, file: str, before: str, after: str) -> dict[str, bytes]:
    text = made[1][file].decode()
    assert before in text
    return {file: text.replace(before, after).encode()}


def test_the_code_as_it_is_does_what_the_urdf_says(made: Made) -> None:
    assert found(made) == []


@pytest.mark.parametrize("fault", PLANTED)
def test_a_fault_in_the_code_is_found(made: Made, fault: str) -> None:
    *place, named = PLANTED[fault]
    messages = found(made, **planted(made, *place))
    assert any(named in message for message in messages), messages[:3]


OTHERWISE: dict[str, Any] = {
    "link 'of_swing': has 0": lambda c: (c.simulation, "contacts", [
        contact for contact in c.simulation.contacts if contact.link != "of_swing"]),
    "joint 'arm': is held": lambda c: (c.asked["posture"].hold, "joints", ["leg"]),
    "joint 'roller': is not held": lambda c: (c.asked["posture"].hold, "joints", ["*"]),
    "'hand', its place": lambda c: (c.simulation.force_torques[0], "link", "trunk"),
    "sensor 'gyro': is not there": lambda c: (c.simulation, "sensors", [
        sensor for sensor in c.simulation.sensors if sensor.name != "gyro"]),
    "joint 'arm': its start": lambda c: (c.asked["posture"], "joints", {"arm": 0.4}),
}  # fmt: skip


@pytest.mark.parametrize("named", OTHERWISE)
def test_what_was_asked_for_otherwise_is_found(
    made: Made, named: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(*OTHERWISE[named](made[0]))
    messages = found(made, **{"userfctR/none.py": b""})
    assert any(named in message for message in messages), messages[:5]


def test_a_force_elsewhere_or_without_a_law_is_found(made: Made) -> None:
    file = "dataR/rich.mbs"
    first, second = (f'"of_{name}_contact_1_force"' for name in ("ankle", "swing"))
    parts = re.split(f"({first}|{second})", made[1][file].decode())
    swapped = "".join({first: second, second: first}.get(part, part) for part in parts)
    messages = found(made, **{file: swapped.encode()})
    assert any("seen from its link" in message for message in messages), messages[:5]
    user = planted(made, f"{USER}ExtForces.py", "SWr[7:10] =", "SWr[1] = 1.0\n    SWr[7:10] =")
    stray, count = re.subn(
        r"(?s)(<pointname>rope_1</pointname>.*?</graphics>)",
        r'\1<extforce name="stray" Pos="true"/>', made[1][file].decode(),
    )  # fmt: skip
    assert count == 1
    messages = found(made, **{file: stray.encode()}, **user)
    assert any("'stray', which has no law: is" in message for message in messages), messages[:5]


def test_accelerations_of_a_tree_are_compared(tmp_path: Path) -> None:
    text = '<robot name="rich">' + link("trunk") + joint("arm", "trunk", "0 0 1", kind="continuous")
    conversion = convert(
        tmp_path, {"equations": {"language": "python"}}, text + link("of_arm") + "</robot>",
        stop_after="project",
    )  # fmt: skip
    whole = conversion, code_of(conversion, ".py")
    for name, before, after, named in (
        ("accelred", "(s)\n    return", "(s)\n    s.qdd[6] = s.qdd[6]\n    return", None),
        ("accelred", "(s)\n    return", "(s)\n    s.qdd[6] += 1\n    return", "accelerations: is"),
        ("dirdyna", "    c[1] = ", "    c[1] = 1.0 + ", "the bias forces: is"),
        ("dirdyna", "    M[1, 1] = ", "    M[1, 1] = 1.0 + ", "the mass matrix: is"),
    ):
        proof = copy.deepcopy(conversion.proof)
        assert proof is not None
        fault = planted(whole, f"symbolicR/mbs_{name}_rich.py", before, after)
        prove_code(conversion, proof, whole[1] | fault)
        assert proof.same is (named is None)
        assert named is None or named in proof.differences[0].message


def test_a_fault_in_a_project_that_was_edited_is_named_beside_the_verdict(
    made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    fault = planted(made, *PLANTED["the sign of damping"][:3])
    monkeypatch.setattr(made[0], "edited", {"mine.yaml": []})
    proof = copy.deepcopy(made[0].proof)
    assert proof is not None
    files = {name: text for name, text in made[1].items() if "symbolicR" not in name}
    prove_code(made[0], proof, files | fault)
    assert proof.same
    said = [message for message, why in proof.but_for.items() if why == "as edited in mine.yaml"]
    assert any("damping" in message for message in said)


@pytest.mark.parametrize(("kind", "named"), [("ball", True), ("rod", False)])
def test_a_cut_of_another_kind_than_asked_for_is_found(
    made: Made, kind: str, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(made[0].asked["loops"].cuts["tie"], "kind", kind)
    files = {name: text for name, text in made[1].items() if "symbolicR" not in name}
    proof = copy.deepcopy(made[0].proof)
    assert proof is not None
    prove_code(made[0], proof, files)
    said = [difference.message for difference in proof.differences]
    assert said == [f"cut 'tie': is no {kind} in the .mbs"] * named


@pytest.mark.parametrize(("point", "named"), [
    ("wind_at", "force 'wind': is"), ("rope_1", "end of spring 'rope'"), ("tie_2", "end of cut"),
    ("of_swing_contact_1", "contact 'of_swing_contact_1_force': is"), ("of_right_at", "'of_right'"),
])  # fmt: skip
def test_a_point_elsewhere_is_found(made: Made, point: str, named: str) -> None:
    file, place = "dataR/rich.mbs", rf"(>{point}</pointname>\s*<coordinates>\s*<x>)(.*)(?=</x>)"
    text, count = re.subn(place, lambda m: f"{m[1]}{float(m[2]) + 1e-3}", made[1][file].decode())
    assert count == 1
    messages = found(made, **{file: text.encode()})
    assert any(named in message for message in messages), messages[:5]


@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_c_does_what_python_does(made: Made) -> None:
    assert found(made, in_c=True) == []


@pytest.mark.slow
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("fault", IN_C)
def test_a_fault_in_c_is_found(made: Made, fault: str) -> None:
    *change, named = IN_C[fault]
    messages = found(made, in_c=True, **planted(made, "userfctR/rich_robot.c", *change))
    assert any(named in message for message in messages), messages[:3]


@pytest.mark.parametrize("place", [
    ("urdf2mbs.passes.mimic.follow", "'slide': its rule"),
    ("urdf2mbs.passes.contacts.dot", "the lowest contact at start"),
    ("urdf2mbs.passes.forces.dist", "spring 'rope'"),
])  # fmt: skip
def test_a_fault_of_a_pass_is_found_and_no_code_is_written(
    place: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, _, name = place[0].rpartition(".")
    own = getattr(__import__(module, fromlist=[name]), name)

    def wrong(*words: Any) -> Any:
        given = own(*words)
        return (*given[:2], given[2] + 0.1) if isinstance(given, tuple) else given + 0.1

    monkeypatch.setattr(place[0], wrong)
    conversion = convert(tmp_path)
    assert conversion.proof is not None
    assert any(place[1] in difference.message for difference in conversion.proof.differences)
    assert conversion.rejected == conversion.settings.output.with_name("rich.rejected.mbs")
    write(conversion)
    files = [path.name for path in (tmp_path / "rich").rglob("*") if path.is_file()]
    assert sorted(files) == ["rich.rejected.mbs"]


def test_what_is_compared_is_no_longer_called_unknown(tmp_path: Path) -> None:
    proof = convert(tmp_path).proof
    assert proof is not None
    assert "not compared" not in proof.in_words()
    assert "force 'wind'" in proof.by_code
    only_c = convert(tmp_path, output={"project": str(tmp_path / "c"), "language": "c"}).proof
    assert only_c is not None
    assert {"the code in C", "force 'wind'"} <= only_c.not_compared.keys()


PLUGIN = '''
from urdf2mbs.plugin import Pass, hookimpl, mbs, simulation

class Laws(Pass):
    """A torque in a joint, and a force at a point."""
    reads = ("joints", "bodies")
    writes = ("anchors", "forces")
    torque: float | None = None
    force: float | None = None

    def run(self, conversion):
        (arm,) = [j for step, j in conversion.single_coordinates() if step.joint.name == "arm"]
        _, point = conversion.add_point("here", "of_hand", (0.1, 0.0, 0.0), "laws-link", "laws: at")
        point.extforce = mbs.Sensor("breeze", ("Pos", "Vit"))
        torque = None if self.torque is None else lambda q, qd: self.torque * q ** 3
        force = None if self.force is None else lambda P, V, t: \
            (-V[0], 0, self.force * P[2], 0, 0, t)
        conversion.simulation.laws += [simulation.Law("rubber", """
def rubber(mbs_data, joint):
    return -3.0 * mbs_data.q[joint] ** 3
""", "", joints=[arm], should=torque), simulation.Law("wind", """
def wind(P, V, mbs_data, tsim, ixF):
    return (-V[1], 0.0, 2.0 * P[3], 0.0, 0.0, tsim)
""", "", points=[point], should=force)]

@hookimpl
def urdf2mbs_passes():
    return [Laws]
'''


@pytest.mark.parametrize(("should", "found"), [
    ({}, None), ({"torque": -3.0, "force": 2.0}, None),
    ({"torque": 3.0}, "joint 'arm': its forces: is "), ({"force": 1.0}, "force 'breeze': is "),
])  # fmt: skip
def test_the_law_of_a_plugin(should: dict[str, float], found: str | None, tmp_path: Path) -> None:
    (tmp_path / "laws.py").write_text(PLUGIN)
    passes = {"mimic": PASSES["mimic"]}
    options = {**passes, **({"laws": should} if should else {})}
    proof = convert(
        tmp_path, options, plugins=[str(tmp_path / "laws.py")],
        after={"joint-parameters": "laws"},
    ).proof  # fmt: skip
    assert proof is not None
    assert proof.same is (found is None)
    if found:
        assert proof.differences[0].message.startswith(found)
    else:
        assert ("law 'rubber'" in proof.not_compared) is ("torque" not in should)
        assert ("force 'breeze'" in proof.not_compared) is ("force" not in should)


def test_verify_runs_the_code_only_when_asked(tmp_path: Path) -> None:
    write(convert(tmp_path, PASSES))
    robot, project = tmp_path / "rich.urdf", tmp_path / "rich"
    trace = tmp_path / "trace"
    user = project / "userfctR" / "user_Derivative.py"
    user.write_text(f"open({str(trace)!r}, 'w')\n" + user.read_text())
    module = project / ROBOT
    text = module.read_text()
    module.write_text(text + f"open({str(trace)!r}, 'w')\n")
    settings: dict[str, Any] = {"gravity": (0.5, -0.3, -9.7)}
    verdict = verify(robot, project, **settings)
    assert verdict.same
    assert verdict.not_compared["the generated code"] == "'--code' runs and compares it"
    assert not trace.exists()
    module.write_text(text)
    verdict = verify(robot, project, code=True, **settings)
    assert verdict.same
    assert not trace.exists()
    assert "force 'wind'" in verdict.by_code
    assert verdict.not_compared["user function 'user_Derivative.py'"] == "changed by its user"
    module.write_text(text.replace("Qq[joint] -= damping", "Qq[joint] += damping"))
    gravity = ["--gravity", "0.5", "-0.3", "-9.7"]
    assert main(["verify", str(robot), str(project), "--code", *gravity]) == 3
    assert main(["verify", str(robot), str(project), *gravity]) == 0
    module.write_text(text)
    stops = "user model 'stop_stiffness'"
    assert stops in verify(robot, project, code=True, **settings).by_code
    model = project / "dataR" / "rich.mbs"
    before, after = model.read_text().split("<name>stop_stiffness</name>")
    after = re.sub("<value>.*?</value>", "<value>7</value>", after, count=1)
    model.write_text(before + "<name>stop_stiffness</name>" + after)
    verdict = verify(robot, project, code=True, **settings)
    assert verdict.same
    assert verdict.not_compared[stops] == "not as urdf2mbs makes it"
    (project / "dataR" / "rich.proof.json").unlink()
    verdict = verify(robot, project, code=True, **settings)
    assert verdict.not_compared["the generated code"] == "there is no 'rich.proof.json'"


@pytest.mark.parametrize(("options", "start"), [
    ({}, 0.5), ({"from_urdf": False}, 0.0), ({"joints": {"arm": 0.3}}, 0.3),
])  # fmt: skip
def test_a_start_that_ros2_control_states_is_right(
    options: dict[str, Any], start: float, tmp_path: Path
) -> None:
    stated = (
        '<ros2_control><joint name="arm"><state_interface name="position">'
        '<param name="initial_value">0.5</param></state_interface></joint></ros2_control>'
    )
    text = '<robot name="rich"><link name="world"/>' + joint("arm", "world", "1 0 0", limit(-2, 2))
    text += link("of_arm") + stated + "</robot>"
    conversion = convert(tmp_path, {"posture": options}, text, base="fixed")
    assert conversion.proof is not None
    assert conversion.proof.same, conversion.proof.differences[0].message
    assert conversion.mbs.joints()["arm"].q == (start or None)


def test_a_robot_without_joints_that_move(tmp_path: Path) -> None:
    text = '<robot name="rich"><link name="world"/></robot>'
    proof = convert(tmp_path, {}, text, base="fixed").proof
    assert proof is not None
    assert proof.same


def test_without_a_compiler_python_is_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("urdf2mbs.runtime.code.compiler", lambda: None)
    solid = link("world") + joint("slide", "world", "0 0 1", limit(-1, 1), "prismatic")
    text = f'<robot name="rich">{solid}{link("of_slide")}</robot>'
    conversion = convert(tmp_path, {}, text, base="fixed")
    verdict = copy.deepcopy(conversion.proof)
    assert verdict is not None
    prove_code(conversion, verdict, code_of(conversion, ".py"), in_c=True)
    assert verdict.same
    assert verdict.not_compared["the code in C"] == "there is no C compiler"


def test_a_robot_that_no_equations_can_move_is_the_same(tmp_path: Path) -> None:
    """A mass point turns about an axis through it: no matter resists."""
    point = '<link name="of_spin"><inertial><mass value="1"/></inertial></link>'
    text = (
        f'<robot name="rich"><link name="world"/>{joint("spin", "world", "1 0 0")}{point}</robot>'
    )
    text = text.replace("</joint>", '<dynamics damping="0.2"/></joint>')
    conversion = convert(tmp_path, {}, text, base="fixed")
    verdict = copy.deepcopy(conversion.proof)
    assert verdict is not None
    prove_code(conversion, verdict, code_of(conversion, ".py"), in_c=True)
    assert verdict.same
    assert "joint 'spin'" in verdict.not_compared["accelerations and C"]
    files = code_of(conversion, ".py")
    files[ROBOT] = files[ROBOT].replace(b"Qq[joint] -= damping", b"Qq[joint] += damping")
    prove_code(conversion, verdict, files, in_c=True)
    assert {found.message.split(":")[0] for found in verdict.differences} == {"joint 'spin'"}
