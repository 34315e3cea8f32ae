"""docs/architecture.md and the READMEs of plugins name all that there is; nothing is long."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from support.folders import ROOT
from urdf2mbs import hookspecs
from urdf2mbs.engine.entry_points import find_own_plugins
from urdf2mbs.engine.plugins import Plugins

#: The names of our own plugins.
OWN = sorted(find_own_plugins(tuple(sys.path)))
PACKAGE = ROOT / "urdf2mbs"


def test_every_module_has_its_place_on_the_page() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    rooms = {found[1]: row for row in rows if (found := re.match(r"\| `(\w+)/` ", row))}
    others = "".join(row for row in rows if row not in rooms.values())
    for room, row in rooms.items():
        files = {file.stem for file in (PACKAGE / room).glob("*.py")} - {"__init__", "codes"}
        named = words(row) - {f"{room}/"}
        assert named <= files if room in ("passes", "commands") else named == files, room
    for file in PACKAGE.glob("[a-z]*"):
        assert file.name in rooms or f"`{file.stem}`" in others or file.suffix != ".py", file


def test_twenty_changes_have_their_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| .*\? \| (.*) \|$", text, re.MULTILINE)
    assert len(rows) == 20
    for row in rows:
        places = words(row)
        assert places
        assert all((ROOT / place).exists() for place in places), row


@pytest.mark.parametrize("name", OWN)
def test_a_readme_says_what_a_plugin_brings(name: str) -> None:
    folder = ROOT / "plugins" / f"urdf2mbs_{name}"
    text = (folder / "README.md").read_text("utf-8")
    rows = dict(re.findall(r"^\| ([a-zP][\w ]*) \| (.*) \|$", text, re.MULTILINE))
    plugin = import_module(folder.name)
    hooks = {hook for hook in vars(plugin) if hook in vars(hookspecs) and hook[:9] == "urdf2mbs_"}
    assert words(rows["hooks"]) == hooks
    passes = plugin.urdf2mbs_passes() if "urdf2mbs_passes" in hooks else []
    linked = re.findall(r"passes/([a-z-]+)\.md", rows.get("passes", ""))
    assert sorted(linked) == sorted(each.name for each in passes)
    commands = plugin.urdf2mbs_commands() if "urdf2mbs_commands" in hooks else []
    assert words(rows.get("commands", "")) == {command.name for command in commands}
    api = plugin.urdf2mbs_api() if "urdf2mbs_api" in hooks else {}
    assert words(rows.get("Python", "")) == {*api}
    assert words(rows.get("needs", "").partition(":")[0]) == {*getattr(plugin, "NEEDS", ())}
    named = {part for word in words(text) for part in word.split("/")}
    for file in (*folder.glob("*.py"), *(one.parent for one in folder.glob("*/*.py"))):
        assert file.stem in {"passes", "commands", "codes", "__init__"} | named, file


def words(text: str) -> set[str]:
    """What stands in `quotes`."""
    return {*re.findall(r"`([\w/.-]+)`", text)}


def test_no_function_is_long() -> None:
    files = sorted([*PACKAGE.rglob("*.py"), *(ROOT / "plugins").rglob("*.py")])
    nodes = [node for file in files for node in ast.walk(ast.parse(file.read_text("utf-8")))]
    assert not [
        node.name
        for node in nodes
        if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno >= 70
    ]


def test_every_pass_has_its_tests() -> None:
    for registered in Plugins(installed=False).passes.values():
        file, plugin = f"test_{registered[0].name.replace('-', '_')}.py", registered[0].plugin
        folder = ROOT / "tests" / ("" if registered[0].is_core else f"plugins/{plugin}")
        assert (folder / "passes" / file).is_file(), (plugin, file)


def test_tests_have_a_folder_for_each_room_and_plugin() -> None:
    folders = {file.name for file in (ROOT / "tests" / "plugins").iterdir() if file.is_dir()}
    assert folders - {"__pycache__"} == {*OWN}


def test_tests_share_code_through_support_alone() -> None:
    """A test can be renamed or cut without breaking another one."""
    support = {file.stem for file in (ROOT / "tests" / "support").iterdir()}
    for file in sorted((ROOT / "tests").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                first, _, rest = node.module.partition(".")
                assert not (ROOT / "tests" / first).is_dir() or first == "support", file
                assert not node.module.rpartition(".")[2].startswith("test_"), file
                assert first != "support" or not rest or rest.partition(".")[0] in support, file


def test_tests_and_their_processes_import_this_checkout() -> None:
    """Also after an installation that is not editable: no edit goes untested."""
    program = "import urdf2mbs, urdf2mbs_report; print(urdf2mbs.__file__, urdf2mbs_report.__file__)"
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True, cwd="/"
    )
    here = [PACKAGE / "__init__.py", ROOT / "plugins" / "urdf2mbs_report" / "__init__.py"]
    assert done.stdout.split() == [str(file) for file in here]
    assert [Path(sys.modules["urdf2mbs"].__file__ or "")] == here[:1]


def test_the_oracle_imports_nothing_that_it_is_compared_with() -> None:
    oracle = ROOT / "tests" / "support" / "oracle"
    program = f"""
import sys
sys.path[:0] = [{str(ROOT / "tests")!r}]
import support.oracle
for name in {sorted(file.stem for file in oracle.glob("[a-z]*.py"))}:
    __import__(f"support.oracle.{{name}}")
print([name for name in sys.modules if name.startswith("urdf2mbs")])
"""
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert done.stdout == "[]\n"
