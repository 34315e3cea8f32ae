"""Whatever is wrong with a plugin: one message that names it, exit code 2 (1 if it failed on a
robot), no traceback."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.cli import main
from urdf2mbs.engine.plugins import Plugins
from urdf2mbs.messages.diagnostics import ConversionError
from urdf2mbs.testing import TINY, convert_text, run_pass

HOOKS = "from making import hookimpl, make\nimport msgspec\n"
CLASS = "from urdf2mbs.plugin import Pass, hookimpl\nclass A(Pass):\n"
PASS = HOOKS + "def run(conversion, options): pass\n@hookimpl\ndef urdf2mbs_passes(): return "


def run_config(folder: Path, plugin: str | None, capsys: Any, config: str = "") -> tuple[int, str]:
    (folder / "tiny.urdf").write_text(TINY)
    if plugin is not None:
        (folder / "mine.py").write_text(plugin)
    (folder / "robot.yaml").write_text(f"source: tiny.urdf\nplugins: [mine.py]\n{config}")
    code = main(["run", str(folder / "robot.yaml")])
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert len(re.findall(r"error\[", said.err)) == 1
    assert not (folder / "tiny.mbs").exists()
    return code, said.err


BROKEN = {
    "syntax": ("x = 1\ndef f(:\n", r"mine.py:2: error\[plugin-broken\].*SyntaxError: invalid"),
    "import": ("import nosuch\n", r"mine.py:1: .*No module named 'nosuch'\n.*install it"),
    "fails": ("x = 1\n1 / 0\n", r"mine.py:2: .*ZeroDivisionError: division by zero"),
    "exits": ("import sys\nsys.exit(0)\n", r"mine.py:2: .*cannot be loaded: SystemExit: 0"),
    "empty": ("", r"plugin-empty\].*'mine' brings nothing.*\n.*@hookimpl"),
    "unmarked": ("def urdf2mbs_passes(): return []\n", r"plugin-empty\]"),
    "binary": ("\0", r"plugin-broken\].*null bytes"),
    "unknown hook": (
        HOOKS + "@hookimpl\ndef urdf2mbs_pass(): pass\n",
        r"mine.py: .*unknown hook 'urdf2mbs_pass'.*\n.*the hooks are: urdf2mbs_passes\(\),",
    ),
    "wrong argument": (
        HOOKS + "@hookimpl\ndef urdf2mbs_before_pass(robot): pass\n",
        r"mine.py: .*'urdf2mbs_before_pass'.*\{'robot'\}.*\n.*before_pass\(pass_, conversion\)",
    ),
    "no list": (
        PASS + "None\n",
        r"plugin 'mine': urdf2mbs_passes returned nothing\n.*list of the classes",
    ),
    "one pass": (PASS + "make('a', run)\n", r"urdf2mbs_passes failed: TypeError"),
    "no pass": (PASS + "['a']\n", r"gave 'a', which is no subclass of Pass\n.*list of the classes"),
    "an instance": (PASS + "[make('a', run)()]\n", r"which is no subclass of Pass"),
    "hook fails": (PASS + "[][0]\n", r"mine.py:5: .*urdf2mbs_passes failed: IndexError"),
    "nameless": (PASS + "[make('', run)]\n", r"pass '': its name is not a word"),
    "name no text": (PASS + "[make(3, run)]\n", r"pass 3: its name is not a word"),
    "pass without run": (
        CLASS + "  pass\n@hookimpl\ndef urdf2mbs_passes(): return [A]\n",
        r"pass 'a': it has no method 'run'\n.*def run\(self, conversion\)",
    ),
    "run of two": (
        CLASS + "  def run(self, conversion, options): pass\n"
        "@hookimpl\ndef urdf2mbs_passes(): return [A]\n",
        r"pass 'a': its 'run' cannot be called with a conversion\n.*self, conversion",
    ),
    "reads no tuple": (
        PASS + "[make('a', run, reads=('robot'))]\n",
        r"pass 'a': 'reads' is 'robot'\n.*reads = \('robot',\), with the comma",
    ),
    "options not for YAML": (
        "from __future__ import annotations\n" + CLASS + "  at: re.Pattern = None\n"
        "  def run(self, conversion): pass\n"
        "@hookimpl\ndef urdf2mbs_passes(): return [A]\n",
        r"plugin-broken\].*NameError",
    ),
    "options of no YAML type": (
        "from pathlib import Path\n" + CLASS + "  at: Path = Path()\n"
        "  def run(self, conversion): pass\n"
        "@hookimpl\ndef urdf2mbs_passes(): return [A]\n",
        r"pass 'a': its options cannot be read from YAML.*\n.*Structs of these",
    ),
    "a pass twice": (PASS + "[make('a', run)] * 2\n", r"brings two passes 'a'"),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_plugin_is_one_message(kind: str, tmp_path: Path, capsys: Any) -> None:
    plugin, said = BROKEN[kind]
    code, err = run_config(tmp_path, plugin, capsys)
    assert code == 2
    assert re.search(said, err), err
    assert "mine" in err


def test_a_config_beside_its_plugin_names_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    for plugin, line in (("x = 1\ndef f(:\n", 2), ("x = 1\n\n1 / 0\n", 3)):
        (tmp_path / "mine.py").write_text(plugin)
        (tmp_path / "c.yaml").write_text("source: r.urdf\nplugins: mine.py\n")
        assert main(["explain", "c.yaml"]) == 2
        assert f"mine.py:{line}: error[plugin-broken]" in capsys.readouterr().err


def test_a_missing_plugin_names_the_line_of_the_config(tmp_path: Path, capsys: Any) -> None:
    code, err = run_config(tmp_path, None, capsys)
    assert code == 2
    assert re.search(r"robot.yaml:2: error\[plugin-missing\].*mine.py' does not exist", err)


def test_a_plugin_that_is_no_python(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "passes.txt").write_text("")
    assert main(["passes", "--plugin", str(tmp_path / "passes.txt")]) == 2
    assert "is not a Python file (.py)" in capsys.readouterr().err


def test_two_plugins_of_one_name(tmp_path: Path, capsys: Any) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(PASS + "[make('a', run)]\n")
    files = [str(tmp_path / folder / "mine.py") for folder in ("one", "two")]
    assert main(["passes", "--plugin", files[0], "--plugin", files[1]]) == 2
    err = capsys.readouterr().err
    assert re.search(r"plugin-doubled\]: two plugins are called 'mine': .*one.*two.*mine.py\n", err)


def test_files_of_one_name_do_not_mix_in_one_process(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(
            HOOKS + f"def run(conversion, options): conversion.robot.name = '{folder}'\n"
            "@hookimpl\ndef urdf2mbs_passes(): return [make('name', run)]\n"
        )
    for folder in ("one", "two", "one"):
        assert run_pass("name", tmp_path / folder / "mine.py").robot.name == folder


def test_each_of_two_files_of_one_name_keeps_its_docstring(tmp_path: Path) -> None:
    found = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        file = tmp_path / folder / "mine.py"
        file.write_text(f'"""{folder}."""\n{PASS}[make("a", run)]\n')
        found.append(Plugins([file], installed=False).passes["a"][0])
    assert [one.kind.summary() for one in found] == ["one.", "two."]
    assert [Path(one.file).parent.name for one in found] == ["one", "two"]


FAIL = """
def deeper(link):
    raise KeyError("colour")

def run(conversion, options):
    for link in conversion.robot.links.values():
        if link.name == "wrist":
            deeper(link)
"""


def test_an_exception_names_plugin_pass_robot_and_line(tmp_path: Path, capsys: Any) -> None:
    plugin = HOOKS + FAIL + "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n"
    code, err = run_config(tmp_path, plugin, capsys, "after: {expand: a}\n")
    assert code == 1
    assert re.search(
        r"mine.py:5: error\[plugin-failed\]: pass 'a' of plugin 'mine' failed on robot 'tiny'"
        r": KeyError: 'colour'\n  --debug",
        err,
    ), err


def test_who_ends_the_process_is_named(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + "def run(conversion, options):\n  import sys; sys.exit('enough')\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError, match="on robot 'tiny': SystemExit: enough") as caught:
        run_pass("a", file)
    assert caught.value.code == "plugin-failed"
    assert (caught.value.file, caught.value.line) == (str(file), 4)


def test_the_line_is_in_the_plugin_not_in_what_it_calls(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + "def run(conversion, options):\n  import json\n  json.loads('{')\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError) as caught:
        run_pass("a", file)
    assert (caught.value.file, caught.value.line) == (str(file), 5)


def test_a_plugins_own_error_stays_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + "from urdf2mbs.messages.diagnostics import ConversionError\n"
                    "def run(conversion, options): raise ConversionError('own', 'no legs')\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError, match=r"^error\[own\]: no legs$"):
        run_pass("a", file)


@pytest.mark.parametrize(("hook", "when"), [("before", "before"), ("after", "after")])
def test_an_exception_in_a_hook(hook: str, when: str, tmp_path: Path, capsys: Any) -> None:
    plugin = HOOKS + (
        f"@hookimpl\ndef urdf2mbs_{hook}_pass(pass_, conversion):\n"
        "  if pass_.name == 'insert-base':\n    joint = conversion.robot.joints['shoulder']\n"
        "    assert joint.mimic, 'no mimic'\n"
    )
    code, err = run_config(tmp_path, plugin, capsys)
    assert code == 1
    assert re.search(
        rf"mine.py:7: error\[plugin-failed\]: hook 'urdf2mbs_{hook}_pass' of plugin 'mine', called "
        rf"{when} pass 'insert-base', failed on robot 'tiny': "
        "AssertionError: no mimic",
        err,
    ), err


BREAKS = {
    "del conversion.robot.links['tool']": "joint 'tool_mount' has the child 'tool', which is no",
    "del conversion.robot.joints['shoulder']": "2 links hang on no joint, 'body', 'arm'",
    "conversion.robot.links['arm'].name = 'x'": r"links\['arm'\] is a link called 'x'",
    "conversion.robot.joints['shoulder'].name = 'x'": r"joints\['shoulder'\] is a joint called",
    "conversion.robot.joints['tool_mount'].child = 'arm'": "child of the joints 'shoulder' and",
    "conversion.robot.joints['shoulder'].parent = 'tool'": "2 links hang on no joint|form a loop",
}


def test_a_pass_that_leaves_no_robot_at_all(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    for line, code in (
        ("conversion.robot.links.clear(); conversion.robot.joints.clear()", "plugin-robot-broken"),
        ("conversion.robot = None", "plugin-failed"),
        ("conversion.robot.links['arm'] = None", "plugin-failed"),
    ):
        file.write_text(HOOKS + f"def run(conversion, options): {line}\n"
                        "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
        with pytest.raises(ConversionError, match="pass 'a' of plugin 'mine'") as caught:
            run_pass("a", file)
        assert caught.value.code == code


@pytest.mark.parametrize("line", BREAKS)
def test_a_pass_that_leaves_no_tree_is_told_at_once(line: str, tmp_path: Path) -> None:
    """Else the next pass would stumble over it, or drop half of the robot in silence."""
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + f"def run(conversion, options): {line}\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError, match=BREAKS[line]) as caught:
        run_pass("a", file)
    assert caught.value.code == "plugin-robot-broken"
    assert "pass 'a' of plugin 'mine' leaves robot 'tiny' broken" in caught.value.message


def test_a_built_in_pass_that_stumbles_after_a_plugins_says_so(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + "def run(conversion, options): conversion.segments.clear()\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError) as caught:
        run_pass("a", file, after="prune-massless")
    assert caught.value.code == "internal"
    assert "what a plugin's pass did before: 'a' (mine)" in (caught.value.hint or "")


def test_debug_shows_the_traceback(tmp_path: Path) -> None:
    (tmp_path / "tiny.urdf").write_text(TINY)
    (tmp_path / "mine.py").write_text("1 / 0\n")
    (tmp_path / "robot.yaml").write_text("source: tiny.urdf\nplugins: mine.py\n")
    with pytest.raises(ConversionError) as caught:
        main(["run", "--debug", str(tmp_path / "robot.yaml")])
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_an_idle_plugin_is_told(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(PASS + "[make('a', run)]\n")
    idle = [d for d in convert_text(plugins=[file]).diagnostics if d.code == "plugin-idle"]
    assert [d.level for d in idle] == ["warning"]
    assert "'mine' does nothing" in idle[0].message
    file.write_text(PASS + "[make('a', run)]\n@hookimpl\ndef urdf2mbs_before_pass(): pass\n")
    codes = [d.code for d in convert_text(plugins=[file]).diagnostics]
    assert "plugin-idle" not in codes


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("conversion.files['a'] = b''", "conversion.files has 'a': bytes"),
        ("conversion.files[conversion.settings.output] = ''", "Path.*: str"),
        ("conversion.facts['a'] = object()", "conversion.facts cannot be JSON"),
    ],
)
def test_outputs_that_could_not_be_written(line: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(HOOKS + f"def run(conversion, options): {line}\n"
                    "@hookimpl\ndef urdf2mbs_passes(): return [make('a', run)]\n")  # fmt: skip
    with pytest.raises(ConversionError, match=said) as caught:
        run_pass("a", file)
    assert caught.value.code == "plugin-output-broken"
