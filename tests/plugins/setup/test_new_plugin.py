"""What `new-plugin` writes installs with pip, runs, passes its own tests, and checks a robot."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from support.folders import ROOT
from support.presets import PRESETS
from urdf2mbs.cli import main
from urdf2mbs_setup.commands.new_plugin import FILES, new_plugin

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.skipif("compact" not in PRESETS, reason="the plugin compact is away")


class Lab:
    """The folder of a new plugin, and the folder where pip has installed it."""

    def __init__(self, folder: Path, site: Path) -> None:
        self.folder = folder
        self.path = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])

    def run(self, *words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run a module of Python where the plugin is installed."""
        return subprocess.run(
            [sys.executable, "-m", *words],
            cwd=cwd or self.folder,
            env={**os.environ, "PYTHONPATH": self.path, "PYTHONDONTWRITEBYTECODE": "1"},
            check=False,
            capture_output=True,
            text=True,
        )


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    parent = tmp_path_factory.mktemp("new")
    folder, _ = new_plugin("our-lab2", parent)
    lab = Lab(folder, parent / "site")
    done = lab.run(
        *("pip", "install", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps"),
        *("--no-build-isolation", "--target", str(parent / "site"), str(folder)),
    )
    assert done.returncode == 0, done.stderr
    return lab


def test_it_runs_and_says_what_it_changed(lab: Lab) -> None:
    done = lab.run("urdf2mbs", "run", "robots/arm.yaml")
    assert done.returncode == 0, done.stderr
    same = "the same robot, but for what our-lab2-payload changed: 1 mass, 1 centre, 1 inertia"
    assert f"{same}; 0 warnings" in done.stdout
    done = lab.run("urdf2mbs", "explain", "our-lab2-payload")
    assert "from     our-lab2 0.1.0 (" in done.stdout
    assert "loads: dict[str, float], default: {}\n        The mass (kg) by link" in done.stdout
    assert re.search(r"our-lab2 +2 of \d+, after 'expand'", done.stdout)
    doctor = lab.run("urdf2mbs", "doctor").stdout
    assert re.search(r"our-lab2 +our-lab2 0\.1\.0 \(.*\)\n", doctor)


def test_its_checks_for_github_find_a_change(lab: Lab) -> None:
    """Each command of the file, after those that install, is one that runs."""
    text = (lab.folder / ".github/workflows/robots.yml").read_text()
    steps = [
        step["run"] for step in yaml.safe_load(text)["jobs"]["robots"]["steps"] if "run" in step
    ]
    install, *commands = steps
    assert install.splitlines()[-2:] == [
        'pip install "urdf2mbs @ $URDF2MBS" pytest',
        "pip install .",
    ]
    assert [command.split()[:2] for command in commands] == [
        ["pytest", "tests"],
        ["urdf2mbs", "lint"],
        ["urdf2mbs", "verify"],
    ]
    *_, verify = commands
    model = lab.folder / "robots/arm.mbs"
    model.unlink(missing_ok=True)
    done = lab.run(*verify.split())
    assert done.returncode == 2
    assert "urdf2mbs run robots/arm.yaml" in done.stderr
    assert lab.run("urdf2mbs", "run", "robots/arm.yaml").returncode == 0
    for command in commands:
        done = lab.run(*command.split())
        assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    config = lab.folder / "robots/arm.yaml"
    heavy = config.read_text()
    config.write_text(heavy.replace("hand: 0.5", "hand: 0.7"))
    try:
        done = lab.run(*verify.split())
    finally:
        config.write_text(heavy)
    assert done.returncode == 3
    assert "link 'hand': mass is 1 in the .mbs" in done.stdout


def test_messages_name_what_is_wrong_in_a_config(lab: Lab, tmp_path: Path) -> None:
    arm = lab.folder / "robots" / "arm.urdf"
    text = (
        f"source: {arm}\npipeline: our-lab2\npasses: {{our-lab2-payload: {{loads: {{LINK: 1}}}}}}\n"
    )
    (tmp_path / "a.yaml").write_text(text.replace("LINK", "hnd"))
    done = lab.run("urdf2mbs", "lint", "a.yaml", cwd=tmp_path)
    assert done.returncode == 2
    assert "error[our-lab2-link]: payload: no link is called 'hnd'" in done.stderr
    level = "diagnostics: {our-lab2-payload: warning}\n"
    (tmp_path / "a.yaml").write_text(text.replace("LINK", "hand") + level)
    done = lab.run("urdf2mbs", "lint", "a.yaml", cwd=tmp_path)
    assert "warning[our-lab2-payload]: link 'hand' carries 1 kg" in done.stdout


def test_it_is_typed(lab: Lab) -> None:
    pytest.importorskip("mypy", reason="mypy comes with urdf2mbs[dev]")
    files = map(str, [lab.folder / "our_lab2", lab.folder / "tests"])
    cache = str(ROOT / ".mypy_cache")
    done = lab.run("mypy", "--strict", "--cache-dir", cache, *files, cwd=ROOT)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("name", ["a", "our-lab2", "a-very-long-name-of-a-robotics-laboratory"])
def test_its_layout_is_that_of_ruff(name: str, tmp_path: Path) -> None:
    pytest.importorskip("ruff", reason="ruff comes with urdf2mbs[dev]")
    folder, _ = new_plugin(name, tmp_path)
    for words in (["check"], ["format", "--check", "--diff"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *words, "--no-cache", str(folder)],
            check=False,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout + done.stderr


def test_no_word_of_the_templates_is_left(lab: Lab) -> None:
    for file in lab.folder.rglob("*"):
        assert not re.search("NAME|PACKAGE|CLASS", file.name)
        if file.is_file() and file.suffix in (".py", ".toml", ".yaml", ".yml", ".md"):
            assert not re.search(r"NAME|PACKAGE|CLASS|OWNER", file.read_text()), file


def test_it_names_its_files(here: Path, capsys: Capture) -> None:
    assert main(["new-plugin", "our-lab", "-o", "src"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("wrote 10 files in src/our-lab:\n  pyproject.toml\n  README.md\n")
    assert "Next: pip install -e src/our-lab\n" in out
    assert main(["new-plugin", "other-lab", "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    assert written["folder"] == "other-lab"
    assert len(written["files"]) == len(FILES)
    assert all(Path(file).is_file() for file in written["files"])


def test_it_replaces_nothing(here: Path, capsys: Capture) -> None:
    Path("our-lab/tests").mkdir(parents=True)
    Path("our-lab/LICENSE").write_text("ours")
    Path("our-lab/tests/test_our_lab.py").write_text("ours")
    assert main(["new-plugin", "our-lab"]) == 2
    told = capsys.readouterr().err
    assert "'our-lab/tests/test_our_lab.py' exists already: nothing is written" in told
    assert sorted(file.name for file in Path("our-lab").iterdir()) == ["LICENSE", "tests"]
    Path("our-lab/tests/test_our_lab.py").unlink()
    assert main(["new-plugin", "our-lab"]) == 0
    assert Path("our-lab/LICENSE").read_text() == "ours"
    Path("file").write_text("")
    assert main(["new-plugin", "our-lab", "-o", "file"]) == 2
    assert "error[output-unwritable]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "why", "instead"),
    [
        ("Our Lab", "small letters, digits and hyphens", "new-plugin our-lab\n"),
        ("../up", "small letters, digits and hyphens", "new-plugin up\n"),
        ("7", "small letters, digits and hyphens", "new-plugin our-lab\n"),
        ("json", "for something else", "new-plugin json-lab\n"),
        ("tests", "for something else", "new-plugin tests-lab\n"),
        ("report", "has a plugin of this name", "new-plugin our-lab\n"),
        ("urdf2mbs", "has a plugin of this name", "new-plugin our-lab\n"),
        ("faithful", "has a preset of this name", "new-plugin faithful-lab\n"),
        ("lxml", "is installed here", "new-plugin lxml-lab\n"),
    ],
)
def test_a_name_that_no_plugin_can_have(
    name: str, why: str, instead: str, here: Path, capsys: Capture
) -> None:
    assert main(["new-plugin", name]) == 2
    told = capsys.readouterr().err
    assert f"error[plugin-name]: '{name}' cannot be the name of a plugin" in told
    assert why in told
    assert told.endswith(instead)
    assert [file.name for file in here.iterdir()] == ["tiny.urdf"]


def test_new_pass_suggests_no_name_that_it_refuses(here: Path, capsys: Capture) -> None:
    assert main(["new-pass", "Expand"]) == 2
    assert "urdf2mbs new-pass expand-links" in capsys.readouterr().err
