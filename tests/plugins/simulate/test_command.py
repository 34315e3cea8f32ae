"""What the command `simulate` says."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from support.build import SOLID, link, robot
from urdf2mbs import simulate
from urdf2mbs.cli import main
from urdf2mbs.commands import parser
from urdf2mbs.mbs.model import Body, Connection, Joint, Mbs
from urdf2mbs.messages.diagnostics import ConfigError
from urdf2mbs_simulate.commands.simulate import MEANT
from urdf2mbs_simulate.support import find_floating_base


@pytest.mark.parametrize(
    ("base", "said"),
    [
        ("floating", "moved most: 0.00196 m\n  nothing holds it: 'base: fixed' bolts it down"),
        ("fixed", " rad\n  alone/"),
    ],
)
def test_a_robot_that_falls_is_told_what_holds_it(
    base: str, said: str, here: Path, capsys: Any
) -> None:
    assert main(["convert", "tiny.urdf", "-o", "tiny.mbs", "--base", base]) == 0
    assert main(["simulate", "tiny.mbs", "-o", "alone/", "--time", "0.02"]) == 0
    assert said in capsys.readouterr().out


#: A pendulum on the world; its joint is of another kind and name in some tests.
PENDULUM = robot(
    '<link name="world"/>',
    link("a", SOLID),
    '<joint name="swing" type="continuous"><parent link="world"/><child link="a"/>'
    '<axis xyz="0 1 0"/></joint>',
)


@pytest.mark.parametrize(
    ("kind", "held", "words"),
    [
        ("continuous", True, ""),
        ("prismatic", True, ""),
        ("planar", True, ""),
        # its own floating joint: no config makes the base fixed
        ("floating", False, "nothing holds it: 'passes: {contacts: {links: [FOOT]}}' gives"),
    ],
)
def test_what_hangs_on_the_world_is_held(
    kind: str, held: bool, words: str, here: Path, capsys: Any
) -> None:
    limit = '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
    text = PENDULUM.replace("continuous", kind).replace("</joint>", limit)
    Path("r.urdf").write_text(text.replace('xyz="0 1 0"', 'xyz="1 0 1"'))
    assert main(["convert", "r.urdf", "-o", "r.mbs"]) == 0
    assert main(["simulate", "r.mbs", "-o", "r/", "--time", "0.02", "--language", "python"]) == 0
    out = capsys.readouterr().out
    assert "moved most" in out
    assert ("nothing holds it" not in out) == held
    assert words in out


def test_a_base_that_floats_unless_something_holds_it() -> None:
    base = [Joint(f"floating_base_{kind}", kind) for kind in ("T1", "T2", "T3", "R1", "R2", "R3")]
    arm = Body("arm", "trunk", None, [Joint("elbow", "R2")])
    model = Mbs("m", bodies=[Body("trunk", joints=base), arm])
    assert find_floating_base(model) == base
    held = Connection("rod", "rope", (None, "hook"), ("arm", None))
    assert find_floating_base(msgspec.structs.replace(model, cuts=[held])) == []
    assert find_floating_base(msgspec.structs.replace(model, links=[held])) == []
    inner = Connection("rod", "rope", ("trunk", None), ("arm", None))
    assert find_floating_base(msgspec.structs.replace(model, links=[inner])) == base
    base[2].nature = "driven"
    assert find_floating_base(model) == []
    gantry = [Body("x", joints=base[:1]), Body("y", "x", None, [Joint("y", "T2")])]
    assert find_floating_base(Mbs("m", bodies=gantry)) == []


def test_a_joint_on_the_ground_is_no_base(here: Path, capsys: Any) -> None:
    """A robot that is bolted down is not told to be, whichever of its joints moves most."""
    ends = '<parent link="world"/><child link="a"/><axis xyz="0 1 0"/>'
    swing = f'<joint name="j" type="continuous">{ends}</joint>'
    text = robot(link("world"), link("a", SOLID), swing)
    Path("a.urdf").write_text(text)
    assert main(["convert", "a.urdf", "-o", "a.mbs", "--base", "fixed"]) == 0
    assert main(["simulate", "a.mbs", "-o", "alone/", "--time", "0.02"]) == 0
    out = capsys.readouterr().out
    assert "joint 'j' moved most" in out
    assert "nothing holds it" not in out


FOREIGN = "0.0 1.0\n"


@pytest.mark.parametrize("file", ["resultsR/dirdyn_q.res", "animationR/dirdyn_q.anim"])
def test_results_of_another_program_stay(file: str, here: Path, capsys: Any) -> None:
    """As those of MBsysC; the simulation is not even computed."""
    assert main(["convert", "tiny.urdf", "-o", "p/"]) == 0
    words = ["simulate", "p", "--time", "0.02", "--language", "python"]
    assert main(words) == 0
    assert main(words) == 0
    Path("p", file).write_text(FOREIGN)
    csv = Path("p/resultsR/dirdyn.csv").read_bytes()
    Path("p/userfctR/user_JointForces.py").write_text("raise SystemExit('computed')\n")
    assert main(words) == 2
    message = capsys.readouterr().err
    assert "output-not-ours" in message
    assert "--force" in message
    assert Path("p", file).read_text() == FOREIGN
    assert Path("p/resultsR/dirdyn.csv").read_bytes() == csv
    Path("p/userfctR/user_JointForces.py").unlink()
    assert main([*words, "--force"]) == 0
    assert Path("p", file).read_text() != FOREIGN
    assert main(words) == 0


def test_results_of_another_program_stay_in_python_and_as_modes(here: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf", "-o", "p/", "--base", "fixed"]) == 0
    results = simulate("p", time=0.01, language="python")
    file = Path("p/resultsR/dirdyn_q.res")
    file.write_text(FOREIGN)
    with pytest.raises(ConfigError, match="is not known to urdf2mbs"):
        results.write()
    assert file.read_text() == FOREIGN
    results.write(force=True)
    assert file.read_text() != FOREIGN
    Path("p/resultsR/modal.csv").write_text(FOREIGN)
    words = ["modes", "p", "--drawn", "--language", "python"]
    assert main(words) == 2
    assert "output-not-ours" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0


def test_a_robot_without_feet_rests_on_the_ground(here: Path, capsys: Any) -> None:
    assert main(["simulate", "tiny.urdf", "-o", "s/", "--time", "0.02"]) == 0
    out = capsys.readouterr().out
    assert "no feet: nobody knows if its base floats; all that is solid touches the ground" in out
    assert "nothing holds it" not in out


def test_an_mbs_alone_becomes_a_project(here: Path, capsys: Any) -> None:
    assert main(["convert", "tiny.urdf", "-o", "tiny.mbs"]) == 0
    words = ["simulate", "tiny.mbs", "-o", "alone", "--time", "0.02", "--language", "python"]
    assert main(words) == 0
    assert Path("alone/dataR/tiny.mbs").read_bytes() == Path("tiny.mbs").read_bytes()
    assert Path("alone/resultsR/dirdyn_q.res").is_file()
    assert not Path("resultsR").exists()
    assert main(["simulate", "alone", *words[2:]]) == 2
    assert "is a project already" in capsys.readouterr().err


@pytest.mark.parametrize("what", ["truncated", "folder", "not XML"])
@pytest.mark.parametrize(
    "words",
    [
        ["simulate", "tiny.urdf", "--time", "0.02", "--language", "python"],
        ["modes", "tiny.urdf", "--drawn", "--language", "python"],
        ["init", "tiny.urdf"],
    ],
)
def test_an_mbs_beside_the_robot_is_not_used(
    words: list[str], what: str, here: Path, capsys: Any
) -> None:
    assert main(["convert", "tiny.urdf"]) == 0
    file = Path("tiny.mbs")
    broken = file.read_text() + "more" if what == "truncated" else "a note"
    if what == "folder":
        file.unlink()
        file.mkdir()
        if words[0] == "init":
            pytest.skip("init proposes this very output")
    else:
        file.write_text(broken)
    assert main(words) == 0, capsys.readouterr().err
    assert file.is_dir() or file.read_text() == broken


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("--duration", "did you mean '--time'?"),
        ("-t", "did you mean '--time'?"),
        ("--fps", "did you mean '--rate'?"),
        ("--dt", "'--tolerance' sets the length of steps, and '--rate' the frames a second"),
    ],
)
def test_what_others_call_an_option(option: str, meant: str, capsys: Any) -> None:
    with pytest.raises(SystemExit):
        main(["simulate", "tiny.urdf", option, "1"])
    assert f"unrecognized arguments: {option} 1; {meant}\n" in capsys.readouterr().err
    commands: Any = next(action.choices for action in parser()._actions if action.choices)
    options = set(commands["simulate"]._option_string_actions)
    assert {word for word in MEANT.values() if word.startswith("--")} <= options


@pytest.mark.parametrize("options", [[], ["--set", "estimate-inertia.total_mass=3"]])
def test_the_project_of_a_robot_has_its_name(options: list[str], here: Path) -> None:
    text = PENDULUM.replace('name="r"', 'name="swing"')
    Path("robot.urdf").write_text(text)
    assert main(["simulate", "robot.urdf", "--time", "0.01", "--language", "python", *options]) == 0
    assert Path("swing_robotran/dataR/swing_robotran.mbs").is_file()
    assert not Path("robot_robotran").exists()
    # its page, made of the .mbs alone
    assert main(["report", "swing_robotran", "-o", "page.html"]) == 0
    assert "<title>swing: motion</title>" in Path("page.html").read_text()
    # a config may have been simulated before: its project stays where it was
    Path("lab.yaml").write_text("source: robot.urdf\n")
    assert main(["simulate", "lab.yaml", "--time", "0.01", "-o", "lab.html"]) == 0
    assert Path("robot_robotran/dataR/robot_robotran.mbs").is_file()
    assert "<title>swing: motion</title>" in Path("lab.html").read_text()


def test_in_python_a_page_has_the_name_of_the_robot(here: Path) -> None:
    Path("robot.urdf").write_text(PENDULUM.replace('name="r"', 'name="swing"'))
    results = simulate("robot.urdf", time=0.01, language="python")
    assert "&lt;title&gt;swing: motion&lt;" in (results._repr_html_() or "")
