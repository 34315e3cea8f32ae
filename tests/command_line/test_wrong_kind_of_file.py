"""A file of the wrong kind: the message names a command that takes it, and this command works."""

import re
import shlex
from pathlib import Path

import pytest

from urdf2mbs.cli import main
from urdf2mbs.commands import kinds
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
MACROS = f"""<robot {XACRO}>
  <xacro:macro name="leg" params="side *place reach:='1 2'">
    <link name="${{side}}_leg"/>
  </xacro:macro>
</robot>
"""
ROBOT = f"""<robot name="walker" {XACRO}>
  <xacro:include filename="$(find walker)/urdf/{{}}"/>{{}}
</robot>
"""
CALL = '<xacro:leg side="left"><origin/></xacro:leg>'


@pytest.fixture
def lab(here: Path) -> Path:
    """A folder with a file or a folder of each kind, which is where we are."""
    texts = {
        "tiny.yaml": "source: tiny.urdf\noutput: {project: tiny}\n",
        "robots/a robot.urdf": TINY,
        "robots/tiny.urdf": TINY,
        "configs/lab.yaml": "source: ../tiny.urdf\n",
        "configs/controllers.yaml": "gains: {p: 1}\n",
        "xml/robot.xml": TINY,
        "walker/package.xml": "<package><name>walker</name></package>",
        "walker/urdf/macros/leg.xacro": MACROS,
        "walker/urdf/body.xacro": ROBOT.format("macros/leg.xacro", "").replace('name="walker"', ""),
        "walker/urdf/walker.urdf.xacro": ROBOT.format("body.xacro", CALL),
    }
    for name, text in texts.items():
        file = here / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    (here / "empty").mkdir()
    assert main(["run", "tiny.yaml", "-q"]) == 0
    assert main(["convert", "tiny.urdf", "-q"]) == 0
    (here / "models").mkdir()
    (here / "models" / "tiny.mbs").write_bytes((here / "tiny.mbs").read_bytes())
    (here / "lone" / "dataR").mkdir(parents=True)
    (here / "lone" / "dataR" / "lone.mbs").write_bytes((here / "tiny.mbs").read_bytes())
    return here


#: A wrong command line, and the commands that its message names.
WRONG = [
    ("run tiny.urdf", ["convert tiny.urdf", "init tiny.urdf"]),
    ("run tiny.mbs", ["report tiny.mbs", "simulate tiny.mbs"]),
    ("run tiny", ["run tiny.yaml"]),
    ("run lone", ["report lone", "simulate lone"]),
    ("run robots", ["convert 'robots/a robot.urdf'"]),
    ("run models", ["report models/tiny.mbs"]),
    ("run configs", ["run configs/lab.yaml"]),
    ("run xml/robot.xml", ["convert xml/robot.xml", "init xml/robot.xml"]),
    ("run tiny.yaml tiny.urdf", ["convert tiny.urdf", "init tiny.urdf"]),
    ("convert tiny.yaml", ["run tiny.yaml", "report tiny.yaml"]),
    ("convert tiny.mbs", ["report tiny.mbs", "simulate tiny.mbs"]),
    ("convert configs -o x/", ["run configs/lab.yaml"]),
    ("convert tiny", ["report tiny", "simulate tiny"]),
    ("init tiny.mbs", ["report tiny.mbs", "simulate tiny.mbs"]),
    ("init tiny.yaml", ["run tiny.yaml", "report tiny.yaml"]),
    ("init robots", ["init 'robots/a robot.urdf'"]),
    ("init configs", ["run configs/lab.yaml"]),
    ("lint tiny.mbs", ["report tiny.mbs", "simulate tiny.mbs"]),
    ("lint robots", ["lint 'robots/a robot.urdf'"]),
    ("explain tiny.mbs", ["report tiny.mbs", "simulate tiny.mbs"]),
    ("explain configs", ["explain configs/lab.yaml"]),
    ("report robots", ["report 'robots/a robot.urdf'"]),
    ("report models", ["report models/tiny.mbs"]),
    ("diagram configs", ["diagram configs/lab.yaml"]),
    ("simulate robots", ["simulate 'robots/a robot.urdf'"]),
    ("modes configs", ["modes configs/lab.yaml"]),
    ("diff tiny.urdf tiny.mbs", ["verify tiny.urdf tiny.mbs"]),
    ("diff tiny.yaml tiny.mbs", ["verify tiny.yaml tiny.mbs"]),
    ("diff models tiny.mbs", ["diff models/tiny.mbs"]),
]


@pytest.mark.parametrize(("line", "commands"), WRONG, ids=[line for line, _ in WRONG])
def test_a_wrong_kind_names_the_command_for_it(
    line: str, commands: list[str], lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(line.split()) == 2
    _, _, hint = capsys.readouterr().err.partition("\n  ")
    named = re.findall(r"urdf2mbs (\w+ (?:'[^']*'|\S+?)(?: [\w/]+\.mbs)?)(?=[;\s])", hint)
    assert named == commands
    best = shlex.split(commands[0])
    if best[0] in ("simulate", "modes", "diff"):  # these compile, or want a second file
        assert kinds.find_kind(Path(best[1])) in ("robot", "config", "model")
    else:  # a lone .mbs is not the project of the config: verify says so, by 3
        assert main(best) == (3 if "verify tiny.yaml" in commands[0] else 0)


def test_a_plugin_that_is_not_there_has_no_command(
    lab: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("urdf2mbs.commands.list_commands", lambda *_: {"convert": None})
    assert main(["run", "tiny.urdf"]) == 2
    assert capsys.readouterr().err.endswith("  urdf2mbs convert tiny.urdf converts it\n")
    assert main(["run", "tiny.mbs"]) == 2
    assert capsys.readouterr().err.endswith("got a model (.mbs)\n")


def test_a_folder_of_a_project_is_its_model(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("report", "diagram"):
        assert main([command, "tiny"]) == 0
    assert (lab / "tiny" / "dataR" / "tiny.html").is_file()
    assert (lab / "tiny" / "dataR" / "tiny.svg").is_file()
    assert main(["diff", "tiny", "tiny/dataR/tiny.mbs"]) == 0
    (lab / "tiny" / "dataR" / "b.mbs").write_bytes((lab / "tiny.mbs").read_bytes())
    capsys.readouterr()
    assert main(["report", "tiny"]) == 2
    assert "has 2 models; expected 1\n  name one: urdf2mbs report tiny/dataR/b.mbs\n" in (
        capsys.readouterr().err
    )


def test_the_diagram_of_a_robot_is_that_of_its_model(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for source, picture in (("tiny.urdf", "tiny.svg"), ("tiny.yaml", "tiny/dataR/tiny.svg")):
        assert main(["diagram", source]) == 0
        drawn = (lab / picture).read_bytes()
        (lab / picture).unlink()
        assert main(["diagram", picture.replace(".svg", ".mbs")]) == 0
        assert (lab / picture).read_bytes() == drawn
    out = capsys.readouterr().out
    assert "the .mbs itself is written by: urdf2mbs convert tiny.urdf\n" in out
    assert "the .mbs itself is written by: urdf2mbs run tiny.yaml\n" in out


@pytest.mark.parametrize("command", ["run", "convert", "report", "init", "lint"])
def test_a_file_of_macros_names_the_robot_that_calls_them(
    command: str, lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The robot includes another file, which includes the macros."""
    assert main([command, "walker/urdf/macros/leg.xacro"]) == (2 if command == "run" else 1)
    said = capsys.readouterr()
    assert "name the robot that includes it instead: walker/urdf/walker.urdf.xacro\n" in (
        said.err + said.out
    )
    if command != "run":
        assert main([command, "walker/urdf/walker.urdf.xacro"]) == 0


def test_a_file_of_macros_that_nothing_calls_comes_with_a_robot(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (lab / "walker/urdf/walker.urdf.xacro").unlink()
    assert main(["convert", "walker/urdf/macros/leg.xacro"]) == 1
    _, _, proposed = capsys.readouterr().err.partition("or write one:\n")
    assert '<xacro:leg side="VALUE"><origin/></xacro:leg>' in proposed
    (lab / "walker/urdf/macros/robot.urdf.xacro").write_text(proposed)
    assert main(["convert", "walker/urdf/macros/robot.urdf.xacro"]) == 0


def test_a_robot_that_cannot_be_searched_is_none_of_macros(lab: Path) -> None:
    (lab / "broken.xacro").write_text("<robot><xacro:macro")
    with pytest.raises(ConversionError, match="'run' expects a config, got a robot"):
        kinds.check_kind(Path("broken.xacro"), Arguments("run"), "config")


class Arguments:
    """The options of a command, which has a name."""

    def __init__(self, command: str) -> None:
        self.command = command
