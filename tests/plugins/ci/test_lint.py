"""`lint`, and `verify --ci`: what a CI of somebody else reads, as lines, JSON and SARIF."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.folders import ROOT
from urdf2mbs import convert
from urdf2mbs.cli import main
from urdf2mbs.commands import list_commands
from urdf2mbs.testing import TINY

#: A xacro robot in two files, with a fault in a link of the second.
MAIN = """<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="arm.xacro"/>
  <link name="body"/>
</robot>"""
ARM = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <joint name="shoulder" type="continuous">
    <parent link="body"/><child link="arm"/><axis xyz="0 0 1"/>
  </joint>

  <link name="arm">
    <inertial>
      <mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/>
    </inertial>
  </link>
</robot>"""


@pytest.fixture
def robots(here: Path) -> Path:
    """Return the current folder, with robots that have faults."""
    Path("wrong.urdf").write_text(TINY.replace('link="arm"', 'link="amr"'))
    Path("odd.urdf").write_text(TINY.replace('izz="0.01"', 'izz="0.1"'))
    Path("two.urdf.xacro").write_text(MAIN)
    Path("arm.xacro").write_text(ARM)
    return here


def results(file: str = "found.sarif") -> list[dict[str, Any]]:
    """Return the results of a SARIF file, and check that it has what GitHub requires."""
    log = json.loads(Path(file).read_text())
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-2.1.0.json")
    (run,) = log["runs"]
    rules = {
        rule["id"]: rule["shortDescription"]["text"] for rule in run["tool"]["driver"]["rules"]
    }
    assert run["tool"]["driver"]["name"] == "urdf2mbs"
    for result in run["results"]:
        assert rules[result["ruleId"]]
        assert result["level"] in ("error", "warning", "note")
        assert result["message"]["text"]
    findings: list[dict[str, Any]] = run["results"]
    return findings


def place(result: dict[str, Any]) -> tuple[str, int]:
    (location,) = result["locations"]
    physical = location["physicalLocation"]
    return physical["artifactLocation"]["uri"], physical["region"]["startLine"]


def test_a_robot_without_a_fault(robots: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lint", "tiny.urdf", "--sarif", "found.sarif"]) == 0
    assert capsys.readouterr().out == "tiny: 0 errors, 0 warnings, 0 notes\n"
    assert not results()
    assert not list(robots.glob("*.mbs"))
    Path("found.sarif").write_text("mine")
    assert main(["lint", "tiny.urdf", "--sarif", "found.sarif"]) == 2
    assert Path("found.sarif").read_text() == "mine"


def test_errors_say_where_and_what_to_do(robots: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lint", "wrong.urdf", "--sarif", "found.sarif"]) == 1
    said = capsys.readouterr()
    assert said.out.startswith("wrong.urdf:13: error[link-unknown]")
    assert "did you mean 'arm'?" in said.out
    (first, *_) = results()
    assert (first["ruleId"], first["level"], place(first)) == (
        "link-unknown",
        "error",
        ("wrong.urdf", 13),
    )
    assert main(["lint", "wrong.urdf", "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["error"] >= 1
    assert report["diagnostics"][0]["line"] == 13


def test_a_warning_is_an_error_with_strict(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["lint", "odd.urdf"]) == 0
    assert "warning[inertia-triangle]" in capsys.readouterr().out
    assert main(["lint", "odd.urdf", "--strict"]) == 1
    assert main(["lint", "odd.urdf", "--strict", "--level", "inertia-triangle=note"]) == 0


def test_a_fault_in_xacro_has_the_line_of_its_own_file(robots: Path) -> None:
    assert main(["lint", "two.urdf.xacro", "--sarif", "found.sarif"]) == 0
    places = {result["ruleId"]: place(result) for result in results()}
    assert places["inertia-triangle"] == ("arm.xacro", 6)


def test_a_config_is_linted_and_a_wrong_command_line_is_no_fault_of_the_robot(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("odd.yaml").write_text("source: odd.urdf\noutput: {project: p}\n")
    assert main(["lint", "odd.yaml", "--strict"]) == 1
    assert not Path("p").exists()
    capsys.readouterr()
    assert main(["lint", "odd.yaml", "--base", "fixed"]) == 2
    assert main(["lint", "odd.urdf", "--level", "nosuch=note", "--sarif", "found.sarif"]) == 2
    assert not Path("found.sarif").exists()


def test_verify_ci_has_the_line_of_what_differs(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("tiny.mbs").write_bytes(convert("tiny.urdf").data)
    words = ["verify", "tiny.urdf", "tiny.mbs", "--ci", "--sarif", "found.sarif"]
    assert main(words) == 0
    assert capsys.readouterr().out.startswith("the same robot")
    Path("tiny.urdf").write_text(TINY.replace('<mass value="0.5"/>', '<mass value="0.6"/>'))
    assert main(words) == 3
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("tiny.urdf:13: error[not-the-same]: link 'arm': mass is 0.5")
    assert out[-1] == "NOT the same robot"
    (differs,) = [result for result in results() if result["level"] == "error"]
    assert (differs["ruleId"], place(differs)) == ("not-the-same", ("tiny.urdf", 13))
    assert main(["verify", "wrong.urdf", "tiny.mbs", "--sarif", "found.sarif"]) == 1
    assert results()[0]["ruleId"] == "link-unknown"


def test_verify_of_a_config_has_the_line_of_what_differs(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("lab").mkdir()
    Path("lab/tiny.urdf").write_text(TINY)
    Path("lab/lab.yaml").write_text("source: tiny.urdf\nbase: floating\n")
    assert main(["run", "lab/lab.yaml", "-q"]) == 0
    Path("lab/tiny.urdf").write_text(TINY.replace('<mass value="0.5"/>', '<mass value="0.6"/>'))
    assert main(["verify", "lab/lab.yaml", "--ci", "--sarif", "found.sarif"]) == 3
    first, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith("lab/tiny.urdf:13: error[not-the-same]: link 'arm': mass is 0.5")
    (differs,) = [result for result in results() if result["level"] == "error"]
    assert place(differs) == ("lab/tiny.urdf", 13)
    Path("lab/tiny.urdf").write_text(TINY.replace('link="arm"', 'link="amr"'))
    assert main(["verify", "lab/lab.yaml", "--sarif", "found.sarif"]) == 1
    assert place(results()[0]) == ("lab/tiny.urdf", 13)


#: A Python for which ``-m venv DIR`` makes an environment whose pip only looks for the package.
FAKE_PYTHON = r"""#!/bin/bash
test "$1 $2" = "-m venv" || exit 9
mkdir -p "$3/bin"
printf '#!/bin/bash\ntest "$1 $2 $3" = "-m pip install" && test -f "${@: -1}/pyproject.toml"\n' \
    > "$3/bin/python"
printf '#!/bin/bash\n"%s" -m urdf2mbs "$@"\n' "$REAL_PYTHON" > "$3/bin/urdf2mbs"
chmod +x "$3"/bin/*
"""


def act(**given: str) -> list[int]:
    """Run the action's shell steps with these inputs until one fails; return the exit codes.

    The other inputs have their defaults.  Nothing is installed.
    """
    action = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
    values = {f"inputs.{name}": about.get("default") for name, about in action["inputs"].items()}
    values |= {f"inputs.{name}": text for name, text in given.items()}
    values["github.action_path"] = str(ROOT)
    values["steps.python.outputs.python-path"] = str(Path("fake-python").absolute())
    Path("fake-python").write_text(FAKE_PYTHON)
    Path("fake-python").chmod(0o755)
    runner = {"RUNNER_TEMP": str(Path("temp").absolute()), "REAL_PYTHON": sys.executable}
    codes: list[int] = []
    for step in action["runs"]["steps"]:
        if "run" in step and not any(codes):
            assert "${{" not in step["run"], "an input in a script is code of whoever wrote it"
            env = {**os.environ, **runner}
            for name, text in step["env"].items():
                env[name] = re.sub(r"\$\{\{ (.*?) \}\}", lambda match: values[match[1]], text)
            script = [step["shell"], "-eo", "pipefail", "-c", step["run"]]
            codes.append(subprocess.run(script, env=env, check=False).returncode)
    return codes


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_the_action_runs_as_github_would_run_it(robots: Path) -> None:
    shutil.copy(ROOT / "configs" / "lamp.urdf", "lamp.urdf")
    assert main(["convert", "lamp.urdf", "-o", "lamp.mbs"]) == 0
    assert act(robot="lamp.urdf") == [0, 0]
    assert act(robot="lamp.urdf", model="lamp.mbs", passes="--frames") == [0, 0]
    assert json.loads(Path("urdf2mbs.sarif").read_text())["runs"]
    text, mass = Path("lamp.urdf").read_text(), '<mass value="'
    Path("lamp.urdf").write_text(text.replace(mass, f"{mass}9"))
    assert act(robot="lamp.urdf", model="lamp.mbs", sarif="found.sarif") == [0, 3]
    assert results()
    assert act(robot="nothing.urdf") == [0, 1]
    Path("lamp.yaml").write_text("source: lamp.urdf\n")
    assert act(robot="lamp.yaml") == [0, 0]
    assert act(robot="lamp.yaml", model="lamp.mbs") == [0, 3]


def test_the_action_leaves_the_python_of_its_caller_alone() -> None:
    steps = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))["runs"]["steps"]
    (setup,) = [step for step in steps if "uses" in step]
    assert setup["uses"].startswith("actions/setup-python@")
    assert setup["with"]["update-environment"] is False
    assert not any("GITHUB_PATH" in step.get("run", "") for step in steps)


NO_MASS = '<robot name="empty"><link name="a"/></robot>'


def test_a_robot_without_mass_and_meshes(robots: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Their levels are the user's, and all are told where they are errors."""
    shape = '<geometry><mesh filename="package://gone/a.stl"/></geometry>'
    Path("empty.urdf").write_text(
        NO_MASS.replace("/></robot>", f"><visual>{shape}</visual></link></robot>")
    )
    assert main(["lint", "empty.urdf"]) == 0
    told = capsys.readouterr().out
    assert told.count("warning[no-mass]") == 1
    assert told.count("warning[mesh-missing]") == 1
    assert "1 mesh not found: 'package://gone/a.stl' (link a)" in told
    assert told.endswith("empty: 0 errors, 2 warnings, 0 notes\n")
    assert main(["lint", "empty.urdf", "--strict", "--level", "mesh-missing=ignore"]) == 1
    assert "error[no-mass]" in capsys.readouterr().out
    assert main(["lint", "empty.urdf", "--strict"]) == 1
    told = capsys.readouterr().out
    assert "error[no-mass]" in told
    assert "error[mesh-missing]" in told
    assert not list(robots.glob("*.mbs"))


@pytest.mark.parametrize(
    "where",
    [
        "after: {expand: weigh}",
        "before: {insert-base: weigh}",
        "pipeline: [expand, weigh, insert-base]",
        "pipeline: [expand]\nafter: {expand: weigh}",
    ],
)
def test_the_plugins_of_a_config_take_part(
    where: str, robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("weigh.py").write_text(
        "from urdf2mbs.plugin import Pass, hookimpl, urdf\n"
        "class Weigh(Pass):\n"
        "    reads = writes = ('robot',)\n"
        "    def run(self, conversion):\n"
        "        inertia = (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)\n"
        "        conversion.robot.links['a'].inertial = urdf.Inertial(2.0, inertia)\n"
        "        conversion.warn('weighed', 'link a weighs 2 kg', link='a')\n"
        "@hookimpl\n"
        "def urdf2mbs_passes(): return [Weigh]\n"
        "@hookimpl\n"
        "def urdf2mbs_codes(): return {'weighed': 'warning: a link got a mass'}\n"
    )
    Path("empty.urdf").write_text(NO_MASS)
    config = f"source: empty.urdf\nplugins: [weigh.py]\ndiagnostics: {{weighed: error}}\n{where}\n"
    Path("empty.yaml").write_text(config)
    assert main(["lint", "empty.yaml"]) == 1
    told = capsys.readouterr().out
    assert "error[weighed]: link a weighs 2 kg" in told
    assert "no-mass" not in told
    Path("empty.yaml").write_text(f"source: empty.urdf\nplugins: [gone.py]\n{where}\n")
    assert main(["lint", "empty.yaml"]) == 2


OWN_FORMAT = """
from urdf2mbs.plugin import Expansion, Pass, hookimpl

class Payload(Pass):
    reads = writes = ("robot",)
    after = ("expand",)
    def run(self, conversion):
        conversion.robot.links["hand"].inertial.mass += 0.5

@hookimpl
def urdf2mbs_passes():
    return [Payload]

@hookimpl
def urdf2mbs_read(source, data):
    if source.suffix == ".rob":
        return Expansion(data.removeprefix(b"ROBOT:"), [str(source)], [])
"""


def test_a_robot_in_the_format_of_a_plugin(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``lint``, ``verify`` and ``report`` read what ``run`` reads."""
    Path("ours.py").write_text(OWN_FORMAT)
    Path("tiny.rob").write_text(f"ROBOT:{TINY}")
    config = "source: tiny.rob\noutput: out.mbs\nplugins: [ours.py]\nbase: floating\n"
    Path("lab.yaml").write_text(config)
    assert main(["run", "lab.yaml", "-q"]) == 0
    capsys.readouterr()
    assert main(["lint", "lab.yaml", "--strict"]) == 0
    assert capsys.readouterr().out == "tiny: 0 errors, 0 warnings, 0 notes\n"
    assert main(["verify", "lab.yaml", "--ci"]) == 0
    same = "the same robot, but for what payload changed: 1 mass"
    assert capsys.readouterr().out == f"{same}\n"
    assert main(["lint", "lab.yaml", "--no-plugins"]) == 1
    if "report" in list_commands():
        assert main(["report", "lab.yaml"]) == 0
        assert same in capsys.readouterr().out
        assert "payload" in Path("out.html").read_text()


def test_inertias_that_a_config_estimates_are_mass(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    visual = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    Path("empty.urdf").write_text(NO_MASS.replace("/></robot>", f">{visual}</link></robot>"))
    Path("empty.yaml").write_text("source: empty.urdf\npasses: {estimate-inertia: {density: 9}}\n")
    assert main(["lint", "empty.yaml"]) == 0
    told = capsys.readouterr().out
    assert "warning[inertia-estimated]" in told
    assert "no-mass" not in told


def test_a_sweep_and_a_config_with_all_kinds_of_passes(
    robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("family.yaml").write_text(
        "source: tiny.urdf\noutput: '{contacts.sink}.mbs'\npasses: {contacts: {links: [hand]}}\n"
        "sweep: {passes: {contacts: {sink: [0.1, 0.2]}}}\n"
    )
    assert main(["lint", "family.yaml"]) == 0
    assert capsys.readouterr().out == "tiny: 0 errors, 0 warnings, 0 notes\n"
